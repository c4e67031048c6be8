//! One trial: the simulated boat goes from its start to the destination under one law.
//!
//! Both laws see the same: the pixel of the boat, of the destination and of the people in each video frame,
//! with noise, after the latency. The camera is at rest, and sees beyond the borders of its picture: a camera
//! that follows the boat would. Both are stepped once for each video frame that arrives.

use std::collections::VecDeque;

use anyhow::{Result, anyhow};
use barrelman_control::guidance::{
    BoatFix, Destination, GuidanceInput, KeepOut, LabInput, LabLaw, LabSettings, LineOfSight,
    LineOfSightTuning, VesselLimits, VesselModel,
};
use barrelman_control::water::WaterView;
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::snapshot::SceneObject;
use barrelman_sim::{CameraPose, Optics, Scenario, World, WorldPoint, noise};
use barrelman_vocab::{
    Angle, CameraAboveWater, Lens, PixelPoint, SightingNoise, Timestamp, VesselCommand, WaterPoint,
};

use super::condition::Condition;
use super::course::{Course, HEIGHT_M, TILT_DEG};

/// Noise of each pixel coordinate, pixels.
pub(super) const NOISE_PX: f64 = 2.0;
/// Radius of the arrival circle around a place, and around a person, metres.
pub(super) const ARRIVAL_M: (f64, f64) = (2.5, 4.0);
/// Stand-off of a person who is the destination, and keep-out of the others, metres.
pub(super) const STAND_OFF_M: f64 = 2.0;
pub(super) const KEEP_OUT_M: f64 = 3.0;
/// Cross-track errors count from this time after engaging on, seconds.
pub(super) const COUNTED_FROM_S: f64 = 4.0;
/// The approach to people counts until this time after the arrival, seconds.
const WATCHED_S: f64 = 15.0;
/// The longest trial, seconds.
const MAX_S: f64 = 90.0;
/// Stream of the pixel noise.
const NOISE_STREAM: u64 = 0x6D1E;

/// The law of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a few of them live at a time")]
pub(super) enum LawUnderTest {
    Lab(LabSettings),
    LineOfSight(LineOfSightTuning, VesselModel, VesselLimits),
}

/// What came of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outcome {
    /// Time to the arrival circle, seconds.
    pub(super) arrived_s: Option<f64>,
    /// Mean of the absolute cross-track error until the arrival, metres.
    pub(super) cross_track_m: f64,
    /// Length of the path over the straight way, until the arrival.
    pub(super) path_ratio: f64,
    /// Travel of the rudder, 1/s.
    pub(super) rudder_per_s: f64,
    /// Least distance to any person's stand-off or keep-out; negative within.
    pub(super) clearance_m: f64,
    /// Least distance to any person.
    pub(super) approach_m: f64,
    /// Mean distance to the destination from the arrival on, metres.
    pub(super) held_m: f64,
}

/// What one video frame shows, in pixels.
#[derive(Debug, Clone)]
struct Frame {
    captured: Timestamp,
    arrives: u64,
    boat: Option<PixelPoint>,
    /// Where the tracker sees the bow point, with noise: 0 ahead, to the right, radians.
    heading: f64,
    /// The destination first.
    people: Vec<Option<PixelPoint>>,
}

/// The law with its memory.
enum RunningLaw {
    Lab(Box<LabLaw>),
    LineOfSight(Box<LineOfSight>, VesselLimits),
}

impl LawUnderTest {
    fn start(self) -> RunningLaw {
        match self {
            Self::Lab(settings) => RunningLaw::Lab(Box::new(LabLaw::new(settings))),
            Self::LineOfSight(tuning, model, limits) => {
                RunningLaw::LineOfSight(Box::new(LineOfSight::new(tuning, model)), limits)
            }
        }
    }
}

/// The lens of the trials.
pub(super) fn lens(scenario: &Scenario) -> Lens {
    let Optics { picture, focal_px, barrel } = scenario.camera.optics;
    Lens::barrel(picture, focal_px, barrel)
}

/// A camera over the water as a law believes it.
pub(super) fn view(lens: Lens, height_factor: f64, tilt_error_deg: f64) -> WaterView {
    WaterView::new(
        lens,
        &CameraAboveWater {
            below: WaterPoint::default(),
            height_m: HEIGHT_M * height_factor,
            pan: Angle::ZERO,
            tilt: Angle::from_degrees(TILT_DEG + tilt_error_deg),
            roll: Angle::ZERO,
        },
    )
}

