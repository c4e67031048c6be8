//! Where boat and camera are in every frame of a clip.
//!
//! The boat moves over the water ([`super::boat_motion`]). Its place in the picture follows a plan
//! ([`super::framing`]), plus sway and lag; the camera looks where both agree. A plan with exits goes through
//! these phases:
//!
//! ```text
//!            planned time is over          the boat is out of the picture
//!   Inside --------------------> Leaving --------------------------------> Away
//!      ^                                                                    | sampled time is over
//!      +---------------------------- Returning <----------------------------+
//!          well inside again
//! ```
//!
//! The boat leaves and returns because the camera pans or because the boat drives. Where the boat drives, its
//! place in the picture moves with its own velocity.

use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{PictureSize, PixelPoint};

use super::boat_motion::{BoatMotion, Order};
use super::camera_motion::{Sway, Zoom};
use super::conditions::{Conditions, REFERENCE};
use super::framing::{BoatGoal, Framing, Limits};
use super::outline::Outline;
use super::script::{FRAMES_PER_SECOND, SceneKind, SceneScript};
use super::view::{PlanePoint, View};

/// How long the boat has been under way when the clip begins, so that it has a wake, s.
const LEAD_S: u32 = 5;
/// Frames before the first frame of the clip.
pub(super) const LEAD_FRAMES: usize = (LEAD_S * FRAMES_PER_SECOND) as usize;
/// Largest speed of the boat over the water, px/s at zoom 1 in the reference picture: a camera could not
/// follow a long hull at three lengths per second.
const MAX_BOAT_PX_S: f64 = 330.0;
/// Largest speed of the sway, px/s in the reference picture.
const MAX_SWAY_PX_S: f64 = 150.0;
/// Time constant with which the camera follows the boat, s.
const CAMERA_LAG_S: f64 = 0.6;
/// Time constant of the sway's gain, s.
const SWAY_GAIN_LAG_S: f64 = 0.5;
/// Gain of the sway while the boat crosses the border: sway must not bring the boat back.
const CROSSING_SWAY_GAIN: f64 = 0.15;
/// Duration of a frame, s.
const FRAME_S: f64 = 1.0 / FRAMES_PER_SECOND as f64;

/// Boat and camera in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) boat: PlanePoint,
    /// Radians, anticlockwise from the plane's x.
    pub(super) heading: f64,
    /// Hull lengths per second over the water.
    pub(super) speed: f64,
    pub(super) view: View,
}

/// A time without the boat: its first frame and the first frame after it, and where in the picture the boat
/// left and returned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Absence {
    pub(super) from: usize,
    pub(super) until: usize,
    pub(super) left_at: PixelPoint,
    pub(super) back_at: PixelPoint,
}

/// Boat and camera in every frame, from [`LEAD_FRAMES`] before the clip to one frame after it.
#[derive(Debug, Clone)]
pub(super) struct Trajectory {
    poses: Vec<Pose>,
    /// All times without the boat.
    pub(super) absences: Vec<Absence>,
}

impl Trajectory {
    /// Plans a clip of a number of frames.
    pub(super) fn new(
        script: &SceneScript,
        frames: usize,
        outline: &Outline,
        conditions: &Conditions,
        rng: SplitMix64,
    ) -> Self {
        let mut simulation = Simulation::new(script, frames, outline, conditions, rng);
        let mut absences = AbsenceRecorder::new(script.size);
        let mut poses = Vec::with_capacity(frames + LEAD_FRAMES + 1);
        // One frame more than the clip has, so that every frame has a next one to move to.
        for step in 0..=frames + LEAD_FRAMES {
            let time_s = (step as f64 - LEAD_FRAMES as f64) * FRAME_S;
            let pose = simulation.pose(time_s);
            poses.push(pose);
            let silhouette = outline.silhouette(pose.boat, pose.heading, &pose.view);
            let is_visible = !silhouette.bounds().clipped(script.size).is_empty();
            if let Some(frame) = step.checked_sub(LEAD_FRAMES) {
                absences.record(frame, pose.view.picture(pose.boat), is_visible);
            }
            simulation.advance(time_s, &pose.view, is_visible);
        }
        Self { poses, absences: absences.absences }
    }

    /// Boat and camera in a frame of the clip, from [`LEAD_FRAMES`] before its first.
    pub(super) fn pose(&self, frame: i64) -> &Pose {
        let index = (frame + LEAD_FRAMES as i64).clamp(0, self.poses.len() as i64 - 1);
        &self.poses[index as usize]
    }
}

/// Notes when the boat leaves the picture and returns.
struct AbsenceRecorder {
    absences: Vec<Absence>,
    /// The frame in which the boat was gone first, and where it was seen last.
    gone: Option<(usize, PixelPoint)>,
    last_seen: PixelPoint,
}

impl AbsenceRecorder {
    fn new(size: PictureSize) -> Self {
        Self { absences: Vec::new(), gone: None, last_seen: size.centre() }
    }

