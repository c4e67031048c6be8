//! The simulated world of one axis, with exact localisations.

use std::time::Duration;

use barrelman_control::{CameraLaw, Law, LawInput, Percept};
use barrelman_sim::camera_axis::CameraAxis;
use barrelman_sim::tick::{TICK_S, TICKS_PER_SECOND};
use barrelman_vocab::{Angle, AngularRate, ImagePoint, PictureSize, Timestamp, VehicleProfile};

use super::super::axis_model::{
    Axis, DEAD_TIME_S, FOCAL_PX, LAG_S, MAX_RATE, RATE_STD_DEV, RATE_TIME_CONSTANT_S, REGION, STEP_S,
    STEPS_PER_SECOND, axis_at_rest, edge,
};
use super::super::model_figures::{Figures, TRIAL_S};
use super::dynamic_programming::DynamicProgramme;
use crate::rng::Rng;

const PICTURE: PictureSize = PictureSize::new(640, 360);
const TICKS_PER_PICTURE: u32 = TICKS_PER_SECOND / 30;
const TICKS_PER_POLICY_STEP: u32 = TICKS_PER_SECOND / STEPS_PER_SECOND;

/// The vehicle whose pan axis this is: both dead times alike, a level camera.
pub(super) fn profile() -> VehicleProfile {
    let mut profile = VehicleProfile::fotokite_pro();
    let dead_time = Duration::from_secs_f64(DEAD_TIME_S);
    profile.camera.focal_share = FOCAL_PX / f64::from(PICTURE.width);
    profile.camera.initial_tilt = Angle::ZERO;
    profile.camera.pan.start_dead_time = dead_time;
    profile.camera.pan.stop_dead_time = dead_time;
    profile.camera.pan.lag = Duration::from_secs_f64(LAG_S);
    profile.limits.pan = AngularRate::from_radians_per_second(MAX_RATE);
    profile
}

/// Target and axis.
struct World {
    bearing: f64,
    bearing_rate: f64,
    axis: CameraAxis,
    rng: Rng,
    tick: u64,
    command: f64,
    figures: Figures,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = Rng::from_name("one axis", seed);
        Self {
            bearing: 0.0,
            bearing_rate: RATE_STD_DEV * rng.approximately_normal(),
            axis: axis_at_rest(),
            rng,
            tick: 0,
            command: 0.0,
            figures: Figures::default(),
        }
    }

    fn is_over(&self) -> bool {
        self.tick as f64 * TICK_S >= TRIAL_S
    }

    fn now(&self) -> Timestamp {
        Timestamp::from_secs_f64(self.tick as f64 * TICK_S)
    }

    fn offset(&self) -> f64 {
        self.bearing - self.axis.angle().radians()
    }

    fn set_command(&mut self, rate: f64) {
        self.figures.add_change([self.command], [rate]);
        self.command = rate;
        self.axis.command(AngularRate::from_radians_per_second(rate), self.tick);
    }

    fn advance(&mut self) {
        self.figures.add_tick(self.offset().abs() > edge(), [self.command]);
        let decay = (-TICK_S / RATE_TIME_CONSTANT_S).exp();
        self.bearing += RATE_TIME_CONSTANT_S * (1.0 - decay) * self.bearing_rate;
        let spread = RATE_STD_DEV * (1.0 - decay * decay).sqrt();
        self.bearing_rate = decay * self.bearing_rate + spread * self.rng.approximately_normal();
        self.axis.advance(self.tick);
        self.tick += 1;
    }
}

/// Simulates a trial of a law. Its pictures arrive at once, with the target's exact place.
pub(super) fn simulate_law(law: Box<dyn Law>, seed: u64) -> Figures {
    let mut world = World::new(seed);
    let mut law = CameraLaw::from_law(law, &profile());
    while !world.is_over() {
        if world.tick.is_multiple_of(u64::from(TICKS_PER_PICTURE)) {
            let now = world.now();
            // Beyond the picture's edge the place is the edge, as the recorded tracker's.
            let x = (FOCAL_PX * world.offset().clamp(-1.4, 1.4).tan()).clamp(-316.0, 316.0);
            let percept = Percept::new(ImagePoint { x, y: 0.0 }, REGION);
            let input = LawInput {
                percept: &percept,
                region: REGION,
                picture: PICTURE,
                captured: now,
                is_measured: true,
                now,
            };
            let command = law.command(&input);
            law.on_command_applied(command, now);
            world.set_command(command.pan.radians_per_second().clamp(-MAX_RATE, MAX_RATE));
        }
        world.advance();
    }
    world.figures
}

/// Simulates a trial of a policy, which knows the target's bearing and rate.
pub(super) fn simulate_policy(programme: &DynamicProgramme, seed: u64) -> Figures {
    let mut world = World::new(seed);
    // The axis at the time at which a command given now takes effect.
    let mut ahead = Axis { angle: 0.0, rate: 0.0 };
    while !world.is_over() {
        if world.tick.is_multiple_of(u64::from(TICKS_PER_POLICY_STEP)) {
            let decay = (-DEAD_TIME_S / RATE_TIME_CONSTANT_S).exp();
            let bearing = world.bearing + RATE_TIME_CONSTANT_S * (1.0 - decay) * world.bearing_rate;
            let rate = programme.decide(
                bearing - ahead.angle,
                decay * world.bearing_rate,
                ahead.rate,
                world.command,
            );
            world.set_command(rate);
            ahead = ahead.after(rate, STEP_S);
        }
        world.advance();
    }
    world.figures
}
