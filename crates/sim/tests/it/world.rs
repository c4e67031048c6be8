//! The world of a trial as a whole.

use barrelman_sim::pursuit::{Pursuit, PursuitScript, REFERENCE_RANGE_M};
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{BeyondBorder, Platform, TargetScript};
use barrelman_sim::sway::Sway;
use barrelman_sim::{LocalisationSensor, Scenario, Truth, World};
use barrelman_vocab::{Angle, AngularRate, CameraCommand};

use crate::trial_world::{plain, pursuit};

fn truths(seed: u64, ticks: u64, swaying: bool) -> Vec<Truth> {
    let mut scenario = plain();
    if swaying {
        let model = OrnsteinUhlenbeck { std_dev: 0.05, time_constant_s: 1.0 };
        scenario.platform =
            Platform::Swaying(Sway { yaw: model, pitch: model, roll: model, position: model });
    }
    let mut world = World::new(&scenario, seed).expect("a path");
    (0..ticks)
        .map(|_| {
            world.advance();
            world.truth()
        })
        .collect()
}

#[test]
fn the_same_seed_is_the_same_trial_and_another_is_not() {
    assert_eq!(truths(7, 600, true), truths(7, 600, true));
    assert_ne!(truths(7, 600, true), truths(8, 600, true));
}

#[test]
fn without_chance_every_seed_is_the_same_trial() {
    assert_eq!(truths(7, 600, false), truths(8, 600, false));
}

#[test]
fn the_first_view_points_at_the_target() {
    let world = World::new(&plain(), 1).expect("a path");
    let truth = world.truth();
    assert!(truth.image.x.abs() < 1e-6 && truth.image.y.abs() < 1e-6, "{:?}", truth.image);
    assert!(truth.in_picture);
    assert!((truth.range_m - 6.0).abs() < 1e-9, "{}: root of 16 + 16 + 4", truth.range_m);
}

#[test]
fn a_target_that_moves_right_is_seen_to_move_right_and_pan_follows_it() {
    let mut still = World::new(&plain(), 1).expect("a path");
    let mut turning = World::new(&plain(), 1).expect("a path");
    let rate = AngularRate::from_radians_per_second(0.15);
    turning.command(CameraCommand::turning(rate, AngularRate::ZERO));
    for _ in 0..360 {
        still.advance();
        turning.advance();
    }
    let (still, turning) = (still.truth(), turning.truth());
    assert!(still.image.x > 100.0, "{:?}", still.image);
    assert!(turning.image.x < still.image.x - 100.0, "{:?} and {:?}", turning.image, still.image);
    assert!((turning.rates.0 - 0.15).abs() < 1e-3, "the lag is over: {:?}", turning.rates);
}

#[test]
fn a_trial_is_over_at_the_end_of_the_path_or_of_its_time() {
    let mut world = World::new(&plain(), 1).expect("a path");
    while !world.is_over() {
        world.advance();
    }
    let (x, s) = (world.target_pose().position.x, world.now().as_secs_f64());
    assert!(x > 3.7, "{x}");
    assert!((7.5..10.0).contains(&s), "8 m at 1 m/s, and a start from rest: {s}");
    let mut short = plain();
    short.max_s = 2.0;
    let mut world = World::new(&short, 1).expect("a path");
    while !world.is_over() {
        world.advance();
    }
    assert_eq!(world.tick(), 240);
}

#[test]
fn the_direction_of_the_bow_is_measured_where_the_scenario_says_so() {
    let mut scenario = plain();
    let mut world = World::new(&scenario, 1).expect("a path");
    for _ in 0..240 {
        world.advance();
    }
    let truth = world.truth();
    let measure = |scenario: &Scenario| {
        LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), 1)
            .measure(&truth)
            .expect("in the picture")
    };
    assert_eq!(measure(&scenario).heading, None);
    scenario.sensing.heading_std_dev = Some(Angle::ZERO);
    let exact = measure(&scenario).heading.expect("a heading").degrees();
    // The target goes to the right of the picture: 0 or nearly 360 degrees.
    assert!(exact.min(360.0 - exact) < 25.0, "{exact}");
    scenario.sensing.heading_std_dev = Some(Angle::from_degrees(8.0));
    let noisy = measure(&scenario).heading.expect("a heading").degrees();
    let off = (noisy - exact + 180.0).rem_euclid(360.0) - 180.0;
    assert!(off != 0.0 && off.abs() < 40.0, "{exact} {noisy}");
}

#[test]
fn a_target_out_of_the_picture_is_absent_or_clamped_as_the_scenario_says() {
    let mut scenario = plain();
    let away = |world: &mut World| {
        while world.truth().in_picture {
            world.advance();
        }
        world.truth()
    };
    let truth = away(&mut World::new(&scenario, 1).expect("a path"));
    let absent = LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), 1).measure(&truth);
    assert_eq!(absent, None);
    scenario.sensing.beyond_border = BeyondBorder::Clamped { x_px: 316.0, y_px: 177.0 };
    let clamped = LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), 1)
        .measure(&truth)
        .expect("clamped");
    assert_eq!(clamped.centre.in_image(clamped.picture).x, 316.0);
}

