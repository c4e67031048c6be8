//! The plan of where the boat is in the picture, which the camera and the boat follow.
//!
//! Positions are offsets from the picture's centre, u to the right and v downwards, px. The phases are drawn
//! in `trajectory.rs`. A position *seeks* a goal like a critically damped spring, or *rides* along with the
//! boat.

use barrelman_vocab::rng::SplitMix64;

use super::choices::Choices;
use super::script::SceneKind;

/// First stay in view, s.
const FIRST_STAY_S: (f64, f64) = (2.5, 4.0);
/// Stay in view between two absences, from when the boat is well inside, s.
const STAY_S: (f64, f64) = (3.4, 7.0);
/// Wait outside, s. The way back to the border adds 0.5 to 1.5 s.
const WAIT_S: (f64, f64) = (2.7, 6.3);
/// Least rest of the clip when the boat starts to leave, s: 3.5 to leave, 3.2 outside, 1.5 to return and 4 to
/// be seen again.
const ROUND_S: f64 = 12.2;
/// Least rest of the clip when the wait ends, s.
const RETURN_S: f64 = 5.0;
/// Largest speed of a pan, px/s in the reference picture: 15 to 21 px from frame to frame.
const PAN_PX_S: (f64, f64) = (450.0, 640.0);
/// Share of the boat's own speed by which a pan is slower.
const PAN_SPEED_REDUCTION: f64 = 0.6;
/// Largest speed of the position while the boat is inside, px/s in the reference picture.
const MAX_INSIDE_PX_S: f64 = 220.0;
/// Time in which the boat crosses the border when it drives, s.
const DRIVE_S: f64 = 2.6;
/// The boat turns towards the border this long before it drives out or in, s.
const TURN_AHEAD_S: f64 = 1.4;
/// Time constant with which the position takes on the boat's velocity, s.
const RIDE_LAG_S: f64 = 0.3;

/// Limits of positions: half extents in px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Within these the boat is in view, whatever sway and lag do.
    pub(super) inner: (f64, f64),
    /// Beyond one of these the boat is wholly outside.
    pub(super) outer: (f64, f64),
    /// The picture's width over the reference picture's.
    pub(super) relative: f64,
}

