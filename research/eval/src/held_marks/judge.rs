//! Compares each mark with its person, in each picture that the pilot processes.

use std::collections::{BTreeMap, VecDeque};

use barrelman_pilot::vessel::{FrameView, Mark};
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::snapshot::{ObjectKind, SceneObject};
use barrelman_sim::{Optics, Truth, World, WorldPoint};
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{Angle, MarkKind, PixelPoint, Timestamp, Track, VehicleRates};

/// A mark is at a person within this distance, metres.
const AT_PERSON_M: f64 = 1.0;
/// An axis is off that differs by more than this angle on the water, radians.
const AXIS_ERROR_RAD: f64 = 0.35;
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
    /// Pictures in which the boat is followed; of those, that in which its axis is seen; of those, that in
    /// which the axis is off by more than [`AXIS_ERROR_RAD`] on the water.
    followed: u64,
    axis_seen: u64,
    axis_off: u64,
    /// Of the pictures in which the boat is followed: that with a heading; of those, that with the stern's.
    headed: u64,
    stern_first: u64,
}

impl Figures {
    pub(super) const fn plus(self, other: Self) -> Self {
        Self {
            marked: self.marked + other.marked,
            held: self.held + other.held,
            lost: self.lost + other.lost,
            at_person: self.at_person + other.at_person,
            at_other: self.at_other + other.at_other,
            followed: self.followed + other.followed,
            axis_seen: self.axis_seen + other.axis_seen,
            axis_off: self.axis_off + other.axis_off,
            headed: self.headed + other.headed,
            stern_first: self.stern_first + other.stern_first,
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

    /// Of the pictures in which the boat is followed: that in which its axis is seen.
    pub(super) fn axis_share(&self) -> f64 {
        share(self.axis_seen, self.followed)
    }

    /// Of the pictures with an axis: that in which the axis is off by more than 0.35 rad.
    pub(super) fn axis_off_share(&self) -> f64 {
        share(self.axis_off, self.axis_seen)
    }

    /// Of the pictures in which the boat is followed: that with a heading.
    pub(super) fn headed_share(&self) -> f64 {
        share(self.headed, self.followed)
    }

    /// Of the pictures with a heading: that in which it is the stern's.
    pub(super) fn stern_share(&self) -> f64 {
        share(self.stern_first, self.headed)
    }
}

fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

/// Pixels to the right, and down, each for a metre along the world's x and y.
type Slopes = ((f64, f64), (f64, f64));

/// The metres along x and y that are so many pixels to the right and down.
fn solved(((a, b), (c, d)): Slopes, (u, v): (f64, f64)) -> (f64, f64) {
    let determinant = a * d - b * c;
    ((d * u - b * v) / determinant, (a * v - c * u) / determinant)
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
        let seen = self.pixel(truth, person)?;
        let (x, y) = solved(self.slopes(truth, person)?, (at.u - seen.u, at.v - seen.v));
        Some(libm::hypot(x, y))
    }

    /// Pixels to the right, and down, each for a metre along the world's x and y at a point of the water.
    fn slopes(&self, truth: &Truth, point: WorldPoint) -> Option<Slopes> {
        let pixel = |x: f64, y: f64| self.pixel(truth, WorldPoint { x: point.x + x, y: point.y + y, z: 0.0 });
        let (seen, along_x, along_y) = (pixel(0.0, 0.0)?, pixel(0.1, 0.0)?, pixel(0.0, 0.1)?);
        let slope = |to: PixelPoint| (10.0 * (to.u - seen.u), 10.0 * (to.v - seen.v));
        let ((a, c), (b, d)) = (slope(along_x), slope(along_y));
        Some(((a, b), (c, d)))
    }

    /// Compares the boat's axis and heading that the tracker sees with the true ones, both on the water.
    fn judge_axis(&mut self, truth: &Truth, track: &Track) {
        let Track::Tracking(seen) = track else { return };
        self.figures.followed += 1;
        let axis = seen.shape.map(|shape| shape.axis);
        let Some(axis) = axis.and_then(|axis| self.direction_on_water(truth, axis)) else { return };
        self.figures.axis_seen += 1;
        // Either end may be the bow.
        let error = libm::asin(libm::sin(axis - truth.target.heading.radians()).abs());
        self.figures.axis_off += u64::from(error > AXIS_ERROR_RAD);
        let heading = seen.heading.and_then(|heading| self.direction_on_water(truth, heading));
        if let Some(heading) = heading {
            self.figures.headed += 1;
            let is_stern = libm::cos(heading - truth.target.heading.radians()) < 0.0;
            self.figures.stern_first += u64::from(is_stern);
        }
    }

    /// A direction in the picture at the boat, as one on the water, radians.
    fn direction_on_water(&self, truth: &Truth, direction: Angle) -> Option<f64> {
        let ((a, b), (c, d)) = self.slopes(truth, truth.target.position)?;
        let (sin, cos) = libm::sincos(direction.radians());
        let (x, y) = solved(((a, b), (c, d)), (cos, -sin));
        Some(libm::atan2(y, x))
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
        self.judge_axis(&taken.truth, &outcome.track);
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