#[test]
fn a_drawn_plant_lies_in_its_ranges_and_differs_from_seed_to_seed() {
    let scenario = plain();
    let mut focal = Vec::new();
    for seed in 0..200 {
        let drawn = scenario.with_sampled_plant(seed);
        assert_eq!(drawn, scenario.with_sampled_plant(seed));
        let pan = drawn.mount.pan;
        assert!((0.1..=0.2).contains(&pan.start_dead_time_s), "{seed}: {pan:?}");
        assert!((0.3..=0.4).contains(&pan.stop_dead_time_s), "{seed}: {pan:?}");
        assert!((0.2..=0.4).contains(&drawn.mount.tilt.lag_s), "{seed}: {pan:?}");
        focal.push(drawn.camera.optics.focal_px);
    }
    let (low, high) =
        focal.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), f| (low.min(*f), high.max(*f)));
    assert!(low >= 300.0 && high <= 360.0 && high - low > 50.0, "{low} to {high}");
}

#[test]
fn way_points_in_one_place_make_no_world() {
    let mut scenario = plain();
    let TargetScript::Pursuit(script) = &mut scenario.target else { panic!("it pursues") };
    script.way_points = vec![(1.0, 1.0), (1.0, 1.0)];
    assert!(World::new(&scenario, 1).is_err());
}

/// The target's way to the end of its path: its length, the speed half a metre before the end, and the end
/// point.
fn way(script: PursuitScript) -> (f64, f64, (f64, f64)) {
    let mut target = Pursuit::new(script, 3).expect("the way-points make a path");
    let (mut length, mut before_end, mut tick) = (0.0, 0.0, 0);
    while !target.is_over() {
        let from = target.position();
        target.advance(tick);
        tick += 1;
        assert!(tick < 12_000, "it does not arrive");
        let to = target.position();
        let (east, north) = (to.0 - from.0, to.1 - from.1);
        length += (east * east + north * north).sqrt();
        if to.0 < 3.5 {
            before_end = target.speed_m_per_s();
        }
    }
    (length, before_end, target.position())
}

#[test]
fn a_target_comes_to_rest_over_the_last_metres() {
    let (_, at_once, _) = way(pursuit());
    let (_, slowly, _) = way(PursuitScript { arrival_m: 2.0, ..pursuit() });
    assert!((at_once - 1.0).abs() < 0.01, "{at_once}");
    // A quarter of the way is left, so half of the speed, but for the lag of a tenth of a second.
    assert!((slowly - 0.5).abs() < 0.05, "{slowly}");
}

#[test]
fn a_target_that_weaves_goes_a_longer_way_to_the_same_end() {
    let (straight, ..) = way(pursuit());
    let weave = OrnsteinUhlenbeck { std_dev: 0.5, time_constant_s: 0.5 };
    let (weaving, _, end) = way(PursuitScript { weave, ..pursuit() });
    assert!(weaving > 1.03 * straight, "{weaving} m, {straight} m");
    assert!((end.0 - 4.0).abs() < 0.4 && (end.1 - 4.0).abs() < 0.4, "{end:?}");
}

#[test]
fn a_target_pauses_at_the_corners_that_it_is_to_pause_at() {
    let script = |corner_pauses: f64| PursuitScript {
        way_points: vec![(0.0, 4.0), (2.0, 4.0), (2.0, 6.0), (2.0, 8.0), (4.0, 8.0)],
        corner_slow_down: 0.0,
        corner_pauses,
        pause_s: 1.5,
        ..pursuit()
    };
    let pauses = |corner_pauses: f64, seed: u64| {
        let mut target = Pursuit::new(script(corner_pauses), seed).expect("a path");
        let (mut places, mut stood) = (Vec::new(), true);
        for tick in 0..120 * 60 {
            target.advance(tick);
            let stands = target.speed_m_per_s() < 0.05;
            if stands && !stood && !target.is_over() {
                places.push(target.position());
            }
            stood = stands;
        }
        places
    };
    // Of 80 corners; one pause in five is over before it has come to rest.
    let (mut all, mut some) = (0, 0);
    for seed in 0..40 {
        assert!(pauses(0.0, seed).len() <= 1, "it stands at its end alone");
        for (x, y) in pauses(1.0, seed) {
            let near = |corner: (f64, f64)| libm::hypot(x - corner.0, y - corner.1) < 0.7;
            assert!(near((2.0, 4.0)) || near((2.0, 8.0)) || near((4.0, 8.0)), "it stands at {x}, {y}");
        }
        all += pauses(1.0, seed).len();
        some += pauses(0.5, seed).len();
    }
    assert!((55..=75).contains(&all), "{all} pauses at all corners");
    assert!((22..=45).contains(&some), "{some} at half of them");
}

