use super::*;

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

fn pages(roles: &[(&str, Role)]) -> Seats {
    let mut seats = Seats::default();
    for (name, role) in roles {
        seats.join(name, *role, at(0));
    }
    seats
}

#[test]
fn the_first_page_that_may_control_takes_the_seat() {
    let seats = pages(&[("w", Role::Watch), ("a", Role::Control), ("b", Role::Control)]);
    assert!(!seats.controls(0) && seats.controls(1) && !seats.controls(2));
}

#[test]
fn a_watcher_never_controls() {
    let mut seats = pages(&[("a", Role::Control), ("w", Role::Watch)]);
    assert!(seats.take(1).is_err() && seats.ask(1).is_err() && seats.give(0, 1).is_err());
    assert!(seats.controls(0));
}

#[test]
fn control_is_asked_for_given_and_taken() {
    let mut seats = pages(&[("a", Role::Control), ("b", Role::Control)]);
    assert_eq!(seats.ask(1), Ok(()));
    assert_eq!(seats.state().asking, [1]);
    assert!(seats.give(1, 1).is_err(), "who asks does not give");
    assert_eq!(seats.give(0, 1), Ok(()));
    assert!(seats.controls(1) && seats.state().asking.is_empty());
    assert!(seats.give(1, 7).is_err());
    assert_eq!(seats.take(0), Ok(()));
    assert!(seats.controls(0) && !seats.controls(1));
}

#[test]
fn a_boat_is_not_left_while_its_control_is_given() {
    let mut seats = pages(&[("a", Role::Control), ("b", Role::Control)]);
    // A page that only looks on is heard once a second.
    seats.hear(1, at(1000));
    seats.hear(0, at(1900));
    assert_eq!(seats.give(0, 1), Ok(()));
    let watched_until = seats.vessel_watched_until();
    assert!(watched_until >= Some(at(2700)), "the new page has not learned of its boat yet");
    assert!(watched_until < Some(at(2900)), "nor does it stay silent for longer than another");
}

#[test]
fn a_reload_keeps_the_seat_and_a_lost_page_frees_it() {
    let mut seats = pages(&[("a", Role::Control), ("b", Role::Control)]);
    seats.leave(0, at(1000));
    assert!(!seats.controls(0) && !seats.is_empty() && !seats.expire(at(2500)));
    let id = seats.join("a", Role::Control, at(2600)).id;
    assert!(seats.controls(id));
    seats.leave(id, at(3000));
    assert!(seats.expire(at(5001)) && seats.is_empty() && !seats.expire(at(5002)));
    assert_eq!(seats.ask(1), Ok(()), "an empty seat is free");
    assert!(seats.controls(1));
}

#[test]
fn with_too_many_pages_the_idlest_watcher_goes() {
    let mut seats = Seats::default();
    for number in 0..MAX_CLIENTS as u64 {
        seats.join(&number.to_string(), Role::Control, at(number));
    }
    seats.hear(1, at(900));
    assert_eq!(seats.join("new", Role::Watch, at(1000)).dropped, Some(2));
    assert!(seats.controls(0), "the page in control stays, though it was silent longer");
}

