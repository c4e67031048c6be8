//! A gimbal that takes the place of the one that was chosen.
//!
//! Managers of several gimbals speak of one after the other, and packets get lost. So the chosen device
//! counts as exchanged where its manager has spoken of others alone for [`EXCHANGED_AFTER_S`], by the
//! vehicle's clock.

use barrelman_vocab::telemetry::ControlState;

use super::{Facts, Received};
use crate::mavlink::command::Gimbal;

/// How long a manager may leave the chosen device out, seconds: it is asked for its status every second.
const EXCHANGED_AFTER_S: f64 = 3.0;

impl Facts {
    /// A manager speaks of a gimbal at a time of the vehicle's clock. Returns the chosen one, if it is that.
    pub(super) fn spoken_of(
        &mut self,
        gimbal: Gimbal,
        at_s: f64,
        each: &mut impl FnMut(Received),
    ) -> Option<Gimbal> {
        let known = self.known(gimbal, each);
        if known.is_some() {
            self.device_heard_s = at_s;
        } else if at_s - self.device_heard_s >= EXCHANGED_AFTER_S {
            self.on_other_device(gimbal, each);
        }
        known
    }

    fn on_other_device(&mut self, other: Gimbal, each: &mut impl FnMut(Received)) {
        match self.gimbal {
            Some(chosen) if chosen.manager == other.manager => {
                self.gimbal = None;
                self.choice.begin_anew(self.peers.device);
                // Told with the next status: it was not another commander.
                self.lose_control(ControlState::Unclaimed);
                each(Received::Restarted);
            }
            Some(_) => {}
            // After a restart, the device of before is not there any more.
            None => self.choice.no_longer_want(self.peers.device),
        }
    }
}
