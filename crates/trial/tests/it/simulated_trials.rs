//! Simulated trials: world, sensor and pilot in lock step.

use barrelman_control::{CentringGains, LawSettings};
use barrelman_pilot::{Input, Outcome, Pilot, PilotSettings};
use barrelman_sim::pursuit::PursuitScript;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{
    AxisRanges, CameraSetup, PlantRanges, Platform, Scenario, SensorModel, TargetScript,
};
use barrelman_sim::snapshot::Light;
use barrelman_sim::sway::Sway;
use barrelman_sim::{Optics, Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{RenderedCamera, Simulation, StepObserver};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::measure;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vision::{CamShift, CamShiftConfig};
use barrelman_vocab::{Angle, PictureSize, Timestamp, VehicleProfile, VehicleRates};

use crate::trial_world::{plain, pursuit};

/// A red target that moves to and fro in front of a camera 2 m above ground.
pub(crate) fn scenario(speed_m_per_s: f64) -> Scenario {
    let base = plain();
    let same = AxisRanges {
        start_dead_time_s: (0.1, 0.1),
        stop_dead_time_s: (0.1, 0.1),
        lag_s: (0.1, 0.1),
        gain: (1.0, 1.0),
    };
    let optics = Optics { picture: PictureSize::new(320, 180), focal_px: 165.0, barrel: 0.0 };
    Scenario {
        name: "to-and-fro".to_owned(),
        camera: CameraSetup { optics, frame: PictureSize::new(320, 240), ..base.camera },
        ranges: PlantRanges { focal_px: (165.0, 165.0), pan: same, tilt: same, ..base.ranges },
        platform: Platform::Swaying(Sway {
            yaw: OrnsteinUhlenbeck { std_dev: 0.01, time_constant_s: 1.0 },
            ..Sway::STILL
        }),
        light: Light { sun_elevation: Angle::from_degrees(60.0), ..base.light },
        target: TargetScript::Pursuit(PursuitScript {
            way_points: vec![(0.0, 4.0), (5.0, 4.0), (-5.0, 4.2), (3.0, 4.4)],
            speed_m_per_s,
            look_ahead_m: 0.4,
            way_point_jitter_m: 0.05,
            surge_lag_s: 0.3,
            stand_before_s: 0.5,
            stand_after_s: 0.5,
            ..pursuit()
        }),
        sensing: SensorModel {
            noise: OrnsteinUhlenbeck { std_dev: 0.3, time_constant_s: 0.0 },
            is_rounded: true,
            target_size_m: (0.3, 0.3),
            ..base.sensing
        },
        max_s: 40.0,
        ..base
    }
}

pub(crate) fn pilot(profile: &VehicleProfile, law: LawSettings) -> Pilot {
    let tracker = CamShift::new(CamShiftConfig::default()).expect("the defaults are in range");
    Pilot::new(PilotSettings { profile: profile.clone(), law }, Box::new(tracker))
}

fn run(scenario: &Scenario, seed: u64, law: LawSettings, observer: &mut dyn StepObserver) -> TrialLog {
    let profile = VehicleProfile::fotokite_pro();
    let world = World::new(scenario, seed).expect("a path");
    Simulation::new(scenario, world, seed, pilot(&profile, law), &profile).run(None, observer)
}

#[test]
fn the_same_seed_gives_the_same_log_and_another_does_not() {
    let scenario = scenario(1.2);
    assert_eq!(
        run(&scenario, 3, LawSettings::MotorSchema, &mut ()),
        run(&scenario, 3, LawSettings::MotorSchema, &mut ())
    );
    assert_ne!(
        run(&scenario, 3, LawSettings::MotorSchema, &mut ()),
        run(&scenario, 4, LawSettings::MotorSchema, &mut ())
    );
}

#[test]
fn a_trial_without_a_log_is_the_same_trial_and_keeps_no_row() {
    let (scenario, profile) = (scenario(1.2), VehicleProfile::fotokite_pro());
    let steps = |keeps_log: bool| {
        let world = World::new(&scenario, 3).expect("a path");
        let law = LawSettings::MotorSchema;
        let simulation = Simulation::new(&scenario, world, 3, pilot(&profile, law), &profile);
        let simulation = simulation.with_log(keeps_log);
        let mut steps = Steps::default();
        let log = simulation.run(None, &mut steps);
        (steps, log.rows.len(), log.truth.map(|rows| rows.len()))
    };
    let ((with, rows, truths), (without, no_rows, no_truths)) = (steps(true), steps(false));
    assert!(rows > 100 && truths == Some(rows), "{rows} rows");
    assert_eq!((no_rows, no_truths), (0, Some(0)));
    assert_eq!(with, without);
}

/// The rates of each step.
#[derive(Debug, Default, PartialEq)]
struct Steps(Vec<(Timestamp, VehicleRates)>);

impl StepObserver for Steps {
    fn on_step(&mut self, now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, rates: VehicleRates) {
        self.0.push((now, rates));
    }

    fn on_truth(&mut self, _truth: &Truth, _target: Option<&TargetInPicture>) {}
}

#[test]
fn the_schema_brings_the_target_back() {
    let log = run(&scenario(1.2), 3, LawSettings::MotorSchema, &mut ());
    let region = log.region(VehicleProfile::fotokite_pro().region);
    let metrics = measure(&log, region, log.picture);
    assert!(metrics.complete_excursions >= 2, "{metrics:?}");
    assert_eq!(metrics.lost, Some(false), "{metrics:?}");
    assert!(metrics.jerk_rad_per_s3.is_some_and(|jerk| jerk > 0.0), "{metrics:?}");
    // Every command is at the rate of the motor schema.
    let effort = metrics.effort_rad2_per_s.expect("rates are known");
    let travel = metrics.travel_rad.expect("rates are known");
    assert!((effort - 0.3 * travel).abs() < 1e-9, "{effort} and {travel}");
}

#[test]
fn a_camera_that_centres_works_more_and_the_target_leaves_less() {
    let figures = |law| {
        let log = run(&scenario(1.2), 3, law, &mut ());
        measure(&log, log.region(VehicleProfile::fotokite_pro().region), log.picture)
    };
    let (schema, centre) =
        (figures(LawSettings::MotorSchema), figures(LawSettings::Centring(CentringGains::HAND_TUNED)));
    assert!(centre.time_outside_s < schema.time_outside_s, "{centre:?} and {schema:?}");
    assert!(centre.travel_rad > schema.travel_rad, "{centre:?} and {schema:?}");
    assert!(centre.duty > schema.duty, "{centre:?} and {schema:?}");
}

#[test]
fn a_target_that_outruns_the_camera_is_lost_by_its_truth() {
    let log = run(&scenario(9.0), 3, LawSettings::MotorSchema, &mut ());
    let metrics = measure(&log, log.region(VehicleProfile::fotokite_pro().region), log.picture);
    assert!(metrics.out_of_picture_s.is_some_and(|s| s > 1.0), "{metrics:?}");
}

/// Counts the calls of an observer.
#[derive(Default)]
struct CountingObserver {
    steps: usize,
    truths: usize,
    rates: Vec<VehicleRates>,
}

impl StepObserver for CountingObserver {
    fn on_step(&mut self, _now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, rates: VehicleRates) {
        self.steps += 1;
        self.rates.push(rates);
    }

    fn on_truth(&mut self, _truth: &Truth, _target: Option<&TargetInPicture>) {
        self.truths += 1;
    }
}

#[test]
fn an_observer_is_told_of_every_picture_and_every_step() {
    let mut observer = CountingObserver::default();
    let log = run(&scenario(1.2), 3, LawSettings::MotorSchema, &mut observer);
    assert!(observer.truths >= log.rows.len(), "{} pictures, {} rows", observer.truths, log.rows.len());
    assert!(observer.steps > log.rows.len(), "the request to engage is a step too");
    assert!(observer.rates.iter().any(|rates| !rates.is_rest()));
}

#[test]
fn in_pixels_the_target_is_selected_and_followed_alike_with_any_instructions() {
    let mut scenario = scenario(0.8);
    scenario.max_s = 4.0;
    let profile = VehicleProfile::fotokite_pro();
    let pixels = |level| {
        let world = World::new(&scenario, 5).expect("a path");
        let mut camera = RenderedCamera::new(
            &world,
            scenario.camera.clone(),
            5,
            Simd::at_most(level),
            &barrelman_sim::render::Serial,
        );
        let pilot = pilot(&profile, LawSettings::MotorSchema);
        Simulation::new(&scenario, world, 5, pilot, &profile).run(Some(&mut camera), &mut ())
    };
    let log = pixels(SimdLevel::Baseline);
    #[cfg(target_arch = "x86_64")]
    assert_ne!(
        Simd::at_most(SimdLevel::Avx512).level(),
        SimdLevel::Baseline,
        "this machine has one vector level: nothing would be compared"
    );
    assert_eq!(log, pixels(SimdLevel::Avx512));
    let metrics = measure(&log, log.region(profile.region), log.picture);
    assert!(metrics.perception.tracked.is_some_and(|share| share > 0.9), "{metrics:?}");
}

/// The motor schema, simulated on the bearings of its own trial, gives the commands of that trial.
#[test]
fn the_shadow_of_the_schema_is_the_schema() {
    let log = run(&scenario(1.2), 3, LawSettings::MotorSchema, &mut ());
    let mut profile = VehicleProfile::fotokite_pro();
    profile.video_latency = scenario(1.2).camera.latency();
    let region = log.region(profile.region);
    let shadow = barrelman_trial::shadow::simulate_motor_schema(&log, region, &profile);
    let mut compared = 0;
    for (row, step) in log.rows.iter().zip(&shadow) {
        let (Some(command), Some(step)) = (row.command, step) else { continue };
        assert_eq!(profile.from_vehicle(profile.to_vehicle(step.command)), command, "at {} s", row.time_s);
        compared += 1;
    }
    assert!(compared > 300, "{compared} rows");
}
