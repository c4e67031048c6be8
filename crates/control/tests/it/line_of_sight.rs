//! The line-of-sight law with a simple vessel: where it goes, where it stops, what it keeps away from.

use std::time::Duration;

use barrelman_control::guidance::track::BoatTrack;
use barrelman_control::guidance::{
    BoatFix, Destination, GuidanceInput, GuidanceState, GuidanceStep, KeepOut, LineOfSight,
    LineOfSightTuning, VesselLimits, VesselModel,
};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{Angle, Timestamp, VesselCommand, WaterCovariance, WaterFix, WaterPoint};

const FRAME_S: f64 = 1.0 / 15.0;
const LATENCY: Duration = Duration::from_millis(200);

/// A vessel that turns by its thrust, with lags, carried by a current; and its law.
struct Scene {
    law: LineOfSight,
    at: WaterPoint,
    heading: f64,
    speed: f64,
    yaw: f64,
    thrust: f64,
    current: (f64, f64),
    gives_heading: bool,
    noise: SplitMix64,
    frame: u64,
    pending: Vec<BoatFix>,
    way_points: Vec<WaterPoint>,
    keep_outs: Vec<KeepOut>,
    limits: VesselLimits,
    route: u32,
}

impl Scene {
    fn new(heading_deg: f64) -> Self {
        Self {
            law: LineOfSight::new(LineOfSightTuning::DEFAULT, VesselModel::JET),
            at: WaterPoint { x: 0.0, y: 0.0 },
            heading: heading_deg.to_radians(),
            speed: 0.0,
            yaw: 0.0,
            thrust: 0.0,
            current: (0.0, 0.0),
            gives_heading: false,
            noise: SplitMix64::new(1),
            frame: 0,
            pending: Vec::new(),
            way_points: Vec::new(),
            keep_outs: Vec::new(),
            limits: VesselLimits::DEFAULT,
            route: 1,
        }
    }

    fn now(&self) -> Timestamp {
        Timestamp::from_secs_f64(self.frame as f64 * FRAME_S)
    }

    /// One video frame, with a measurement or without.
    fn step(&mut self, destination: Option<Destination>, is_measured: bool) -> GuidanceStep {
        let now = self.now();
        let noise = || 0.1 * (self.noise.uniform() - 0.5);
        let mut noise = noise;
        let point = WaterPoint { x: self.at.x + noise(), y: self.at.y + noise() };
        let heading = (Angle::from_radians(self.heading), Angle::from_degrees(8.0));
        self.pending.push(BoatFix {
            captured: now,
            water: WaterFix { point, covariance: WaterCovariance::isotropic(0.05) },
            heading: self.gives_heading.then_some(heading),
            is_commanded: true,
            sway_per_s: None,
        });
        let arrives = self.pending.iter().position(|fix| now.since(fix.captured) >= LATENCY);
        let fix = arrives.map(|index| self.pending.remove(index)).filter(|_| is_measured);
        let step = self.law.step(&GuidanceInput {
            now,
            fix,
            destination,
            route: self.route,
            way_points: &self.way_points,
            keep_outs: &self.keep_outs,
            limits: self.limits,
        });
        self.law.on_command_applied(step.command, now);
        for _ in 0..8 {
            self.advance(step.command, FRAME_S / 8.0);
        }
        self.frame += 1;
        step
    }

    fn advance(&mut self, command: VesselCommand, dt: f64) {
        self.thrust += (command.throttle - self.thrust) * dt / 0.25;
        let braking = if self.thrust < 0.0 { 2.0 } else { 1.2 };
        self.speed += (3.6 * self.thrust - self.speed) * dt / braking;
        self.yaw += (1.8 * self.thrust.max(0.0) * command.rudder - self.yaw) * dt / 0.4;
        self.heading += self.yaw * dt;
        let (sin, cos) = libm::sincos(self.heading);
        self.at.x += (self.speed * sin + self.current.0) * dt;
        self.at.y += (self.speed * cos + self.current.1) * dt;
    }

