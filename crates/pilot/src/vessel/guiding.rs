//! The guidance of the boat: which law steers, and what the law is told.
//!
//! The line-of-sight law steers over the water. Where height or tilt of the camera are not known, the
//! laboratory's law steers in the picture instead ([`GuidanceBasis::Picture`]): it knows no distances, no
//! current and no circles.

use barrelman_control::guidance::input::Progress;
use barrelman_control::guidance::{
    BoatFix, GuidanceInput, GuidanceState, KeepOut, LabBranch, LabInput, LabLaw, LabSettings, LineOfSight,
    LineOfSightTuning, VesselModel,
};
use barrelman_vocab::{
    FailSafe, Localisation, MarkKind, Timestamp, VesselCommand, VesselProfile, WaterPoint,
};

use super::frame_view::FrameView;
use super::gate::{GUIDED_LASTS, VesselHold};
use super::marks::{MAX_MARKS, Marks};

pub use super::no_water::{GO_AGAIN, NoWater};

/// In the picture, the boat stops this many of its own lengths before a person: a boat of 1.2 m and a
/// stand-off of 2 m, with room to stop.
const PERSON_LENGTHS: f64 = 3.5;

/// From neutral to rest a boat goes about as far as in this time at its speed: the lags of thrust and speed,
/// and some more.
const RUN_OUT_S: f64 = 2.5;

/// The law that guides the boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum GuidanceLaw {
    /// Along a line over the water.
    #[default]
    LineOfSight,
    /// The law of the paper's laboratory, in the picture.
    Laboratory,
    /// None: the boat is steered by hand alone.
    ByHand,
}

/// In which coordinates the boat is guided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GuidanceBasis {
    /// Over the water, with distances.
    Water,
    /// In the picture, without distances.
    Picture,
}

/// What the guidance did in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guidance {
    /// In which coordinates.
    pub basis: GuidanceBasis,
    /// What the law is doing.
    pub state: GuidanceState,
    /// Where the boat is on its way; `None` without distances.
    pub progress: Option<Progress>,
}

/// The law with its state.
#[derive(Debug, Clone)]
pub struct Guide {
    law: GuidanceLaw,
    line_of_sight: LineOfSight,
    laboratory: LabLaw,
    newest: Option<Guidance>,
    has_room: bool,
}

/// What the guidance is told of the view of a video frame.
#[derive(Debug, Clone, Copy)]
pub struct GuideView<'a> {
    /// The camera, where its model says.
    pub camera: &'a FrameView,
    /// Whether nothing but this program steers the boat.
    pub is_commanded: bool,
}

impl Guide {
    /// A law without observations.
    pub fn new(law: GuidanceLaw) -> Self {
        Self {
            law,
            line_of_sight: LineOfSight::new(LineOfSightTuning::DEFAULT, VesselModel::JET),
            laboratory: LabLaw::new(LabSettings::PAPER),
            newest: None,
            has_room: false,
        }
    }

    /// The law.
    pub const fn law(&self) -> GuidanceLaw {
        self.law
    }

    /// Another boat was selected.
    pub fn reset_boat(&mut self) {
        self.line_of_sight.reset_boat();
        self.laboratory.reset();
        self.newest = None;
        self.has_room = false;
    }

    /// The guidance is engaged: an answer of the boat to its commands is expected from now on.
    pub fn expect_answer(&mut self) {
        self.line_of_sight.expect_answer();
    }

    /// Whether what is followed did not move as the commanded boat would have. Only over the water: in the
    /// picture, no distances are known.
    pub fn is_unanswered(&self) -> bool {
        matches!(self.newest, Some(Guidance { basis: GuidanceBasis::Water, .. }))
            && self.line_of_sight.is_unanswered()
    }

    /// A command is in force from `now` on.
    pub fn on_command_applied(&mut self, command: VesselCommand, now: Timestamp) {
        self.line_of_sight.on_command_applied(command, now);
    }

    /// What the guidance did last; `None` before a destination.
    pub const fn newest(&self) -> Option<Guidance> {
        self.newest
    }

    /// Whether the boat had room to keep way at the last fresh localisation: it was under way over the water,
    /// and so far from all marks that it cannot reach a circle or the destination with the way that its
    /// profile lets it keep.
    pub const fn has_room(&self) -> bool {
        self.has_room
    }

    fn finds_room(&self, marks: &Marks, profile: &VesselProfile, now: Timestamp) -> bool {
        let (
            FailSafe::KeepWay(keep),
            Some(Guidance { state: GuidanceState::UnderWay, progress: Some(progress), .. }),
        ) = (profile.fail_safe, self.newest)
        else {
            return false;
        };
        let speed = progress.speed_m_per_s.max(VesselModel::JET.speed_per_throttle * keep.throttle);
        let time_s = (GUIDED_LASTS + keep.lasts).as_secs_f64() + RUN_OUT_S;
        marks.are_beyond(progress.boat, speed * time_s, profile, now)
    }

