//! The zoom that keeps the target's size.

use core::time::Duration;

use barrelman_control::size_keeping::{SizeInput, SizeKeeper};
use barrelman_vocab::profile::SizeKeeping;
use barrelman_vocab::{Timestamp, ZoomDynamics, ZoomRate};

const ZOOM: ZoomDynamics =
    ZoomDynamics { ratio: 8.0, max_rate: ZoomRate::from_per_second(0.3), dead_time: Duration::ZERO };
const FRAME_S: f64 = 1.0 / 30.0;

/// A camera whose zoom follows the keeper, and a target of 1.2 m.
struct Scene {
    keeper: SizeKeeper,
    frame: u32,
    focal_share: f64,
    /// Rates that differ from the ones before.
    movements: Vec<f64>,
}

impl Scene {
    fn new() -> Self {
        let keeper = SizeKeeper::new(SizeKeeping::DEFAULT, ZOOM, 1.0);
        Self { keeper, frame: 0, focal_share: 1.0, movements: vec![0.0] }
    }

    /// The size of a target at this range, metres, in a picture of 16:9.
    fn size_at(&self, range_m: f64) -> f64 {
        1.2 / range_m * self.focal_share * 16.0 / 9.0
    }

    fn step(&mut self, range_m: f64, change: impl FnOnce(&mut SizeInput)) -> f64 {
        self.frame += 1;
        let mut input = SizeInput {
            size: self.size_at(range_m),
            p: 0.1,
            destination_share: 0.0,
            is_measured: true,
            confidence: 0.9,
            focal_shares: (self.focal_share, self.focal_share),
            captured: Timestamp::from_secs_f64(f64::from(self.frame) * FRAME_S),
        };
        change(&mut input);
        let rate = self.keeper.rate(&input).per_second();
        if self.movements.last() != Some(&rate) {
            self.movements.push(rate);
        }
        self.focal_share = (self.focal_share * libm::exp(rate * FRAME_S)).clamp(1.0, ZOOM.ratio);
        rate
    }

    /// The rate after some seconds of this.
    fn after(&mut self, seconds: f64, range_m: f64, change: impl Fn(&mut SizeInput)) -> f64 {
        (0..(seconds / FRAME_S) as u32).map(|_| self.step(range_m, &change)).last().unwrap()
    }
}

#[test]
fn a_target_that_goes_away_and_comes_back_is_kept_within_the_range_by_few_movements() {
    let mut scene = Scene::new();
    let mut smallest = f64::INFINITY;
    let mut largest: f64 = 0.0;
    // From 40 m to 400 m at 3 m/s, and back.
    for frame in 0..2 * 3600 {
        let away = f64::from(if frame < 3600 { frame } else { 7200 - frame });
        let range_m = 40.0 + 0.1 * away;
        scene.step(range_m, |_| {});
        (smallest, largest) = (smallest.min(scene.size_at(range_m)), largest.max(scene.size_at(range_m)));
    }
    assert!(smallest > 0.018 && largest < 0.125, "{smallest} to {largest}");
    let zooms = scene.movements.iter().filter(|rate| **rate != 0.0).count();
    assert!((3..=8).contains(&zooms), "{:?}", scene.movements);
}

#[test]
fn the_view_becomes_closer_only_while_all_is_well() {
    let far_m = 300.0;
    let closer = |change: &dyn Fn(&mut SizeInput)| Scene::new().after(3.0, far_m, change) > 0.0;
    assert!(closer(&|_| {}));
    assert!(!closer(&|input| input.p = 0.75), "near the border");
    assert!(!closer(&|input| input.confidence = 0.6));
    assert!(!closer(&|input| input.is_measured = false));
    assert_eq!(Scene::new().after(0.9, far_m, |_| {}), 0.0, "not sure for a second yet");
    let mut scene = Scene::new();
    assert!(scene.after(3.0, far_m, |_| {}) > 0.0);
    assert_eq!(scene.step(far_m, |input| input.p = 0.9), 0.0, "it rests at once");
}

#[test]
fn the_view_becomes_wider_at_once_where_a_target_near_the_border_is_in_doubt() {
    let mut scene = Scene::new();
    scene.after(20.0, 300.0, |_| {});
    assert!(scene.focal_share > 1.5);
    let coasting = |input: &mut SizeInput| (input.is_measured, input.p) = (false, 0.8);
    assert_eq!(scene.step(300.0, coasting), -0.3);
    assert_eq!(scene.step(300.0, |input| (input.confidence, input.p) = (0.4, 0.8)), -0.3);
    assert_eq!(scene.step(300.0, |input| input.is_measured = false), 0.0, "in the middle it waits");
    scene.after(60.0, 300.0, coasting);
    assert_eq!((scene.focal_share, scene.step(300.0, coasting)), (1.0, 0.0), "the widest view");
}

#[test]
fn a_target_that_leaves_the_region_widens_the_view_which_waits_before_it_becomes_closer() {
    let mut scene = Scene::new();
    scene.after(20.0, 300.0, |_| {});
    let closest = scene.focal_share;
    assert_eq!(scene.after(1.0, 300.0, |input| input.p = 1.3), -0.3);
    assert!(scene.focal_share < 0.8 * closest);
    assert_eq!(scene.after(7.0, 400.0, |_| {}), 0.0, "it waits");
    assert!(scene.after(2.0, 400.0, |_| {}) > 0.0);
}

#[test]
fn no_input_makes_a_rate_that_is_above_the_limit_or_no_number() {
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
        for p in [0.0, f64::NAN, f64::INFINITY] {
            let mut scene = Scene::new();
            for _ in 0..90 {
                let rate = scene.step(100.0, |input| (input.size, input.p) = (size, p));
                assert!(rate.abs() <= 0.3, "{size} {p}: {rate}");
            }
        }
    }
}

#[test]
fn a_destination_that_is_to_be_shown_widens_the_view_as_far_as_the_target_stays_large_enough() {
    let far_m = 300.0;
    let mut scene = Scene::new();
    scene.after(20.0, far_m, |_| {});
    let closest = scene.focal_share;
    let beyond = |input: &mut SizeInput| input.destination_share = 1.2;
    assert_eq!(scene.after(1.0, 0.7 * far_m, beyond), -0.2);
    assert!(scene.focal_share < closest);
    assert_eq!(scene.after(1.0, 0.7 * far_m, |input| input.destination_share = 0.7), 0.0, "it is shown");
    scene.after(60.0, 0.7 * far_m, beyond);
    assert!((1.4..1.6).contains(&(scene.size_at(0.7 * far_m) / 0.02)), "{}", scene.size_at(0.7 * far_m));
    let closer = |share: f64| Scene::new().after(3.0, far_m, |input| input.destination_share = share) > 0.0;
    assert!(closer(0.7) && !closer(0.85));
}

#[test]
fn a_boat_that_turns_away_for_some_seconds_is_no_reason_to_zoom() {
    // 0.027 of the picture's height from the side, 0.011 from the stern.
    let range_m = 80.0;
    let from_astern = |input: &mut SizeInput| input.size *= 0.4;
    let mut scene = Scene::new();
    for _ in 0..4 {
        assert_eq!(scene.after(6.0, range_m, |_| {}), 0.0);
        assert_eq!(scene.after(4.0, range_m, from_astern), 0.0);
    }
    assert!(scene.after(6.0, range_m, from_astern) > 0.0, "one that stays so is too small");
}
