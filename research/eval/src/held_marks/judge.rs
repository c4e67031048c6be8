//! Compares each mark with its person, in each picture that the pilot processes.

use std::collections::{BTreeMap, VecDeque};

use barrelman_pilot::vessel::{FrameView, Mark};
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::snapshot::{ObjectKind, SceneObject};
use barrelman_sim::{Optics, Truth, World, WorldPoint};
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{MarkKind, PixelPoint, Timestamp, Track, VehicleRates};

/// A mark is at a person within this distance, metres.
const AT_PERSON_M: f64 = 1.0;
/// Truths of pictures that are on their way.
const KEPT: usize = 64;

/// Pictures, counted for each mark of a person.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Figures {
    marked: u64,
    held: u64,
    lost: u64,
    at_person: u64,
    at_other: u64,
}

impl Figures {
    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            marked: self.marked + other.marked,
            held: self.held + other.held,
            lost: self.lost + other.lost,
            at_person: self.at_person + other.at_person,
            at_other: self.at_other + other.at_other,
        }
    }

    /// Of the pictures with a mark: that in which the mark is held.
    pub(super) fn held_share(&self) -> f64 {
        share(self.held, self.marked)
    }

    /// Of the pictures with a held mark: that in which the mark is at its person.
    pub(super) fn at_person_share(&self) -> f64 {
        share(self.at_person, self.held)
    }

    /// Of the pictures with a mark that was held: that in which it is at its person, or says that it is lost.
    pub(super) fn honest_share(&self) -> f64 {
        share(self.at_person + self.lost, self.held + self.lost)
    }

    /// Of the same pictures: that in which the mark is lost.
    pub(super) fn lost_share(&self) -> f64 {
        share(self.lost, self.held + self.lost)
    }

    /// Of the pictures with a held mark: that in which it is at another person.
    pub(super) fn wrong_share(&self) -> f64 {
        share(self.at_other, self.held)
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// What was true when a picture was taken.
struct Taken {
    truth: Truth,
    people: Vec<WorldPoint>,
}

/// The judge of one trial.
pub(super) struct Judge {
    optics: Optics,
    taken: VecDeque<Taken>,
    objects: Vec<SceneObject>,
    /// The person of each mark.
    persons: BTreeMap<u32, usize>,
    figures: Figures,
}

impl Judge {
    pub(super) fn new(optics: Optics) -> Self {
        Self {
            optics,
            taken: VecDeque::new(),
            objects: Vec::new(),
            persons: BTreeMap::new(),
            figures: Figures::default(),
        }
    }

    pub(super) const fn figures(&self) -> Figures {
        self.figures
    }

    fn pixel(&self, truth: &Truth, point: WorldPoint) -> Option<PixelPoint> {
        self.optics.project(truth.camera.camera_from_world(WorldPoint { z: 0.0, ..point }))
    }

    /// Distance over the water between a pixel and a person, metres, to first order.
    fn distance_m(&self, truth: &Truth, person: WorldPoint, at: PixelPoint) -> Option<f64> {
        let pixel =
            |x: f64, y: f64| self.pixel(truth, WorldPoint { x: person.x + x, y: person.y + y, z: 0.0 });
        let (seen, right, ahead) = (pixel(0.0, 0.0)?, pixel(0.1, 0.0)?, pixel(0.0, 0.1)?);
        let slope = |to: PixelPoint| (10.0 * (to.u - seen.u), 10.0 * (to.v - seen.v));
        let ((a, c), (b, d)) = (slope(right), slope(ahead));
        let (u, v) = (at.u - seen.u, at.v - seen.v);
        let determinant = a * d - b * c;
        Some(libm::hypot((d * u - b * v) / determinant, (a * v - c * u) / determinant))
    }

    fn judge(&mut self, taken: &Taken, mark: &Mark, frame_view: &FrameView, now: Timestamp) -> Option<()> {
        let at = mark.pixel(frame_view, now)?;
        let distances: Vec<f64> = taken
            .people
            .iter()
            .map(|person| self.distance_m(&taken.truth, *person, at).unwrap_or(f64::INFINITY))
            .collect();
        let nearest =
            (0..distances.len()).min_by(|one, other| distances[*one].total_cmp(&distances[*other]))?;
        let own = *self.persons.entry(mark.id).or_insert(nearest);
        let figures = &mut self.figures;
        figures.marked += 1;
        match mark.held {
            Some(Track::Tracking(_) | Track::Coasting(_)) => {
                figures.held += 1;
                let is_at_person = distances[own] <= AT_PERSON_M;
                figures.at_person += u64::from(is_at_person);
                figures.at_other += u64::from(!is_at_person && distances[nearest] <= AT_PERSON_M);
            }
            Some(Track::Lost { .. }) => figures.lost += 1,
            Some(Track::Unseeded) | None => {}
        }
        Some(())
    }
}

impl StepObserver for Judge {
    fn on_step(&mut self, _now: Timestamp, input: &Input<'_>, outcome: &Outcome, _rates: VehicleRates) {
        let (Input::Frame(frame), Some(frame_view)) = (input, outcome.vessel.frame_view) else { return };
        let captured = frame.capture.at;
        let Some(index) = self.taken.iter().position(|taken| taken.truth.at == captured) else { return };
        self.taken.drain(..index);
        let Some(taken) = self.taken.pop_front() else { return };
        for mark in outcome.vessel.marks.iter().filter(|mark| mark.kind == MarkKind::Person) {
            self.judge(&taken, mark, &frame_view, captured);
        }
    }

    fn on_truth(&mut self, truth: &Truth, _target: Option<&TargetInPicture>) {
        if self.taken.len() == KEPT {
            self.taken.pop_front();
        }
        self.taken.push_back(Taken { truth: *truth, people: Vec::new() });
    }

    fn on_world(&mut self, world: &World) {
        world.write_objects(&mut self.objects);
        let people = self.objects.iter().filter(|object| object.kind == ObjectKind::Swimmer);
        if let Some(taken) = self.taken.back_mut() {
            taken.people = people.map(|person| person.pose.position).collect();
        }
    }
}