    /// The destination is moved now.
    pub const fn move_destination(&mut self) {
        self.line_of_sight.move_destination();
    }

    /// A mark is set or moved now.
    pub fn anchor(&mut self) {
        self.line_of_sight.anchor();
    }

    /// The camera's apparent displacement at a time of capture.
    pub fn displacement_at(&self, captured: Timestamp) -> WaterPoint {
        self.line_of_sight.track().displacement_at(captured)
    }

    /// Whether a boat that is commanded went ahead at a time of capture.
    pub fn went_ahead_at(&self, captured: Timestamp) -> bool {
        self.line_of_sight.track().went_ahead_at(captured)
    }

    /// The command for a fresh localisation of the boat.
    pub fn step(
        &mut self,
        seen: &Localisation,
        guide_view: GuideView<'_>,
        marks: &Marks,
        profile: &VesselProfile,
        now: Timestamp,
    ) -> Result<VesselCommand, VesselHold> {
        let GuideView { camera: frame_view, is_commanded } = guide_view;
        let is_over_water = self.law == GuidanceLaw::LineOfSight && frame_view.sees_water;
        if is_over_water && marks.have_unplaced(profile) {
            (self.newest, self.has_room) = (None, false);
            return Err(VesselHold::UnplacedMark);
        }
        let (command, guidance) = if is_over_water {
            self.step_over_water(frame_view.boat(seen, is_commanded), marks, profile, now)
        } else {
            self.step_in_picture(seen, frame_view, marks, now)
        };
        self.newest = Some(guidance);
        self.has_room = self.finds_room(marks, profile, now);
        match guidance.state {
            // There is a destination, but the camera has turned away from it.
            GuidanceState::NoDestination if marks.destination().is_some() => Err(VesselHold::NoPlace),
            GuidanceState::NoDestination => Err(VesselHold::NoDestination),
            GuidanceState::NoFix => Err(VesselHold::NoPlace),
            _ => Ok(command),
        }
    }

    fn step_over_water(
        &mut self,
        fix: Option<BoatFix>,
        marks: &Marks,
        profile: &VesselProfile,
        now: Timestamp,
    ) -> (VesselCommand, Guidance) {
        let mut way_points = [WaterPoint::default(); MAX_MARKS];
        let mut circles = [KeepOut { centre: WaterPoint::default(), radius_m: 0.0 }; MAX_MARKS];
        let way_points_set = marks.way_points(now, &mut way_points);
        let circles_set = marks.keep_outs(profile, now, &mut circles);
        let step = self.line_of_sight.step(&GuidanceInput {
            now,
            fix,
            destination: marks.water_destination(profile, now),
            route: marks.route(),
            way_points: &way_points[..way_points_set],
            keep_outs: &circles[..circles_set],
            limits: profile.limits,
        });
        let guidance = Guidance { basis: GuidanceBasis::Water, state: step.state, progress: step.progress };
        (step.command, guidance)
    }

    fn step_in_picture(
        &mut self,
        seen: &Localisation,
        frame_view: &FrameView,
        marks: &Marks,
        now: Timestamp,
    ) -> (VesselCommand, Guidance) {
        let mark = marks.destination();
        let target = mark.and_then(|mark| mark.pixel(frame_view, now));
        let boat = seen.bounds.centre();
        let (command, branch) = self.laboratory.step(&LabInput { now, boat: Some(boat), target });
        let state = match branch {
            LabBranch::Idle => GuidanceState::NoDestination,
            LabBranch::UnknownHeading => GuidanceState::GettingWay,
            LabBranch::Turning | LabBranch::Cruising => GuidanceState::UnderWay,
            LabBranch::Reached => GuidanceState::Holding,
        };
        let guidance = Guidance { basis: GuidanceBasis::Picture, state, progress: None };
        // The laboratory's law knows no people: the boat stops some of its lengths before one.
        let length_px = seen.shape.map_or(seen.bounds.w.max(seen.bounds.h), |shape| shape.major_px);
        let is_near_person = mark.is_some_and(|mark| mark.kind == MarkKind::Person)
            && target.is_some_and(|target| {
                libm::hypot(target.u - boat.u, target.v - boat.v) < PERSON_LENGTHS * length_px
            });
        if is_near_person {
            return (VesselCommand::NEUTRAL, Guidance { state: GuidanceState::StandingOff, ..guidance });
        }
        (command, guidance)
    }
}