/// Runs a trial.
///
/// # Errors
/// If the scenario makes no world.
pub(super) fn run(condition: &Condition, base: &Scenario, law: LawUnderTest, seed: u64) -> Result<Outcome> {
    let lens = lens(base);
    let course = Course::drawn(condition, base, &view(lens, 1.0, 0.0), seed);
    let believed = view(lens, condition.height_factor, condition.tilt_error_deg);
    let scenario = course.scenario(base, condition, MAX_S);
    let mut world = World::new(&scenario, seed).map_err(|_| anyhow!("the way-points make no path"))?;
    let pose = CameraPose {
        position: WorldPoint { x: 0.0, y: 0.0, z: HEIGHT_M },
        pan: Angle::ZERO,
        tilt: Angle::from_degrees(TILT_DEG),
        roll: Angle::ZERO,
    };
    let optics = scenario.camera.optics;
    let mut frame_number = 0_u64;
    let seen_at = |position: WorldPoint, index: u64| -> Option<PixelPoint> {
        optics.project(pose.camera_from_world(position)).map(|seen| PixelPoint {
            u: seen.u + NOISE_PX * noise::normal(seed, NOISE_STREAM, 2 * index),
            v: seen.v + NOISE_PX * noise::normal(seed, NOISE_STREAM, 2 * index + 1),
        })
    };
    let latency_ticks = (120.0 * condition.latency_s) as u64;
    let mut in_flight: VecDeque<Frame> = VecDeque::new();
    let mut running = law.start();
    let mut command = VesselCommand::NEUTRAL;
    let mut objects: Vec<SceneObject> = Vec::new();
    let mut meter = Meter::new(condition, &course);
    world.override_helm(Some(HelmCommand::default()));
    while !world.is_over() && !meter.is_over() {
        world.write_objects(&mut objects);
        let boat = world.target_pose().position;
        if world.tick().is_multiple_of(condition.ticks_per_frame) {
            frame_number += 1;
            let index = |which: usize| frame_number * 16 + which as u64;
            in_flight.push_back(Frame {
                captured: world.now(),
                arrives: world.tick() + latency_ticks,
                boat: seen_at(boat, index(0)),
                // Headings of the simulator are 0 to the right and grow anticlockwise.
                heading: core::f64::consts::FRAC_PI_2 - world.target_pose().heading.radians()
                    + condition.heading_noise_deg.to_radians()
                        * noise::normal(seed, NOISE_STREAM + 1, frame_number),
                people: objects
                    .iter()
                    .enumerate()
                    .map(|(which, object)| {
                        // A place is marked once, without noise.
                        let is_place = which == 0 && !condition.to_person;
                        if is_place {
                            optics.project(pose.camera_from_world(object_on_water(object)))
                        } else {
                            seen_at(object_on_water(object), index(which + 1))
                        }
                    })
                    .collect(),
            });
        }
        while let Some(frame) = in_flight.pop_front_if(|frame| frame.arrives <= world.tick()) {
            let next = step(&mut running, &frame, &believed, condition, world.now());
            meter.command(command, next);
            command = next;
            // The simulated boat's rudder is positive to the left.
            world.override_helm(Some(HelmCommand { throttle: command.throttle, rudder: -command.rudder }));
        }
        let people =
            objects.iter().map(|object| WaterPoint { x: object.pose.position.x, y: object.pose.position.y });
        meter.tick(world.now().as_secs_f64(), WaterPoint { x: boat.x, y: boat.y }, people);
        world.advance();
    }
    Ok(meter.outcome())
}

fn object_on_water(object: &SceneObject) -> WorldPoint {
    object.pose.position
}

fn step(
    law: &mut RunningLaw,
    frame: &Frame,
    view: &WaterView,
    condition: &Condition,
    now: Timestamp,
) -> VesselCommand {
    let destination = frame.people.first().copied().flatten();
    match law {
        RunningLaw::Lab(lab) => lab.step(&LabInput { now, boat: frame.boat, target: destination }).0,
        RunningLaw::LineOfSight(line_of_sight, limits) => {
            let sighting_noise = SightingNoise {
                pixel_px: NOISE_PX,
                height_m: 0.0,
                pan: Angle::ZERO,
                tilt: Angle::ZERO,
                roll: Angle::ZERO,
            };
            let fix = frame.boat.and_then(|pixel| view.fix(pixel, &sighting_noise)).map(|water| BoatFix {
                captured: frame.captured,
                water,
                heading: (condition.heading_noise_deg > 0.0).then(|| {
                    (Angle::from_radians(frame.heading), Angle::from_degrees(condition.heading_noise_deg))
                }),
                // The camera is at rest.
                is_commanded: true,
                sway_per_s: None,
            });
            let keep_outs: Vec<KeepOut> = frame
                .people
                .iter()
                .skip(1)
                .filter_map(|pixel| view.sighting((*pixel)?).point())
                .map(|centre| KeepOut { centre, radius_m: KEEP_OUT_M + condition.uncertainty_m })
                .collect();
            let point = destination.and_then(|pixel| view.sighting(pixel).point());
            let destination = point.map(|at| {
                if condition.to_person {
                    Destination::Person {
                        at,
                        velocity_m_per_s: (0.0, 0.0),
                        stand_off_m: STAND_OFF_M,
                        uncertainty_m: condition.uncertainty_m,
                    }
                } else {
                    Destination::Place(at)
                }
            });
            let input = GuidanceInput {
                now,
                fix,
                destination,
                route: 1,
                way_points: &[],
                keep_outs: &keep_outs,
                limits: *limits,
            };
            let command = line_of_sight.step(&input).command;
            line_of_sight.on_command_applied(command, now);
            command
        }
    }
}

