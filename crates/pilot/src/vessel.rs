//! The pilot's second actuator: a boat that is steered by hand from the video, or goes to a mark by itself.
//!
//! ```text
//!   localisation --> FrameView --> Guide --> VesselGate --> command
//!   marks ------------^                    ^
//!   helm that is held ---------------------+
//! ```
//!
//! What must not be here: anything that moves the camera, and a second place that decides whether the boat
//! may be commanded: only [`gate`] decides it.

use core::time::Duration;

use barrelman_control::CameraModel;
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{
    HoldCause, Localisation, MarkKind, PictureSize, PixelPoint, StopCause, Telemetry, Timestamp,
    VesselCommand, VesselProfile, WaterPoint,
};

use crate::object_trackers::ObjectTrackers;
use crate::vehicle::CommandPath;

pub mod gate;
pub mod no_water;
pub mod said;

pub mod guiding;
pub mod marks;

pub mod frame_view;

pub mod unasked_speed;

mod requests;

pub use frame_view::FrameView;
pub use gate::{VesselHold, VesselMode, VesselStop};
pub use guiding::{Guidance, GuidanceBasis, GuidanceLaw};
pub use marks::{Mark, Marks};

use gate::{GateInput, VesselGate};
use guiding::{GO_AGAIN, Guide, GuideView, NoWater};
use marks::RouteChange;
use unasked_speed::UnaskedSpeed;

/// A reported height or tilt holds for this time.
pub const POSE_LASTS: Duration = Duration::from_secs(10);
/// Least height, metres: on the ground nothing is looked down on.
const LEAST_HEIGHT_M: f64 = 1.0;

/// Settings of the second actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselSettings {
    /// The vessel.
    pub profile: VesselProfile,
    /// The law that guides it.
    pub guidance: GuidanceLaw,
    /// Where its commands go.
    pub path: CommandPath,
}

/// The vessel's part of a step's outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselOutcome {
    /// The vessel.
    pub profile: VesselProfile,
    /// The mode.
    pub mode: VesselMode,
    /// The command in force from this step on.
    pub command: VesselCommand,
    /// Time by which the pilot renews the command.
    pub renew_by: Option<Timestamp>,
    /// Whether another Go would be accepted that was refused just now, as the boat would go in the picture.
    pub asks_go_again: bool,
    /// The speed of a boat that moves although neutral is commanded, m/s; `None`: no such motion is reported.
    pub unasked_speed_m_per_s: Option<f64>,
    /// What the guidance did last; `None`: nothing yet.
    pub guidance: Option<Guidance>,
    /// The operator's marks.
    pub marks: Marks,
    /// The camera of the newest video frame; `None` before the first.
    pub frame_view: Option<FrameView>,
}

impl VesselOutcome {
    /// Without a vessel.
    pub fn absent() -> Self {
        Self {
            profile: VesselProfile::SIMULATOR,
            mode: VesselMode::Absent,
            command: VesselCommand::NEUTRAL,
            renew_by: None,
            asks_go_again: false,
            unasked_speed_m_per_s: None,
            guidance: None,
            marks: Marks::default(),
            frame_view: None,
        }
    }

    /// Whether this program commands the boat.
    pub const fn is_commanded(&self) -> bool {
        !matches!(self.mode, VesselMode::Absent | VesselMode::Released)
    }
}

/// What a step tells the vessel's part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VesselView<'a> {
    pub(crate) camera: &'a CameraModel,
    pub(crate) now: Timestamp,
}

/// What a step observed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Observed<'a> {
    /// A fresh localisation of the boat.
    Boat(&'a Localisation),
    /// Video, without a fresh localisation.
    NoBoat(HoldCause),
    /// No observation.
    Nothing,
}

/// What the operator has to know of a request about the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum VesselNotice {
    /// The mark of this number was set.
    Marked(u32, MarkKind),
    /// The boat goes: over the water, or, for this reason, in the picture.
    Going(Option<NoWater>),
}

