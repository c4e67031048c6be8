//! A target that moves along a path as the laboratory's target was moved by hand: it aims at a point ahead on
//! the path, with a weaving heading and a varying speed, slows down in turns and on arrival, and pauses now
//! and then.
//!
//! Kinematic: turn rate and speed follow their set points through first-order lags; nothing disturbs them.
//! For a boat with jet, waves and wind see [`crate::boat`].

use barrelman_vocab::Angle;

use crate::path::{InvalidPath, Path};
use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::tick::{TICK_S, TICKS_PER_SECOND, lag_share};

/// How the target moves.
#[derive(Debug, Clone, PartialEq)]
pub struct PursuitScript {
    /// Way-points, metres.
    pub way_points: Vec<(f64, f64)>,
    /// Median of the speeds over the trials, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the logarithm of the speed over the trials.
    pub log_speed_std_dev: f64,
    /// Exponent of the speed over the distance from the point below the camera, relative to
    /// [`REFERENCE_RANGE_M`]. 0: the same speed everywhere; 1: nearly the same speed in the picture.
    pub range_exponent: f64,
    /// Variation of the logarithm of the speed during a trial.
    pub speed_variation: OrnsteinUhlenbeck,
    /// Variation of the heading about the direction to the aim, radians.
    pub weave: OrnsteinUhlenbeck,
    /// Distance of the aim along the path, metres.
    pub look_ahead_m: f64,
    /// Standard deviation of each coordinate of each way-point from trial to trial, metres.
    pub way_point_jitter_m: f64,
    /// Turn rate for each radian of heading error, 1/s.
    pub heading_gain: f64,
    /// Largest turn rate, rad/s.
    pub max_turn_rad_per_s: f64,
    /// Time constant of the speed, seconds.
    pub surge_lag_s: f64,
    /// Time constant of the turn rate, seconds.
    pub turn_lag_s: f64,
    /// Share by which the speed is reduced at a heading error of a right angle or more, 0 to 1.
    pub corner_slow_down: f64,
    /// Share by which the speed is reduced at the ends of each leg from corner to corner, relative to the
    /// middle of the leg, 0 to 1.
    pub leg_end_slow_down: f64,
    /// Length of path over which the target comes to rest with constant deceleration, metres; 0: it stops at
    /// once.
    pub arrival_m: f64,
    /// Mean time at rest before the start, seconds.
    pub stand_before_s: f64,
    /// Mean time at rest at the end, seconds.
    pub stand_after_s: f64,
    /// Rate of random pauses under way, 1/s.
    pub pauses_per_s: f64,
    /// Share of the corners at which the target also pauses, 0 to 1.
    pub corner_pauses: f64,
    /// Mean duration of a pause, seconds.
    pub pause_s: f64,
}

/// What the target is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// At rest at the start until this tick.
    StandingBefore { until: u64 },
    /// Moving along the path.
    UnderWay,
    /// At rest under way until this tick.
    Paused { until: u64 },
    /// At rest at the end until this tick.
    StandingAfter { until: u64 },
    /// The trial is over.
    Over,
}

/// A target on its way.
#[derive(Debug, Clone)]
pub struct Pursuit {
    script: PursuitScript,
    path: Path,
    pauses: CounterRng,
    pace: CounterRng,
    speed_variation: OrnsteinUhlenbeckProcess,
    weave: OrnsteinUhlenbeckProcess,
    /// Speed of this trial before variations, m/s.
    speed_of_trial: f64,
    phase: Phase,
    position: (f64, f64),
    heading: f64,
    speed: f64,
    turn: f64,
    along_m: f64,
    /// Arc lengths of the corners, metres, and how many of them are passed.
    corners_m: Vec<f64>,
    passed: usize,
    corner_pauses: CounterRng,
}

