//! Things of the target's colour near it, and on which side of the target they pass.
//!
//! A boat that passes a buoy of its colour becomes one blob with it, and the track may stay with the buoy. Nothing in one picture
//! tells the two apart. Their relative motion does: a buoy ahead that comes nearer is astern after the boat has passed. If
//! afterwards the other thing is ahead of what is followed, then what is followed is the buoy. Relative motion needs neither the
//! camera's motion nor the water's.
//!
//! The side is not known where the two move little, or turn while they touch. There the chroma of both before tells ([`Contact`]).

use barrelman_vocab::PixelBox;

use super::contact::{Chroma, Contact, Followed, MAX_AGE_S, learn};
use super::vector::{Vector, difference, length, product, scaled, sum};
use crate::components::{Component, MAX_COMPONENTS};

/// Distance, in sizes of the target, from which on a thing does not touch the target.
pub(super) const CLEAR_SIZES: f32 = 1.6;
/// Number of things that are followed.
const MAX_THINGS: usize = 6;
/// Gains of place and velocity of a thing that is measured.
const PLACE_GAIN: f32 = 0.3;
const VELOCITY_GAIN: f32 = 0.04;
/// A thing is measured within this distance of its prediction: sizes of the target, and pixels; more for each second in which
/// it was not measured, in its own speeds.
const GATE_SIZES: f32 = 0.5;
const GATE_PX: f32 = 2.0;
const GATE_SPEEDS: f32 = 0.5;
/// A thing that was not measured for longer is forgotten, seconds.
const MAX_HIDDEN_S: f32 = 6.0;
/// The other side is judged by a thing that was measured for so long before, and not for at least so long since, seconds, ...
const MIN_SEEN_S: f32 = 0.7;
const MIN_HIDDEN_S: f32 = 0.2;
/// ... that touched the target then, that passed at this speed at least, sizes a second, and is expected at this distance at least, sizes.
const MIN_SPEED: f32 = 0.4;
const MIN_DISTANCE: f32 = 0.8;
/// A component is on the other side if the cosine of the angle to the opposite of the expected place is at least this, and its
/// distance within this factor of the expected one.
const MIN_COSINE: f32 = 0.5;
const MAX_DISTANCE_FACTOR: f32 = 2.2;
/// Consecutive frames on the other side after which the two were exchanged.
const FRAMES: u32 = 6;
/// A thing that touched the target is in contact with it when it was not measured for so long, seconds.
const CONTACT_S: core::ops::Range<f32> = 0.1..0.3;
/// Largest distance from what is followed of a thing that is seen first after a contact, and is one of the two that touched; and of
/// one that is judged, sizes.
const APART_SIZES: f32 = 2.3;
const JUDGED_SIZES: f32 = 3.0;
/// Smallest chroma of a thing onto which the track is moved, along the target's and as a share of it.
const MIN_CHROMA_SHARE: f32 = 0.5;
/// A thing within this distance of the place to which the track is moved is the target, sizes.
const OWN_SIZES: f32 = 0.5;

/// The things around a target.
#[derive(Debug, Clone, Default)]
pub(super) struct Companions {
    things: [Option<Companion>; MAX_THINGS],
    /// Chroma of the target while nothing else touched it.
    own_chroma: Option<Chroma>,
    /// The last contact, until it is judged.
    contact: Option<Contact>,
    /// Time since the last contact, seconds, until something tells which of the two is the target.
    in_doubt_s: Option<f32>,
}

/// A component that is not what is followed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Seen {
    /// From what is followed, pixels.
    pub(super) place: Vector,
    pub(super) chroma: Chroma,
}

/// What is known of a contact after a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Judgement {
    /// Nothing.
    None,
    /// It will be judged soon.
    Pending,
    /// The target is this component.
    Target(usize),
}

/// Something of the target's colour.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Companion {
    /// From the target, pixels.
    place: Vector,
    /// The place when it was measured last.
    seen_at: Vector,
    /// Pixels a second.
    velocity: Vector,
    /// Time since it was first measured, seconds.
    age_s: f32,
    /// How long it was measured, and how long it was not since, seconds.
    seen_s: f32,
    hidden_s: f32,
    /// Consecutive frames with a component on the other side.
    frames: u32,
    /// Its chroma while it did not touch the target.
    chroma: Chroma,
    /// Whether it may be one of the two that touched, when they are apart again.
    is_of_contact: bool,
}

