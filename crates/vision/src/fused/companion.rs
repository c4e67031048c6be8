//! An object of the target's colour near the target: its place and its motion relative to the target.

use super::contact::{Chroma, ContactSettings};
use super::ratio::is_within;
use crate::vector::{Vector, difference, distance, length, product, scaled, sum};

/// Settings of the companions. The *judge* of an exchange is a companion that touched the target, is out of
/// view since, and is expected on one side of the target. Settings without a figure were not measured
/// individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct CompanionSettings {
    /// Minimum distance of an object that does not touch the target, sizes.
    pub(super) clear_sizes: f32,
    /// Gain of the place, 0 to 1.
    place_gain: f32,
    /// Gain of the velocity, 0 to 1.
    velocity_gain: f32,
    /// Maximum distance of a measured object from its prediction, sizes.
    gate_sizes: f32,
    /// Added to that distance, pixels.
    gate_px: f32,
    /// Added for each second without a measurement, in speeds of the object.
    gate_speeds: f32,
    /// Maximum time without a measurement, seconds; then the object is forgotten.
    pub(super) max_hidden_s: f32,
    /// Minimum time for which a judge was measured before it went out of view, seconds.
    min_seen_s: f32,
    /// Minimum time for which a judge has been out of view, seconds.
    min_hidden_s: f32,
    /// Minimum speed of a judge, sizes per second.
    min_speed: f32,
    /// Minimum expected distance of a judge from the target, sizes.
    min_distance: f32,
    /// Minimum cosine of the angle between a component on the other side and the opposite of the judge's
    /// expected place, 0 to 1.
    min_cosine: f32,
    /// Maximum ratio of the distance of that component to the judge's expected distance.
    max_distance_factor: f32,
    /// Number of consecutive frames with a component on the other side that show an exchange.
    pub(super) frames: u32,
    /// Range of the time without a measurement in which an object that touched the target counts as in
    /// contact, seconds: minimum (inclusive) and maximum (exclusive).
    pub(super) contact_s: (f32, f32),
    /// Maximum distance from the followed object of a new object after a contact that may be one of the two
    /// that touched, sizes.
    pub(super) apart_sizes: f32,
    /// Maximum distance of an object whose chroma is compared after a contact, sizes.
    pub(super) judged_sizes: f32,
    /// Minimum chroma of an object onto which the track is moved: the component along the target's chroma,
    /// relative to it.
    pub(super) min_chroma_share: f32,
    /// Maximum distance from the place to which the track is moved of a companion that is the target itself,
    /// sizes.
    pub(super) own_sizes: f32,
    pub(super) contact: ContactSettings,
}

impl Default for CompanionSettings {
    fn default() -> Self {
        Self {
            clear_sizes: 1.6,
            place_gain: 0.3,
            velocity_gain: 0.04,
            gate_sizes: 0.5,
            gate_px: 2.0,
            gate_speeds: 0.5,
            max_hidden_s: 6.0,
            min_seen_s: 0.7,
            min_hidden_s: 0.2,
            min_speed: 0.4,
            min_distance: 0.8,
            min_cosine: 0.5,
            max_distance_factor: 2.2,
            frames: 6,
            contact_s: (0.1, 0.3),
            apart_sizes: 2.3,
            judged_sizes: 3.0,
            min_chroma_share: 0.5,
            own_sizes: 0.5,
            contact: ContactSettings::default(),
        }
    }
}

/// A component other than the followed object's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// From the followed object, pixels.
    pub(super) place: Vector,
    pub(super) chroma: Chroma,
}

/// An object of the target's colour that is not followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Companion {
    /// From the target, pixels.
    pub(super) place: Vector,
    /// Place at the last measurement.
    pub(super) seen_at: Vector,
    /// Pixels per second.
    pub(super) velocity: Vector,
    /// Time since it was first measured, seconds.
    pub(super) age_s: f32,
    /// Duration of the measurements, and time since the last one, seconds.
    pub(super) seen_s: f32,
    pub(super) hidden_s: f32,
    /// Consecutive frames with a component on the other side.
    pub(super) frames: u32,
    /// Chroma while the object did not touch the target.
    pub(super) chroma: Chroma,
    /// Whether the object may be one of the two that touched.
    pub(super) is_of_contact: bool,
}

