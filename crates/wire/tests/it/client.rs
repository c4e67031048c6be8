//! The client's end: start-up, pacing, shut-down, and the load of the line.

use core::time::Duration;

use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use barrelman_wire::fotokite_pro::pacing::Pacing;
use barrelman_wire::fotokite_pro::{Command, FotokiteProSession, SessionSettings};
use barrelman_wire::{Framing, LinkHistory, NextAction, Session as _};

use crate::transcript::{Case, Event, cases, words};

/// Permitted delay of a line, as stated in the transcripts' README.
const ROOM_MS: u64 = 5;

const UNANSWERED: NextAction = NextAction::Reopen { reason: "the ground station does not answer" };

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

fn settings(case: &Case) -> SessionSettings {
    let framing = if case.has("framing=lf") { Framing::LineFeed } else { Framing::CarriageReturns };
    let baud = case.value("baud").map_or(115_200, |baud| baud.parse().expect("a baud rate"));
    SessionSettings::for_baud(framing, baud)
}

/// The lines that were sent, each with its time, and the time at which the client asked to reopen the port.
#[derive(Default)]
struct Sent {
    lines: Vec<(u64, Vec<u8>)>,
    reopened_at: Option<u64>,
}

/// Runs a session through a case in steps of 1 ms, from `start` on.
fn run(session: &mut FotokiteProSession, case: &Case, start: u64) -> Sent {
    let mut sent = Sent::default();
    let end = case.events.last().expect("a case has events").0;
    let mut events = case.events.iter().peekable();
    for ms in 0..=end {
        let now = at(start + ms);
        let mut poll = |session: &mut FotokiteProSession| {
            let mut out = Vec::new();
            if session.poll(now, &mut out) == UNANSWERED {
                sent.reopened_at.get_or_insert(ms);
            }
            sent.lines.extend(out.into_iter().map(|packet| (ms, packet)));
        };
        while let Some((_, event)) = events.next_if(|(time, _)| *time == ms) {
            match event {
                Event::StationSends(bytes) => session.received(bytes, now, &mut |_| {}),
                Event::Asked(rates) => session.request(*rates, None),
                Event::AskedToEnd => session.close(now),
                Event::ClientSends(_) | Event::Reopens | Event::Holds(_) | Event::Ends => continue,
            }
            poll(session);
        }
        poll(session);
    }
    sent
}

/// The bytes that a case expects from the client at each time.
fn expected_bytes(case: &Case) -> Vec<(u64, Vec<u8>)> {
    let mut expected: Vec<(u64, Vec<u8>)> = Vec::new();
    for (time, event) in &case.events {
        if let Event::ClientSends(bytes) = event {
            match expected.last_mut() {
                Some((last, together)) if last == time => together.extend_from_slice(bytes),
                _ => expected.push((*time, bytes.clone())),
            }
        }
    }
    expected
}

#[test]
fn the_start_up_sequence_leaves_byte_for_byte_with_its_waits() {
    for name in ["startup-115200.txt", "startup-9600.txt"] {
        for case in cases(name) {
            let mut session = FotokiteProSession::open(settings(&case), at(0));
            let sent = run(&mut session, &case, 0);
            // Other transcripts cover the rates, which are sent after the start-up.
            let start_up: Vec<_> = sent
                .lines
                .into_iter()
                .map(|(ms, bytes)| (ms, without_zeros(&bytes, settings(&case).framing)))
                .filter(|(_, bytes)| !bytes.is_empty())
                .collect();
            let expected = expected_bytes(&case);
            let texts = |lines: &[(u64, Vec<u8>)]| -> Vec<String> {
                lines
                    .iter()
                    .map(|(_, bytes)| String::from_utf8_lossy(bytes).escape_debug().to_string())
                    .collect()
            };
            assert_eq!(texts(&start_up), texts(&expected), "{name}, {}", case.name);
            for ((ms, bytes), (due, _)) in start_up.iter().zip(&expected) {
                let text = String::from_utf8_lossy(bytes);
                assert!((*due..=due + ROOM_MS).contains(ms), "{}: {text:?} at {ms}, not {due} ms", case.name);
            }
            let reopens = case.events.iter().find(|(_, event)| *event == Event::Reopens).map(|(ms, _)| *ms);
            assert_eq!(sent.reopened_at, reopens, "{}", case.name);
        }
    }
}