impl Companions {
    /// Moves the predictions by a frame without a measurement, `seconds` after the last one. The target has this size, pixels.
    pub(super) fn predict(&mut self, size: f32, seconds: f32) {
        for slot in &mut self.things {
            if let Some(thing) = slot {
                thing.place = sum(thing.place, scaled(thing.velocity, seconds));
                thing.hidden_s += seconds;
                thing.age_s += seconds;
                if thing.hidden_s > MAX_HIDDEN_S {
                    *slot = None;
                }
            }
        }
        self.contact.take_if(|contact| !contact.advance(seconds));
        self.in_doubt_s = self.in_doubt_s.map(|since| since + seconds).filter(|&since| since <= MAX_AGE_S);
        self.find_contact(size);
    }

    /// Looks for a thing that has just come into contact with the target.
    fn find_contact(&mut self, size: f32) {
        // One contact lasts for several frames.
        if self.contact.is_some_and(|contact| contact.age_s() < CONTACT_S.end) {
            return;
        }
        let Some(thing) = self.things.iter().flatten().find(|thing| thing.is_in_contact(size)) else {
            return;
        };
        self.in_doubt_s = Some(0.0);
        let Some(own) = self.own_chroma else { return };
        self.contact = Contact::new(own, thing.chroma);
        for thing in self.things.iter_mut().flatten() {
            thing.is_of_contact = thing.is_in_contact(size);
        }
    }

    /// Measures the things after [`Self::predict`], with the chroma of what is followed, the components that are not that, and
    /// its size, pixels. `is_visible` tells whether a place from it is in view. The index of the component that is the target, where
    /// that is another one than what is followed.
    pub(super) fn measure(
        &mut self,
        chroma: Chroma,
        others: &[Seen],
        size: f32,
        seconds: f32,
        is_visible: impl Fn(Vector) -> bool,
    ) -> Option<usize> {
        let mut is_taken = [false; MAX_COMPONENTS];
        let mut measured = [None; MAX_THINGS];
        // Those that are known first: a component is theirs if it is near enough.
        for known in [true, false] {
            for (index, slot) in self.things.iter_mut().enumerate() {
                if let Some(thing) = slot.as_mut().filter(|thing| thing.is_known() == known) {
                    measured[index] = thing.find(others, &mut is_taken, size, seconds);
                }
            }
        }
        for (&seen, _) in others.iter().zip(&is_taken).filter(|(_, taken)| !**taken) {
            if let Some(slot) = self.things.iter_mut().find(|slot| slot.is_none()) {
                let is_of_contact = self.contact.is_some() && length(seen.place) <= APART_SIZES * size;
                *slot = Some(Companion { is_of_contact, ..Companion::new(seen) });
            }
        }
        let is_clear = others.iter().all(|other| length(other.place) > CLEAR_SIZES * size);
        if is_clear && self.contact.is_none() {
            learn(self.own_chroma.get_or_insert(chroma), chroma, seconds);
        }
        let target = match self.judge_contact(chroma, others, &measured, (size, seconds)) {
            Judgement::Target(index) => Some(index),
            Judgement::Pending => None,
            Judgement::None => self.find_exchanged(&measured, size, is_visible),
        };
        target.filter(|&index| self.has_own_chroma(others[index].chroma))
    }

    /// Whether a thing has the target's chroma. Glitter and foam may be among the target's colours, but lack its paint.
    fn has_own_chroma(&self, chroma: Chroma) -> bool {
        self.own_chroma.is_none_or(|own| product(chroma, own) >= MIN_CHROMA_SHARE * product(own, own))
    }