impl Companion {
    pub(super) const fn new(Seen { place, chroma }: Seen) -> Self {
        Self {
            place,
            seen_at: place,
            velocity: (0.0, 0.0),
            age_s: 0.0,
            seen_s: 0.0,
            hidden_s: 0.0,
            frames: 0,
            chroma,
            is_of_contact: false,
        }
    }

    pub(super) fn gate(&self, settings: &CompanionSettings, size: f32) -> f32 {
        settings.gate_sizes * size
            + settings.gate_px
            + settings.gate_speeds * length(self.velocity) * self.hidden_s
    }

    pub(super) fn correct(
        &mut self,
        settings: &CompanionSettings,
        Seen { place, chroma }: Seen,
        (size, seconds): (f32, f32),
    ) {
        if length(place) > settings.clear_sizes * size || !self.is_known(settings) {
            settings.contact.learn(&mut self.chroma, chroma, seconds);
        }
        let error = difference(place, self.place);
        self.place = sum(self.place, scaled(error, settings.place_gain));
        if seconds > 0.0 {
            self.velocity = sum(self.velocity, scaled(error, settings.velocity_gain / seconds));
        }
        self.seen_at = self.place;
        self.seen_s += seconds;
        self.hidden_s = 0.0;
    }

    /// Measures the object by the nearest free component within the gate. Returns the index of that
    /// component.
    pub(super) fn find(
        &mut self,
        settings: &CompanionSettings,
        others: &[Seen],
        is_taken: &mut [bool],
        (size, seconds): (f32, f32),
    ) -> Option<usize> {
        let (index, distance) = nearest(others, is_taken, self.place)?;
        let opposite = length(sum(others[index].place, self.place));
        let is_ambiguous = self.hidden_s > settings.min_hidden_s && opposite < 2.0 * distance;
        if distance > self.gate(settings, size) || is_ambiguous {
            return None;
        }
        self.correct(settings, others[index], (size, seconds));
        is_taken[index] = true;
        Some(index)
    }

    /// Whether the object was measured for long enough to know its velocity.
    pub(super) fn is_known(&self, settings: &CompanionSettings) -> bool {
        self.seen_s >= settings.min_seen_s
    }

    /// Whether the object is known and touched the target at the last measurement.
    pub(super) fn has_touched(&self, settings: &CompanionSettings, size: f32) -> bool {
        self.is_known(settings) && length(self.seen_at) <= settings.clear_sizes * size
    }

    /// Whether the object has just come into contact with the target.
    pub(super) fn is_in_contact(&self, settings: &CompanionSettings, size: f32) -> bool {
        self.has_touched(settings, size)
            && (settings.contact_s.0..settings.contact_s.1).contains(&self.hidden_s)
    }

    /// Whether the object can be a judge (see [`CompanionSettings`]) for a target of this size, pixels.
    pub(super) fn can_judge(&self, settings: &CompanionSettings, size: f32) -> bool {
        self.has_touched(settings, size)
            && self.hidden_s >= settings.min_hidden_s
            && length(self.velocity) >= settings.min_speed * size
            && length(self.place) >= settings.min_distance * size
    }

    pub(super) fn is_opposite(&self, settings: &CompanionSettings, place: Vector) -> bool {
        let (expected, seen) = (length(self.place), length(place));
        let cosine = -product(self.place, place) / (expected * seen).max(f32::MIN_POSITIVE);
        cosine >= settings.min_cosine && is_within(seen / expected, settings.max_distance_factor)
    }
}

/// The free component nearest to a place, with its distance.
fn nearest(others: &[Seen], is_taken: &[bool], to: Vector) -> Option<(usize, f32)> {
    let free = others.iter().enumerate().filter(|&(index, _)| !is_taken[index]);
    free.map(|(index, other)| (index, distance(other.place, to))).min_by(|a, b| a.1.total_cmp(&b.1))
}