    /// Steps for some seconds; calls `check` after each step.
    fn run(&mut self, destination: Destination, seconds: f64, mut check: impl FnMut(&Self, &GuidanceStep)) {
        for _ in 0..(seconds / FRAME_S) as u64 {
            let step = self.step(Some(destination), true);
            let VesselCommand { throttle, rudder } = step.command;
            assert!(throttle <= self.limits.ahead + 1e-12 && throttle >= -self.limits.astern - 1e-12);
            assert!(rudder.abs() <= self.limits.rudder + 1e-12);
            check(self, &step);
        }
    }
}

fn place(x: f64, y: f64) -> Destination {
    Destination::Place(WaterPoint { x, y })
}

fn person(x: f64, y: f64) -> Destination {
    Destination::Person {
        at: WaterPoint { x, y },
        velocity_m_per_s: (0.0, 0.0),
        stand_off_m: 2.0,
        uncertainty_m: 0.3,
    }
}

#[test]
fn the_boat_goes_to_a_place_from_any_heading_and_stays_there() {
    for heading_deg in [0.0, 80.0, 170.0, -120.0] {
        for current in [(0.0, 0.0), (0.3, 0.1), (-0.2, -0.3)] {
            let mut scene = Scene { current, ..Scene::new(heading_deg) };
            let goal = WaterPoint { x: 3.0, y: 20.0 };
            let mut worst_m: f64 = 0.0;
            scene.run(Destination::Place(goal), 90.0, |scene, _| {
                if scene.frame > 40 * 15 {
                    worst_m = worst_m.max(scene.at.distance_to(goal));
                }
            });
            assert!(worst_m < 5.0, "heading {heading_deg}, current {current:?}: {worst_m} m away");
        }
    }
}

#[test]
fn the_boat_keeps_to_the_line_across_a_current() {
    let mut scene = Scene { current: (0.35, 0.0), ..Scene::new(0.0) };
    let mut worst_m: f64 = 0.0;
    scene.run(place(0.0, 40.0), 14.0, |scene, _| {
        if scene.frame > 6 * 15 {
            worst_m = worst_m.max(scene.at.x.abs());
        }
    });
    assert!(scene.at.y > 20.0 && worst_m < 0.5, "{worst_m} m off the line");
}

#[test]
fn the_boat_stops_before_a_person_and_stays_outside_of_the_stand_off() {
    for heading_deg in [0.0, 40.0, -100.0] {
        let mut scene = Scene::new(heading_deg);
        let at = WaterPoint { x: 2.0, y: 18.0 };
        let mut states = Vec::new();
        scene.run(person(at.x, at.y), 60.0, |scene, step| {
            assert!(scene.at.distance_to(at) > 2.3, "{} m from the person", scene.at.distance_to(at));
            states.push(step.state);
        });
        assert!(scene.at.distance_to(at) < 5.5, "{} m away", scene.at.distance_to(at));
        assert!(states.contains(&GuidanceState::StandingOff));
    }
}

#[test]
fn a_vessel_that_cannot_go_astern_stops_before_a_person_too() {
    let mut scene = Scene::new(0.0);
    scene.limits.astern = 0.0;
    let at = WaterPoint { x: 0.0, y: 18.0 };
    scene.run(person(at.x, at.y), 60.0, |scene, _| {
        assert!(scene.at.distance_to(at) > 2.3, "{} m from the person", scene.at.distance_to(at));
    });
}

#[test]
fn the_boat_goes_around_circles_and_arrives() {
    let circle = |x: f64, y: f64, radius_m: f64| KeepOut { centre: WaterPoint { x, y }, radius_m };
    for keep_outs in [
        vec![circle(0.0, 12.0, 3.0)],
        vec![circle(0.5, 12.0, 3.0), circle(-7.0, 13.0, 2.0)],
        vec![circle(0.0, 10.0, 2.0), circle(1.0, 18.0, 3.0)],
    ] {
        let mut scene = Scene { keep_outs: keep_outs.clone(), ..Scene::new(10.0) };
        let goal = WaterPoint { x: 0.0, y: 28.0 };
        let mut has_avoided = false;
        scene.run(Destination::Place(goal), 60.0, |scene, step| {
            has_avoided |= step.state == GuidanceState::Avoiding;
            for circle in &keep_outs {
                let left_m = scene.at.distance_to(circle.centre) - circle.radius_m;
                assert!(left_m > 0.0, "{left_m} m from the edge of {circle:?}");
            }
        });
        assert!(has_avoided && scene.at.distance_to(goal) < 4.0, "{:?}", scene.at);
    }
}

