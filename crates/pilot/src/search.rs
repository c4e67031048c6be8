//! The search for a target that is lost: first the bearing at which the target was seen last, then a bounded
//! sweep.
//!
//! ```text
//!   pan relative to the last bearing, a = half the picture's width
//!        -2a      -a       0       +a      +2a
//!                          1
//!                          +-------->2------>3        the side on which the target left comes first
//!        5<-----4<-------------------------+
//!                                                    a narrow lens goes on: 3a and 4a, a third of a picture higher,
//!                                                    then 5a and 6a, as much lower
//! ```
//! A leg ends when both axes have arrived, or after a time in which the camera should have arrived: an end
//! stop, or the limit of the net yaw, may be in the way. The rates are the low rate of [`crate::safety`]; the
//! search holds no licence itself, but proposes commands to the safety rule with each video frame.
//!
//! Angles are those of the camera model: pan relative to the direction at the start, positive to the right;
//! tilt positive upwards; radians. They are predicted from the commands, so that kite and vehicle turn the
//! search with them.

use core::time::Duration;

use barrelman_control::view::{Direction, View};
use barrelman_vocab::profile::CameraDynamics;
use barrelman_vocab::{AngularRate, CameraCommand, ImagePoint, Timestamp};

use crate::safety::NUDGE_RATE_RAD_PER_S;

/// A search gives up after this time, before its consent ends.
pub const SEARCH_LASTS: Duration = Duration::from_secs(58);

/// Largest distance of the sweep from the last bearing, radians (150 degrees).
const MAX_SWEEP: f64 = 2.62;
/// Tilt of the second and third four legs relative to the first, as a share of the picture's height.
const ROW_SHARE: f64 = 1.0 / 3.0;
/// In the sweep, the camera is raised by up to a quarter of the picture's height, until the horizon lies at
/// this share of the upper half.
const HORIZON_SHARE: f64 = 0.8;
/// An axis has arrived at this distance, radians (1.1 degrees).
const ARRIVED: f64 = 0.02;
/// Distance kept from the end stops of the tilt, radians (3 degrees).
const STOP_MARGIN: f64 = 0.052;
/// A leg is given up after this time beyond the time that it takes at the low rate, seconds.
const LEG_SLACK_S: f64 = 3.0;
/// Two bearings that tell the side on which the target left lie at least so far apart, and at most twice as
/// far.
const SIDE_INTERVAL: Duration = Duration::from_millis(3000);

/// The bearing at which the target was seen last, and the side to which the bearing moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastBearing {
    /// Pan and tilt of the target's direction, radians.
    newest: (f64, f64),
    seen_at: Timestamp,
    /// Pan at two times before, and when: the older one tells the side.
    before: [(f64, Timestamp); 2],
}

impl LastBearing {
    /// The bearing of an image point in the view of a camera that points to (pan, tilt).
    pub fn bearing(focal_px: f64, (pan, tilt): (f64, f64), point: ImagePoint) -> (f64, f64) {
        // Seen from a camera that points ahead at the same tilt, so that the pan stays continuous over
        // several turns.
        let [right, ahead, up]: Direction = View::new(focal_px, 0.0, tilt).unproject(point);
        (pan + libm::atan2(right, ahead), libm::asin(up.clamp(-1.0, 1.0)))
    }

    /// The target is seen at a bearing.
    pub fn update(last: Option<Self>, bearing: (f64, f64), at: Timestamp) -> Self {
        let before = match last {
            Some(last) if at.since(last.before[1].1) < SIDE_INTERVAL => last.before,
            Some(last) => [last.before[1], (last.newest.0, last.seen_at)],
            None => [(bearing.0, at); 2],
        };
        Self { newest: bearing, seen_at: at, before }
    }

    /// 1 where the bearing moved to the right, -1 where it moved to the left.
    fn side(&self) -> f64 {
        if self.newest.0 < self.before[0].0 { -1.0 } else { 1.0 }
    }
}

/// What the camera sees at once, and how far it can tilt, as angles in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchReach {
    /// Half the picture's width.
    half_width: f64,
    /// The picture's height.
    height: f64,
    /// The lowest and the highest tilt of a search.
    tilt_range: (f64, f64),
}

impl SearchReach {
    /// The reach of a camera whose focal length is this share of the picture's width, for a picture of height
    /// / width `aspect`.
    pub fn new(focal_share: f64, aspect: f64, camera: &CameraDynamics) -> Self {
        let (low, high) = camera.tilt_stops;
        Self {
            half_width: libm::atan(0.5 / focal_share),
            height: 2.0 * libm::atan(0.5 * aspect / focal_share),
            tilt_range: (low.radians() + STOP_MARGIN, high.radians() - STOP_MARGIN),
        }
    }
}

/// A search in progress.
#[derive(Debug, Clone)]
pub struct Search {
    begun: Timestamp,
    origin: (f64, f64),
    side: f64,
    reach: SearchReach,
    leg: u32,
    /// The leg's end and deadline; `None` before its first step.
    towards: Option<Towards>,
}

