//! Which of two objects is the target after a contact, by the chroma of both before the contact.
//!
//! A red boat and a red buoy differ by some levels of chroma. Light and white balance change the chroma of
//! both by the same amount. The difference of the two is therefore the same after a contact as before. It has
//! the opposite sign if the track stayed with the other object.

use super::time_constant::rate_in;
use crate::vector::{Vector, difference, length, product, scaled, sum};

/// U and V less those of the surroundings, levels.
pub(super) type Chroma = Vector;

/// Settings of the judgement by chroma. On 40 clips of `distractors` that no setting was chosen with, 7 boats
/// are lost instead of 13 (decision 22). Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactSettings {
    /// Minimum difference before a contact that distinguishes two objects, levels.
    min_difference: f32,
    /// Minimum number of frames with both objects apart before a contact is judged.
    min_frames: u32,
    /// Minimum time with both objects apart before a contact is judged, seconds.
    min_apart_s: f32,
    /// Time with both objects apart after which a contact is not judged any more, seconds.
    max_apart_s: f32,
    /// Maximum age of a contact that is judged, seconds.
    pub(super) max_age_s: f32,
    /// Minimum component of the difference along the difference before the contact, relative to the latter, 0
    /// to 1. With less, the contact is not decided.
    clear_share: f32,
    /// Time constant of a learned chroma, seconds.
    chroma_s: f64,
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self {
            min_difference: 3.0,
            min_frames: 4,
            min_apart_s: 0.38,
            max_apart_s: 3.0,
            max_age_s: 5.0,
            clear_share: 0.3,
            chroma_s: 0.4,
        }
    }
}

/// A contact of the target with another object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Chroma of the target less that of the other object, before the contact.
    before: Chroma,
    /// Integral, over the time with both apart, of the chroma of the followed object less that of the other
    /// one, level-seconds.
    since: Chroma,
    apart_s: f32,
    /// Number of frames with both apart.
    frames: u32,
    age_s: f32,
}

/// The object that is followed after a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Followed {
    /// The two have not been apart for long enough.
    Unseen,
    /// The difference of the two does not decide.
    Unknown,
    Target,
    Other,
}

impl Contact {
    /// A contact that begins. `None` if the chroma of the two is too similar.
    pub(super) fn new(settings: &ContactSettings, target: Chroma, other: Chroma) -> Option<Self> {
        let before = difference(target, other);
        (length(before) >= settings.min_difference).then_some(Self {
            before,
            since: (0.0, 0.0),
            apart_s: 0.0,
            frames: 0,
            age_s: 0.0,
        })
    }

    /// Adds a frame, `seconds` after the last one. Returns whether the contact can still be judged.
    pub(super) fn advance(&mut self, settings: &ContactSettings, seconds: f32) -> bool {
        self.age_s += seconds;
        self.age_s <= settings.max_age_s && self.apart_s < settings.max_apart_s
    }

    /// Time since the contact began, seconds.
    pub(super) fn age_s(&self) -> f32 {
        self.age_s
    }

    /// Adds the chroma of both in a frame in which they are apart, `seconds` after the last one.
    pub(super) fn judge(
        &mut self,
        settings: &ContactSettings,
        followed: Chroma,
        other: Chroma,
        seconds: f32,
    ) -> Followed {
        self.since = sum(self.since, scaled(difference(followed, other), seconds));
        self.apart_s += seconds;
        self.frames += 1;
        if self.frames < settings.min_frames || self.apart_s < settings.min_apart_s {
            return Followed::Unseen;
        }
        let mean = scaled(self.since, 1.0 / self.apart_s);
        let squared = product(self.before, self.before);
        let share = product(mean, self.before) / squared;
        // The component across the difference before the contact. A larger one belongs to a third object.
        let across = difference(mean, scaled(self.before, share));
        if share.abs() < settings.clear_share || product(across, across) > squared {
            Followed::Unknown
        } else if share > 0.0 {
            Followed::Target
        } else {
            Followed::Other
        }
    }
}

impl ContactSettings {
    /// Moves a known chroma towards a new value, `seconds` after the last one.
    pub(super) fn learn(&self, known: &mut Chroma, seen: Chroma, seconds: f32) {
        *known = sum(*known, scaled(difference(seen, *known), rate_in(f64::from(seconds), self.chroma_s)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOAT: Chroma = (-4.0, 20.0);
    const BUOY: Chroma = (-12.0, 18.0);
    const FRAME_S: f32 = 1.0 / 30.0;

    /// The judgement within 100 frames after a contact of boat and buoy.
    fn judged(followed: Chroma, other: Chroma) -> Followed {
        let settings = ContactSettings::default();
        let mut contact = Contact::new(&settings, BOAT, BUOY).expect("the two differ");
        for _ in 0..100 {
            if !contact.advance(&settings, FRAME_S) {
                break;
            }
            let followed = contact.judge(&settings, followed, other, FRAME_S);
            if matches!(followed, Followed::Target | Followed::Other) {
                return followed;
            }
        }
        Followed::Unknown
    }

    #[test]
    fn the_sign_of_the_difference_tells_which_one_is_followed() {
        assert_eq!(judged(BOAT, BUOY), Followed::Target);
        assert_eq!(judged(BUOY, BOAT), Followed::Other);
    }

    #[test]
    fn a_change_of_the_light_changes_nothing() {
        let shifted = |(u, v): Chroma| (u + 9.0, v - 6.0);
        assert_eq!(judged(shifted(BUOY), shifted(BOAT)), Followed::Other);
    }

    #[test]
    fn what_looks_alike_is_not_judged() {
        assert_eq!(judged(BOAT, BOAT), Followed::Unknown);
        assert_eq!(judged(BOAT, (BOAT.0 + 2.0, BOAT.1 - 8.0)), Followed::Unknown, "another difference");
        assert!(Contact::new(&ContactSettings::default(), BOAT, (BOAT.0 + 2.0, BOAT.1)).is_none());
    }

    #[test]
    fn a_third_object_is_not_judged() {
        let orange = (BOAT.0 - 4.0, BOAT.1 + 14.0);
        assert_eq!(judged(orange, BUOY), Followed::Unknown);
    }

    #[test]
    fn a_contact_is_forgotten() {
        let settings = ContactSettings::default();
        let mut contact = Contact::new(&settings, BOAT, BUOY).expect("the two differ");
        assert!(contact.advance(&settings, settings.max_age_s - 1.0));
        assert!(!contact.advance(&settings, 1.1));
    }
}