/// The second actuator with its state.
#[derive(Debug, Clone)]
pub struct VesselPilot {
    profile: VesselProfile,
    gate: VesselGate,
    unasked_speed: UnaskedSpeed,
    guide: Guide,
    marks: Marks,
    height: Option<(f64, Timestamp)>,
    /// Whether the operator has confirmed a guidance in the picture, which keeps out of no circles.
    goes_without_circles: bool,
    /// When a Go was refused that would have gone in the picture.
    gone_in_picture_at: Option<Timestamp>,
    tilt_reported_at: Option<Timestamp>,
    frame_view: Option<FrameView>,
}

impl VesselPilot {
    /// A vessel that is not commanded yet.
    pub fn new(settings: VesselSettings) -> Self {
        let VesselSettings { profile, guidance, path } = settings;
        Self {
            gate: VesselGate::new(profile, path),
            unasked_speed: UnaskedSpeed::new(),
            profile,
            guide: Guide::new(guidance),
            marks: Marks::default(),
            height: None,
            goes_without_circles: false,
            gone_in_picture_at: None,
            tilt_reported_at: None,
            frame_view: None,
        }
    }

    /// The vessel.
    pub const fn profile(&self) -> &VesselProfile {
        &self.profile
    }

    /// The operator's marks, oldest first.
    pub(crate) fn marks(&self) -> impl Iterator<Item = &Mark> {
        self.marks.iter()
    }

    /// The pixel of the destination in the newest video frame, also outside of the picture.
    pub(crate) fn destination_in_picture(&self, now: Timestamp) -> Option<PixelPoint> {
        self.marks.destination()?.pixel(self.frame_view.as_ref()?, now)
    }

    /// Another boat was selected: the guidance of the previous one ends.
    pub(crate) fn begin_target(&mut self) {
        self.guide.reset_boat();
        self.gone_in_picture_at = None;
        if self.gate.is_guiding() {
            self.gate.stop(VesselStop::OtherBoat);
        }
    }

    /// Whether the boat may have gone bow first at a time of capture. A boat that this program does not
    /// command may always have.
    pub(crate) fn may_be_bow_first(&self, captured: Timestamp) -> bool {
        !self.gate.is_commanding() || self.guide.went_ahead_at(captured)
    }

    /// A video frame that is fresh has arrived.
    pub(crate) const fn on_video(&mut self, now: Timestamp) {
        self.gate.on_video(now);
    }

    /// What the camera's vehicle reports of its height and tilt.
    pub(crate) fn on_camera_report(&mut self, telemetry: &Telemetry) {
        if let Report::CameraTilt(_) = telemetry.report {
            self.tilt_reported_at = Some(telemetry.at);
        }
        if let Some(height_m) = telemetry.report.height_m().filter(|height_m| height_m.is_finite()) {
            self.height = Some((height_m, telemetry.at));
        }
    }

    /// A tilt was read from the gimbal's reported attitude.
    pub(crate) const fn on_tilt(&mut self, at: Timestamp) {
        self.tilt_reported_at = Some(at);
    }

    /// What the vessel or its link reports.
    pub(crate) fn on_vessel_report(&mut self, telemetry: &Telemetry) {
        self.gate.on_report(&telemetry.report);
        self.unasked_speed.on_report(&telemetry.report, telemetry.at);
    }

    /// Whether a further stop would change nothing.
    pub(crate) fn is_at_rest_by_stop(&self) -> bool {
        self.gate.is_at_rest_by_stop() && self.gone_in_picture_at.is_none()
    }

    /// Everything is stopped.
    pub(crate) const fn stop(&mut self, cause: StopCause) {
        self.gone_in_picture_at = None;
        self.gate.stop(VesselStop::Everything(cause));
    }