#[test]
fn the_boat_stops_before_a_circle_around_its_goal() {
    let goal = WaterPoint { x: 0.0, y: 20.0 };
    let circle = KeepOut { centre: goal, radius_m: 5.0 };
    let mut scene = Scene { keep_outs: vec![circle], ..Scene::new(0.0) };
    let mut last = GuidanceState::UnderWay;
    scene.run(Destination::Place(goal), 40.0, |scene, step| {
        assert!(scene.at.distance_to(goal) > 5.0, "{} m", scene.at.distance_to(goal));
        last = step.state;
    });
    assert_eq!(last, GuidanceState::Blocked);
    assert!(scene.at.distance_to(goal) < 9.0, "it comes near the circle");
}

#[test]
fn way_points_are_passed_in_their_order() {
    let way_points = vec![WaterPoint { x: 8.0, y: 8.0 }, WaterPoint { x: -6.0, y: 18.0 }];
    let mut scene = Scene { way_points: way_points.clone(), ..Scene::new(30.0) };
    let mut nearest = [f64::INFINITY; 2];
    let mut legs = Vec::new();
    scene.run(place(4.0, 28.0), 60.0, |scene, step| {
        let leg = step.progress.map_or(0, |progress| progress.leg);
        for (index, point) in way_points.iter().enumerate() {
            if leg <= index {
                nearest[index] = nearest[index].min(scene.at.distance_to(*point));
            }
        }
        legs.push(leg);
    });
    assert!(legs.is_sorted() && legs.last() == Some(&2), "{legs:?}");
    assert!(nearest.iter().all(|distance| *distance < 3.0), "{nearest:?}");
    assert!(scene.at.distance_to(WaterPoint { x: 4.0, y: 28.0 }) < 3.0);
}

#[test]
fn a_speed_limit_holds() {
    let mut scene = Scene::new(0.0);
    scene.limits.speed_m_per_s = Some(1.0);
    let mut fastest: f64 = 0.0;
    scene.run(place(0.0, 30.0), 20.0, |scene, _| fastest = fastest.max(scene.speed));
    assert!((0.7..1.25).contains(&fastest), "{fastest} m/s");
}

#[test]
fn a_known_heading_needs_no_first_move() {
    let mut scene = Scene { gives_heading: true, ..Scene::new(150.0) };
    let mut states = Vec::new();
    scene.run(place(0.0, 20.0), 20.0, |_, step| states.push(step.state));
    assert!(!states.contains(&GuidanceState::GettingWay));
    assert!(scene.at.distance_to(WaterPoint { x: 0.0, y: 20.0 }) < 4.0, "{:?}", scene.at);
}

#[test]
fn a_boat_that_lies_too_close_to_a_person_leaves_by_the_shortest_way() {
    // Where the person lies off the bow, degrees to the right; the least and the greatest throttle, and the
    // rudder's side.
    for (off_bow_deg, throttle, side) in
        [(0.0, -0.6..-0.1, 0.0), (-90.0, 0.05..0.6, 1.0), (120.0, 0.05..0.6, -1.0)]
    {
        let mut scene = Scene { gives_heading: true, ..Scene::new(-off_bow_deg) };
        let close = person(0.0, 2.2);
        let mut command = VesselCommand::NEUTRAL;
        let mut farthest_m: f64 = 0.0;
        scene.run(close, 1.0, |_, step| {
            if step.state == GuidanceState::StandingOff && command.is_neutral() {
                command = step.command;
            }
        });
        assert!(throttle.contains(&command.throttle), "{off_bow_deg}: {command:?}");
        assert!(
            command.rudder * side > 0.0 || (side == 0.0 && command.rudder == 0.0),
            "{off_bow_deg}: {command:?}"
        );
        let mut least_m = f64::INFINITY;
        scene.run(close, 12.0, |scene, _| {
            let distance_m = scene.at.distance_to(close.point());
            least_m = least_m.min(distance_m);
            farthest_m = farthest_m.max(distance_m);
        });
        assert!(least_m > 1.9 && farthest_m > 3.0, "{off_bow_deg}: {least_m} {farthest_m}");
    }
}

