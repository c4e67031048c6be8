//! Objects of the target's colour near the target, and on which side of the target they pass.
//!
//! A boat that passes a buoy of its colour merges with the buoy into one blob, and the track may stay with
//! the buoy. One picture does not distinguish the two. Their relative motion does: a buoy ahead that comes
//! nearer is astern after the boat has passed. If the other object is ahead of the followed object then, the
//! followed object is the buoy. Relative motion requires no knowledge of the motion of camera or water.
//!
//! The side is unknown if the two move little, or turn while they touch. Then the chroma of both before the
//! contact decides ([`Contact`]).

use super::companion::{Companion, CompanionSettings, Seen};
use super::contact::{Chroma, Contact, Followed};
use crate::components::MAX_COMPONENTS;
use crate::vector::{Vector, difference, length, product, scaled, sum};

/// Maximum number of companions.
const MAX_OBJECTS: usize = 6;

/// The objects around a target.
#[derive(Debug, Default)]
pub(super) struct Companions {
    settings: CompanionSettings,
    objects: [Option<Companion>; MAX_OBJECTS],
    /// Chroma of the target while no other object touched it.
    own_chroma: Option<Chroma>,
    /// The last contact, until it is judged.
    contact: Option<Contact>,
    /// Time since the last contact, seconds; `None` once the target is identified.
    in_doubt_s: Option<f32>,
}

/// State of the judgement of a contact after a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Judgement {
    /// There is no contact, or the chroma does not decide.
    None,
    /// More frames are needed.
    Pending,
    /// The target is this component.
    Target(usize),
}

impl Companions {
    /// Moves the predictions by a frame without a measurement, `seconds` after the last one. The target has
    /// this size, pixels.
    pub(super) fn predict(&mut self, size: f32, seconds: f32) {
        for slot in &mut self.objects {
            if let Some(object) = slot {
                object.place = sum(object.place, scaled(object.velocity, seconds));
                object.hidden_s += seconds;
                object.age_s += seconds;
                if object.hidden_s > self.settings.max_hidden_s {
                    *slot = None;
                }
            }
        }
        self.contact.take_if(|contact| !contact.advance(&self.settings.contact, seconds));
        self.in_doubt_s = self
            .in_doubt_s
            .map(|since| since + seconds)
            .filter(|&since| since <= self.settings.contact.max_age_s);
        self.find_contact(size);
    }

    /// Looks for an object that has just come into contact with the target.
    fn find_contact(&mut self, size: f32) {
        let settings = self.settings;
        // One contact lasts for several frames.
        if self.contact.is_some_and(|contact| contact.age_s() < self.settings.contact_s.1) {
            return;
        }
        let Some(object) = self.objects.iter().flatten().find(|object| object.is_in_contact(&settings, size))
        else {
            return;
        };
        self.in_doubt_s = Some(0.0);
        let Some(own) = self.own_chroma else { return };
        self.contact = Contact::new(&self.settings.contact, own, object.chroma);
        for object in self.objects.iter_mut().flatten() {
            object.is_of_contact = object.is_in_contact(&settings, size);
        }
    }

    /// Measures the objects after [`Self::predict`]. `chroma` and `size` (pixels) are those of the followed
    /// object; `others` are the other components. `is_visible`: whether a place relative to the followed
    /// object is in view. Returns the index of the component that is the target if the followed object is not
    /// the target.
    pub(super) fn measure(
        &mut self,
        chroma: Chroma,
        others: &[Seen],
        size: f32,
        seconds: f32,
        is_visible: impl Fn(Vector) -> bool,
    ) -> Option<usize> {
        let settings = self.settings;
        let mut is_taken = [false; MAX_COMPONENTS];
        let mut measured = [None; MAX_OBJECTS];
        // Known objects first: they have priority for components within their gates.
        for known in [true, false] {
            for (index, slot) in self.objects.iter_mut().enumerate() {
                if let Some(object) = slot.as_mut().filter(|object| object.is_known(&settings) == known) {
                    measured[index] = object.find(&settings, others, &mut is_taken, (size, seconds));
                }
            }
        }
        for (&seen, _) in others.iter().zip(&is_taken).filter(|(_, taken)| !**taken) {
            if let Some(slot) = self.objects.iter_mut().find(|slot| slot.is_none()) {
                let is_of_contact =
                    self.contact.is_some() && length(seen.place) <= self.settings.apart_sizes * size;
                *slot = Some(Companion { is_of_contact, ..Companion::new(seen) });
            }
        }
        let is_clear = others.iter().all(|other| length(other.place) > self.settings.clear_sizes * size);
        if is_clear && self.contact.is_none() {
            settings.contact.learn(self.own_chroma.get_or_insert(chroma), chroma, seconds);
        }
        let target = match self.judge_contact(chroma, others, &measured, (size, seconds)) {
            Judgement::Target(index) => Some(index),
            Judgement::Pending => None,
            Judgement::None => self.find_exchanged(&measured, size, is_visible),
        };
        target.filter(|&index| self.has_own_chroma(others[index].chroma))
    }

