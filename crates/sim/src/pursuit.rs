//! A target that is moved along a path, as a hand moved the laboratory's: it looks a little ahead on the path,
//! turns towards that place, weaving, hurries and dawdles, slows down where it must turn and where it arrives, and
//! stands still now and then.
//!
//! Kinematic: turn rate and speed follow what is wanted through first-order lags, and nothing pushes it aside.
//! For a boat that does what its jet and the water make it do see [`crate::boat`].

use barrelman_vocab::Angle;

use crate::camera_axis::{TICK_S, TICKS_PER_SECOND};
use crate::chance::{Draws, Stream, Wander, Wandering};
use crate::path::{NoPath, Path};

/// How it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct PursuitScript {
    /// Way-points, metres.
    pub way_points: Vec<(f64, f64)>,
    /// Median of the trials' speeds, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the trials' speeds.
    pub speed_spread: f64,
    /// By which power of its distance from the place below the camera its speed grows; as it is at [`RANGE_M`]. 0: the same
    /// speed everywhere, 1: the same speed in the picture, nearly.
    pub range_exponent: f64,
    /// How the logarithm of the speed wanders during a trial.
    pub gust: Wander,
    /// How its heading weaves about where it means to go, radians.
    pub weave: Wander,
    /// How far ahead on the path it looks, metres.
    pub look_ahead_m: f64,
    /// Standard deviation by which each way-point is missed, metres.
    pub way_point_jitter_m: f64,
    /// Turn rate for each radian that it points off, 1/s.
    pub heading_gain: f64,
    /// Largest turn rate, rad/s.
    pub most_turn_rad_per_s: f64,
    /// Time constant of its speed, seconds.
    pub surge_lag_s: f64,
    /// Time constant of its turn rate, seconds.
    pub turn_lag_s: f64,
    /// What share of its speed it gives up where it must turn by a right angle or more, 0 to 1.
    pub corner_slow_down: f64,
    /// What share of its speed it gives up at the ends of each leg from corner to corner, beside the leg's middle, 0 to 1.
    pub leg_rhythm: f64,
    /// It comes to rest over so many of the path's last metres, as with a constant deceleration; 0: it stops at once.
    pub arrival_m: f64,
    /// Mean time that it stands before it starts, seconds.
    pub stand_before_s: f64,
    /// Mean time that it stands at the end, seconds.
    pub stand_after_s: f64,
    /// Pauses for each second under way.
    pub pauses_per_s: f64,
    /// At what share of the path's corners, 0 to 1, it pauses in addition.
    pub corner_pauses: f64,
    /// Mean duration of a pause, seconds.
    pub pause_s: f64,
}

/// What it is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    /// Stands at the start until this tick.
    StandingBefore { until: u64 },
    /// Goes along the path.
    UnderWay,
    /// Pauses until this tick.
    Paused { until: u64 },
    /// Stands at the end until this tick.
    StandingAfter { until: u64 },
    /// The trial is over.
    Over,
}

/// The target on its way.
#[derive(Debug, Clone)]
pub struct Pursuit {
    script: PursuitScript,
    path: Path,
    pauses: Draws,
    pace: Draws,
    gust: Wandering,
    weave: Wandering,
    /// Speed of this trial, m/s.
    speed_of_trial: f64,
    doing: Doing,
    place: (f64, f64),
    heading: f64,
    speed: f64,
    turn: f64,
    along_m: f64,
    /// How far along the path its corners lie, metres, and how many of them are passed.
    corners_m: Vec<f64>,
    passed: usize,
    corner_pauses: Draws,
}

/// Where the target's speed is what the script says, whatever its exponent: so far from the place below the camera,
/// metres.
pub const RANGE_M: f64 = 4.0;
/// Where the path turns by more than this is a corner, radians.
const CORNER: f64 = core::f64::consts::FRAC_PI_4;
/// It has arrived when no more than this is left of the path, metres.
const ARRIVED_M: f64 = 0.15;
/// So many look-aheads of the path are searched for the place that is nearest.
const REACH_LOOK_AHEADS: f64 = 3.0;

impl Pursuit {
    /// The target of a trial, at the start of its path.
    ///
    /// # Errors
    /// [`NoPath`] where the way-points make none.
    pub fn new(script: PursuitScript, seed: u64) -> Result<Self, NoPath> {
        let jitter = Draws::of(seed, Stream::WayPoints);
        let jittered = script.way_points.iter().enumerate().map(|(index, (x, y))| {
            let off = |which: u64| script.way_point_jitter_m * jitter.normal(2 * index as u64 + which);
            (x + off(0), y + off(1))
        });
        let path = Path::through(jittered)?;
        let pace = Draws::of(seed, Stream::Pace);
        let gust = Wandering::new(script.gust, Draws::of(seed, Stream::Gust));
        let weave = Wandering::new(script.weave, Draws::of(seed, Stream::Weave));
        let (haste, patience) = Self::lot(seed);
        let speed_of_trial = script.speed_m_per_s * libm::exp(script.speed_spread * haste);
        let place = path.at(0.0);
        let until = ticks(script.stand_before_s * patience);
        let corners_m = path.corners(CORNER).collect();
        Ok(Self {
            pauses: Draws::of(seed, Stream::Pauses),
            pace,
            gust,
            weave,
            speed_of_trial,
            doing: Doing::StandingBefore { until },
            place,
            heading: path.direction_at(0.0),
            speed: 0.0,
            turn: 0.0,
            along_m: 0.0,
            corners_m,
            passed: 0,
            corner_pauses: Draws::of(seed, Stream::CornerPauses),
            path,
            script,
        })
    }