#[test]
fn a_boat_at_rest_whose_bow_is_not_known_does_not_move_before_a_person() {
    for off_bow_deg in [0.0, 180.0] {
        let mut scene = Scene::new(off_bow_deg);
        scene.run(person(0.0, 2.2), 10.0, |_, step| {
            assert!(step.command.is_neutral(), "{off_bow_deg}: {step:?}");
        });
        assert!(scene.at.distance_to(WaterPoint { x: 0.0, y: 0.0 }) < 1e-9);
    }
}

#[test]
fn a_person_who_drifts_towards_the_boat_is_given_way() {
    let mut scene = Scene { gives_heading: true, ..Scene::new(0.0) };
    let mut least_m = f64::INFINITY;
    for frame in 0..450 {
        let y = 6.0 - 0.35 * f64::from(frame) * FRAME_S;
        let Destination::Person { stand_off_m, uncertainty_m, .. } = person(0.0, y) else { unreachable!() };
        let at = WaterPoint { x: 0.0, y };
        let drifting = Destination::Person { at, velocity_m_per_s: (0.0, -0.35), stand_off_m, uncertainty_m };
        scene.step(Some(drifting), true);
        least_m = least_m.min(scene.at.distance_to(at));
    }
    assert!(least_m > 2.0, "{least_m}");
}

#[test]
fn a_person_who_drifts_to_a_boat_on_the_way_to_a_way_point_is_given_way() {
    // The way-point lies behind the person, whom the boat reaches first.
    let way_points = vec![WaterPoint { x: 0.0, y: 9.0 }];
    let mut scene = Scene { gives_heading: true, way_points, ..Scene::new(0.0) };
    let mut least_m = f64::INFINITY;
    for frame in 0..450 {
        let at = WaterPoint { x: 0.0, y: 8.0 - 0.35 * f64::from(frame) * FRAME_S };
        let velocity_m_per_s = (0.0, -0.35);
        let drifting = Destination::Person { at, velocity_m_per_s, stand_off_m: 2.0, uncertainty_m: 0.3 };
        scene.step(Some(drifting), true);
        least_m = least_m.min(scene.at.distance_to(at));
    }
    assert!(least_m > 2.0, "{least_m}");
}

#[test]
fn a_boat_that_backs_off_from_a_circle_stays_out_of_that_behind_it() {
    let mut scene = Scene { gives_heading: true, ..Scene::new(0.0) };
    let circle = |y: f64| KeepOut { centre: WaterPoint { x: 0.0, y }, radius_m: 3.0 };
    scene.keep_outs = vec![circle(4.2), circle(-4.2)];
    let mut least_m = f64::INFINITY;
    scene.run(place(0.0, 30.0), 20.0, |scene, _| {
        for circle in &scene.keep_outs {
            least_m = least_m.min(scene.at.distance_to(circle.centre) - circle.radius_m);
        }
    });
    assert!(least_m > 0.0, "{least_m}");
}