    /// Whether an object has the target's chroma. Glitter and foam may have colours of the target, but not
    /// the chroma of its paint.
    fn has_own_chroma(&self, chroma: Chroma) -> bool {
        self.own_chroma
            .is_none_or(|own| product(chroma, own) >= self.settings.min_chroma_share * product(own, own))
    }

    /// Judges a contact by the chroma of both objects in a frame.
    fn judge_contact(
        &mut self,
        chroma: Chroma,
        others: &[Seen],
        measured: &[Option<usize>],
        (size, seconds): (f32, f32),
    ) -> Judgement {
        let nearest = self
            .objects
            .iter()
            .zip(measured)
            .filter_map(|(slot, &component)| slot.filter(|object| object.is_of_contact).and(component))
            .map(|index| (index, length(others[index].place)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let (Some(contact), Some((index, distance))) = (&mut self.contact, nearest) else {
            return Judgement::None;
        };
        if distance > self.settings.judged_sizes * size {
            return Judgement::None;
        }
        match contact.judge(&self.settings.contact, chroma, others[index].chroma, seconds) {
            Followed::Unseen => Judgement::Pending,
            Followed::Unknown => Judgement::None,
            Followed::Other => Judgement::Target(index),
            Followed::Target => {
                (self.contact, self.in_doubt_s) = (None, None);
                // The chroma outweighs the side on which the object was expected.
                for slot in &mut self.objects {
                    slot.take_if(|object| object.is_of_contact && object.hidden_s > 0.0);
                }
                Judgement::None
            }
        }
    }

    /// The component of an object that has been opposite to the expected place of a judge for several frames.
    /// The judge was known before that object, and is out of view.
    fn find_exchanged(
        &mut self,
        measured: &[Option<usize>],
        size: f32,
        is_visible: impl Fn(Vector) -> bool,
    ) -> Option<usize> {
        let settings = self.settings;
        let hidden = self
            .objects
            .map(|slot| slot.filter(|object| object.can_judge(&settings, size) && is_visible(object.place)));
        for (slot, &component) in self.objects.iter_mut().zip(measured) {
            let (Some(object), Some(component)) = (slot, component) else { continue };
            let is_exchanged = |judge: &Companion| {
                object.age_s < judge.hidden_s && judge.is_opposite(&settings, object.place)
            };
            object.frames = if hidden.iter().flatten().any(is_exchanged) { object.frames + 1 } else { 0 };
            if object.frames >= self.settings.frames {
                return Some(component);
            }
        }
        None
    }

    /// Continues with the target at this place, relative to the object that was followed until now.
    pub(super) fn exchange(&mut self, place: Vector, size: f32) {
        let settings = self.settings;
        (self.contact, self.in_doubt_s) = (None, None);
        let judges = self.objects.map(|slot| {
            slot.is_some_and(|object| {
                object.can_judge(&settings, size) && object.is_opposite(&settings, place)
            })
        });
        for (slot, is_judge) in self.objects.iter_mut().zip(judges) {
            let Some(object) = slot else { continue };
            let moved = difference(object.place, place);
            if is_judge {
                (object.place, object.hidden_s) = (scaled(place, -1.0), 0.0);
                object.seen_at = object.place;
            } else if object.is_known(&settings)
                && object.frames < self.settings.frames
                && length(moved) > self.settings.own_sizes * size
            {
                (object.place, object.seen_at) = (moved, difference(object.seen_at, place));
            } else {
                *slot = None;
            }
        }
    }

    /// Whether an object touched the target recently, and it is not known which of the two is followed.
    pub(super) fn are_in_doubt(&self) -> bool {
        self.in_doubt_s.is_some()
    }

    /// Minimum distance of an object that does not touch a target of this size, pixels.
    pub(super) fn clear_distance(&self, size: f32) -> f32 {
        self.settings.clear_sizes * size
    }

    /// Distance of the nearest known object, pixels; infinite if there is none.
    pub(super) fn nearest_distance(&self) -> f32 {
        let settings = self.settings;
        self.objects
            .iter()
            .flatten()
            .filter(|object| object.is_known(&settings))
            .fold(f32::INFINITY, |least, object| least.min(length(object.place)))
    }
}

#[cfg(test)]
mod tests;