    /// Why the boat would be guided in the picture; `None`: it is guided over the water.
    fn no_water(&self, now: Timestamp) -> Option<NoWater> {
        let is_tilt_current = self.tilt_reported_at.is_some_and(|at| now.since(at) <= POSE_LASTS);
        match (self.guide.law(), is_tilt_current, self.height_m(now)) {
            (GuidanceLaw::Laboratory | GuidanceLaw::ByHand, ..) => Some(NoWater::Law),
            (GuidanceLaw::LineOfSight, false, _) => Some(NoWater::NoTilt),
            (GuidanceLaw::LineOfSight, true, None) => Some(NoWater::NoHeight),
            (GuidanceLaw::LineOfSight, true, Some(_)) => None,
        }
    }

    /// Height of the camera, where height and tilt are known now.
    fn height_m(&self, now: Timestamp) -> Option<f64> {
        let is_current = |at: Timestamp| now.since(at) <= POSE_LASTS;
        let (height_m, _) =
            self.height.filter(|(height_m, at)| is_current(*at) && *height_m >= LEAST_HEIGHT_M)?;
        self.tilt_reported_at.filter(|at| is_current(*at)).map(|_| height_m)
    }

    fn frame_view_at(
        &self,
        captured: Timestamp,
        picture: PictureSize,
        view: VesselView<'_>,
        below: WaterPoint,
    ) -> FrameView {
        FrameView::new(view.camera, captured, picture, self.height_m(view.now), below)
    }

    /// Makes the vessel's part of a step.
    pub(crate) fn step(
        &mut self,
        observed: Observed<'_>,
        newest: Option<(Timestamp, PictureSize)>,
        mark_trackers: &mut ObjectTrackers,
        view: VesselView<'_>,
    ) -> VesselOutcome {
        let now = view.now;
        let sight = match (observed, newest) {
            (Observed::Boat(seen), Some((captured, picture))) => {
                let modelled = self.frame_view_at(captured, picture, view, WaterPoint::default());
                if !self.marks.are_placed() {
                    let below = self.guide.displacement_at(captured);
                    let frame_view = self.frame_view_at(captured, picture, view, below);
                    if self.marks.place_on_water(&frame_view) == RouteChange::DestinationMoved {
                        self.guide.move_destination();
                    }
                }
                let guide_view = GuideView { camera: &modelled, is_commanded: self.gate.is_commanding() };
                let advice = self.guide.step(seen, guide_view, &self.marks, &self.profile, now);
                self.gate.set_clear(self.guide.has_room());
                let needs_water = !self.goes_without_circles && self.marks.have_circles();
                let is_water_lost = self.no_water(now).is_some_and(|why| why != NoWater::Law);
                if needs_water && is_water_lost && self.gate.is_guiding() {
                    self.gate.stop(VesselStop::WaterLost);
                }
                if self.gate.is_guiding() && self.guide.is_unanswered() {
                    self.gate.stop(VesselStop::NoAnswer);
                }
                GateInput::Fresh(advice)
            }
            (Observed::NoBoat(cause), _) => GateInput::Unusable(cause),
            (Observed::Boat(_) | Observed::Nothing, _) => GateInput::NoObservation,
        };
        if let (Observed::Boat(_) | Observed::NoBoat(_), Some((captured, picture))) = (observed, newest) {
            let below = self.guide.displacement_at(captured);
            let frame_view = self.frame_view_at(captured, picture, view, below);
            self.frame_view = Some(frame_view);
            let boat = if let Observed::Boat(seen) = observed { Some(seen.bounds) } else { None };
            self.marks.take_sightings(mark_trackers, boat, &frame_view, captured);
        }
        let decision = self.gate.decide(sight, now);
        self.guide.on_command_applied(decision.command, now);
        let is_commanded = decision.mode != VesselMode::Released;
        self.unasked_speed.on_command(is_commanded.then_some(decision.command), now);
        VesselOutcome {
            profile: self.profile,
            mode: decision.mode,
            command: decision.command,
            renew_by: decision.renew_by,
            asks_go_again: self.gone_in_picture_at.is_some_and(|at| at <= now && now.since(at) <= GO_AGAIN),
            unasked_speed_m_per_s: self.unasked_speed.moving(),
            guidance: self.guide.newest(),
            marks: self.marks,
            frame_view: self.frame_view,
        }
    }
}