#[test]
fn a_boat_that_gives_way_to_a_person_stays_out_of_the_circles() {
    // The person drifts towards the boat; beyond the boat is a circle. The boat points at the person, or
    // away.
    let least_m = |heading_deg: f64| {
        let mut scene = Scene { gives_heading: true, ..Scene::new(heading_deg) };
        let circle = KeepOut { centre: WaterPoint { x: 0.0, y: -7.0 }, radius_m: 3.0 };
        scene.keep_outs.push(circle);
        let (mut least_m, mut retreats) = (f64::INFINITY, false);
        for frame in 0..450 {
            let y = 3.6 - 0.35 * f64::from(frame) * FRAME_S;
            let at = WaterPoint { x: 0.0, y };
            let velocity_m_per_s = (0.0, -0.35);
            let drifting = Destination::Person { at, velocity_m_per_s, stand_off_m: 2.0, uncertainty_m: 0.3 };
            let step = scene.step(Some(drifting), true);
            retreats |= step.state == GuidanceState::StandingOff && !step.command.is_neutral();
            // Until the person has reached the boat.
            if y > scene.at.y {
                least_m = least_m.min(scene.at.distance_to(circle.centre) - circle.radius_m);
            }
        }
        assert!(retreats, "{heading_deg}");
        least_m
    };
    for heading_deg in [0.0, 180.0] {
        let least_m = least_m(heading_deg);
        assert!(least_m > 0.5, "{heading_deg}: {least_m}");
    }
}

#[test]
fn without_a_destination_or_a_fresh_fix_the_vessel_is_neutral() {
    let mut scene = Scene::new(0.0);
    let first = scene.step(Some(place(0.0, 20.0)), true);
    assert_eq!((first.command, first.state), (VesselCommand::NEUTRAL, GuidanceState::NoFix));
    scene.run(place(0.0, 20.0), 5.0, |_, _| {});
    let none = scene.step(None, true);
    assert_eq!((none.command, none.state), (VesselCommand::NEUTRAL, GuidanceState::NoDestination));
    scene.run(place(0.0, 40.0), 2.0, |_, _| {});
    let lost_at = scene.frame;
    loop {
        let step = scene.step(Some(place(0.0, 40.0)), false);
        let silence_s = (scene.frame - lost_at) as f64 * FRAME_S;
        if step.state == GuidanceState::NoFix {
            assert_eq!(step.command, VesselCommand::NEUTRAL);
            assert!((0.5..0.8).contains(&silence_s), "after {silence_s} s");
            break;
        }
        assert!(silence_s < 0.8, "no fix for {silence_s} s: {step:?}");
    }
}

#[test]
fn values_that_are_not_finite_move_nothing() {
    let mut scene = Scene::new(0.0);
    scene.run(place(0.0, 20.0), 3.0, |_, _| {});
    let now = scene.now();
    let bad = WaterFix {
        point: WaterPoint { x: f64::NAN, y: 1.0 },
        covariance: WaterCovariance { xx: f64::INFINITY, ..WaterCovariance::default() },
    };
    let step = scene.law.step(&GuidanceInput {
        now,
        fix: Some(BoatFix {
            captured: now,
            water: bad,
            heading: Some((Angle::from_radians(f64::NAN), Angle::ZERO)),
            is_commanded: true,
            sway_per_s: None,
        }),
        destination: Some(place(f64::NAN, f64::INFINITY)),
        route: 2,
        way_points: &[],
        keep_outs: &[KeepOut { centre: WaterPoint { x: f64::NAN, y: 0.0 }, radius_m: f64::NAN }],
        limits: VesselLimits::DEFAULT,
    });
    assert!(!step.command.throttle.is_nan() && !step.command.rudder.is_nan(), "{step:?}");
    assert!(step.command.is_neutral(), "{step:?}");
}

#[test]
fn a_new_selection_starts_a_new_route() {
    let mut scene = Scene::new(0.0);
    scene.run(place(0.0, 20.0), 6.0, |_, _| {});
    scene.route = 2;
    let step = scene.step(Some(place(20.0, scene.at.y)), true);
    let progress = step.progress.unwrap();
    assert!(progress.cross_track_m.abs() < 0.3, "the line starts at the boat: {progress:?}");
}

