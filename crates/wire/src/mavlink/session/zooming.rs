//! The zoom of the vehicle's camera: what is sent of it beside the rates of the gimbal.
//!
//! A camera that has told that it zooms is sent a speed with each message of rates, and one that has not told
//! anything zeros alone. A camera keeps the last speed, as the gimbal does, also that of a session before:
//! zeros are sent until enough of them have been answered. Afterwards nothing is sent, since another client
//! may zoom.

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, ComponentId, SystemId};
use barrelman_vocab::{Timestamp, ZoomAbility};
use mavlink::dialects::common::COMMAND_LONG_DATA;

use crate::mavlink::camera_information::CameraInformation;
use crate::mavlink::command::{Command, Wanted};
use crate::mavlink::session_times::{CAMERA_INTERVAL, FIELD_OF_VIEW_INTERVAL};
use crate::mavlink::subscription::Subscription;

/// Zeros that have to be answered.
const ANSWERS: u8 = 3;
/// An answer that comes earlier after a speed may be that to the speed.
const ANSWER_AFTER: Duration = Duration::from_secs(1);

/// The zoom of a camera; nothing is sent where there is none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Zooming {
    camera: Option<ComponentId>,
    ability: ZoomAbility,
    /// What the camera is.
    information: Subscription,
    field_of_view: Subscription,
    /// When a speed other than zero was sent last.
    moved_at: Option<Timestamp>,
    /// Zeros that have not been answered yet.
    unanswered: u8,
}

impl Zooming {
    /// What moves the zoom is not known.
    pub(super) const fn new(camera: Option<ComponentId>) -> Self {
        Self {
            camera,
            ability: ZoomAbility::NotKnown,
            information: Subscription::by_requests(Wanted::CameraInformation.id(), CAMERA_INTERVAL),
            field_of_view: Subscription::new(Wanted::FieldOfView.id(), FIELD_OF_VIEW_INTERVAL),
            moved_at: None,
            unanswered: ANSWERS,
        }
    }

    fn camera_of(&self, system: SystemId) -> Option<Address> {
        self.camera.map(|component| Address { system, component })
    }

    /// The requests to the camera of a vehicle that are due: what it is, and its field of view.
    pub(super) fn requests(&mut self, system: SystemId, now: Timestamp) -> [Option<COMMAND_LONG_DATA>; 2] {
        let Some(camera) = self.camera_of(system) else { return [None, None] };
        let zooms = self.ability == ZoomAbility::Present;
        let field_of_view = zooms.then(|| self.field_of_view.due(camera, now)).flatten();
        [self.information.due(camera, now), field_of_view]
    }

    /// A camera says what it is: the one of this system, or another one.
    pub(super) fn on_information(
        &mut self,
        information: CameraInformation,
        system: SystemId,
        now: Timestamp,
    ) {
        if self.camera_of(system) == Some(information.camera) {
            self.information.on_heard(now);
            self.ability = information.zoom;
        }
    }

    /// The camera says how much it sees.
    pub(super) fn on_field_of_view(&mut self, now: Timestamp) {
        self.field_of_view.on_heard(now);
    }

    /// The control begins: zeros first.
    pub(super) const fn begin_with_zeros(&mut self) {
        self.unanswered = ANSWERS;
    }

    /// The command beside rates whose zoom has this speed.
    pub(super) fn due(&mut self, system: SystemId, speed: f64, now: Timestamp) -> Option<Command> {
        let speed = match self.ability {
            ZoomAbility::Absent if !self.may_zoom() => return None,
            // Zeros alone: a session before may have left the camera zooming.
            ZoomAbility::Absent | ZoomAbility::NotKnown => 0.0,
            ZoomAbility::Present => speed,
        };
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

    /// A zero, to a camera that may zoom.
    pub(super) fn zero(&self, system: SystemId) -> Option<Command> {
        self.command(system, 0.0).filter(|_| self.may_zoom())
    }

    /// Whether the camera may be zooming. A camera that says that it has no zoom may, too, where it was sent
    /// a speed.
    fn may_zoom(&self) -> bool {
        self.ability != ZoomAbility::Absent || self.moved_at.is_some() && self.unanswered > 0
    }

    fn command(&self, system: SystemId, speed: f64) -> Option<Command> {
        self.camera_of(system).map(|camera| Command::Zoom { camera, speed })
    }
}
