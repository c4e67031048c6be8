//! Which of two objects is the target after they touched: their chroma before tells.
//!
//! Boat and buoy, both red, differ by some levels of chroma. The light and the camera's white balance change
//! both alike. So the difference between the two is the same after a contact as before, or has the other sign
//! if the track stayed with the other one.

use super::time_constant::rate_in;
use crate::vector::{Vector, difference, length, product, scaled, sum};

/// U and V less those of the surroundings, levels.
pub(super) type Chroma = Vector;

/// Settings of the judgement by chroma. As a whole, on 40 clips of `distractors` that nothing was chosen
/// with, 7 boats are lost instead of 13 (decision 22).
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactSettings {
    /// Smallest difference before a contact that tells two objects apart, levels. Not measured by itself.
    min_difference: f32,
    /// A contact is judged after this number of frames with both apart. Not measured by itself.
    min_frames: u32,
    /// A contact is judged from this time with both apart on, seconds. Not measured by itself.
    min_apart_s: f32,
    /// A contact is judged up to this time with both apart, seconds. Not measured by itself.
    max_apart_s: f32,
    /// A contact after which the two are not seen apart is forgotten, seconds. Not measured by itself.
    pub(super) max_age_s: f32,
    /// The difference along the one before from which on it is judged, as a share of the one before. Not
    /// measured by itself.
    clear_share: f32,
    /// Time constant of a chroma that is learned, seconds. Not measured by itself.
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
    /// Chroma of the target less that of the other object, before.
    before: Chroma,
    /// Integral, over the time with both apart, of the chroma of what is followed less that of the other one,
    /// level-seconds.
    since: Chroma,
    apart_s: f32,
    /// Number of frames with both apart.
    frames: u32,
    age_s: f32,
}

/// What is followed after a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Followed {
    /// The two were not seen apart for long enough.
    Unseen,
    /// The difference of the two tells nothing.
    Unknown,
    Target,
    Other,
}

impl Contact {
    /// A contact that begins; `None` where the chroma of both is too much alike.
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

    /// Adds a frame, `seconds` after the last one. Whether the contact can still be judged.
    pub(super) fn advance(&mut self, settings: &ContactSettings, seconds: f32) -> bool {
        self.age_s += seconds;
        self.age_s <= settings.max_age_s && self.apart_s < settings.max_apart_s
    }

    /// Time since it began, seconds.
    pub(super) fn age_s(&self) -> f32 {
        self.age_s
    }

    /// Adds what is seen in a frame with both apart, `seconds` after the last one.
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
        // Across the difference of before: more than that is another object's.
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

    /// What is judged within 100 frames after a contact of boat and buoy.
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
