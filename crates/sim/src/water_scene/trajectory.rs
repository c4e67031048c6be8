//! Boat and camera together, frame by frame: a voyage.
//!
//! The boat goes its way over the water; where it is to stand in the picture follows a plan, with sway and lag on
//! top; the camera looks to where both agree. A plan with exits goes through these phases (all times in s):
//!
//! ```text
//!            planned time is up            nothing of the boat shows
//!   Inside --------------------> Leaving --------------------------> Away
//!      ^                                                              | drawn time is up
//!      +------------------------- Returning <-------------------------+
//!          well inside again
//! ```
//!
//! The boat leaves, and comes back, because the camera pans or because the boat drives: in the latter case the
//! place in the picture moves with the boat's own velocity.

use barrelman_vocab::PixelPoint;

use super::boat_motion::{BoatMotion, Order};
use super::conditions::{Conditions, REFERENCE};
use super::framing::{BoatGoal, Framing, Limits};
use super::outline::{Outline, Silhouette};
use super::rng::Rng;
use super::view::{PlanePoint, View};
use super::{FRAMES_PER_SECOND, SceneKind, SceneScript};

/// How long the boat has been under way when the clip begins, so that it has a wake, s.
const LEAD_S: u32 = 5;
/// Frames before the clip's first.
pub(super) const LEAD_FRAMES: usize = (LEAD_S * FRAMES_PER_SECOND) as usize;
/// The fastest the boat goes over the water, px/s at zoom 1 in the reference picture: a camera could not follow
/// a long hull at its three lengths per second.
const MAX_BOAT_PX_S: f64 = 330.0;
/// Sway at its fastest, px/s in the reference picture.
const MAX_SWAY_PX_S: f64 = 150.0;
/// How far the camera lags behind the boat, s.
const CAMERA_LAG_S: f64 = 0.6;
/// How fast the sway calms down and comes up again, s.
const SWAY_GAIN_LAG_S: f64 = 0.5;
/// Share of the sway that is left while the boat crosses the border: it must not bring the boat back.
const CROSSING_SWAY_GAIN: f64 = 0.15;

/// Hull length over picture height from which on the boat only shrinks from its first size, and up to which it only
/// grows.
const ONLY_SHRINKS: f64 = 0.15;
const ONLY_GROWS: f64 = 0.05;

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

/// A time without the boat, in frames of the clip, and where in the picture it went and came back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Absence {
    pub(super) from: usize,
    pub(super) until: usize,
    pub(super) left_at: PixelPoint,
    pub(super) back_at: PixelPoint,
}

#[derive(Debug, Clone)]
pub(super) struct Trajectory {
    poses: Vec<Pose>,
    /// All times without the boat.
    pub(super) absences: Vec<Absence>,
}

/// Sums of two sinusoids per axis.
#[derive(Debug, Clone)]
struct Sway {
    parts: [[f64; 3]; 4],
}

impl Sway {
    /// At most that far to the side and up, px.
    fn new(rng: &mut Rng, reach: (f64, f64), max_speed: f64) -> Self {
        let mut part = |reach: f64| {
            let rate = core::f64::consts::TAU * rng.uniform(0.1, 0.5);
            [reach.min(max_speed / rate), rate, rng.uniform(0.0, core::f64::consts::TAU)]
        };
        Self { parts: [part(0.7 * reach.0), part(0.3 * reach.0), part(0.7 * reach.1), part(0.3 * reach.1)] }
    }

    fn at(&self, time_s: f64) -> (f64, f64) {
        let [a, b, c, d] = self.parts.map(|[reach, rate, phase]| reach * libm::sin(rate * time_s + phase));
        (a + b, c + d)
    }
}

/// Zoom over time: 1 in the first frame, one slow wave of the logarithm.
#[derive(Debug, Clone, Copy)]
struct Zoom {
    reach: f64,
    rate: f64,
    phase: f64,
}

impl Zoom {
    fn new(rng: &mut Rng, kind: SceneKind, hull_over_height: f64) -> Self {
        let factor = if kind == SceneKind::Manoeuvre { rng.uniform(1.5, 2.0) } else { rng.uniform(1.0, 1.2) };
        // A hull that fills much of the picture may only shrink, and one of few pixels only grow.
        let phase = if hull_over_height > ONLY_SHRINKS {
            core::f64::consts::FRAC_PI_2
        } else if hull_over_height < ONLY_GROWS {
            -core::f64::consts::FRAC_PI_2
        } else {
            rng.uniform(0.0, core::f64::consts::TAU)
        };
        let rate = core::f64::consts::TAU / rng.uniform(14.0, 36.0);
        Self { reach: 0.5 * libm::log(factor), rate, phase }
    }

    fn at(self, time_s: f64) -> f64 {
        libm::exp(self.reach * (libm::sin(self.rate * time_s + self.phase) - libm::sin(self.phase)))
    }

    fn max_zoom(self) -> f64 {
        libm::exp(self.reach * (1.0 - libm::sin(self.phase)))
    }
}

