//! The rule of the campaign, judged apart from the program: the rate in force at the ground station is zero
//! within the time to rest of the last moment that permitted motion: 350 ms, or longer where a command has to
//! expire.
//!
//! Motion is permitted at the arrival of a fresh localisation while the operator's consent to follow lasts,
//! at each renewal of a nudge, and at the arrival of a picture while the consent to a search or a calibration
//! lasts. That consent ends where no picture permitted motion for the time to rest. Nothing permits motion
//! while no guard carries out what the program asks for. After a fault of the line the time counts from the
//! line's return, after the death of a guard and after the beginning of its hang from that, after a
//! suspension from the end of it.

use super::permitted::Permitted;

/// Which licence a run moved the camera with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Licence {
    Follow,
    Nudge,
    Search,
    Calibrate,
}

impl Licence {
    /// Every licence that an operator can ask for. A further one is added here and in the script of
    /// [`super::run`].
    pub(super) const ALL: [Self; 4] = [Self::Follow, Self::Nudge, Self::Search, Self::Calibrate];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Follow => "follow",
            Self::Nudge => "nudge",
            Self::Search => "search",
            Self::Calibrate => "calibrate",
        }
    }
}

/// The judge of one run.
#[derive(Debug)]
pub(super) struct Oracle {
    /// The longest time to rest, ms.
    rest_limit_ms: u64,
    consent: Option<Licence>,
    permitted: Permitted,
    /// The newest moment from which the time to rest counts at the earliest.
    excused_until_ms: u64,
    worst_ms: u64,
    moved: Vec<Licence>,
    violation: Option<(u64, String)>,
}

impl Oracle {
    pub(super) const fn new(rest_limit_ms: u64) -> Self {
        Self {
            rest_limit_ms,
            consent: None,
            permitted: Permitted::new(),
            excused_until_ms: 0,
            worst_ms: 0,
            moved: Vec::new(),
            violation: None,
        }
    }

    /// Whether a guard carries out what the program asks for.
    pub(super) fn set_live_guard(&mut self, is_live: bool) {
        self.permitted.set_live_guard(is_live);
    }

    /// The operator consents.
    pub(super) fn consent(&mut self, licence: Licence) {
        self.consent = Some(licence);
    }

    /// The consent ends.
    pub(super) fn withdraw(&mut self) {
        self.consent = None;
    }

    /// The operator consents to a search or a calibration, which is a moment that permits motion.
    pub(super) fn consent_to_behaviour(&mut self, licence: Licence, at_ms: u64) {
        self.consent(licence);
        self.permitted.permit(at_ms);
    }

    /// The consent to a search or a calibration ends; that to follow lasts.
    pub(super) fn end_behaviours(&mut self) {
        self.consent = self.consent.filter(|licence| matches!(licence, Licence::Follow | Licence::Nudge));
    }

    /// A picture arrived, with a fresh localisation or without.
    pub(super) fn saw(&mut self, at_ms: u64, is_fresh: bool) {
        match self.consent {
            Some(Licence::Follow) if is_fresh => self.permitted.permit(at_ms),
            Some(Licence::Search | Licence::Calibrate) => {
                let before_ms = self.permitted.newest_ms();
                if before_ms.is_some_and(|before_ms| at_ms - before_ms <= self.rest_limit_ms) {
                    self.permitted.permit(at_ms);
                } else {
                    self.end_behaviours();
                }
            }
            _ => {}
        }
    }

    /// A nudge was renewed.
    pub(super) fn nudged(&mut self, at_ms: u64) {
        if self.consent == Some(Licence::Nudge) {
            self.permitted.permit(at_ms);
        }
    }

    /// The time to rest counts from here at the earliest.
    pub(super) fn excuse(&mut self, at_ms: u64) {
        self.excused_until_ms = self.excused_until_ms.max(at_ms);
    }

    /// A command came to a camera that another commander has had for this time.
    pub(super) fn meddles(&mut self, at_ms: u64, after_ms: u64) {
        let text = format!("commands a camera that another commander has had for {after_ms} ms");
        self.violation.get_or_insert((at_ms, text));
    }

    /// The camera turns fast, zero is commanded, and the vehicle's reports arrive, for this time, without a
    /// word to the operator.
    pub(super) fn is_silent_about_motion(&mut self, at_ms: u64, for_ms: u64) {
        let text =
            format!("has turned for {for_ms} ms although zero is commanded, and the operator is not told");
        self.violation.get_or_insert((at_ms, text));
    }

    /// The operator is told of motion though the camera has been at rest for this time.
    pub(super) fn tells_of_no_motion(&mut self, at_ms: u64, for_ms: u64) {
        let text = format!("tells of a camera that turns, which has been at rest for {for_ms} ms");
        self.violation.get_or_insert((at_ms, text));
    }

    /// Judges a millisecond.
    pub(super) fn judge(&mut self, at_ms: u64, is_moving: bool) {
        if !is_moving {
            return;
        }
        if let Some(licence) = self.consent
            && !self.moved.contains(&licence)
        {
            self.moved.push(licence);
        }
        let Some(permitted_ms) = self.permitted.heard_ms() else {
            self.violation.get_or_insert((at_ms, "moves without ever a licence".to_owned()));
            return;
        };
        let since_ms = at_ms.saturating_sub(permitted_ms.max(self.excused_until_ms));
        self.worst_ms = self.worst_ms.max(since_ms);
        if since_ms > self.rest_limit_ms {
            let text = format!("still moves {since_ms} ms after the last moment that permitted it");
            self.violation.get_or_insert((at_ms, text));
        }
    }

    /// The longest time that the camera moved after the last moment that permitted it, ms.
    pub(super) const fn worst_ms(&self) -> u64 {
        self.worst_ms
    }

    /// The licences with which the camera moved.
    pub(super) fn moved(&self) -> &[Licence] {
        &self.moved
    }

    /// The first violation of the rule: when, and how.
    pub(super) const fn violation(&self) -> Option<&(u64, String)> {
        self.violation.as_ref()
    }
}