/// Distance from the point below the camera at which the target has the script's speed, whatever the
/// exponent, metres.
pub const REFERENCE_RANGE_M: f64 = 4.0;
/// A way-point at which the path turns by more than this is a corner, radians.
const CORNER: f64 = core::f64::consts::FRAC_PI_4;
/// The target has arrived when at most this is left of the path, metres.
const ARRIVED_M: f64 = 0.15;
/// Length of path, in look-ahead distances, that is searched for the nearest point.
const REACH_LOOK_AHEADS: f64 = 3.0;

impl Pursuit {
    /// The target of a trial, at the start of its path.
    ///
    /// # Errors
    /// [`InvalidPath`] where the way-points make no path.
    pub fn new(script: PursuitScript, seed: u64) -> Result<Self, InvalidPath> {
        let jitter = CounterRng::new(seed, Stream::WayPoints);
        let jittered = script.way_points.iter().enumerate().map(|(index, (x, y))| {
            let off = |which: u64| script.way_point_jitter_m * jitter.normal(2 * index as u64 + which);
            (x + off(0), y + off(1))
        });
        let path = Path::from_way_points(jittered)?;
        let pace = CounterRng::new(seed, Stream::Pace);
        let speed_variation = OrnsteinUhlenbeckProcess::new(
            script.speed_variation,
            CounterRng::new(seed, Stream::SpeedVariation),
        );
        let weave = OrnsteinUhlenbeckProcess::new(script.weave, CounterRng::new(seed, Stream::Weave));
        let (speed_deviations, wait_factor) = Self::sampled_pace(seed);
        let speed_of_trial = script.speed_m_per_s * libm::exp(script.log_speed_std_dev * speed_deviations);
        let position = path.point_at(0.0);
        let until = ticks(script.stand_before_s * wait_factor);
        let corners_m = path.corners(CORNER).collect();
        Ok(Self {
            pauses: CounterRng::new(seed, Stream::Pauses),
            pace,
            speed_variation,
            weave,
            speed_of_trial,
            phase: Phase::StandingBefore { until },
            position,
            heading: path.direction_at(0.0),
            speed: 0.0,
            turn: 0.0,
            along_m: 0.0,
            corners_m,
            passed: 0,
            corner_pauses: CounterRng::new(seed, Stream::CornerPauses),
            path,
            script,
        })
    }

