//! The ground station's end of the protocol.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::command::Stream;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, StationState};

use crate::transcript::{Case, Event, cases};

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

fn holds(station: &GroundStation, words: &[String]) -> bool {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let rates = station.rates();
    let is = |rate: barrelman_vocab::AngularRate, text: &str| {
        rate.radians_per_second() == text.parse::<f64>().expect("a rate")
    };
    match words[..] {
        ["state", "idle"] => station.state() == StationState::Shell,
        ["state", "remote-controlled"] => station.state() == StationState::RemoteControlled,
        ["yaw", rate] => is(rates.yaw, rate),
        ["gimbal-pitch", rate] => is(rates.pitch, rate),
        ["gimbal-roll", rate] => is(rates.roll, rate),
        ["stream", name, per_second] => {
            let stream = match name {
                "GSStatus" => Stream::GroundStatus,
                "Attitude" => Stream::Attitude,
                "Pos" => Stream::Position,
                "FlightStatus" => Stream::FlightStatus,
                "Gimbal" => Stream::Gimbal,
                other => panic!("unknown stream {other:?}"),
            };
            station.stream_per_second(stream) == per_second.parse().ok()
        }
        _ => panic!("unknown condition {words:?}"),
    }
}

fn run(file: &str, case: &Case) {
    let rate_timeout = case.value("rate-time-out").map(|ms| Duration::from_millis(ms.parse().expect("ms")));
    let settings = GroundStationSettings { rate_timeout, ..GroundStationSettings::default() };
    let mut station = GroundStation::boot(settings, at(0));
    let (mut expected, mut answered) = (Vec::new(), Vec::new());
    let settle = |expected: &mut Vec<u8>, answered: &mut Vec<u8>, ms: u64| {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).escape_debug().to_string();
        assert_eq!(text(answered), text(expected), "{file}, {}, before {ms} ms", case.name);
        expected.clear();
        answered.clear();
    };
    for (ms, event) in &case.events {
        station.tick(at(*ms));
        match event {
            Event::ClientSends(bytes) => {
                settle(&mut expected, &mut answered, *ms);
                station.receive(bytes, at(*ms), &mut answered, |_| {});
            }
            Event::StationSends(bytes) => expected.extend_from_slice(bytes),
            Event::Holds(words) => {
                assert!(
                    holds(&station, words),
                    "{file}, {}: at {ms} ms not {words:?}: {station:?}",
                    case.name
                );
            }
            Event::Asked(_) | Event::AskedToEnd | Event::Reopens | Event::Ends => {}
        }
    }
    settle(&mut expected, &mut answered, u64::MAX);
}

#[test]
fn the_shell_and_remote_control_answer_as_the_transcript_says() {
    for case in cases("station-shell.txt") {
        run("station-shell.txt", &case);
    }
}

#[test]
fn the_start_up_gets_the_answers_of_the_transcript() {
    for name in ["startup-115200.txt", "startup-9600.txt"] {
        let cases = cases(name);
        let case = cases.iter().find(|case| case.name == "prompt-comes").expect("the case is there");
        run(name, case);
    }
}

#[test]
fn a_flood_of_lines_is_lost_beyond_a_hundred_a_second() {
    let mut station = GroundStation::boot(GroundStationSettings::default(), at(0));
    let mut out = Vec::new();
    for _ in 0..150 {
        station.receive(b"hello\r", at(10), &mut out, |_| {});
    }
    assert_eq!(station.dropped_lines(), 50);
    station.receive(b"RemoteControl start\r", at(1_010), &mut out, |_| {});
    assert_eq!(station.state(), StationState::RemoteControlled);
}
