//! Input and output of a guidance step over the water plane.

use barrelman_vocab::{Angle, Timestamp, VesselCommand, VesselLimits, WaterCovariance, WaterFix, WaterPoint};

/// Input of one step. All points are in one water frame, at the time of the newest video frame.
#[derive(Debug, Clone, Copy)]
pub struct GuidanceInput<'a> {
    /// Present time.
    pub now: Timestamp,
    /// The boat in the newest video frame; `None` if it was not measured. A fix that is given again is
    /// ignored.
    pub fix: Option<BoatFix>,
    /// Where the boat shall go; `None`: nowhere.
    pub destination: Option<Destination>,
    /// Number of the operator's selection: a change starts a new route from where the boat is, with all
    /// way-points. A destination that is moved is told by [`super::LineOfSight::move_destination`].
    pub route: u32,
    /// Points to pass before the destination, in their order.
    pub way_points: &'a [WaterPoint],
    /// Circles that the boat must not enter: all persons but the destination, and forbidden areas.
    pub keep_outs: &'a [KeepOut],
    /// Limits of the commands.
    pub limits: VesselLimits,
}

/// A measurement of the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoatFix {
    /// Time of capture of the video frame.
    pub captured: Timestamp,
    /// Where the boat is.
    pub water: WaterFix,
    /// Where the bow points, and the standard deviation; `None` if unknown.
    pub heading: Option<(Angle, Angle)>,
    /// Whether the vessel does what this law's commands say: nothing else steers it.
    pub is_commanded: bool,
    /// How fast the covariance of the camera's apparent displacement grows, m²/s: its sway, and what its
    /// model does not know; `None`: the camera is where its model says.
    pub sway_per_s: Option<WaterCovariance>,
}

/// Where the boat shall go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Destination {
    /// A place: the boat stops there.
    Place(WaterPoint),
    /// A person: the boat stops before the stand-off.
    Person {
        /// Where the person is.
        at: WaterPoint,
        /// How the person drifts along x and y, m/s.
        velocity_m_per_s: (f64, f64),
        /// Distance that the boat keeps, metres.
        stand_off_m: f64,
        /// How far the person may be from there, metres; added to the stand-off.
        uncertainty_m: f64,
    },
}

impl Destination {
    /// The point itself.
    pub const fn point(self) -> WaterPoint {
        match self {
            Self::Place(point) | Self::Person { at: point, .. } => point,
        }
    }
}

/// A circle that the boat must not enter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeepOut {
    /// Centre.
    pub centre: WaterPoint,
    /// Radius, metres, with the uncertainty of the centre.
    pub radius_m: f64,
}

/// What the law is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GuidanceState {
    /// There is no destination: neutral.
    NoDestination,
    /// The boat was not measured lately: neutral.
    NoFix,
    /// The heading is unknown: straight on, gently.
    GettingWay,
    /// Along the line.
    UnderWay,
    /// Around a circle.
    Avoiding,
    /// No way leads past the circles, or the destination lies in one: stopped before it.
    Blocked,
    /// At the destination, or within the radius in which the boat may drift there.
    Holding,
    /// Stopped before the stand-off of the person.
    StandingOff,
}

/// Where the boat is on its way, at the present time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The boat.
    pub boat: WaterPoint,
    /// Speed over ground, m/s.
    pub speed_m_per_s: f64,
    /// Course over ground; the heading while the boat is too slow for a course; `None` while both are
    /// unknown.
    pub course: Option<Angle>,
    /// Distance to the destination, metres.
    pub distance_m: f64,
    /// Distance from the line, metres, positive to the right of it.
    pub cross_track_m: f64,
    /// Number of the next way-point; the number of way-points on the last leg.
    pub leg: usize,
}

/// Output of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuidanceStep {
    /// The command.
    pub command: VesselCommand,
    /// What the law is doing.
    pub state: GuidanceState,
    /// Where the boat is; `None` without a fix or a destination.
    pub progress: Option<Progress>,
}