    /// What the seed decides for the whole trial: the deviation of the logarithm of the speed in standard
    /// deviations (normal), and the time at rest before the start over its mean (exponential).
    pub fn sampled_pace(seed: u64) -> (f64, f64) {
        let pace = CounterRng::new(seed, Stream::Pace);
        (pace.normal(0), pace.exponential(100))
    }

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        self.speed_variation.advance(tick);
        self.weave.advance(tick);
        let is_at_corner = self.advance_corner();
        self.phase = self.next_phase(tick, is_at_corner);
        let (speed, turn) = match self.phase {
            Phase::UnderWay => self.desired_motion(),
            Phase::StandingBefore { .. }
            | Phase::Paused { .. }
            | Phase::StandingAfter { .. }
            | Phase::Over => (0.0, 0.0),
        };
        self.speed += (speed - self.speed) * lag_share(self.script.surge_lag_s);
        self.turn += (turn - self.turn) * lag_share(self.script.turn_lag_s);
        self.heading += self.turn * TICK_S;
        self.position.0 += self.speed * libm::cos(self.heading) * TICK_S;
        self.position.1 += self.speed * libm::sin(self.heading) * TICK_S;
        let reach = REACH_LOOK_AHEADS * self.script.look_ahead_m;
        self.along_m = self.path.nearest_arc_length(self.position, self.along_m, reach);
    }

    /// Whether the target passes a corner in this tick; each corner is passed once.
    fn advance_corner(&mut self) -> bool {
        let passes = self.corners_m.get(self.passed).is_some_and(|corner_m| *corner_m <= self.along_m);
        self.passed += usize::from(passes);
        passes
    }

    fn next_phase(&self, tick: u64, is_at_corner: bool) -> Phase {
        let draw_index = 2 * self.passed as u64;
        let pauses_here = || is_at_corner && self.corner_pauses.unit(draw_index) < self.script.corner_pauses;
        match self.phase {
            Phase::StandingBefore { until } | Phase::Paused { until } if tick >= until => Phase::UnderWay,
            Phase::UnderWay if self.path.length() - self.along_m <= ARRIVED_M => {
                let stand_s = self.script.stand_after_s * self.pace.exponential(101);
                Phase::StandingAfter { until: tick + ticks(stand_s) }
            }
            Phase::UnderWay if self.pauses.unit(2 * tick) < self.script.pauses_per_s * TICK_S => {
                let pause_s = self.script.pause_s * self.pauses.exponential(2 * tick + 1);
                Phase::Paused { until: tick + ticks(pause_s) }
            }
            Phase::UnderWay if pauses_here() => {
                let pause_s = self.script.pause_s * self.corner_pauses.exponential(draw_index + 1);
                Phase::Paused { until: tick + ticks(pause_s) }
            }
            Phase::StandingAfter { until } if tick >= until => Phase::Over,
            unchanged => unchanged,
        }
    }

    /// Speed relative to the middle of the leg from corner to corner. A hand that moves from mark to mark
    /// minimises jerk (`flash1985`): its speed is (t (1 - t))^2 over the time of the leg, which is nearly (s
    /// (1 - s))^(2/3) over its length.
    fn leg_speed_factor(&self) -> f64 {
        let from = self.passed.checked_sub(1).map_or(0.0, |last| self.corners_m[last]);
        let to = self.corners_m.get(self.passed).copied().unwrap_or_else(|| self.path.length());
        let share = ((self.along_m - from) / (to - from)).clamp(0.0, 1.0);
        let parabola = 4.0 * share * (1.0 - share);
        let bell = libm::cbrt(parabola * parabola);
        1.0 - self.script.leg_end_slow_down * (1.0 - bell)
    }

    /// Set points of speed (m/s) and turn rate (rad/s).
    fn desired_motion(&self) -> (f64, f64) {
        let ahead = self.path.point_at(self.along_m + self.script.look_ahead_m);
        let bearing = libm::atan2(ahead.1 - self.position.1, ahead.0 - self.position.0);
        let off = wrap_angle(bearing + self.weave.value() - self.heading);
        let sharp = (off.abs() / core::f64::consts::FRAC_PI_2).min(1.0);
        let left = self.path.length() - self.along_m;
        let arriving =
            if left < self.script.arrival_m { libm::sqrt(left / self.script.arrival_m) } else { 1.0 };
        let speed = self.speed_of_trial
            * libm::exp(self.speed_variation.value())
            * (1.0 - self.script.corner_slow_down * sharp)
            * self.leg_speed_factor()
            * libm::pow(
                libm::hypot(self.position.0, self.position.1) / REFERENCE_RANGE_M,
                self.script.range_exponent,
            )
            * arriving;
        let max_turn = self.script.max_turn_rad_per_s;
        (speed, (self.script.heading_gain * off).clamp(-max_turn, max_turn))
    }

    /// Position along the world's x and y, metres.
    pub const fn position(&self) -> (f64, f64) {
        self.position
    }

    /// Heading: 0 along x, anticlockwise.
    pub const fn heading(&self) -> Angle {
        Angle::from_radians(self.heading)
    }

    /// Speed, m/s.
    pub const fn speed_m_per_s(&self) -> f64 {
        self.speed
    }

    /// Whether the time at rest at the end is over.
    pub const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }
}

fn ticks(seconds: f64) -> u64 {
    (seconds * f64::from(TICKS_PER_SECOND) + 0.5) as u64
}

/// The same angle within -pi to pi.
pub(crate) fn wrap_angle(radians: f64) -> f64 {
    libm::remainder(radians, core::f64::consts::TAU)
}