/// The end of a leg.
#[derive(Debug, Clone, Copy)]
struct Towards {
    pan: AxisTarget,
    tilt: AxisTarget,
    gives_up_at: Timestamp,
}

/// The end of a leg on one axis.
#[derive(Debug, Clone, Copy)]
struct AxisTarget {
    angle: f64,
    /// The side of the beginning, on which the axis has not arrived: 1 or -1, or 0 where the axis has
    /// arrived.
    direction: f64,
}

impl AxisTarget {
    fn new(angle: f64, from: f64) -> Self {
        let distance = angle - from;
        Self { angle, direction: if distance.abs() <= ARRIVED { 0.0 } else { distance.signum() } }
    }

    /// The rate at an angle; zero from the arrival on.
    fn rate(&mut self, angle: f64) -> f64 {
        if (self.angle - angle) * self.direction <= ARRIVED {
            self.direction = 0.0;
        }
        self.direction * NUDGE_RATE_RAD_PER_S
    }
}

impl Search {
    /// A search that begins at the last bearing; without one, where the camera points.
    pub fn new(last: Option<LastBearing>, pointing: (f64, f64), reach: SearchReach, now: Timestamp) -> Self {
        Self {
            begun: now,
            origin: last.map_or(pointing, |last| last.newest),
            side: last.map_or(1.0, |last| last.side()),
            reach,
            leg: 0,
            towards: None,
        }
    }

    /// The next command of the search for a camera that points to (pan, tilt), whose pan may lie in
    /// `pan_range`. `None`: the search has ended without the target.
    pub fn command(
        &mut self,
        (pan, tilt): (f64, f64),
        pan_range: (f64, f64),
        now: Timestamp,
    ) -> Option<CameraCommand> {
        if now.since(self.begun) >= SEARCH_LASTS {
            return None;
        }
        loop {
            let towards = match self.towards {
                Some(towards) => towards,
                None => self.begin_leg((pan, tilt), pan_range, now)?,
            };
            let mut towards = towards;
            let (pan_rate, tilt_rate) = (towards.pan.rate(pan), towards.tilt.rate(tilt));
            let has_ended = (pan_rate == 0.0 && tilt_rate == 0.0) || now >= towards.gives_up_at;
            if !has_ended {
                self.towards = Some(towards);
                let rate = AngularRate::from_radians_per_second;
                return Some(CameraCommand::turning(rate(pan_rate), rate(tilt_rate)));
            }
            (self.towards, self.leg) = (None, self.leg + 1);
        }
    }

    /// Begins the present leg. `None`: the sweep has been made.
    fn begin_leg(
        &self,
        (pan, tilt): (f64, f64),
        (left, right): (f64, f64),
        now: Timestamp,
    ) -> Option<Towards> {
        let (offset, row) = self.leg_offsets()?;
        let clamp = |angle: f64, low: f64, high: f64| angle.max(low.min(high)).min(high);
        let to_pan = clamp(self.origin.0 + offset, left, right);
        let (low, high) = self.reach.tilt_range;
        let to_tilt = clamp(self.origin.1 + row, low, high);
        let way = (to_pan - pan).abs().max((to_tilt - tilt).abs());
        let takes = Duration::from_secs_f64(way / NUDGE_RATE_RAD_PER_S * 1.2 + LEG_SLACK_S);
        Some(Towards {
            pan: AxisTarget::new(to_pan, pan),
            tilt: AxisTarget::new(to_tilt, tilt),
            gives_up_at: now.plus(takes),
        })
    }

