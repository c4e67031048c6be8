//! The helm of the console: a position that a page must renew, or it goes back to neutral.

use std::time::Duration;

use barrelman_experiments::drive::DriveInput;
use barrelman_vocab::Timestamp;

/// A helm that is not renewed for this long goes back to neutral.
const HELM_TIMEOUT: Duration = Duration::from_millis(500);
/// No throttle, rudder amidships.
const NEUTRAL: DriveInput = DriveInput::Helm { thrust: 0, rudder: 0 };

/// The helm as the page set it last.
#[derive(Debug, Default)]
pub(super) struct RenewedHelm {
    /// The position, and when it was set or renewed; `None` while the scenario's helmsman steers.
    set: Option<(DriveInput, Timestamp)>,
}

impl RenewedHelm {
    /// Sets or renews the position. Returns whether the position is new.
    pub(super) fn set(&mut self, helm: DriveInput, now: Timestamp) -> bool {
        let is_new = self.set.is_none_or(|(before, _)| before != helm);
        self.set = Some((helm, now));
        is_new
    }

    /// Returns control to the scenario's helmsman.
    pub(super) fn release(&mut self) {
        self.set = None;
    }

    /// Goes back to neutral when the position was not renewed in time. Returns the neutral helm, once.
    pub(super) fn expire(&mut self, now: Timestamp) -> Option<DriveInput> {
        let (helm, since) = self.set?;
        if helm == NEUTRAL || now.since(since) <= HELM_TIMEOUT {
            return None;
        }
        self.set = Some((NEUTRAL, since));
        Some(NEUTRAL)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: DriveInput = DriveInput::Helm { thrust: 100, rudder: 0 };

    fn at(ms: u64) -> Timestamp {
        Timestamp::from_nanos(ms * 1_000_000)
    }

    #[test]
    fn a_helm_that_is_renewed_is_kept_and_is_not_new() {
        let mut helm = RenewedHelm::default();
        assert!(helm.set(AHEAD, at(0)));
        assert!(!helm.set(AHEAD, at(400)));
        assert_eq!(helm.expire(at(900)), None);
    }

    #[test]
    fn a_helm_that_is_not_renewed_goes_back_to_neutral_once() {
        let mut helm = RenewedHelm::default();
        helm.set(AHEAD, at(0));
        assert_eq!(helm.expire(at(501)), Some(NEUTRAL));
        assert_eq!(helm.expire(at(2000)), None);
        assert!(helm.set(AHEAD, at(2100)));
    }

    #[test]
    fn a_helm_that_was_released_does_not_expire() {
        let mut helm = RenewedHelm::default();
        helm.set(AHEAD, at(0));
        helm.release();
        assert_eq!(helm.expire(at(2000)), None);
    }
}