/// Measures a trial.
#[derive(Debug, Clone)]
struct Meter {
    circle_m: f64,
    to_person: bool,
    start: WaterPoint,
    straight_m: f64,
    last: WaterPoint,
    now_s: f64,
    arrived_s: Option<f64>,
    path_m: f64,
    cross_track: (f64, u64),
    held: (f64, u64),
    rudder: f64,
    clearance_m: f64,
    approach_m: f64,
}

impl Meter {
    fn new(condition: &Condition, course: &Course) -> Self {
        let circle_m = if condition.to_person { ARRIVAL_M.1 } else { ARRIVAL_M.0 };
        Self {
            circle_m,
            to_person: condition.to_person,
            start: course.start,
            straight_m: course.start.distance_to(course.target) - circle_m,
            last: course.start,
            now_s: 0.0,
            arrived_s: None,
            path_m: 0.0,
            cross_track: (0.0, 0),
            held: (0.0, 0),
            rudder: 0.0,
            clearance_m: f64::INFINITY,
            approach_m: f64::INFINITY,
        }
    }

    fn is_over(&self) -> bool {
        self.arrived_s.is_some_and(|arrived| self.now_s >= arrived + WATCHED_S)
    }

    fn command(&mut self, before: VesselCommand, next: VesselCommand) {
        if self.arrived_s.is_none() {
            self.rudder += (next.rudder - before.rudder).abs();
        }
    }

    fn tick(&mut self, now_s: f64, boat: WaterPoint, people: impl Iterator<Item = WaterPoint>) {
        self.now_s = now_s;
        let mut target = boat;
        for (index, person) in people.enumerate() {
            let distance_m = boat.distance_to(person);
            if index == 0 {
                target = person;
            }
            let required_m = match (index, self.to_person) {
                (0, false) => continue,
                (0, true) => STAND_OFF_M,
                _ => KEEP_OUT_M,
            };
            self.approach_m = self.approach_m.min(distance_m);
            self.clearance_m = self.clearance_m.min(distance_m - required_m);
        }
        let distance_m = boat.distance_to(target);
        if self.arrived_s.is_some() {
            self.held = (self.held.0 + distance_m, self.held.1 + 1);
        } else {
            self.path_m += self.last.distance_to(boat);
            self.last = boat;
            if now_s >= COUNTED_FROM_S {
                let (x, y) = self.start.vector_to(target);
                let (bx, by) = self.start.vector_to(boat);
                let off = ((bx * y - by * x) / self.start.distance_to(target)).abs();
                self.cross_track = (self.cross_track.0 + off, self.cross_track.1 + 1);
            }
            if distance_m <= self.circle_m {
                self.arrived_s = Some(now_s);
            }
        }
    }

    fn outcome(&self) -> Outcome {
        let duration_s = self.arrived_s.unwrap_or(self.now_s).max(1.0);
        Outcome {
            arrived_s: self.arrived_s,
            cross_track_m: self.cross_track.0 / self.cross_track.1.max(1) as f64,
            path_ratio: self.path_m / self.straight_m,
            rudder_per_s: self.rudder / duration_s,
            clearance_m: self.clearance_m,
            approach_m: self.approach_m,
            held_m: if self.held.1 == 0 { f64::NAN } else { self.held.0 / self.held.1 as f64 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_simulators_camera_and_the_water_geometry_agree() {
        let optics =
            Optics { picture: barrelman_vocab::PictureSize::new(1280, 720), focal_px: 950.0, barrel: 0.09 };
        let lens = Lens::barrel(optics.picture, optics.focal_px, optics.barrel);
        for (pan, tilt, roll) in [(0.0, -40.0, 0.0), (70.0, -15.0, 8.0), (-160.0, -80.0, -20.0)] {
            let angle = Angle::from_degrees;
            let position = WorldPoint { x: 3.0, y: -2.0, z: 15.0 };
            let pose = CameraPose { position, pan: angle(pan), tilt: angle(tilt), roll: angle(roll) };
            let view = WaterView::new(
                lens,
                &CameraAboveWater {
                    below: WaterPoint { x: 3.0, y: -2.0 },
                    height_m: 15.0,
                    pan: pose.pan,
                    tilt: pose.tilt,
                    roll: pose.roll,
                },
            );
            for (u, v) in [(640.0, 360.0), (100.0, 650.0), (1200.0, 400.0)] {
                let pixel = PixelPoint { u, v };
                let point = view.sighting(pixel).point().unwrap();
                let at = WorldPoint { x: point.x, y: point.y, z: 0.0 };
                let seen = optics.project(pose.camera_from_world(at)).unwrap();
                assert!((seen.u - u).abs() < 1e-6 && (seen.v - v).abs() < 1e-6, "{pixel:?} {seen:?}");
            }
        }
    }
}