    /// Pan and tilt of the present leg relative to the last bearing; `None` beyond the sweep.
    fn leg_offsets(&self) -> Option<(f64, f64)> {
        let Some(index) = self.leg.checked_sub(1) else { return Some((0.0, 0.0)) };
        let SearchReach { half_width, height, .. } = self.reach;
        let block = index / 4;
        let width = half_width * f64::from(2 * block + 1 + index % 2);
        let is_within = f64::from(2 * block) * half_width < MAX_SWEEP;
        let side = if index % 4 < 2 { self.side } else { -self.side };
        let row = match block % 3 {
            // A target that goes away comes nearer to the horizon.
            0 => (-HORIZON_SHARE * 0.5 * height - self.origin.1).clamp(0.0, 0.25 * height),
            1 => ROW_SHARE * height,
            _ => -ROW_SHARE * height,
        };
        is_within.then_some((side * width.min(MAX_SWEEP), row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    fn at(seconds: f64) -> Timestamp {
        Timestamp::from_secs_f64(100.0 + seconds)
    }

    fn seen(pan_before: f64, pan: f64, tilt: f64) -> LastBearing {
        let first = LastBearing::update(None, (pan_before, tilt), at(-8.0));
        LastBearing::update(Some(first), (pan, tilt), at(-4.0))
    }

    fn reach(dynamics: &CameraDynamics) -> SearchReach {
        SearchReach::new(dynamics.focal_share, 9.0 / 16.0, dynamics)
    }

    /// The way of a camera without lag: pan and tilt every 0.1 s until the search ends.
    fn way(
        last: LastBearing,
        from: (f64, f64),
        pan_range: (f64, f64),
        dynamics: &CameraDynamics,
    ) -> Vec<(f64, f64)> {
        let mut search = Search::new(Some(last), from, reach(dynamics), at(0.0));
        let (mut pointing, mut way) = (from, Vec::new());
        let (low, high) = dynamics.tilt_stops;
        for step in 0..2_000 {
            let Some(command) = search.command(pointing, pan_range, at(0.1 * f64::from(step))) else { break };
            pointing.0 += 0.1 * command.pan.radians_per_second();
            pointing.1 =
                (pointing.1 + 0.1 * command.tilt.radians_per_second()).clamp(low.radians(), high.radians());
            way.push(pointing);
        }
        way
    }

    #[test]
    fn the_last_bearing_comes_first_and_then_the_side_on_which_the_target_left() {
        for (before, side) in [(0.2, 1.0), (0.4, -1.0)] {
            let way = way(seen(before, 0.3, -0.5), (0.0, -0.4), EVERYWHERE, &CameraDynamics::laboratory());
            let first =
                way.iter().position(|(pan, tilt)| (pan - 0.3).abs() < 0.03 && (tilt + 0.5).abs() < 0.03);
            let first = first.expect("the search comes to the last bearing");
            assert!(first <= 40, "3 s at 0.1 rad/s: {first}");
            let after = way[first + 60].0 - 0.3;
            assert!(after * side > 0.3, "{side}: {after}");
        }
    }

    #[test]
    fn a_search_is_bounded_in_angle_and_in_time() {
        for focal_share in [0.3, 0.5, 1.0, 3.0] {
            let dynamics = CameraDynamics { focal_share, ..CameraDynamics::laboratory() };
            let way = way(seen(0.0, 0.0, -0.4), (0.0, -0.4), EVERYWHERE, &dynamics);
            assert!(way.len() <= 580 && way.len() > 100, "{focal_share}: {} steps", way.len());
            let (low, high) = dynamics.tilt_stops;
            for (pan, tilt) in way {
                assert!(pan.abs() <= MAX_SWEEP + 0.02, "{focal_share}: {pan}");
                assert!(
                    tilt >= low.radians() + 0.03 && tilt <= high.radians() - 0.03,
                    "{focal_share}: {tilt}"
                );
            }
        }
    }

    #[test]
    fn a_limit_of_the_pan_cuts_the_sweep_and_does_not_hold_it_up() {
        let way = way(seen(0.0, 0.1, -0.4), (0.0, -0.4), (-2.0, 0.2), &CameraDynamics::laboratory());
        let most = |pick: fn(f64, f64) -> f64| way.iter().map(|(pan, _)| *pan).fold(0.0, pick);
        assert!(most(f64::max) <= 0.22, "{}", most(f64::max));
        assert!(most(f64::min) < -0.6, "the other side is searched: {}", most(f64::min));
    }

    #[test]
    fn a_camera_that_does_not_turn_ends_the_search_by_itself() {
        let mut search = Search::new(None, (0.0, 0.0), reach(&CameraDynamics::laboratory()), at(0.0));
        let ends = (0..1_000)
            .find(|step| search.command((0.0, 0.0), EVERYWHERE, at(0.1 * f64::from(*step))).is_none());
        assert!(ends.is_some_and(|step| step <= 580), "{ends:?}");
    }

    #[test]
    fn the_bearing_of_a_point_is_continuous_over_several_turns() {
        let ahead = LastBearing::bearing(330.0, (13.0, -0.3), ImagePoint { x: 0.0, y: 0.0 });
        assert!((ahead.0 - 13.0).abs() < 1e-9 && (ahead.1 + 0.3).abs() < 1e-9, "{ahead:?}");
        let right = LastBearing::bearing(330.0, (13.0, 0.0), ImagePoint { x: 330.0, y: 0.0 });
        assert!((right.0 - 13.0 - core::f64::consts::FRAC_PI_4).abs() < 1e-9, "{right:?}");
    }

    #[test]
    fn the_side_is_that_of_a_boat_that_goes_slowly_under_a_swaying_camera() {
        let mut last = None;
        for frame in 0..30_u32 * 60 {
            let seconds = f64::from(frame) / 30.0;
            let sway = 0.005 * (libm::sin(2.9 * seconds) + 0.7 * libm::sin(7.3 * seconds + 1.0));
            let now = Timestamp::from_secs_f64(100.0 + seconds);
            let updated = LastBearing::update(last, (0.01 * seconds + sway, -0.4), now);
            assert!(seconds < 4.0 || updated.side() > 0.0, "{seconds} s");
            last = Some(updated);
        }
    }
}
