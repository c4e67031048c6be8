//! Licences to move: for which purpose the camera may move, and until when.
//!
//! A licence is the operator's consent to one purpose, renewed again and again by what that purpose needs.
//! There is at most one at a time. A licence that is not renewed within its time to live does not move the
//! camera.
//!
//! ```text
//!                  consent             renewed by                       ends by itself
//!   Nobody -----> Follow (engage)      a fresh localisation             never: it waits for the next renewal
//!     ^  \------> Nudge                the nudge that is held           without renewal
//!     |  \------> Search               the search, on fresh video       without renewal, and after 60 s
//!     |  \------> Calibrate            the calibration, on fresh video  without renewal, and after 120 s
//!     |             | | |
//!     +-------------+ | +--- stop ---> Stopped --- engage ---> Follow
//!       withdraw      |                   |
//!     ^               +-- engage -> Follow|
//!     +------------- withdraw ------------+
//! ```
//!
//! A search that took the place of following gives the licence back when it has found the target or has given
//! up.
//!
//! Whether commands reach the camera, and whether video arrives, is not here: [`crate::safety`] asks for
//! both.

use core::time::Duration;

use barrelman_vocab::profile::MAX_COAST_MOTION;
use barrelman_vocab::{StopCause, Timestamp};

use crate::purpose::Purpose;
use crate::refusal::Refusal;

/// How long a nudge lasts without a renewal: a page that is lost during a nudge ends in rest.
pub const NUDGE_LASTS: Duration = Duration::from_millis(250);
/// How long a search or a calibration lasts without a renewal: some video frames.
const BEHAVIOUR_LASTS: Duration = Duration::from_millis(250);
/// How long the consent to a search lasts.
pub const SEARCH_CONSENT: Duration = Duration::from_secs(60);
/// How long the consent to a calibration lasts.
pub const CALIBRATION_CONSENT: Duration = Duration::from_secs(120);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holder {
    Nobody,
    Purpose {
        purpose: Purpose,
        consented_at: Timestamp,
        /// `None`: not renewed yet.
        renewed_at: Option<Timestamp>,
    },
    Stopped(StopCause),
}

/// The licence, if there is one.
#[derive(Debug, Clone)]
pub struct Licences {
    coast_motion: Duration,
    holder: Holder,
    /// Whether the search that is held took the place of following.
    resumes_following: bool,
}

impl Licences {
    /// No licence. A fresh localisation lets the camera follow for `coast_motion`, at most
    /// [`MAX_COAST_MOTION`].
    pub fn new(coast_motion: Duration) -> Self {
        Self {
            coast_motion: coast_motion.min(MAX_COAST_MOTION),
            holder: Holder::Nobody,
            resumes_following: false,
        }
    }

    /// The operator consents to a purpose. Consent to follow ends every other purpose, and a stop. The others
    /// need a camera without a licence; a search may take the place of following.
    ///
    /// # Errors
    /// The reason, if another purpose or a stop is in the way. Nothing changes then.
    pub fn consent(&mut self, purpose: Purpose, now: Timestamp) -> Result<(), Refusal> {
        match (self.holder, purpose) {
            (Holder::Purpose { purpose: held, .. }, _) if held == purpose => return Ok(()),
            (_, Purpose::Follow) | (Holder::Nobody, _) => {}
            (Holder::Purpose { purpose: Purpose::Follow, .. }, Purpose::Search) => {}
            (Holder::Stopped(_), _) => return Err(Refusal::Stopped),
            (Holder::Purpose { purpose: Purpose::Follow, .. }, _) => return Err(Refusal::Engaged),
            (Holder::Purpose { purpose: held, .. }, _) => return Err(Refusal::Busy(held)),
        }
        self.resumes_following = purpose == Purpose::Search && self.held() == Some(Purpose::Follow);
        let renewed_at = (purpose != Purpose::Follow).then_some(now);
        self.holder = Holder::Purpose { purpose, consented_at: now, renewed_at };
        Ok(())
    }