/// What the plan wants of the boat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum BoatGoal {
    Roam,
    Loiter,
    /// Drive in a direction of the picture (du, dv).
    Towards(f64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum CrossingMode {
    Pan { omega: f64 },
    Drive,
}

#[derive(Debug, Clone, Copy)]
struct Exit {
    mode: CrossingMode,
    /// Unit vector outwards across the border.
    outwards: (f64, f64),
    begin_s: f64,
    /// Goal of a pan on the outer limits.
    goal: (f64, f64),
}

#[derive(Debug, Clone, Copy)]
enum Phase {
    Inside {
        goal: (f64, f64),
        next_goal_s: f64,
        exit: Option<Exit>,
    },
    Leaving {
        exit: Exit,
        speed: f64,
    },
    /// Moves along the circumference of the outer limits, from one position to another.
    Away {
        since_s: f64,
        until_s: f64,
        from: f64,
        to: f64,
        mode: CrossingMode,
    },
    Returning {
        mode: CrossingMode,
        goal: (f64, f64),
        speed: f64,
    },
}

#[derive(Debug, Clone)]
pub(super) struct Framing {
    rng: SplitMix64,
    limits: Limits,
    kind: SceneKind,
    end_s: f64,
    pan_px_s: f64,
    phase: Phase,
    at: (f64, f64),
    velocity: (f64, f64),
}

impl Framing {
    pub(super) fn new(mut rng: SplitMix64, limits: Limits, kind: SceneKind, end_s: f64) -> Self {
        let pan_px_s = rng.between(PAN_PX_S.0, PAN_PX_S.1) * limits.relative;
        let at = sampled_inside(&mut rng, limits);
        let phase = Phase::Inside { goal: at, next_goal_s: 0.0, exit: None };
        let mut framing = Self { rng, limits, kind, end_s, pan_px_s, phase, at, velocity: (0.0, 0.0) };
        let stay_s = framing.rng.between(FIRST_STAY_S.0, FIRST_STAY_S.1);
        let exit = framing.plan_exit(stay_s.min(end_s - ROUND_S));
        framing.phase = Phase::Inside { goal: at, next_goal_s: 1.0, exit };
        framing
    }

    pub(super) fn position(&self) -> (f64, f64) {
        self.at
    }

    /// Whether the boat is on its way across the border.
    pub(super) fn is_crossing(&self) -> bool {
        matches!(self.phase, Phase::Leaving { .. } | Phase::Returning { .. })
    }

    /// Advances by a short time. `visible`: some of the boat is in the picture; `boat`: its velocity over the
    /// water in the picture, px/s.
    pub(super) fn step(&mut self, now_s: f64, dt_s: f64, visible: bool, boat: (f64, f64)) -> BoatGoal {
        // The camera follows the boat and pans in addition; together they are not faster than a pan.
        let pan_px_s = self.pan_px_s - PAN_SPEED_REDUCTION * libm::hypot(boat.0, boat.1);
        match self.phase {
            Phase::Inside { goal, next_goal_s, exit } => self.stay(goal, next_goal_s, exit, now_s, dt_s),
            Phase::Leaving { exit, speed } => {
                match exit.mode {
                    CrossingMode::Pan { omega } => self.seek(exit.goal, omega, pan_px_s, dt_s),
                    CrossingMode::Drive => self.ride_with_boat(exit.outwards, speed, boat, dt_s),
                }
                if !visible {
                    self.start_absence(now_s);
                }
                match exit.mode {
                    CrossingMode::Pan { .. } => BoatGoal::Loiter,
                    CrossingMode::Drive => BoatGoal::Towards(exit.outwards.0, exit.outwards.1),
                }
            }
            Phase::Away { since_s, until_s, from, to, mode } => {
                // Half a second to come to rest outside, then along the circumference.
                let share = ((now_s - since_s - 0.5) / (until_s - since_s - 0.5)).clamp(0.0, 1.0);
                let eased = share * share * (3.0 - 2.0 * share);
                let omega = 2.5 + 4.5 * ((now_s - since_s) / 0.6).min(1.0);
                let goal = self.point_on_circumference(from + (to - from) * eased);
                self.seek(goal, omega, pan_px_s, dt_s);
                let inwards = self.inwards();
                if now_s >= until_s {
                    self.start_return(mode);
                }
                match mode {
                    CrossingMode::Drive if now_s >= until_s - TURN_AHEAD_S => {
                        BoatGoal::Towards(inwards.0, inwards.1)
                    }
                    _ => BoatGoal::Loiter,
                }
            }
            Phase::Returning { mode, goal, speed } => {
                let inwards = self.inwards();
                match mode {
                    CrossingMode::Pan { omega } => self.seek(goal, omega, pan_px_s, dt_s),
                    CrossingMode::Drive => self.ride_with_boat(inwards, speed, boat, dt_s),
                }
                let (u, v) = self.limits.inner;
                if self.at.0.abs() <= u && self.at.1.abs() <= v {
                    let stay_s = self.rng.between(STAY_S.0, STAY_S.1);
                    let exit = self.plan_exit(now_s + stay_s);
                    self.phase = Phase::Inside { goal, next_goal_s: now_s + 1.0, exit };
                }
                match mode {
                    CrossingMode::Pan { .. } => BoatGoal::Loiter,
                    CrossingMode::Drive => BoatGoal::Towards(inwards.0, inwards.1),
                }
            }
        }
    }

    fn stay(
        &mut self,
        goal: (f64, f64),
        next_goal_s: f64,
        exit: Option<Exit>,
        now_s: f64,
        dt_s: f64,
    ) -> BoatGoal {
        let drive = exit.filter(|exit| exit.mode == CrossingMode::Drive);
        let (mut goal, mut next_goal_s) = (goal, next_goal_s);
        if now_s >= next_goal_s {
            goal = sampled_inside(&mut self.rng, self.limits);
            next_goal_s = now_s + self.rng.between(2.0, 4.0);
        }
        // A boat that will drive out approaches the border first.
        if let Some(exit) = drive.filter(|exit| now_s >= exit.begin_s - 2.5) {
            let (u, v) = self.limits.inner;
            goal = (
                if exit.outwards.0 == 0.0 { goal.0 } else { exit.outwards.0 * u },
                if exit.outwards.1 == 0.0 { goal.1 } else { exit.outwards.1 * v },
            );
        }
        self.phase = Phase::Inside { goal, next_goal_s, exit };
        self.seek(goal, 1.2, MAX_INSIDE_PX_S * self.limits.relative, dt_s);
        if let Some(exit) = exit.filter(|exit| now_s >= exit.begin_s) {
            let outer = (self.limits.outer.0 * exit.outwards.0, self.limits.outer.1 * exit.outwards.1);
            let (du, dv) = ((outer.0 - self.at.0) * exit.outwards.0, (outer.1 - self.at.1) * exit.outwards.1);
            self.phase = Phase::Leaving { exit, speed: (du.abs() + dv.abs()) / DRIVE_S };
        }
        match drive {
            Some(exit) if now_s >= exit.begin_s - TURN_AHEAD_S => {
                BoatGoal::Towards(exit.outwards.0, exit.outwards.1)
            }
            _ => BoatGoal::Roam,
        }
    }

    /// The next exit, if the clip is long enough for it and for the return.
    fn plan_exit(&mut self, begin_s: f64) -> Option<Exit> {
        if self.kind == SceneKind::Manoeuvre
            || begin_s < FIRST_STAY_S.0 - 1.0
            || begin_s + ROUND_S > self.end_s
        {
            return None;
        }
        let outwards = self.rng.choose(&[(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]);
        let (u, v) = self.limits.outer;
        let along = self.rng.between(-0.6, 0.6);
        let goal = (
            if outwards.0 == 0.0 { along * u } else { outwards.0 * u },
            if outwards.1 == 0.0 { along * v } else { outwards.1 * v },
        );
        Some(Exit { mode: self.mode(), outwards, begin_s, goal })
    }

    fn mode(&mut self) -> CrossingMode {
        let omega = self.rng.between(1.8, 2.6);
        if self.rng.chance(0.5) { CrossingMode::Pan { omega } } else { CrossingMode::Drive }
    }

    fn start_absence(&mut self, now_s: f64) {
        let max_wait_s = (self.end_s - RETURN_S - now_s).clamp(WAIT_S.0, WAIT_S.1);
        let wait_s = self.rng.between(WAIT_S.0, max_wait_s);
        let from = self.circumference_position();
        // Distractors stay in view only if the camera does not go far.
        let max_distance = match self.kind {
            SceneKind::ExitAndReturnWithDistractor => 400.0,
            _ => 260.0 * wait_s,
        };
        let to = from + self.rng.between(-1.0, 1.0) * max_distance * self.limits.relative;
        let mode = self.mode();
        self.phase = Phase::Away { since_s: now_s, until_s: now_s + wait_s, from, to, mode };
    }

    fn start_return(&mut self, mode: CrossingMode) {
        let (u, v) = self.limits.inner;
        let goal = match mode {
            CrossingMode::Pan { .. } => sampled_inside(&mut self.rng, self.limits),
            CrossingMode::Drive => (self.at.0.clamp(-u, u), self.at.1.clamp(-v, v)),
        };
        let distance = libm::hypot(goal.0 - self.at.0, goal.1 - self.at.1);
        self.phase = Phase::Returning { mode, goal, speed: distance / DRIVE_S };
    }

    /// Unit vector to the nearest position well inside.
    fn inwards(&self) -> (f64, f64) {
        let (u, v) = self.limits.inner;
        let to =
            (self.at.0.clamp(-0.9 * u, 0.9 * u) - self.at.0, self.at.1.clamp(-0.9 * v, 0.9 * v) - self.at.1);
        let distance = libm::hypot(to.0, to.1).max(1e-9);
        (to.0 / distance, to.1 / distance)
    }

    /// A critically damped spring with a largest speed.
    fn seek(&mut self, goal: (f64, f64), omega: f64, max_speed: f64, dt_s: f64) {
        let pull = |at: f64, velocity: f64, goal: f64| {
            velocity + (omega * omega * (goal - at) - 2.0 * omega * velocity) * dt_s
        };
        let (vu, vv) = (pull(self.at.0, self.velocity.0, goal.0), pull(self.at.1, self.velocity.1, goal.1));
        let speed_limit = (max_speed / libm::hypot(vu, vv).max(1e-9)).min(1.0);
        self.advance((vu * speed_limit, vv * speed_limit), dt_s);
    }

    /// Moves with the boat, but at least at `speed` in a direction.
    fn ride_with_boat(&mut self, direction: (f64, f64), speed: f64, boat: (f64, f64), dt_s: f64) {
        let along = boat.0 * direction.0 + boat.1 * direction.1;
        let aside = (boat.0 - along * direction.0, boat.1 - along * direction.1);
        let forward = along.max(speed);
        let wanted = (forward * direction.0 + 0.4 * aside.0, forward * direction.1 + 0.4 * aside.1);
        let share = dt_s / RIDE_LAG_S;
        let velocity = (
            self.velocity.0 + (wanted.0 - self.velocity.0) * share,
            self.velocity.1 + (wanted.1 - self.velocity.1) * share,
        );
        self.advance(velocity, dt_s);
    }

    fn advance(&mut self, velocity: (f64, f64), dt_s: f64) {
        self.velocity = velocity;
        self.at = (self.at.0 + velocity.0 * dt_s, self.at.1 + velocity.1 * dt_s);
    }

    /// The point `along` px on the circumference of the outer limits, from the top right corner downwards.
    fn point_on_circumference(&self, along: f64) -> (f64, f64) {
        let (u, v) = self.limits.outer;
        let (right, bottom, left) = (2.0 * v, 2.0 * (u + v), 4.0 * v + 2.0 * u);
        let along = along.rem_euclid(4.0 * (u + v));
        if along < right {
            (u, along - v)
        } else if along < bottom {
            (u - (along - right), v)
        } else if along < left {
            (-u, v - (along - bottom))
        } else {
            (along - left - u, -v)
        }
    }

    /// The position on the circumference of the outer limits nearest to the present position.
    fn circumference_position(&self) -> f64 {
        let (u, v) = self.limits.outer;
        let (at_u, at_v) = (self.at.0.clamp(-u, u), self.at.1.clamp(-v, v));
        if self.at.0.abs() - u > self.at.1.abs() - v {
            if at_u > 0.0 { at_v + v } else { 2.0 * (u + v) + v - at_v }
        } else if at_v > 0.0 {
            2.0 * v + u - at_u
        } else {
            4.0 * v + 2.0 * u + at_u + u
        }
    }
}

fn sampled_inside(rng: &mut SplitMix64, limits: Limits) -> (f64, f64) {
    (rng.between(-0.8, 0.8) * limits.inner.0, rng.between(-0.8, 0.8) * limits.inner.1)
}
