//! A trial in which the boat goes to a person by guidance: what the simulated operator marks, and how the
//! boat goes.
//!
//! The first person of the scenario is the one to go to. As soon as the boat is tracked, the operator marks
//! all people in the picture and lets the boat go. Every [`MARKED_ANEW`], the operator moves the marks that
//! no tracker holds, as the people drift. A mark is off by up to [`MARK_ERROR_PX`].

use core::time::Duration;

use barrelman_pilot::{Outcome, VesselMode};
use barrelman_sim::random::{CounterRng, Stream};
use barrelman_sim::snapshot::{ObjectKind, SceneObject};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::world::{Truth, World};
use barrelman_sim::{Optics, WorldPoint};
use barrelman_vocab::{
    DrawnMark, MarkKind, MovedMark, OperatorRequest, PixelPoint, Timestamp, Track, VesselCommand,
    VesselRequest, WaterPoint,
};

use crate::metrics::GuidanceMetrics;

/// The boat has arrived within this distance of the person, metres.
const ARRIVAL_M: f64 = 4.0;
/// Cross-track errors count from this time after the engagement on, seconds.
const COUNTED_FROM_S: f64 = 4.0;
/// The trial goes on for this time after the arrival, seconds.
const WATCHED_S: f64 = 15.0;
/// Longest time from the engagement to the end, seconds.
const LONGEST_S: f64 = 90.0;
/// Interval between two times at which the operator moves all marks.
const MARKED_ANEW: Duration = Duration::from_secs(5);
/// Largest error of a mark in each direction, pixels.
const MARK_ERROR_PX: f64 = 4.0;
/// Numbers of the operator's draws in their stream, from here on: those of the selection come before.
const FIRST_DRAW: u64 = 100;

/// The operator and the figures of one trial.
pub(super) struct Rescue {
    optics: Optics,
    rng: CounterRng,
    draws: u64,
    people: Vec<SceneObject>,
    marked: Option<Timestamp>,
    /// The people that are marked, each with the number of the mark.
    mark_ids: Vec<(usize, u32)>,
    engaged: Option<Way>,
    last_rudder: f64,
}

/// The way since the engagement.
#[derive(Debug, Clone, Copy)]
struct Way {
    start: WaterPoint,
    straight_m: f64,
    last: WaterPoint,
    ticks: u64,
    arrived_s: Option<f64>,
    path_m: f64,
    cross_track: (f64, u64),
    rudder: f64,
    closest_m: f64,
    in_view: u64,
}

impl Rescue {
    pub(super) const fn new(optics: Optics, seed: u64) -> Self {
        Self {
            optics,
            rng: CounterRng::new(seed, Stream::Operator),
            draws: FIRST_DRAW,
            people: Vec::new(),
            marked: None,
            mark_ids: Vec::new(),
            engaged: None,
            last_rudder: 0.0,
        }
    }

    /// Whether the trial is over.
    pub(super) fn is_over(&self) -> bool {
        self.engaged.is_some_and(|way| {
            let now_s = way.now_s();
            now_s >= LONGEST_S || way.arrived_s.is_some_and(|arrived| now_s >= arrived + WATCHED_S)
        })
    }

    /// What the operator asks for when a picture with this truth has been processed.
    pub(super) fn requests(
        &mut self,
        truth: &Truth,
        world: &World,
        outcome: &Outcome,
        now: Timestamp,
    ) -> Vec<OperatorRequest> {
        let is_due = self.marked.is_none_or(|at| now.since(at) >= MARKED_ANEW);
        if !is_due || !matches!(outcome.track, Track::Tracking(_)) || outcome.is_confirming {
            return Vec::new();
        }
        world.write_objects(&mut self.people);
        self.people.retain(|object| object.kind == ObjectKind::Swimmer);
        let mut requests = Vec::new();
        for index in 0..self.people.len() {
            let Some(pixel) = self.pixel_of(truth, self.people[index].pose.position) else { continue };
            let captured = truth.at;
            // The number that the pilot gives to the next mark.
            let next_id = self.mark_ids.len() as u32 + 1;
            if let Some((_, id)) = self.mark_ids.iter().find(|(person, _)| *person == index) {
                if outcome.vessel.marks.iter().any(|mark| mark.id == *id && mark.is_held()) {
                    continue;
                }
                requests.push(OperatorRequest::Vessel(VesselRequest::MoveMark(MovedMark {
                    id: *id,
                    at: pixel,
                    captured_ns: captured,
                })));
                continue;
            }
            self.mark_ids.push((index, next_id));
            requests.push(OperatorRequest::Vessel(VesselRequest::Mark(DrawnMark {
                mark: MarkKind::Person,
                at: pixel,
                captured_ns: captured,
            })));
            // The person to go to came into the picture after others: the boat goes there from now on.
            if let Some(destination) = outcome.vessel.marks.destination().filter(|_| index == 0) {
                requests.extend(
                    (destination.id..next_id).map(|_| OperatorRequest::Vessel(VesselRequest::NextMark)),
                );
            }
        }
        if !requests.is_empty() {
            self.marked = Some(now);
            // A boat that waits or goes already goes on.
            let goes = matches!(
                outcome.vessel.mode,
                VesselMode::Guided | VesselMode::Holding(_) | VesselMode::KeepingWay(_)
            );
            requests.extend((!goes).then_some(OperatorRequest::Vessel(VesselRequest::Guide)));
        }
        requests
    }

