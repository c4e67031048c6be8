//! A law whose pictures carry a wrong time of capture: the arrival less a latency that is assumed.

use core::time::Duration;

use barrelman_control::{CameraModel, Law, LawInput};
use barrelman_vocab::{CameraCommand, Timestamp};

/// The law, with the newest picture's true and assumed times of capture.
pub(super) struct AssumedLatency<L> {
    law: L,
    latency: Duration,
    newest: Option<[Timestamp; 2]>,
}

impl<L: Law> AssumedLatency<L> {
    /// A law that takes pictures to be `latency_s` seconds old on arrival.
    pub(super) fn new(law: L, latency_s: f64) -> Self {
        Self { law, latency: Duration::from_secs_f64(latency_s), newest: None }
    }

    /// The assumed time of capture of the picture that was captured at `captured`, now.
    fn assumed(&mut self, captured: Timestamp, now: Timestamp) -> Timestamp {
        match self.newest {
            Some([newest, assumed]) if newest == captured => assumed,
            _ => {
                let assumed = now.minus(self.latency);
                self.newest = Some([captured, assumed]);
                assumed
            }
        }
    }
}

impl<L: Law> Law for AssumedLatency<L> {
    fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        let captured = self.assumed(input.captured, input.now);
        self.law.command(&LawInput { captured, ..*input }, camera)
    }

    fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        self.law.on_command_applied(command, now);
    }

    fn reset_target(&mut self) {
        self.newest = None;
        self.law.reset_target();
    }
}

#[cfg(test)]
mod tests {
    use barrelman_control::{CentringGains, centring::Centring};
    use barrelman_vocab::VehicleProfile;

    use super::*;

    #[test]
    fn a_picture_keeps_the_time_that_was_assumed_when_it_arrived() {
        let at = Timestamp::from_secs_f64;
        let centring = Centring::new(CentringGains::HAND_TUNED, VehicleProfile::fotokite_pro().limits);
        let mut law = AssumedLatency::new(centring, 0.25);
        assert_eq!(law.assumed(at(0.5), at(1.0)), at(0.75));
        assert_eq!(law.assumed(at(0.5), at(1.5)), at(0.75));
        assert_eq!(law.assumed(at(0.75), at(2.0)), at(1.75));
    }
}