#[test]
fn a_destination_that_is_moved_begins_another_line_and_sends_no_boat_back_to_a_way_point() {
    let mut scene = Scene { way_points: vec![WaterPoint { x: 0.0, y: 6.0 }], ..Scene::new(0.0) };
    scene.run(place(0.0, 20.0), 40.0, |_, _| {});
    let resting = scene.step(Some(place(0.0, 20.0)), true);
    assert_eq!((resting.state, resting.progress.unwrap().leg), (GuidanceState::Holding, 1));
    // Not as far as the boat may drift at a place: without word of the move, it stays.
    let near = place(scene.at.x + 1.7, scene.at.y);
    let stays = scene.step(Some(near), true);
    assert_eq!(stays.state, GuidanceState::Holding);
    scene.law.move_destination();
    let goes_on = scene.step(Some(near), true);
    let progress = goes_on.progress.unwrap();
    assert!(matches!(goes_on.state, GuidanceState::UnderWay | GuidanceState::GettingWay), "{goes_on:?}");
    assert_eq!(progress.leg, 1);
    assert!(progress.cross_track_m.abs() < 0.3, "the line starts at the boat: {progress:?}");
}

#[test]
fn a_destination_that_is_moved_leaves_the_line_to_a_way_point_as_it_is() {
    let mut scene = Scene { way_points: vec![WaterPoint { x: 0.0, y: 20.0 }], ..Scene::new(0.0) };
    scene.run(place(0.0, 40.0), 2.0, |_, _| {});
    // The boat is pushed aside.
    scene.at.x += 1.5;
    scene.run(place(0.0, 40.0), 1.0, |_, _| {});
    let before = scene.step(Some(place(0.0, 40.0)), true).progress.unwrap();
    scene.law.move_destination();
    let after = scene.step(Some(place(9.0, 40.0)), true).progress.unwrap();
    assert!(before.cross_track_m > 0.5, "{before:?}");
    assert!((after.cross_track_m - before.cross_track_m).abs() < 0.2, "{before:?} {after:?}");
}

#[test]
fn the_same_inputs_give_the_same_bits_and_no_step_allocates() {
    let run = || {
        let mut scene = Scene { current: (0.2, 0.1), ..Scene::new(60.0) };
        let mut bits = Vec::new();
        scene.run(place(4.0, 20.0), 20.0, |_, step| {
            bits.push((step.command.throttle.to_bits(), step.command.rudder.to_bits()));
        });
        bits
    };
    assert_eq!(run(), run());
    let mut law = LineOfSight::new(LineOfSightTuning::DEFAULT, VesselModel::JET);
    let keep_outs = [KeepOut { centre: WaterPoint { x: 0.0, y: 10.0 }, radius_m: 2.0 }];
    let allocations = allocation_counter::measure(|| {
        for frame in 0..200_u64 {
            let now = Timestamp::from_nanos(frame * 66_666_667);
            let water = WaterFix {
                point: WaterPoint { x: 0.0, y: 0.02 * frame as f64 },
                covariance: WaterCovariance::isotropic(0.1),
            };
            let step = law.step(&GuidanceInput {
                now,
                fix: Some(BoatFix {
                    captured: now,
                    water,
                    heading: None,
                    is_commanded: true,
                    sway_per_s: None,
                }),
                destination: Some(place(1.0, 20.0)),
                route: 1,
                way_points: &[],
                keep_outs: &keep_outs,
                limits: VesselLimits::DEFAULT,
            });
            law.on_command_applied(step.command, now);
        }
    });
    assert_eq!(allocations.count_total, 0);
}

/// A boat on the line x = 0 whose track is fed with its place and with a bow that the tracker reports.
struct Straight {
    track: BoatTrack,
    now_s: f64,
    y_m: f64,
}

impl Straight {
    fn new() -> Self {
        let track = BoatTrack::new(VesselModel::JET, &LineOfSightTuning::DEFAULT);
        Self { track, now_s: 0.0, y_m: 0.0 }
    }

    /// Goes on for some seconds at `speed` (m/s, ahead positive) with the bow reported `reported_deg` from
    /// ahead. The heading of the track at the end, degrees.
    fn heading_after(&mut self, seconds: f64, speed: f64, reported_deg: f64) -> f64 {
        self.goes(seconds, speed, Some(reported_deg), true).unwrap()
    }

