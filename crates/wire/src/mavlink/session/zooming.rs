//! The zoom of the vehicle's camera: what is sent of it beside the rates of the gimbal.
//!
//! A speed is sent with each message of rates. A camera keeps the last speed, as the gimbal does: zeros are sent until enough
//! of them have been answered. Afterwards nothing is sent, since another client may zoom.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::{Address, ComponentId, SystemId};

use crate::mavlink::command::Command;

/// Zeros that have to be answered.
const ANSWERS: u8 = 3;
/// An answer that comes earlier after a speed may be that to the speed.
const ANSWER_AFTER: Duration = Duration::from_secs(1);

/// The zoom of a camera; nothing is sent where there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zooming {
    camera: Option<ComponentId>,
    /// When a speed other than zero was sent last.
    moved_at: Option<Timestamp>,
    /// Zeros that have not been answered yet.
    unanswered: u8,
}

impl Zooming {
    /// What moves the zoom is not known.
    pub(super) const fn new(camera: Option<ComponentId>) -> Self {
        Self { camera, moved_at: None, unanswered: ANSWERS }
    }

    /// The camera of a vehicle.
    pub(super) fn camera_of(self, system: SystemId) -> Option<Address> {
        self.camera.map(|component| Address { system, component })
    }

    /// The control begins: zeros first.
    pub(super) const fn begin_with_zeros(&mut self) {
        self.unanswered = ANSWERS;
    }

    /// The command beside rates whose zoom has this speed.
    pub(super) fn due(&mut self, system: SystemId, speed: f64, now: Timestamp) -> Option<Command> {
        if speed != 0.0 {
            (self.moved_at, self.unanswered) = (Some(now), ANSWERS);
        }
        self.command(system, speed).filter(|_| self.unanswered > 0)
    }

    /// A command to zoom was answered.
    pub(super) fn on_answer(&mut self, now: Timestamp) {
        if self.moved_at.is_none_or(|at| now.since(at) >= ANSWER_AFTER) {
            self.unanswered = self.unanswered.saturating_sub(1);
        }
    }

    /// A zero.
    pub(super) fn zero(self, system: SystemId) -> Option<Command> {
        self.command(system, 0.0)
    }

    fn command(self, system: SystemId, speed: f64) -> Option<Command> {
        self.camera_of(system).map(|camera| Command::Zoom { camera, speed })
    }
}