/// A packet without its lines that rest an axis.
fn without_zeros(packet: &[u8], framing: Framing) -> Vec<u8> {
    let zeros =
        [Command::GimbalRest, Command::GimbalPitch(AngularRate::ZERO), Command::Yaw(AngularRate::ZERO)];
    zeros.iter().fold(packet.to_vec(), |mut rest, command| {
        let mut line = Vec::new();
        command.encode(framing, &mut line);
        while let Some(at) = rest.windows(line.len()).position(|window| window == line) {
            rest.drain(at..at + line.len());
        }
        rest
    })
}

fn is_zero_of(axis: &str, line: &str) -> bool {
    line.strip_prefix(axis) == Some(" 0.000000")
}

/// Compares lines with those of a case. Additional zeros for an axis at rest are permitted, unless the case
/// is `exact`.
fn compare(case: &Case, sent: &[(u64, String)]) {
    let mut expected = case
        .events
        .iter()
        .filter_map(|(time, event)| match event {
            Event::ClientSends(bytes) => Some((*time, words(bytes).join(" | "))),
            _ => None,
        })
        .peekable();
    let mut moving = [("Yaw", false), ("GimbalPitch", false)];
    for (ms, line) in sent {
        let matches =
            expected.peek().is_some_and(|(due, text)| text == line && (*due..=due + ROOM_MS).contains(ms));
        if matches {
            expected.next();
        } else {
            let spare =
                moving.iter().any(|(axis, moves)| !moves && is_zero_of(axis, line)) && !case.has("exact");
            assert!(spare, "{}: {line:?} at {ms} ms; expected {:?}", case.name, expected.peek());
        }
        for (axis, moves) in &mut moving {
            if line.starts_with(&format!("{axis} ")) {
                *moves = !is_zero_of(axis, line);
            }
        }
    }
    assert_eq!(expected.next(), None, "{}: never sent", case.name);
}

#[test]
fn rates_asked_for_leave_as_the_transcript_says() {
    for case in cases("pacing.txt") {
        let mut pacing = Pacing::default();
        let mut sent: Vec<(u64, String)> = Vec::new();
        let end = case.events.last().expect("a case has events").0;
        let mut events = case.events.iter().peekable();
        for ms in 0..=end {
            while let Some((_, event)) = events.next_if(|(time, _)| *time == ms) {
                if let Event::Asked(rates) = event {
                    pacing.set_rates(*rates);
                }
            }
            let before = sent.len();
            if pacing.wake_at() <= at(ms) {
                pacing.poll(at(ms), |command| sent.push((ms, command.to_string())));
                assert!(sent.len() > before, "{}: woken at {ms} ms for nothing", case.name);
            } else {
                pacing.poll(at(ms), |command| sent.push((ms, command.to_string())));
                assert_eq!(
                    sent.len(),
                    before,
                    "{}: {:?} before it asked to be woken",
                    case.name,
                    sent.last()
                );
            }
        }
        compare(&case, &sent);
    }
}

/// Opens a session, answers its start-up, and returns the running session with the current time.
fn settled(settings: SessionSettings) -> (FotokiteProSession, u64) {
    let mut session = FotokiteProSession::open(settings, at(0));
    let mut out = Vec::new();
    for ms in 0..10_000 {
        if ms == 620 {
            session.received(b"\r\nnsh> ", at(ms), &mut |_| {});
        }
        session.poll(at(ms), &mut out);
    }
    assert_eq!(session.link_state(), LinkState::Up);
    (session, 10_000)
}

#[test]
fn the_shut_down_leaves_as_the_transcript_says() {
    for case in cases("shutdown.txt") {
        let (mut session, start) = settled(settings(&case));
        let sent = run(&mut session, &case, start);
        let lines: Vec<(u64, String)> = sent
            .lines
            .iter()
            .flat_map(|(ms, bytes)| words(bytes).into_iter().map(|line| (*ms, line)))
            .collect();
        compare(&case, &lines);
        assert_eq!(session.link_state(), LinkState::Closed, "{}", case.name);
    }
}