/// What happens to the seats. Pages are numbered in the order in which they join, from 0.
#[derive(Debug, Clone, Copy)]
enum Act {
    /// A page with this name that may control joins.
    Join(&'static str),
    /// A page that may only watch joins.
    Watch(&'static str),
    Leave(ClientId),
    Take(ClientId),
    Ask(ClientId),
    Give(ClientId, ClientId),
    /// The seats of lost pages are looked at.
    Expire,
}

use Act::{Ask, Expire, Give, Join, Leave, Take, Watch};

const GRACE_MS: u64 = 2000;

/// Who controls after these acts and their times in milliseconds, and who asks; `refused` after each refused
/// act.
fn seated(acts: &[(u64, Act)]) -> String {
    let mut seats = Seats::default();
    let mut text = String::new();
    for (ms, act) in acts {
        let now = at(*ms);
        let mut result = Ok(());
        match *act {
            Join(name) => _ = seats.join(name, Role::Control, now),
            Watch(name) => _ = seats.join(name, Role::Watch, now),
            Leave(id) => seats.leave(id, now),
            Take(id) => result = seats.take(id),
            Ask(id) => result = seats.ask(id),
            Give(from, to) => result = seats.give(from, to),
            Expire => _ = seats.expire(now),
        }
        text += if result.is_ok() { "" } else { "refused; " };
    }
    let ControlSeat { holder, holder_connected, clients, asking, .. } = seats.state();
    assert!(clients.is_sorted() && asking.iter().all(|id| clients.contains(id)), "{clients:?} {asking:?}");
    assert_eq!(seats.is_empty(), holder.is_none());
    for id in 0..10 {
        assert_eq!(seats.controls(id), holder == Some(id) && holder_connected, "page {id}");
    }
    text += &match (holder, holder_connected) {
        (None, _) => "nobody".to_owned(),
        (Some(id), true) => format!("page {id}"),
        (Some(id), false) => format!("page {id}, lost"),
    };
    if !asking.is_empty() {
        text += &format!(", asked by {asking:?}");
    }
    text
}

#[track_caller]
fn check(acts: &[(u64, Act)], expected: &str) {
    assert_eq!(seated(acts), expected, "{acts:?}");
}

#[test]
fn an_empty_seat_is_taken_by_joining_asking_or_taking() {
    check(&[], "nobody");
    check(&[(0, Watch("w"))], "nobody");
    check(&[(0, Join("a"))], "page 0");
    check(&[(0, Join(""))], "page 0");
    let emptied = [(0, Join("a")), (0, Join("b")), (0, Watch("w")), (10, Leave(0)), (5000, Expire)];
    let then = |act| [&emptied[..], &[(5000, act)]].concat();
    check(&emptied, "nobody");
    check(&then(Join("c")), "page 3");
    check(&then(Join("a")), "page 3");
    check(&then(Ask(1)), "page 1");
    check(&then(Take(1)), "page 1");
    check(&then(Watch("v")), "nobody");
    check(&then(Ask(2)), "refused; nobody");
    check(&then(Take(2)), "refused; nobody");
    check(&then(Give(1, 1)), "refused; nobody");
    check(&then(Leave(1)), "nobody");
    check(&then(Expire), "nobody");
}

#[test]
fn a_taken_seat_changes_by_taking_and_giving_only() {
    let taken = [(0, Join("a")), (0, Join("b")), (0, Watch("w"))];
    let then = |acts: &[Act]| {
        let acts: Vec<_> = acts.iter().map(|act| (2900, *act)).collect();
        [&taken[..], &acts].concat()
    };
    check(&taken, "page 0");
    check(&then(&[Join("c")]), "page 0");
    check(&then(&[Expire]), "page 0");
    check(&then(&[Leave(1)]), "page 0");
    check(&then(&[Ask(1)]), "page 0, asked by [1]");
    check(&then(&[Ask(1), Ask(1)]), "page 0, asked by [1]");
    check(&then(&[Ask(0)]), "page 0");
    check(&then(&[Take(0)]), "page 0");
    check(&then(&[Take(1)]), "page 1");
    check(&then(&[Take(2)]), "refused; page 0");
    check(&then(&[Give(0, 1)]), "page 1");
    check(&then(&[Give(0, 0)]), "page 0");
    check(&then(&[Give(0, 2)]), "refused; page 0");
    check(&then(&[Give(0, 9)]), "refused; page 0");
    check(&then(&[Give(1, 1)]), "refused; page 0");
    check(&then(&[Give(0, 1), Give(0, 0)]), "refused; page 1");
    check(&then(&[Take(9)]), "refused; page 0");
    check(&then(&[Ask(9)]), "refused; page 0");
}

#[test]
fn a_page_asks_until_it_controls_or_leaves() {
    let asked = [(0, Join("a")), (0, Join("b")), (0, Join("c")), (1, Ask(1)), (1, Ask(2))];
    let then = |act| [&asked[..], &[(2, act)]].concat();
    check(&asked, "page 0, asked by [1, 2]");
    check(&then(Give(0, 2)), "page 2, asked by [1]");
    check(&then(Take(1)), "page 1, asked by [2]");
    check(&then(Leave(1)), "page 0, asked by [2]");
    check(&then(Join("b")), "page 0, asked by [1, 2]");
    check(&then(Take(0)), "page 0, asked by [1, 2]");
}

#[test]
fn the_seat_of_a_lost_page_is_kept_for_its_return() {
    let lost = [(0, Join("a")), (0, Join("b")), (1000, Leave(0))];
    let then = |acts: &[(u64, Act)]| [&lost[..], acts].concat();
    check(&lost, "page 0, lost");
    check(&then(&[(1000 + GRACE_MS, Expire)]), "page 0, lost");
    check(&then(&[(1001 + GRACE_MS, Expire)]), "nobody");
    check(&then(&[(1500, Join("a"))]), "page 2");
    check(&then(&[(1500, Join("a")), (3000, Expire)]), "page 2");
    check(&then(&[(1500, Join("c"))]), "page 0, lost");
    check(&then(&[(1500, Join(""))]), "page 0, lost");
    check(&then(&[(1500, Watch("a"))]), "page 0, lost");
    check(&then(&[(1500, Take(1))]), "page 1");
    check(&then(&[(1500, Take(1)), (1600, Join("a"))]), "page 1");
    check(&then(&[(1500, Ask(1))]), "page 0, lost, asked by [1]");
    check(&then(&[(1500, Give(0, 1))]), "refused; page 0, lost");
    check(&then(&[(1500, Take(0))]), "refused; page 0, lost");
    check(&then(&[(1500, Join("a")), (1600, Leave(2)), (1500 + GRACE_MS, Expire)]), "page 2, lost");
}

#[test]
fn a_page_that_reloads_before_its_old_connection_ends_keeps_the_seat() {
    let reloaded = [(0, Join("a")), (10, Join("a"))];
    check(&reloaded, "page 1");
    check(&[&reloaded[..], &[(20, Leave(0)), (3000, Expire)]].concat(), "page 1");
    check(&[&reloaded[..], &[(20, Leave(1))]].concat(), "page 1, lost");
}

#[test]
fn a_full_house_drops_the_page_that_was_silent_longest() {
    /// The pages joined at 0, 1, 2, ... ms; page 0 controls. Then a page joins, and this one goes.
    #[track_caller]
    fn check(heard: &[(ClientId, u64)], leaves: &[ClientId], expected: Option<ClientId>) {
        let mut seats = Seats::default();
        for id in 0..MAX_CLIENTS as u64 {
            seats.join(&format!("{id}"), Role::Control, at(id));
        }
        for (id, ms) in heard {
            seats.hear(*id, at(*ms));
        }
        for id in leaves {
            seats.leave(*id, at(500));
        }
        let joined = seats.join("new", Role::Watch, at(1000));
        assert_eq!(joined.dropped, expected, "heard {heard:?}, left {leaves:?}");
        let clients = seats.state().clients;
        assert!(clients.len() <= MAX_CLIENTS && clients.contains(&joined.id));
        assert!(expected.is_none_or(|dropped| !clients.contains(&dropped)));
    }
    check(&[], &[], Some(1));
    check(&[(1, 900)], &[], Some(2));
    check(&[(1, 900), (2, 901), (3, 902)], &[], Some(4));
    check(&[(0, 999)], &[], Some(1));
    check(&[(99, 999)], &[], Some(1));
    check(&[], &[5], None);
    check(&[], &[0], None);
}

#[test]
fn a_dropped_page_can_neither_ask_nor_take() {
    let mut seats = Seats::default();
    for _ in 0..=MAX_CLIENTS {
        seats.join("", Role::Control, at(0));
    }
    let dropped = (0..).find(|id| !seats.state().clients.contains(id)).unwrap();
    assert!(seats.ask(dropped).is_err() && seats.take(dropped).is_err() && seats.give(0, dropped).is_err());
    seats.leave(dropped, at(1));
    assert!(seats.controls(0), "its connection ends without an effect");
}

#[test]
fn a_silent_page_loses_the_seat_and_a_page_that_asks_gets_it() {
    let mut seats = Seats::default();
    let (a, b) = (seats.join("a", Role::Control, at(0)).id, seats.join("b", Role::Control, at(0)).id);
    seats.hear(a, at(1000));
    seats.hear(b, at(3500));
    assert!(!seats.expire(at(4000)) && seats.controls(a), "silent for three seconds");
    assert!(seats.expire(at(4001)) && seats.is_empty());
    assert_eq!(seats.take(a), Ok(()), "the page is still there, and can take the control");
    seats.hear(a, at(4100));
    assert_eq!(seats.ask(b), Ok(()));
    assert!(seats.expire(at(7101)) && seats.controls(b) && seats.state().asking.is_empty());
}

#[test]
fn a_page_that_hangs_before_it_is_lost_leaves_the_boat_when_it_was_silent_for_too_long() {
    let mut seats = Seats::default();
    let id = seats.join("page", Role::Control, at(0)).id;
    seats.hear(id, at(1_000));
    assert_eq!(seats.vessel_watched_until(), Some(at(1_900)));
    seats.leave(id, at(1_900));
    assert_eq!(seats.vessel_watched_until(), Some(at(1_900)), "not another 0.9 s from the loss");
    seats.join("page", Role::Control, at(2_000));
    assert_eq!(seats.vessel_watched_until(), Some(at(2_900)));
}

#[test]
fn a_program_that_makes_no_request_loses_the_seat() {
    let mut seats = pages(&[("a", Role::Control)]);
    let program = seats.join_program(at(0));
    assert_eq!(seats.join_program(at(10)), program, "programs are one client");
    assert_eq!(seats.take(program), Ok(()));
    assert!(
        seats.program_controls() && seats.vessel_watched_until().is_none(),
        "no page watches over the boat"
    );
    seats.hear(0, at(3000));
    seats.hear_program(at(2000));
    assert!(!seats.expire(at(5000)) && seats.program_controls());
    assert!(seats.expire(at(5001)) && seats.is_empty());
    assert_eq!(seats.program(), None);
}

#[test]
fn a_program_takes_no_place_of_a_page() {
    let mut seats = Seats::default();
    let program = seats.join_program(at(0));
    for number in 0..MAX_CLIENTS as u64 {
        assert_eq!(seats.join(&number.to_string(), Role::Watch, at(10 + number)).dropped, None);
    }
    assert_eq!(seats.join("new", Role::Watch, at(1000)).dropped, Some(program + 1));
    assert_eq!(seats.program(), Some(program));
}