    /// The same; without a reported bow the tracker sees no axis. `is_commanded`: by this program.
    fn goes(
        &mut self,
        seconds: f64,
        speed: f64,
        reported_deg: Option<f64>,
        is_commanded: bool,
    ) -> Option<f64> {
        let throttle = (speed / VesselModel::JET.speed_per_throttle).clamp(-0.6, 0.6);
        let mut now = Timestamp::from_secs_f64(self.now_s);
        for _ in 0..(seconds / FRAME_S) as u64 {
            now = Timestamp::from_secs_f64(self.now_s);
            self.track.apply_command(VesselCommand { throttle, rudder: 0.0 }, now);
            let point = WaterPoint { x: 0.0, y: self.y_m };
            let water = WaterFix { point, covariance: WaterCovariance::isotropic(0.05) };
            let heading = reported_deg.map(|bow| (Angle::from_degrees(bow), Angle::from_degrees(15.0)));
            self.track
                .observe(&BoatFix { captured: now, water, heading, is_commanded, sway_per_s: None }, now);
            self.y_m += speed * FRAME_S;
            self.now_s += FRAME_S;
        }
        self.track.predicted(now).unwrap().1.heading.map(Angle::degrees)
    }
}

#[test]
fn the_bow_of_a_boat_at_rest_is_kept_unless_another_hand_may_turn_the_boat() {
    let mut boat = Straight::new();
    boat.heading_after(3.0, 1.8, 5.0);
    assert!(boat.goes(20.0, 0.0, None, true).is_some());
    assert_eq!(boat.goes(3.0, 0.0, None, false), None);
    assert!(boat.goes(1.0, 0.0, Some(100.0), false).is_some_and(|bow| (bow - 100.0).abs() < 5.0));
}

#[test]
fn a_boat_that_goes_astern_keeps_its_bow_whatever_end_the_tracker_sees() {
    let mut boat = Straight::new();
    let ahead = boat.heading_after(3.0, 1.8, 5.0);
    assert!((0.0..6.0).contains(&ahead), "{ahead}");
    // The boat slows down, and then the tracker takes the stern, which goes first, for the bow.
    boat.heading_after(3.0, 0.0, 5.0);
    let astern = boat.heading_after(4.0, -0.8, 185.0);
    assert!((astern - 5.0).abs() < 3.0, "{astern}");
}

#[test]
fn a_bow_that_was_taken_for_the_stern_is_corrected_by_the_way_ahead() {
    let mut boat = Straight::new();
    let at_rest = boat.heading_after(1.0, 0.0, 180.0);
    assert!(at_rest.abs() > 170.0, "{at_rest}");
    let under_way = boat.heading_after(3.0, 1.8, 180.0);
    assert!(under_way.abs() < 10.0, "{under_way}");
}

#[test]
fn a_boat_whose_bow_is_not_known_comes_near_nobody() {
    for heading_deg in [0.0, 30.0, 60.0, 90.0] {
        for distance_m in [3.3, 4.0, 5.0, 8.0, 12.0] {
            let mut scene = Scene::new(heading_deg);
            let at = WaterPoint { x: 0.0, y: distance_m };
            scene.keep_outs = vec![KeepOut { centre: at, radius_m: 3.3 }];
            let mut least_m = f64::INFINITY;
            scene.run(place(0.0, -20.0), 40.0, |scene, _| least_m = least_m.min(scene.at.distance_to(at)));
            assert!(least_m > 2.0, "{heading_deg} deg, {distance_m} m: {least_m:.2} m");
        }
    }
}

#[test]
fn a_boat_that_was_selected_anew_before_a_person_does_not_run_into_them() {
    let mut scene = Scene { gives_heading: true, ..Scene::new(0.0) };
    let at = WaterPoint { x: 0.0, y: 15.0 };
    scene.run(person(at.x, at.y), 30.0, |_, _| {});
    scene.law.reset_boat();
    scene.gives_heading = false;
    scene.route += 1;
    scene.keep_outs = vec![KeepOut { centre: at, radius_m: 3.3 }];
    let mut least_m = f64::INFINITY;
    scene.run(place(0.0, -20.0), 30.0, |scene, _| least_m = least_m.min(scene.at.distance_to(at)));
    assert!(least_m > 3.0, "{least_m:.2} m");
}
