//! The simulated world of two axes, with exact localisations.

use std::time::Duration;

use barrelman_control::{CameraLaw, Law, LawInput, Percept};
use barrelman_sim::camera_axis::CameraAxis;
use barrelman_sim::tick::{TICK_S, TICKS_PER_SECOND};
use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{Angle, AngularRate, ImagePoint, PictureSize, Timestamp, VehicleProfile};

use super::super::axis_model::{
    Axis, DEAD_TIME_S, FOCAL_PX, LAG_S, MAX_RATE, REGION, STEP_S, STEPS_PER_SECOND, axis_at_rest,
};
use super::super::model_figures::Figures;
use super::policy::{Policy, Situation};
use super::target::{SeenBearing, TargetPath};

const PICTURE: PictureSize = PictureSize::new(640, 480);
/// The largest |x| and |y| of a place, pixels: beyond the picture's edge the place is the edge, as the recorded tracker's.
const MAX_PLACE: [f64; 2] = [316.0, 236.0];
const TICKS_PER_PICTURE: usize = (TICKS_PER_SECOND / 30) as usize;
pub(super) const TICKS_PER_POLICY_STEP: usize = (TICKS_PER_SECOND / STEPS_PER_SECOND) as usize;

/// The vehicle: both axes alike, all dead times alike, a level camera.
pub(super) fn profile() -> VehicleProfile {
    let mut profile = VehicleProfile::fotokite_pro();
    let camera = &mut profile.camera;
    camera.focal_share = FOCAL_PX / f64::from(PICTURE.width);
    camera.initial_tilt = Angle::ZERO;
    camera.tilt_stops = (Angle::from_radians(-1.5), Angle::from_radians(1.5));
    for axis in [&mut camera.pan, &mut camera.tilt] {
        axis.start_dead_time = Duration::from_secs_f64(DEAD_TIME_S);
        axis.stop_dead_time = axis.start_dead_time;
        axis.lag = Duration::from_secs_f64(LAG_S);
    }
    let limit = AngularRate::from_radians_per_second(MAX_RATE);
    profile.limits = AxisRates { pan: limit, tilt: limit };
    profile
}

/// Target and axes.
struct World<'a> {
    path: &'a TargetPath,
    axes: [CameraAxis; 2],
    tick: usize,
    command: [f64; 2],
    figures: Figures,
}

impl<'a> World<'a> {
    fn new(path: &'a TargetPath) -> Self {
        let axes = [0, 1].map(|_| axis_at_rest());
        Self { path, axes, tick: 0, command: [0.0; 2], figures: Figures::default() }
    }

    fn is_over(&self) -> bool {
        self.tick >= self.path.ticks()
    }

    fn now(&self) -> Timestamp {
        Timestamp::from_secs_f64(self.tick as f64 * TICK_S)
    }

    fn pointing(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.axes[axis].angle().radians())
    }

    fn seen(&self) -> SeenBearing {
        SeenBearing::of(self.path.at(self.tick).bearing)
    }

    fn set_command(&mut self, rates: [f64; 2]) {
        let rates = rates.map(|rate| rate.clamp(-MAX_RATE, MAX_RATE));
        self.figures.add_change(self.command, rates);
        self.command = rates;
        for (axis, rate) in self.axes.iter_mut().zip(rates) {
            axis.command(AngularRate::from_radians_per_second(rate), self.tick as u64);
        }
    }

    fn advance(&mut self) {
        self.figures.add_tick(self.seen().radius(self.pointing()) > 1.0, self.command);
        for axis in &mut self.axes {
            axis.advance(self.tick as u64);
        }
        self.tick += 1;
    }
}

/// Simulates a trial of a law. Its pictures arrive at once, with the target's exact place.
pub(super) fn simulate_law(law: Box<dyn Law>, path: &TargetPath) -> Figures {
    let mut world = World::new(path);
    let mut law = CameraLaw::from_law(law, &profile());
    while !world.is_over() {
        if world.tick.is_multiple_of(TICKS_PER_PICTURE)
            && let Some([x, y]) = world.seen().in_picture(world.pointing())
        {
            let now = world.now();
            let [x, y] = [(x, MAX_PLACE[0]), (y, MAX_PLACE[1])]
                .map(|(place, max)| (FOCAL_PX * place).clamp(-max, max));
            let percept = Percept::new(ImagePoint { x, y }, REGION);
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
            world.set_command([command.pan, command.tilt].map(AngularRate::radians_per_second));
        }
        world.advance();
    }
    world.figures
}

/// Simulates a trial of a policy, which knows the target's bearing and rates.
pub(super) fn simulate_policy(policy: &mut impl Policy, path: &TargetPath) -> Figures {
    let mut world = World::new(path);
    let mut ahead = [Axis { angle: 0.0, rate: 0.0 }; 2];
    while !world.is_over() {
        if world.tick.is_multiple_of(TICKS_PER_POLICY_STEP) {
            let situation = Situation { target: path.at(world.tick), ahead, command: world.command };
            let rates = policy.decide(&situation, world.tick);
            world.set_command(rates);
            ahead = [0, 1].map(|axis| ahead[axis].after(rates[axis], STEP_S));
        }
        world.advance();
    }
    world.figures
}
