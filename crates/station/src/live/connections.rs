//! The connections to a video: how often it was lost, and why.

/// Most reasons of one loss that are logged: a text may differ with each attempt.
const MAX_REASONS: usize = 8;

/// The connections to a video so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Connections {
    pub(super) has_been_up: bool,
    /// Failed attempts to connect since the video was last up.
    pub(super) failed: u64,
    /// The reasons that were logged since then.
    reasons: Vec<String>,
}

impl Connections {
    /// Counts a failed attempt. Returns whether its reason is logged: not again, while the video stays lost.
    pub(super) fn on_lost(&mut self, reason: &str) -> bool {
        self.failed += 1;
        let is_new = self.reasons.len() < MAX_REASONS && !self.reasons.iter().any(|told| told == reason);
        if is_new {
            self.reasons.push(reason.to_owned());
        }
        is_new
    }

    /// Returns the number of attempts that failed before.
    pub(super) fn on_up(&mut self) -> u64 {
        self.has_been_up = true;
        self.reasons.clear();
        std::mem::take(&mut self.failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reason_of_a_loss_is_logged_once() {
        let mut connections = Connections::default();
        let logged =
            ["silence", "silence", "refused", "silence", "refused"].map(|reason| connections.on_lost(reason));
        assert_eq!(logged, [true, false, true, false, false]);
        assert_eq!(connections.on_up(), 5);
        assert!(connections.on_lost("silence"));
    }

    #[test]
    fn reasons_that_differ_each_time_do_not_fill_the_log() {
        let mut connections = Connections::default();
        let logged = (0..100).filter(|attempt| connections.on_lost(&format!("port {attempt}"))).count();
        assert_eq!(logged, MAX_REASONS);
    }
}