    /// What a trial's seed decides about all of it: deviations of its speed's logarithm (normal), and how many of the
    /// mean times it stands before it starts (exponential).
    pub fn lot(seed: u64) -> (f64, f64) {
        let pace = Draws::of(seed, Stream::Pace);
        (pace.normal(0), pace.exponential(100))
    }

    /// Advances through a tick.
    pub fn advance(&mut self, tick: u64) {
        self.gust.advance(tick);
        self.weave.advance(tick);
        let at_corner = self.passes_corner();
        self.doing = self.next(tick, at_corner);
        let (speed, turn) = match self.doing {
            Doing::UnderWay => self.wanted(),
            Doing::StandingBefore { .. }
            | Doing::Paused { .. }
            | Doing::StandingAfter { .. }
            | Doing::Over => (0.0, 0.0),
        };
        self.speed += (speed - self.speed) * lag_share(self.script.surge_lag_s);
        self.turn += (turn - self.turn) * lag_share(self.script.turn_lag_s);
        self.heading += self.turn * TICK_S;
        self.place.0 += self.speed * libm::cos(self.heading) * TICK_S;
        self.place.1 += self.speed * libm::sin(self.heading) * TICK_S;
        let reach = REACH_LOOK_AHEADS * self.script.look_ahead_m;
        self.along_m = self.path.nearest(self.place, self.along_m, reach);
    }

    /// Whether it comes to a corner now, of those that are passed once each.
    fn passes_corner(&mut self) -> bool {
        let passes = self.corners_m.get(self.passed).is_some_and(|corner_m| *corner_m <= self.along_m);
        self.passed += usize::from(passes);
        passes
    }

    fn next(&self, tick: u64, at_corner: bool) -> Doing {
        let draw = 2 * self.passed as u64;
        let pauses_here = || at_corner && self.corner_pauses.unit(draw) < self.script.corner_pauses;
        match self.doing {
            Doing::StandingBefore { until } | Doing::Paused { until } if tick >= until => Doing::UnderWay,
            Doing::UnderWay if self.path.length() - self.along_m <= ARRIVED_M => {
                let stand_s = self.script.stand_after_s * self.pace.exponential(101);
                Doing::StandingAfter { until: tick + ticks(stand_s) }
            }
            Doing::UnderWay if self.pauses.unit(2 * tick) < self.script.pauses_per_s * TICK_S => {
                let pause_s = self.script.pause_s * self.pauses.exponential(2 * tick + 1);
                Doing::Paused { until: tick + ticks(pause_s) }
            }
            Doing::UnderWay if pauses_here() => {
                let pause_s = self.script.pause_s * self.corner_pauses.exponential(draw + 1);
                Doing::Paused { until: tick + ticks(pause_s) }
            }
            Doing::StandingAfter { until } if tick >= until => Doing::Over,
            unchanged => unchanged,
        }
    }

    /// By what its speed is less here than in the middle of the leg from corner to corner. A hand that moves from mark to
    /// mark goes with the least jerk (`flash1985`): its speed rises and falls as (t (1 - t))^2 over the leg's time, which
    /// over the leg's length is nearly (s (1 - s))^(2/3).
    fn rhythm(&self) -> f64 {
        let from = self.passed.checked_sub(1).map_or(0.0, |last| self.corners_m[last]);
        let to = self.corners_m.get(self.passed).copied().unwrap_or_else(|| self.path.length());
        let share = ((self.along_m - from) / (to - from)).clamp(0.0, 1.0);
        let parabola = 4.0 * share * (1.0 - share);
        let bell = libm::cbrt(parabola * parabola);
        1.0 - self.script.leg_rhythm * (1.0 - bell)
    }

    /// The speed and the turn rate that it wants now.
    fn wanted(&self) -> (f64, f64) {
        let ahead = self.path.at(self.along_m + self.script.look_ahead_m);
        let bearing = libm::atan2(ahead.1 - self.place.1, ahead.0 - self.place.0);
        let off = wrapped(bearing + self.weave.value() - self.heading);
        let sharp = (off.abs() / core::f64::consts::FRAC_PI_2).min(1.0);
        let left = self.path.length() - self.along_m;
        let arriving =
            if left < self.script.arrival_m { libm::sqrt(left / self.script.arrival_m) } else { 1.0 };
        let speed = self.speed_of_trial
            * libm::exp(self.gust.value())
            * (1.0 - self.script.corner_slow_down * sharp)
            * self.rhythm()
            * libm::pow(libm::hypot(self.place.0, self.place.1) / RANGE_M, self.script.range_exponent)
            * arriving;
        let most = self.script.most_turn_rad_per_s;
        (speed, (self.script.heading_gain * off).clamp(-most, most))
    }

    /// Where it is, metres.
    pub const fn place(&self) -> (f64, f64) {
        self.place
    }

    /// Where it is headed: 0 along x, anticlockwise.
    pub const fn heading(&self) -> Angle {
        Angle::from_radians(self.heading)
    }

    /// How fast it goes, m/s.
    pub const fn speed_m_per_s(&self) -> f64 {
        self.speed
    }

    /// Whether it has stood at the end for as long as it was to.
    pub const fn is_over(&self) -> bool {
        matches!(self.doing, Doing::Over)
    }
}

fn ticks(seconds: f64) -> u64 {
    (seconds * f64::from(TICKS_PER_SECOND) + 0.5) as u64
}

/// What share of the way to what is wanted a first-order lag goes in one tick.
fn lag_share(lag_s: f64) -> f64 {
    if lag_s > 0.0 { 1.0 - libm::exp(-TICK_S / lag_s) } else { 1.0 }
}

/// An angle as one from -pi to pi.
pub(crate) fn wrapped(radians: f64) -> f64 {
    libm::remainder(radians, core::f64::consts::TAU)
}