#[test]
fn what_was_asked_for_during_the_start_up_moves_only_after_zeros() {
    let mut session = FotokiteProSession::open(SessionSettings::for_baud(Framing::LineFeed, 115_200), at(0));
    let mut lines = Vec::new();
    for ms in 0..4_000 {
        match ms {
            620 => session.received(b"nsh> ", at(ms), &mut |_| {}),
            700 => session.request(
                VehicleRates::turning(AngularRate::from_radians_per_second(0.3), AngularRate::ZERO),
                None,
            ),
            _ => {}
        }
        let mut out = Vec::new();
        session.poll(at(ms), &mut out);
        lines.extend(out.iter().flat_map(|packet| words(packet)));
    }
    let rates: Vec<&String> =
        lines.iter().filter(|line| line.starts_with(['Y', 'G']) && !line.starts_with("Get")).collect();
    let (opening, up) =
        rates.split_at(rates.iter().position(|line| line.starts_with("GimbalPitch")).unwrap_or(0));
    assert!(opening.iter().all(|line| line.ends_with(" 0.000000") || line.ends_with(" 0.000000,0.000000")));
    assert_eq!(up[..3], ["GimbalPitch 0.000000", "Yaw 0.000000", "Yaw 0.300000"], "{lines:?}");
}

/// The lines that a session sends in this time, and their times.
fn lines_between(session: &mut FotokiteProSession, from: u64, to: u64) -> Vec<(u64, String)> {
    let mut lines = Vec::new();
    for ms in from..to {
        let mut out = Vec::new();
        session.poll(at(ms), &mut out);
        lines.extend(out.iter().flat_map(|packet| words(packet)).map(|line| (ms, line)));
    }
    lines
}

#[test]
fn the_first_bytes_of_a_session_are_zeros_three_times() {
    let mut session = FotokiteProSession::open(SessionSettings::for_baud(Framing::LineFeed, 115_200), at(0));
    let lines = lines_between(&mut session, 0, 300);
    let zeros = |ms| [(ms, "Gimbal 0.000000,0.000000".to_owned()), (ms, "Yaw 0.000000".to_owned())];
    let stop = [(100, "stop".to_owned())];
    assert_eq!(lines, [&zeros(0)[..], &zeros(50), &zeros(100), &stop].concat());
}

#[test]
fn control_that_another_client_took_comes_back_by_request_only() {
    let (mut session, start) = settled(SessionSettings::for_baud(Framing::LineFeed, 115_200));
    let moving = VehicleRates::turning(AngularRate::from_radians_per_second(0.3), AngularRate::ZERO);
    session.received(b"!GSStatus 0,1.0,11.8,0\r\n", at(start), &mut |_| {});
    session.request(moving, None);
    assert_eq!(
        lines_between(&mut session, start, start + 1_000),
        [],
        "nothing is sent to another client's vehicle"
    );
    assert_eq!(session.link_state(), LinkState::Up);
    session.take_control(at(start + 1_000));
    let lines = lines_between(&mut session, start + 1_000, start + 1_200);
    assert_eq!(lines.first().map(|(_, line)| line.as_str()), Some("Gimbal 0.000000,0.000000"));
    assert_eq!(lines.last().map(|(_, line)| line.as_str()), Some("stop"));
}

#[test]
fn control_that_another_client_took_stays_its_own_over_a_reopened_port_and_at_the_end() {
    let settings = SessionSettings::for_baud(Framing::LineFeed, 115_200);
    let (mut session, start) = settled(settings);
    assert!(!session.is_anothers());
    session.received(b"!GSStatus 0,1.0,11.8,0\r\n", at(start), &mut |_| {});
    assert!(session.is_anothers() && session.last_will(at(start)).is_empty());

    let history = LinkHistory { is_anothers: true, ..LinkHistory::default() };
    let open = || {
        let mut next = FotokiteProSession::open(settings, at(0));
        next.resume(history);
        next
    };
    let mut next = open();
    assert_eq!((next.link_state(), next.is_anothers()), (LinkState::Starting, true));
    assert_eq!(lines_between(&mut next, 0, 5_000), []);
    next.received(b"!GSStatus 0,6.0,11.8,0\r\n", at(5_000), &mut |_| {});
    assert_eq!((next.link_state(), next.is_anothers()), (LinkState::Up, true));
    next.take_control(at(5_000));
    let lines = lines_between(&mut next, 5_000, 5_200);
    assert_eq!(lines.first().map(|(_, line)| line.as_str()), Some("Gimbal 0.000000,0.000000"));
    assert!(!next.is_anothers() && !next.last_will(at(5_200)).is_empty());

    // A station that gives the control back has not been started by this session: the start-up is made first.
    let mut given = open();
    given.received(b"!GSStatus 10,1.0,11.8,0\r\n", at(0), &mut |_| {});
    let lines = lines_between(&mut given, 0, 300);
    assert_eq!(lines.last().map(|(_, line)| line.as_str()), Some("stop"));

    for mut session in [session, open()] {
        session.close(at(start));
        let mut out = Vec::new();
        assert_eq!((session.poll(at(start), &mut out), out.len()), (NextAction::Closed, 0));
    }
}

