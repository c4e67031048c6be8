//! Objects beside a target that pass it, touch it and go.

use super::*;

const FRAME_S: f32 = 1.0 / 30.0;
const SIZE: f32 = 10.0;
const BOAT: Chroma = (-4.0, 20.0);
const BUOY: Chroma = (-12.0, 18.0);

fn buoy(place: (f32, f32)) -> Seen {
    Seen { place, chroma: BUOY }
}

/// What is found when an object, at first 20 px to the right of the target, comes nearer with 10 px a
/// second, is not visible within 9 px, and from then on is seen where `shown` puts it.
fn after_passing(shown: impl Fn(f32) -> f32) -> Option<(f32, f32)> {
    after_passing_at(1.0, |(right, down)| (shown(right), down))
}

/// The same with an object that passes `down` pixels below the target.
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
fn an_object_that_was_passed_is_on_the_other_side() {
    assert_eq!(after_passing(|right| right), None, "it is where it is expected");
    let (right, _) = after_passing(|right| -right).expect("what is followed is the object");
    assert!((9.0..13.0).contains(&right), "{right}");
}

/// Whether target and buoy are in doubt, this long after the buoy, of this chroma at first, came into
/// contact with the target; it is not seen again before `apart_s` after that.
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
    let opposite = |chroma| after_passing_seen(1.0, |(right, down)| Seen { place: (-right, -down), chroma });
    assert!(opposite(BUOY).is_some());
    assert_eq!(opposite((-1.0, 3.0)), None);
}

#[test]
fn an_object_that_went_out_of_view_at_a_distance_tells_nothing() {
    let opposite = |(right, down): (f32, f32)| (-right, -down);
    assert!(after_passing_at(5.0, opposite).is_some());
    assert_eq!(after_passing_at(18.0, opposite), None);
}

#[test]
fn an_object_that_was_there_before_is_not_the_target() {
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
fn after_an_exchange_the_object_is_where_the_track_was() {
    let mut companions = Companions::default();
    for frame in 0_u8..150 {
        let right = 20.0 - 10.0 * f32::from(frame) * FRAME_S;
        companions.predict(SIZE, FRAME_S);
        let others = [buoy((right.abs(), 1.0))];
        let visible = if right.abs() > 9.0 { &others[..] } else { &[] };
        if companions.measure(BUOY, visible, SIZE, FRAME_S, |_| true).is_some() {
            companions.exchange(others[0].place, SIZE);
            let distance = length(sum(others[0].place, companions.objects[0].expect("the object").place));
            assert!(distance < 1e-3, "{companions:?}");
            return;
        }
    }
    panic!("no exchange");
}

#[test]
fn an_object_that_stays_hidden_is_forgotten() {
    let mut companions = Companions::default();
    companions.measure(BOAT, &[buoy((20.0, 0.0))], SIZE, FRAME_S, |_| true);
    companions.predict(SIZE, companions.settings.max_hidden_s - 0.1);
    assert!(companions.objects[0].is_some());
    companions.predict(SIZE, 0.2);
    assert!(companions.objects[0].is_none());
}

/// The place of what is found after a boat turned back at a buoy, with the chroma of what is followed
/// then, and with what is seen beside it.
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