impl Trajectory {
    pub(super) fn new(
        script: &SceneScript,
        frames: usize,
        outline: &Outline,
        conditions: &Conditions,
        mut rng: Rng,
    ) -> Self {
        let size = script.size;
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let relative = width / f64::from(REFERENCE.width);
        let hull = 2.0 * outline.half_length;
        let zoom = Zoom::new(&mut rng, script.kind, hull / height);
        let reach = outline.reach() * zoom.max_zoom();
        // What is left between the hull and 5 % of the border is shared out to plan, sway and lag.
        // Pictures of a few pixels have no such room; something must be left to share.
        let room = ((0.45 * width - reach).max(0.02 * width), (0.45 * height - reach).max(0.02 * height));
        let wanted_reach = rng.uniform(8.0, 100.0) * relative;
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
        let exits = script.kind != SceneKind::Manoeuvre;
        let home = exits.then_some(0.3 * height);
        let motion_rng = Rng::new(rng.unit().to_bits(), 0);
        let mut motion = BoatMotion::new(motion_rng, hull, MAX_BOAT_PX_S * relative, home);
        let end_s = frames as f64 / f64::from(FRAMES_PER_SECOND);
        let mut framing = Framing::new(rng, limits, script.kind, end_s);

        let dt_s = 1.0 / f64::from(FRAMES_PER_SECOND);
        let mut followed = motion.at;
        let mut sway_gain = 1.0;
        let mut poses = Vec::with_capacity(frames + LEAD_FRAMES + 1);
        let mut absences = Vec::new();
        let mut gone: Option<(usize, PixelPoint)> = None;
        let mut last_seen = size.centre();
        // One frame more than the clip has, so that every frame has a next one to move to.
        for step in 0..=frames + LEAD_FRAMES {
            let time_s = (step as f64 - LEAD_FRAMES as f64) * dt_s;
            let zoom = zoom.at(time_s);
            let goal = if framing.is_crossing() { CROSSING_SWAY_GAIN } else { 1.0 };
            sway_gain += (goal - sway_gain) * (dt_s / SWAY_GAIN_LAG_S);
            followed = followed.offset(
                (motion.at.x - followed.x) * (dt_s / CAMERA_LAG_S),
                (motion.at.y - followed.y) * (dt_s / CAMERA_LAG_S),
            );
            let view = View { camera: motion.at, zoom, foreshortening: conditions.foreshortening, size };
            let (lag_u, lag_v) = view.picture_offset(motion.at.x - followed.x, motion.at.y - followed.y);
            let limited = |lag: f64, reach: f64| reach * libm::tanh(lag / reach);
            let (sway_u, sway_v) = sway.at(time_s);
            let position = framing.position();
            let du = position.0 + sway_gain * (sway_u + limited(lag_u, lag_reach.0));
            let dv = position.1 + sway_gain * (sway_v + limited(lag_v, lag_reach.1));
            let (x, y) = view.plane_offset(du, dv);
            let view = View { camera: motion.at.offset(-x, -y), ..view };
            // Waves make the bow yaw by a few degrees.
            let yaw = 0.035 * libm::sin(1.9 * time_s) + 0.02 * libm::sin(4.3 * time_s + 1.0);
            let pose = Pose { boat: motion.at, heading: motion.heading + yaw, speed: motion.speed, view };
            poses.push(pose);

            let silhouette = outline.silhouette(pose.boat, pose.heading, &view);
            let visible = is_in_picture(&silhouette, &view);
            if let Some(frame) = step.checked_sub(LEAD_FRAMES) {
                let at = view.picture(pose.boat);
                match gone {
                    None if !visible => gone = Some((frame, last_seen)),
                    Some((from, left_at)) if visible => {
                        absences.push(Absence { from, until: frame, left_at, back_at: at });
                        gone = None;
                    }
                    _ => {}
                }
                if visible {
                    last_seen = at;
                }
            }
            let (vx, vy) = motion.velocity();
            let boat_in_picture = view.picture_offset(vx, vy);
            let order = match framing.step(time_s, dt_s, visible, boat_in_picture) {
                BoatGoal::Roam => Order::Roam,
                BoatGoal::Loiter => Order::Loiter,
                BoatGoal::Towards(du, dv) => {
                    let (x, y) = view.plane_offset(du, dv);
                    Order::Head(libm::atan2(y, x))
                }
            };
            motion.step(order, time_s, dt_s);
        }
        Self { poses, absences }
    }

    /// Boat and camera in a frame of the clip, from [`LEAD_FRAMES`] before its first.
    pub(super) fn pose(&self, frame: i64) -> &Pose {
        let index = (frame + LEAD_FRAMES as i64).clamp(0, self.poses.len() as i64 - 1);
        &self.poses[index as usize]
    }
}

fn is_in_picture(silhouette: &Silhouette, view: &View) -> bool {
    !silhouette.bounds().clipped(view.size).is_empty()
}