#[test]
fn control_that_is_given_back_begins_with_zeros() {
    let (mut session, start) = settled(SessionSettings::for_baud(Framing::LineFeed, 115_200));
    session.received(b"!GSStatus 0,1.0,11.8,0\r\n", at(start), &mut |_| {});
    session.received(b"!GSStatus 10,1.1,11.8,0\r\n", at(start + 100), &mut |_| {});
    let lines = lines_between(&mut session, start + 100, start + 110);
    assert_eq!(
        lines,
        [(start + 100, "GimbalPitch 0.000000".to_owned()), (start + 100, "Yaw 0.000000".to_owned())]
    );
}

/// Ends a session whose telemetry, at 10 Hz, shows a yaw of this rate until a time after the request, and a
/// camera at rest then. Returns the number of zeros on yaw, and when `stop` was sent after the request.
fn shut_down_with_yaw(rate: f64, until_ms: u64) -> (usize, u64) {
    let (mut session, start) = settled(SessionSettings::for_baud(Framing::LineFeed, 115_200));
    let mut lines = Vec::new();
    for ms in 0..6_000 {
        if ms % 100 == 7 {
            let yaw: f64 = rate * ms.min(until_ms + 1_000) as f64 / 1000.0;
            let (w, z) = ((yaw / 2.0).cos(), (yaw / 2.0).sin());
            let text = format!("!Attitude {w:.6},0,0,{z:.6}\r\n!Gimbal 1,0,0,0\r\n");
            session.received(text.as_bytes(), at(start + ms), &mut |_| {});
        }
        if ms == 1_000 {
            session.close(at(start + ms));
        }
        let sent = lines_between(&mut session, start + ms, start + ms + 1);
        lines.extend(sent.into_iter().filter(|_| ms >= 1_000).map(|(_, line)| (ms - 1_000, line)));
        if session.link_state() == LinkState::Closed {
            break;
        }
    }
    let stop_at = lines.iter().find(|(_, line)| line == "stop").expect("it was stopped").0;
    (lines.iter().filter(|(_, line)| line.starts_with("Yaw")).count(), stop_at)
}

#[test]
fn zeros_are_repeated_until_telemetry_shows_no_motion() {
    assert_eq!(shut_down_with_yaw(0.0, 0), (3, 600), "a camera at rest: two reports after the first zeros");
    assert_eq!(shut_down_with_yaw(0.04, 6_000), (3, 600), "the sway of the flight unit");
    let (zeros, stop_at) = shut_down_with_yaw(0.3, 800);
    assert!(
        (9..=12).contains(&zeros) && (1_200..=1_600).contains(&stop_at),
        "{zeros} zeros, stop after {stop_at} ms"
    );
    let (zeros, stop_at) = shut_down_with_yaw(0.1, 60_000);
    // One of them in the half second before `stop`.
    assert!(zeros == 23 && (2_400..=2_700).contains(&stop_at), "{zeros} zeros, stop after {stop_at} ms");
    // Faster than any sway: the zeros do not arrive.
    let (zeros, stop_at) = shut_down_with_yaw(0.3, 3_500);
    assert!((32..=40).contains(&zeros) && stop_at > 3_500, "{zeros} zeros, stop after {stop_at} ms");
}