    /// Where a hand marks a point; `None`: it is out of the picture.
    fn pixel_of(&mut self, truth: &Truth, position: WorldPoint) -> Option<PixelPoint> {
        let on_water = WorldPoint { z: 0.0, ..position };
        let seen = self.optics_of(truth).project(truth.camera.camera_from_world(on_water))?;
        let mut error = || {
            self.draws += 1;
            self.rng.between(self.draws, (-MARK_ERROR_PX, MARK_ERROR_PX))
        };
        let pixel = PixelPoint { u: seen.u + error(), v: seen.v + error() };
        self.is_in_picture(seen).then_some(pixel)
    }

    /// The optics with the zoom of that moment.
    const fn optics_of(&self, truth: &Truth) -> Optics {
        Optics { focal_px: truth.focal_px, ..self.optics }
    }

    fn is_in_picture(&self, pixel: PixelPoint) -> bool {
        let (width, height) = (f64::from(self.optics.picture.width), f64::from(self.optics.picture.height));
        (0.0..width).contains(&pixel.u) && (0.0..height).contains(&pixel.v)
    }

    /// Measures one tick of the world under a command to the boat.
    pub(super) fn on_tick(&mut self, world: &World, mode: VesselMode, command: VesselCommand) {
        if self.engaged.is_none() && mode != VesselMode::Guided {
            return;
        }
        world.write_objects(&mut self.people);
        self.people.retain(|object| object.kind == ObjectKind::Swimmer);
        let truth = world.truth();
        let boat = on_water(truth.target.position);
        let Some(target) = self.people.first().map(|person| on_water(person.pose.position)) else { return };
        let way = self.engaged.get_or_insert_with(|| Way {
            start: boat,
            straight_m: boat.distance_to(target) - ARRIVAL_M,
            last: boat,
            ticks: 0,
            arrived_s: None,
            path_m: 0.0,
            cross_track: (0.0, 0),
            rudder: 0.0,
            closest_m: f64::INFINITY,
            in_view: 0,
        });
        let change = (command.rudder - self.last_rudder).abs();
        self.last_rudder = command.rudder;
        for person in &self.people {
            way.closest_m = way.closest_m.min(boat.distance_to(on_water(person.pose.position)));
        }
        if way.arrived_s.is_none() {
            way.rudder += change;
            way.path_m += way.last.distance_to(boat);
            way.last = boat;
            if way.now_s() >= COUNTED_FROM_S {
                let (x, y) = way.start.vector_to(target);
                let (bx, by) = way.start.vector_to(boat);
                let off = (bx * y - by * x).abs() / way.start.distance_to(target).max(1e-9);
                way.cross_track = (way.cross_track.0 + off, way.cross_track.1 + 1);
            }
            if boat.distance_to(target) <= ARRIVAL_M {
                way.arrived_s = Some(way.now_s());
            }
        }
        way.ticks += 1;
        let target_position = WorldPoint { z: 0.0, ..self.people[0].pose.position };
        let seen = self.optics_of(&truth).project(truth.camera.camera_from_world(target_position));
        let is_seen = seen.is_some_and(|pixel| self.is_in_picture(pixel)) && truth.in_picture;
        if let Some(way) = &mut self.engaged {
            way.in_view += u64::from(is_seen);
        }
    }

    /// The figures so far.
    pub(super) fn metrics(&self) -> GuidanceMetrics {
        let Some(way) = &self.engaged else {
            return GuidanceMetrics::default();
        };
        let arrived = way.arrived_s.is_some();
        let (off, counted) = way.cross_track;
        GuidanceMetrics {
            arrived,
            time_to_circle_s: way.arrived_s,
            cross_track_m: (counted > 0).then(|| off / counted as f64),
            rudder_travel: Some(way.rudder),
            closest_person_m: Some(way.closest_m).filter(|closest| closest.is_finite()),
            path_ratio: (arrived && way.straight_m > 0.0).then(|| way.path_m / way.straight_m),
            both_in_view: (way.ticks > 0).then(|| way.in_view as f64 / way.ticks as f64),
        }
    }
}

impl Way {
    fn now_s(&self) -> f64 {
        self.ticks as f64 / f64::from(TICKS_PER_SECOND)
    }
}

const fn on_water(position: WorldPoint) -> WaterPoint {
    WaterPoint { x: position.x, y: position.y }
}