    /// The operator withdraws every consent. This also ends a stop.
    pub fn withdraw(&mut self) {
        self.holder = Holder::Nobody;
    }

    /// Ends every licence until the next consent to follow. The first cause counts.
    pub fn stop(&mut self, cause: StopCause) {
        if !matches!(self.holder, Holder::Stopped(_)) {
            self.holder = Holder::Stopped(cause);
        }
    }

    /// Ends a search that has come to its end: the camera follows again if it did before. Returns whether it
    /// does.
    pub fn finish_search(&mut self, now: Timestamp) -> bool {
        if self.held() != Some(Purpose::Search) {
            return false;
        }
        let follows = core::mem::take(&mut self.resumes_following);
        self.holder = if follows {
            Holder::Purpose { purpose: Purpose::Follow, consented_at: now, renewed_at: None }
        } else {
            Holder::Nobody
        };
        follows
    }

    /// Ends the licence of a purpose, if it is that one.
    pub fn end(&mut self, purpose: Purpose) {
        if self.held() == Some(purpose) {
            self.holder = Holder::Nobody;
        }
    }

    /// Ends all but the licence to follow.
    pub fn end_behaviours(&mut self) {
        if self.held().is_some_and(|held| held != Purpose::Follow) {
            self.holder = Holder::Nobody;
        }
    }

    /// Renews the licence of a purpose, if it is that one.
    pub fn renew(&mut self, purpose: Purpose, now: Timestamp) {
        if let Holder::Purpose { purpose: held, renewed_at, .. } = &mut self.holder
            && *held == purpose
        {
            *renewed_at = Some(now);
        }
    }

    /// Forgets the renewals so far: the camera rests until the next one.
    pub fn forget_renewals(&mut self) {
        if let Holder::Purpose { renewed_at, .. } = &mut self.holder {
            *renewed_at = None;
        }
    }

    /// The purpose that the operator consented to.
    pub const fn held(&self) -> Option<Purpose> {
        match self.holder {
            Holder::Purpose { purpose, .. } => Some(purpose),
            Holder::Nobody | Holder::Stopped(_) => None,
        }
    }

    /// Why the camera is stopped.
    pub const fn stop_cause(&self) -> Option<StopCause> {
        match self.holder {
            Holder::Stopped(cause) => Some(cause),
            Holder::Nobody | Holder::Purpose { .. } => None,
        }
    }

    /// The purpose for which the camera may move now. A time before the consent or its renewal permits
    /// nothing: the licence's age is not known then.
    pub fn in_force(&self, now: Timestamp) -> Option<Purpose> {
        let Holder::Purpose { purpose, renewed_at: Some(renewed_at), .. } = self.holder else { return None };
        (renewed_at <= now && self.ends_at().is_some_and(|ends| now < ends)).then_some(purpose)
    }

    /// When the licence ends without a further renewal; `None`: there is none, or it was not renewed yet.
    pub fn ends_at(&self) -> Option<Timestamp> {
        let Holder::Purpose { purpose, consented_at, renewed_at: Some(renewed_at) } = self.holder else {
            return None;
        };
        let lasts = match purpose {
            Purpose::Follow => self.coast_motion,
            Purpose::Nudge => NUDGE_LASTS,
            Purpose::Search | Purpose::Calibrate => BEHAVIOUR_LASTS,
        };
        let renewed_until = renewed_at.plus(lasts);
        let consented_until = consent_lasts(purpose).map(|lasts| consented_at.plus(lasts));
        Some(consented_until.map_or(renewed_until, |until| until.min(renewed_until)))
    }
}

/// How long the operator's consent lasts at most; `None`: until it is withdrawn.
const fn consent_lasts(purpose: Purpose) -> Option<Duration> {
    match purpose {
        Purpose::Follow | Purpose::Nudge => None,
        Purpose::Search => Some(SEARCH_CONSENT),
        Purpose::Calibrate => Some(CALIBRATION_CONSENT),
    }
}