    fn record(&mut self, frame: usize, at: PixelPoint, is_visible: bool) {
        match self.gone {
            None if !is_visible => self.gone = Some((frame, self.last_seen)),
            Some((from, left_at)) if is_visible => {
                self.absences.push(Absence { from, until: frame, left_at, back_at: at });
                self.gone = None;
            }
            _ => {}
        }
        if is_visible {
            self.last_seen = at;
        }
    }
}

/// Boat and camera while a clip is planned.
struct Simulation {
    size: PictureSize,
    foreshortening: f64,
    zoom: Zoom,
    sway: Sway,
    sway_gain: f64,
    /// Largest offset by the camera's lag, px.
    lag_reach: (f64, f64),
    /// Where the camera looks, behind the boat by its lag.
    followed: PlanePoint,
    motion: BoatMotion,
    framing: Framing,
}

impl Simulation {
    fn new(
        script: &SceneScript,
        frames: usize,
        outline: &Outline,
        conditions: &Conditions,
        mut rng: SplitMix64,
    ) -> Self {
        let size = script.size;
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let relative = width / f64::from(REFERENCE.width);
        let hull = 2.0 * outline.half_length;
        let zoom = Zoom::new(&mut rng, script.kind, hull / height);
        let reach = outline.reach() * zoom.max_zoom();
        // The room between the hull and 5 % from the border is shared by plan, sway and lag. Pictures of a
        // few pixels have no such room; something must be left to share.
        let room = ((0.45 * width - reach).max(0.02 * width), (0.45 * height - reach).max(0.02 * height));
        let wanted_reach = rng.between(8.0, 100.0) * relative;
        let sway_reach = (wanted_reach.min(0.25 * room.0), wanted_reach.min(0.25 * room.1));
        let sway = Sway::new(&mut rng, sway_reach, MAX_SWAY_PX_S * relative);
        let lag_reach = (0.2 * room.0, 0.2 * room.1);
        let limits = Limits {
            inner: (room.0 - sway_reach.0 - lag_reach.0, room.1 - sway_reach.1 - lag_reach.1),
            outer: (
                0.5 * width + reach + sway_reach.0 + lag_reach.0 + 0.03 * width,
                0.5 * height + reach + sway_reach.1 + lag_reach.1 + 0.03 * width,
            ),
            relative,
        };
        let home_radius = (script.kind != SceneKind::Manoeuvre).then_some(0.3 * height);
        let motion_rng = SplitMix64::of_stream(rng.uniform().to_bits(), 0);
        let motion = BoatMotion::new(motion_rng, hull, MAX_BOAT_PX_S * relative, home_radius);
        let end_s = frames as f64 / f64::from(FRAMES_PER_SECOND);
        Self {
            size,
            foreshortening: conditions.foreshortening,
            zoom,
            sway,
            sway_gain: 1.0,
            lag_reach,
            followed: motion.at,
            motion,
            framing: Framing::new(rng, limits, script.kind, end_s),
        }
    }

    /// Boat and camera at a time; the sway's gain and the camera's lag go on by a frame.
    fn pose(&mut self, time_s: f64) -> Pose {
        let boat = self.motion.at;
        let goal = if self.framing.is_crossing() { CROSSING_SWAY_GAIN } else { 1.0 };
        self.sway_gain += (goal - self.sway_gain) * (FRAME_S / SWAY_GAIN_LAG_S);
        self.followed = self.followed.offset(
            (boat.x - self.followed.x) * (FRAME_S / CAMERA_LAG_S),
            (boat.y - self.followed.y) * (FRAME_S / CAMERA_LAG_S),
        );
        let view = View {
            camera: boat,
            zoom: self.zoom.at(time_s),
            foreshortening: self.foreshortening,
            size: self.size,
        };
        let (lag_u, lag_v) = view.picture_offset(boat.x - self.followed.x, boat.y - self.followed.y);
        let limited = |lag: f64, reach: f64| reach * libm::tanh(lag / reach);
        let (sway_u, sway_v) = self.sway.at(time_s);
        let position = self.framing.position();
        let du = position.0 + self.sway_gain * (sway_u + limited(lag_u, self.lag_reach.0));
        let dv = position.1 + self.sway_gain * (sway_v + limited(lag_v, self.lag_reach.1));
        let (x, y) = view.plane_offset(du, dv);
        let view = View { camera: boat.offset(-x, -y), ..view };
        // Waves make the bow yaw by a few degrees.
        let yaw = 0.035 * libm::sin(1.9 * time_s) + 0.02 * libm::sin(4.3 * time_s + 1.0);
        Pose { boat, heading: self.motion.heading + yaw, speed: self.motion.speed, view }
    }

    /// Advances the plan and the boat by a frame.
    fn advance(&mut self, time_s: f64, view: &View, is_visible: bool) {
        let (vx, vy) = self.motion.velocity();
        let boat_in_picture = view.picture_offset(vx, vy);
        let order = match self.framing.step(time_s, FRAME_S, is_visible, boat_in_picture) {
            BoatGoal::Roam => Order::Roam,
            BoatGoal::Loiter => Order::Loiter,
            BoatGoal::Towards(du, dv) => {
                let (x, y) = view.plane_offset(du, dv);
                Order::Head(libm::atan2(y, x))
            }
        };
        self.motion.step(order, time_s, FRAME_S);
    }
}