#[test]
fn a_target_goes_from_corner_to_corner_with_a_rhythm_and_arrives() {
    let fastest_near = |leg_end_slow_down: f64| {
        let script = PursuitScript {
            way_points: vec![(0.0, 4.0), (6.0, 4.0), (6.0, 10.0)],
            speed_m_per_s: 1.0,
            corner_slow_down: 0.0,
            leg_end_slow_down,
            ..pursuit()
        };
        let mut target = Pursuit::new(script, 1).expect("a path");
        let places = [(0.0, 4.0), (3.0, 4.0), (6.0, 4.0), (6.0, 7.0), (6.0, 10.0)];
        let mut fastest = places.map(|_| 0.0_f64);
        for tick in 0..120 * 120 {
            target.advance(tick);
            let (x, y) = target.position();
            for (fastest, position) in fastest.iter_mut().zip(places) {
                if libm::hypot(x - position.0, y - position.1) < 0.3 {
                    *fastest = fastest.max(target.speed_m_per_s());
                }
            }
        }
        assert!(target.is_over(), "it has not arrived with a rhythm of {leg_end_slow_down}");
        fastest
    };
    for fastest in fastest_near(0.0) {
        assert!((fastest - 1.0).abs() < 0.05, "steady: {fastest} m/s");
    }
    let [start, middle, corner, further, end] = fastest_near(0.8);
    for fastest in [middle, further] {
        assert!((fastest - 1.0).abs() < 0.05, "in the middle of a leg: {fastest} m/s");
    }
    for fastest in [start, corner, end] {
        assert!((0.2..0.6).contains(&fastest), "at the end of a leg: {fastest} m/s");
    }
    fastest_near(0.95);
}

#[test]
fn a_target_goes_faster_where_it_is_far_by_the_power_that_it_is_told() {
    let speed_at = |distance_m: f64, range_exponent: f64| {
        let way_points = vec![(-1.0, distance_m), (1.0, distance_m)];
        let script = PursuitScript { way_points, speed_m_per_s: 0.8, range_exponent, ..pursuit() };
        let mut target = Pursuit::new(script, 1).expect("a path");
        let mut passes_middle = |tick: u64| {
            target.advance(tick);
            target.position().0 >= 0.0
        };
        assert!((0..120 * 60).any(&mut passes_middle), "it does not get there");
        target.speed_m_per_s()
    };
    for (distance_m, range_exponent, speed) in [
        (8.0, 0.0, 0.8),
        (REFERENCE_RANGE_M, 0.5, 0.8),
        (4.0 * REFERENCE_RANGE_M, 0.5, 1.6),
        (0.25 * REFERENCE_RANGE_M, 1.0, 0.2),
    ] {
        let found = speed_at(distance_m, range_exponent);
        assert!((found / speed - 1.0).abs() < 0.05, "{found} m/s at {distance_m} m, power {range_exponent}");
    }
}

#[test]
fn a_localisation_is_off_by_as_much_and_for_as_long_as_the_scenario_says() {
    let mut scenario = plain();
    let pictures: Vec<Truth> = truths(1, 120 * 60, false).into_iter().step_by(4).collect();
    let mut errors = |time_s: f64| {
        scenario.sensing.noise = OrnsteinUhlenbeck { std_dev: 0.6, time_constant_s: time_s };
        scenario.sensing.beyond_border = BeyondBorder::Clamped { x_px: 1e9, y_px: 1e9 };
        let mut all = Vec::new();
        for seed in 0..20 {
            let mut sensor = LocalisationSensor::new(scenario.sensing, scenario.camera.clone(), seed);
            let of_trial = pictures.iter().map(|truth| {
                let seen = sensor.measure(truth).expect("clamped");
                seen.centre.in_image(seen.picture).y - truth.image.y
            });
            all.push(of_trial.collect::<Vec<f64>>());
        }
        let mean =
            |of: &dyn Fn(&[f64]) -> f64| all.iter().map(|trial| of(trial)).sum::<f64>() / all.len() as f64;
        let square = mean(&|trial| trial.iter().map(|x| x * x).sum::<f64>() / trial.len() as f64);
        let pairs = |trial: &[f64]| {
            trial.windows(31).map(|window| window[0] * window[30]).sum::<f64>() / (trial.len() - 30) as f64
        };
        (square.sqrt(), mean(&pairs) / square)
    };
    let (std_dev, after_1_s) = errors(1.0);
    assert!(
        (std_dev - 0.6).abs() < 0.05 && (after_1_s - libm::exp(-1.0)).abs() < 0.1,
        "{std_dev} {after_1_s}"
    );
    let (std_dev, after_1_s) = errors(0.0);
    assert!((std_dev - 0.6).abs() < 0.02 && after_1_s.abs() < 0.03, "{std_dev} {after_1_s}");
}
