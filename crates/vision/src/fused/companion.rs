//! An object of the target's colour near the target: where it is, and how it moves.

use super::contact::{Chroma, ContactSettings};
use super::ratio::is_within;
use crate::vector::{Vector, difference, distance, length, product, scaled, sum};

/// Settings of how such objects are followed and judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct CompanionSettings {
    /// Distance from which on an object does not touch the target, sizes. Not measured by itself.
    pub(super) clear_sizes: f32,
    /// Gain of the place of an object that is measured, 0 to 1. Not measured by itself.
    place_gain: f32,
    /// Gain of its velocity, 0 to 1. Not measured by itself.
    velocity_gain: f32,
    /// An object is measured within this distance of its prediction, sizes. Not measured by itself.
    gate_sizes: f32,
    /// Added to that distance, pixels. Not measured by itself.
    gate_px: f32,
    /// Added for each second in which it was not measured, its own speeds. Not measured by itself.
    gate_speeds: f32,
    /// An object that was not measured for longer is forgotten, seconds. Not measured by itself.
    pub(super) max_hidden_s: f32,
    /// The other side is judged by an object that was measured for so long before, seconds. Not measured by
    /// itself.
    min_seen_s: f32,
    /// And that was not measured for at least so long since, seconds. Not measured by itself.
    min_hidden_s: f32,
    /// And that passed at this speed at least, sizes per second. Not measured by itself.
    min_speed: f32,
    /// And that is expected at this distance at least, sizes. Not measured by itself.
    min_distance: f32,
    /// A component is on the other side if the cosine of the angle to the opposite of the expected place is
    /// at least this, 0 to 1. Not measured by itself.
    min_cosine: f32,
    /// And if its distance is within this factor of the expected one. Not measured by itself.
    max_distance_factor: f32,
    /// Consecutive frames on the other side after which the two were exchanged. Not measured by itself.
    pub(super) frames: u32,
    /// An object that touched the target is in contact with it when it was not measured for so long, seconds:
    /// at least, and less than. Not measured by itself.
    pub(super) contact_s: (f32, f32),
    /// Largest distance from what is followed of an object that is seen first after a contact, and is one of
    /// the two that touched, sizes. Not measured by itself.
    pub(super) apart_sizes: f32,
    /// Largest distance of an object that is judged, sizes. Not measured by itself.
    pub(super) judged_sizes: f32,
    /// Smallest chroma of an object onto which the track is moved, along the target's and as a share of it.
    /// Not measured by itself.
    pub(super) min_chroma_share: f32,
    /// An object within this distance of the place to which the track is moved is the target, sizes. Not
    /// measured by itself.
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

/// A component that is not what is followed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// From what is followed, pixels.
    pub(super) place: Vector,
    pub(super) chroma: Chroma,
}

/// An object of the target's colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Companion {
    /// From the target, pixels.
    pub(super) place: Vector,
    /// The place when it was measured last.
    pub(super) seen_at: Vector,
    /// Pixels a second.
    pub(super) velocity: Vector,
    /// Time since it was first measured, seconds.
    pub(super) age_s: f32,
    /// How long it was measured, and how long it was not since, seconds.
    pub(super) seen_s: f32,
    pub(super) hidden_s: f32,
    /// Consecutive frames with a component on the other side.
    pub(super) frames: u32,
    /// Its chroma while it did not touch the target.
    pub(super) chroma: Chroma,
    /// Whether it may be one of the two that touched, when they are apart again.
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

    /// Measures the object by the nearest component that is not taken, if it is near enough.
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

    /// Whether the object is known and touched the target when it was measured last.
    pub(super) fn has_touched(&self, settings: &CompanionSettings, size: f32) -> bool {
        self.is_known(settings) && length(self.seen_at) <= settings.clear_sizes * size
    }

    /// Whether the object is in contact with the target since a moment ago.
    pub(super) fn is_in_contact(&self, settings: &CompanionSettings, size: f32) -> bool {
        self.has_touched(settings, size)
            && (settings.contact_s.0..settings.contact_s.1).contains(&self.hidden_s)
    }

    /// Whether it touched the target when it went out of view, and moves so that it can be told where it is
    /// now.
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

/// The component that is not taken and nearest to a place, with its distance.
fn nearest(others: &[Seen], is_taken: &[bool], to: Vector) -> Option<(usize, f32)> {
    let free = others.iter().enumerate().filter(|&(index, _)| !is_taken[index]);
    free.map(|(index, other)| (index, distance(other.place, to))).min_by(|a, b| a.1.total_cmp(&b.1))
}
