//! The pilot's part of what turns the vehicle: the net yaw, and motion against the command.

use barrelman_vocab::{CameraCommand, Timestamp, VideoFrame};

use super::Pilot;
use crate::opposed_motion::FrameShift;
use crate::purpose::Purpose;

impl Pilot {
    /// The pan of the camera model at a time, radians.
    pub(super) fn pan_at(&self, at: Timestamp) -> f64 {
        self.law.camera().angles_at(at).0
    }

    /// The command without a pan that winds up the tether beyond the limit.
    pub(super) fn within_net_yaw(&self, command: CameraCommand, now: Timestamp) -> CameraCommand {
        self.net_yaw.limited(command, self.pan_at(now))
    }

    /// Compares the shift of the background in a tracked frame with the commands.
    pub(super) fn check_motion(&mut self, frame: &VideoFrame) {
        let may_turn = !matches!(self.safety.held(), None | Some(Purpose::Calibrate));
        if !may_turn {
            self.opposed_motion.clear();
        }
        let Some((shift, from)) = self.tracker.background_shift().zip(self.last_capture) else { return };
        let seen = FrameShift { shift, picture: frame.picture.size(), from, to: frame.capture.at };
        self.opposed_motion.observe_rest(&seen, self.law.camera());
        if !may_turn {
            return;
        }
        if let Some(cause) = self.opposed_motion.add(&seen, self.law.camera()) {
            self.safety.on_opposed_motion(cause);
            self.opposed_motion.clear();
        }
    }
}