    /// Judges a contact by what is seen in a frame.
    fn judge_contact(
        &mut self,
        chroma: Chroma,
        others: &[Seen],
        measured: &[Option<usize>],
        (size, seconds): (f32, f32),
    ) -> Judgement {
        let nearest = self
            .things
            .iter()
            .zip(measured)
            .filter_map(|(slot, &component)| slot.filter(|thing| thing.is_of_contact).and(component))
            .map(|index| (index, length(others[index].place)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let (Some(contact), Some((index, distance))) = (&mut self.contact, nearest) else {
            return Judgement::None;
        };
        if distance > JUDGED_SIZES * size {
            return Judgement::None;
        }
        match contact.judge(chroma, others[index].chroma, seconds) {
            Followed::Unseen => Judgement::Pending,
            Followed::Unknown => Judgement::None,
            Followed::Other => Judgement::Target(index),
            Followed::Target => {
                (self.contact, self.in_doubt_s) = (None, None);
                // The side on which the thing was expected tells less.
                for slot in &mut self.things {
                    slot.take_if(|thing| thing.is_of_contact && thing.hidden_s > 0.0);
                }
                Judgement::None
            }
        }
    }

    /// The component of a thing that lies where the opposite of one is expected that was known before it and is not in view now.
    fn find_exchanged(
        &mut self,
        measured: &[Option<usize>],
        size: f32,
        is_visible: impl Fn(Vector) -> bool,
    ) -> Option<usize> {
        let hidden =
            self.things.map(|slot| slot.filter(|thing| thing.can_judge(size) && is_visible(thing.place)));
        for (slot, &component) in self.things.iter_mut().zip(measured) {
            let (Some(thing), Some(component)) = (slot, component) else { continue };
            let is_exchanged =
                |judge: &Companion| thing.age_s < judge.hidden_s && judge.is_opposite(thing.place);
            thing.frames = if hidden.iter().flatten().any(is_exchanged) { thing.frames + 1 } else { 0 };
            if thing.frames >= FRAMES {
                return Some(component);
            }
        }
        None
    }

    /// The target is at this place from what was followed until now.
    pub(super) fn exchange(&mut self, place: Vector, size: f32) {
        (self.contact, self.in_doubt_s) = (None, None);
        let judges = self
            .things
            .map(|slot| slot.is_some_and(|thing| thing.can_judge(size) && thing.is_opposite(place)));
        for (slot, is_judge) in self.things.iter_mut().zip(judges) {
            let Some(thing) = slot else { continue };
            let moved = difference(thing.place, place);
            if is_judge {
                (thing.place, thing.hidden_s) = (scaled(place, -1.0), 0.0);
                thing.seen_at = thing.place;
            } else if thing.is_known() && thing.frames < FRAMES && length(moved) > OWN_SIZES * size {
                (thing.place, thing.seen_at) = (moved, difference(thing.seen_at, place));
            } else {
                *slot = None;
            }
        }
    }

    /// Whether a thing touched the target a moment ago, and nothing told since which of the two is followed.
    pub(super) fn are_in_doubt(&self) -> bool {
        self.in_doubt_s.is_some()
    }

    /// Distance of the nearest thing that is known, pixels; infinite where there is none.
    pub(super) fn nearest_distance(&self) -> f32 {
        self.things
            .iter()
            .flatten()
            .filter(|thing| thing.is_known())
            .fold(f32::INFINITY, |least, thing| least.min(length(thing.place)))
    }
}

impl Companion {
    const fn new(Seen { place, chroma }: Seen) -> Self {
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

    fn gate(&self, size: f32) -> f32 {
        GATE_SIZES * size + GATE_PX + GATE_SPEEDS * length(self.velocity) * self.hidden_s
    }

    fn correct(&mut self, Seen { place, chroma }: Seen, size: f32, seconds: f32) {
        if length(place) > CLEAR_SIZES * size || !self.is_known() {
            learn(&mut self.chroma, chroma, seconds);
        }
        let error = difference(place, self.place);
        self.place = sum(self.place, scaled(error, PLACE_GAIN));
        if seconds > 0.0 {
            self.velocity = sum(self.velocity, scaled(error, VELOCITY_GAIN / seconds));
        }
        self.seen_at = self.place;
        self.seen_s += seconds;
        self.hidden_s = 0.0;
    }

    /// Measures the thing by the nearest component that is not taken, if it is near enough.
    fn find(&mut self, others: &[Seen], is_taken: &mut [bool], size: f32, seconds: f32) -> Option<usize> {
        let (index, distance) = nearest(others, is_taken, self.place)?;
        let opposite = length(sum(others[index].place, self.place));
        let is_ambiguous = self.hidden_s > MIN_HIDDEN_S && opposite < 2.0 * distance;
        if distance > self.gate(size) || is_ambiguous {
            return None;
        }
        self.correct(others[index], size, seconds);
        is_taken[index] = true;
        Some(index)
    }

    /// Whether the thing was measured for long enough to know its velocity.
    fn is_known(&self) -> bool {
        self.seen_s >= MIN_SEEN_S
    }

    /// Whether the thing is known and touched the target when it was measured last.
    fn has_touched(&self, size: f32) -> bool {
        self.is_known() && length(self.seen_at) <= CLEAR_SIZES * size
    }

    /// Whether the thing is in contact with the target since a moment ago.
    fn is_in_contact(&self, size: f32) -> bool {
        self.has_touched(size) && CONTACT_S.contains(&self.hidden_s)
    }

    /// Whether it touched the target when it went out of view, and moves so that it can be told where it is now.
    fn can_judge(&self, size: f32) -> bool {
        self.has_touched(size)
            && self.hidden_s >= MIN_HIDDEN_S
            && length(self.velocity) >= MIN_SPEED * size
            && length(self.place) >= MIN_DISTANCE * size
    }

    fn is_opposite(&self, place: Vector) -> bool {
        let (expected, seen) = (length(self.place), length(place));
        let cosine = -product(self.place, place) / (expected * seen).max(f32::MIN_POSITIVE);
        cosine >= MIN_COSINE && (1.0 / MAX_DISTANCE_FACTOR..=MAX_DISTANCE_FACTOR).contains(&(seen / expected))
    }
}

/// The component that is not taken and nearest to a place, with its distance.
fn nearest(others: &[Seen], is_taken: &[bool], to: Vector) -> Option<(usize, f32)> {
    let free = others.iter().enumerate().filter(|&(index, _)| !is_taken[index]);
    free.map(|(index, other)| (index, length(difference(other.place, to)))).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The index of the component whose bounds have the largest part in common with a box.
pub(super) fn own_component(components: &[Component], own_box: PixelBox) -> Option<usize> {
    let common = components.iter().map(|component| component.bounds.intersection(own_box).area()).enumerate();
    common.filter(|&(_, area)| area > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;
    const SIZE: f32 = 10.0;
    const BOAT: Chroma = (-4.0, 20.0);
    const BUOY: Chroma = (-12.0, 18.0);

    fn buoy(place: (f32, f32)) -> Seen {
        Seen { place, chroma: BUOY }
    }

    /// What is found when a thing, at first 20 px to the right of the target, comes nearer with 10 px a second, is not visible
    /// within 9 px, and from then on is seen where `shown` puts it.
    fn after_passing(shown: impl Fn(f32) -> f32) -> Option<(f32, f32)> {
        after_passing_at(1.0, |(right, down)| (shown(right), down))
    }

    /// The same with a thing that passes `down` pixels below the target.
    fn after_passing_at(down: f32, shown: impl Fn((f32, f32)) -> (f32, f32)) -> Option<(f32, f32)> {
        after_passing_seen(down, |place| buoy(shown(place)))
    }

    /// The same with what is seen after it passed.
    fn after_passing_seen(down: f32, shown: impl Fn((f32, f32)) -> Seen) -> Option<(f32, f32)> {
        let mut companions = Companions::default();
        for frame in 0_u8..150 {
            let right = 20.0 - 10.0 * f32::from(frame) * FRAME_S;
            companions.predict(SIZE, FRAME_S);
            let is_before = right > 0.0;
            let others = [if is_before { buoy((right, down)) } else { shown((right, down)) }];
            let visible = if right.abs() > 9.0 { &others[..] } else { &[] };
            // All of one chroma: only the side tells.
            if let Some(index) = companions.measure(BUOY, visible, SIZE, FRAME_S, |_| true) {
                return Some(visible[index].place);
            }
        }
        None
    }

    #[test]
    fn a_thing_that_was_passed_is_on_the_other_side() {
        assert_eq!(after_passing(|right| right), None, "it is where it is expected");
        let (right, _) = after_passing(|right| -right).expect("what is followed is the thing");
        assert!((9.0..13.0).contains(&right), "{right}");
    }

    /// Whether target and buoy are in doubt, this long after the buoy, of this chroma at first, came into contact with the target; it is
    /// not seen again before `apart_s` after that.
    fn are_in_doubt(buoy: Chroma, apart_s: f32, after_s: f32) -> bool {
        let mut companions = Companions::default();
        let mut since_s = 0.0;
        let mut frame = 0_u16;
        while since_s < after_s {
            let right = 45.0 - 10.0 * f32::from(frame) * FRAME_S;
            frame += 1;
            let is_hidden = right < 10.0 && since_s < apart_s;
            let others = [Seen { place: (right.max(10.5), 0.0), chroma: buoy }];
            companions.predict(SIZE, FRAME_S);
            let seen = if is_hidden { &[][..] } else { &others[..] };
            assert_eq!(companions.measure(BOAT, seen, SIZE, FRAME_S, |_| false), None);
            if right < 10.0 {
                since_s += FRAME_S;
            } else {
                assert!(!companions.are_in_doubt(), "before, at {right}");
            }
        }
        companions.are_in_doubt()
    }

    #[test]
    fn a_contact_leaves_a_doubt_until_it_is_judged_or_five_seconds_have_passed() {
        assert!(are_in_doubt(BUOY, 9.0, 0.5));
        assert!(are_in_doubt(BUOY, 9.0, 4.5));
        assert!(!are_in_doubt(BUOY, 9.0, 5.5));
        assert!(are_in_doubt(BUOY, 1.0, 1.2), "apart for a moment");
        assert!(!are_in_doubt(BUOY, 1.0, 2.0), "its chroma tells");
        assert!(are_in_doubt(BOAT, 1.0, 2.0), "the chroma of the two is the same");
    }

    #[test]
    fn glitter_on_the_other_side_is_not_the_target() {
        let opposite =
            |chroma| after_passing_seen(1.0, |(right, down)| Seen { place: (-right, -down), chroma });
        assert!(opposite(BUOY).is_some());
        assert_eq!(opposite((-1.0, 3.0)), None);
    }

    #[test]
    fn a_thing_that_went_out_of_view_at_a_distance_tells_nothing() {
        let opposite = |(right, down): (f32, f32)| (-right, -down);
        assert!(after_passing_at(5.0, opposite).is_some());
        assert_eq!(after_passing_at(18.0, opposite), None);
    }

    #[test]
    fn a_thing_that_was_there_before_is_not_the_target() {
        let mut companions = Companions::default();
        for frame in 0_u8..150 {
            let right = 20.0 - 10.0 * f32::from(frame) * FRAME_S;
            companions.predict(SIZE, FRAME_S);
            let others = [(18.0, -3.0), (right, 1.0)].map(buoy);
            let visible = if right > 9.0 { &others[..] } else { &others[..1] };
            assert_eq!(companions.measure(BOAT, visible, SIZE, FRAME_S, |_| true), None, "{frame}");
        }
    }

    #[test]
    fn after_an_exchange_the_thing_is_where_the_track_was() {
        let mut companions = Companions::default();
        for frame in 0_u8..150 {
            let right = 20.0 - 10.0 * f32::from(frame) * FRAME_S;
            companions.predict(SIZE, FRAME_S);
            let others = [buoy((right.abs(), 1.0))];
            let visible = if right.abs() > 9.0 { &others[..] } else { &[] };
            if companions.measure(BUOY, visible, SIZE, FRAME_S, |_| true).is_some() {
                companions.exchange(others[0].place, SIZE);
                let distance = length(sum(others[0].place, companions.things[0].expect("the thing").place));
                assert!(distance < 1e-3, "{companions:?}");
                return;
            }
        }
        panic!("no exchange");
    }

    #[test]
    fn a_thing_that_stays_hidden_is_forgotten() {
        let mut companions = Companions::default();
        companions.measure(BOAT, &[buoy((20.0, 0.0))], SIZE, FRAME_S, |_| true);
        companions.predict(SIZE, MAX_HIDDEN_S - 0.1);
        assert!(companions.things[0].is_some());
        companions.predict(SIZE, 0.2);
        assert!(companions.things[0].is_none());
    }

    /// The place of what is found after a boat turned back at a buoy, with the chroma of what is followed then, and with what is seen
    /// beside it.
    fn after_turning_back(followed: Chroma, beside: &[Seen]) -> Option<(f32, f32)> {
        let mut companions = Companions::default();
        for frame in 0_u8..90 {
            // The boat comes from 30 to 9 px, touches the buoy for half a second, and goes back.
            let (chroma, others) = match frame {
                0..=44 => (BOAT, vec![buoy((30.0 - 0.48 * f32::from(frame), 1.0))]),
                45..=59 => (BOAT, Vec::new()),
                _ => (followed, beside.to_vec()),
            };
            companions.predict(SIZE, FRAME_S);
            if let Some(index) = companions.measure(chroma, &others, SIZE, FRAME_S, |_| true) {
                return Some(others[index].place);
            }
        }
        None
    }

    #[test]
    fn after_a_contact_the_chroma_tells_the_target() {
        let place = (12.0, 1.0);
        assert_eq!(after_turning_back(BOAT, &[Seen { place, chroma: BUOY }]), None);
        assert_eq!(after_turning_back(BUOY, &[Seen { place, chroma: BOAT }]), Some(place));
    }

    #[test]
    fn what_comes_from_elsewhere_after_a_contact_is_not_the_target() {
        let far = Seen { place: (26.0, 1.0), chroma: BOAT };
        assert_eq!(after_turning_back(BUOY, &[far]), None);
        let near = Seen { place: (-12.0, 1.0), chroma: BOAT };
        assert_eq!(after_turning_back(BUOY, &[far, near]), Some(near.place));
    }
}