#[test]
fn telemetry_that_falls_silent_asks_for_the_port_to_be_opened_anew() {
    let (mut session, start) = settled(SessionSettings::for_baud(Framing::LineFeed, 115_200));
    session.received(b"!GSStatus 10,1.0,11.8,0\r\n", at(start), &mut |_| {});
    let mut out = Vec::new();
    assert!(matches!(session.poll(at(start + 2_900), &mut out), NextAction::WaitUntil(_)));
    assert_eq!(session.poll(at(start + 3_001), &mut out), UNANSWERED);
}

/// A serial line. It carries a tenth of its baud rate in bytes per second (8 data bits, start bit, stop bit).
struct Line {
    bytes_per_ms: f64,
    waiting_bytes: f64,
}

/// Load of a line with the highest rate of commands from a pilot: 30 per second for 10 s, with zeros every
/// second. Returns bytes per second and the longest waiting time in milliseconds.
fn worst_case(framing: Framing, baud: u32) -> (f64, f64) {
    let (mut session, start) = settled(SessionSettings::for_baud(framing, baud));
    let mut line = Line { bytes_per_ms: f64::from(baud) / 10.0 / 1000.0, waiting_bytes: 0.0 };
    let (mut total, mut longest_wait_ms) = (0.0, 0.0_f64);
    for ms in 0..10_000_u64 {
        let moving = ms % 1000 >= 200;
        if ms % 33 == 0 {
            let wobble = if moving { 0.1 + (ms % 7) as f64 * 0.01 } else { 0.0 };
            let rate = AngularRate::from_radians_per_second(-wobble);
            session.request(VehicleRates::turning(rate, rate), None);
        }
        let mut out = Vec::new();
        session.poll(at(start + ms), &mut out);
        let bytes = out.concat().len() as f64;
        line.waiting_bytes += bytes;
        total += bytes;
        longest_wait_ms = longest_wait_ms.max(line.waiting_bytes / line.bytes_per_ms);
        line.waiting_bytes = (line.waiting_bytes - line.bytes_per_ms).max(0.0);
    }
    (total / 10.0, longest_wait_ms)
}

#[test]
fn both_baud_rates_keep_up_with_the_worst_that_can_be_asked_for() {
    for framing in [Framing::CarriageReturns, Framing::LineFeed] {
        for baud in [9_600, 115_200] {
            let (bytes_per_second, wait_ms) = worst_case(framing, baud);
            let budget = f64::from(baud) / 10.0;
            assert!(
                bytes_per_second < 0.75 * budget,
                "{framing:?} {baud}: {bytes_per_second} of {budget} bytes/s"
            );
            // Two zeros that are sent together, after one line that was just sent: 72 bytes at 960 bytes/s.
            assert!(wait_ms < 80.0, "{framing:?} {baud}: a line waited {wait_ms:.1} ms");
        }
    }
}

#[test]
fn telemetry_at_9600_baud_is_asked_for_at_2_hz_and_fits() {
    let slow = SessionSettings::for_baud(Framing::CarriageReturns, 9_600);
    assert_eq!(slow.telemetry_per_second, 2.0);
    // Five telemetry lines of about 45 bytes, and occasionally a !Param.
    let bytes_per_second = slow.telemetry_per_second * (5.0 * 45.0 + 22.0);
    assert!(bytes_per_second < 960.0 * 0.75, "{bytes_per_second}");
    assert_eq!(SessionSettings::for_baud(Framing::CarriageReturns, 115_200).telemetry_per_second, 10.0);
    let never_early = Duration::from_millis(ROOM_MS);
    assert!(never_early < Duration::from_millis(50));
}

#[test]
fn the_last_will_stops_the_vehicle_from_any_state() {
    let (session, _) = settled(SessionSettings::for_baud(Framing::LineFeed, 115_200));
    let will: Vec<(Vec<String>, u128)> = session
        .last_will(Timestamp::ZERO)
        .iter()
        .map(|step| (words(&step.packet), step.pause.as_millis()))
        .collect();
    let zeros = || vec!["Gimbal 0.000000,0.000000".to_owned(), "Yaw 0.000000".to_owned()];
    let stop = vec!["stop".to_owned()];
    assert_eq!(will, [(zeros(), 50), (zeros(), 50), (zeros(), 550), (stop, 0)]);
}
