//! The bytes of every command.

use barrelman_vocab::AngularRate;
use barrelman_wire::Framing;
use barrelman_wire::fotokite_pro::Command;
use barrelman_wire::fotokite_pro::command::Stream;

use crate::transcript::{fixture, meaningful, rate, unescaped};

fn commands_named(text: &str) -> Vec<Command> {
    let words: Vec<&str> = text.split(' ').collect();
    match words[..] {
        ["yaw", r] => vec![Command::Yaw(rate(r))],
        ["gimbal-pitch", r] => vec![Command::GimbalPitch(rate(r))],
        ["gimbal", _, _] => vec![Command::GimbalRest],
        ["stop"] => vec![Command::Stop],
        ["carriage-returns"] => vec![Command::PromptRequest; 5],
        ["remote-control-start"] => vec![Command::RemoteControlStart],
        ["checksums-off"] => vec![Command::ChecksumsOff],
        ["telemetry-rate", per_second] => {
            vec![Command::TelemetryRate(per_second.parse().expect("a rate per second"))]
        }
        ["debug-text-off"] => vec![Command::DebugTextOff],
        ["commit-parameters"] => vec![Command::CommitParameter],
        ["get", "ground-status"] => vec![Command::Stream(Stream::GroundStatus)],
        ["get", "attitude"] => vec![Command::Stream(Stream::Attitude)],
        ["get", "position"] => vec![Command::Stream(Stream::Position)],
        ["get", "flight-status"] => vec![Command::Stream(Stream::FlightStatus)],
        ["get", "gimbal"] => vec![Command::Stream(Stream::Gimbal)],
        _ => panic!("unknown command {text:?}"),
    }
}

#[test]
fn every_command_has_the_bytes_of_the_transcript() {
    let text = fixture("commands.txt");
    let mut framing = None;
    let mut compared = 0;
    for line in meaningful(&text) {
        if let Some(name) = line.strip_prefix("framing ") {
            framing = Some(match name {
                "cr-around" => Framing::CarriageReturns,
                "lf" => Framing::LineFeed,
                other => panic!("unknown framing {other:?}"),
            });
        } else if let Some((command, bytes)) = line.split_once(" -> ") {
            let mut sent = Vec::new();
            for command in commands_named(command) {
                command.encode(framing.expect("a framing is named first"), &mut sent);
            }
            assert_eq!(String::from_utf8_lossy(&sent), String::from_utf8_lossy(&unescaped(bytes)), "{line}");
            compared += 1;
        }
    }
    assert!(compared > 60, "only {compared} commands compared");
}

#[test]
fn no_command_begins_with_a_word_that_moves_the_kite() {
    let text = fixture("commands.txt");
    let never: Vec<&str> = meaningful(&text).filter_map(|line| line.strip_prefix("never ")).collect();
    assert!(never.contains(&"StartTakeoff") && never.contains(&"MotorStop") && never.contains(&"Pos"));
    let rate = AngularRate::from_radians_per_second(0.1);
    // A match without a wildcard: a new command must be added here.
    let every = |command: Command| match command {
        Command::PromptRequest
        | Command::Stop
        | Command::RemoteControlStart
        | Command::ChecksumsOff
        | Command::TelemetryRate(_)
        | Command::DebugTextOff
        | Command::CommitParameter
        | Command::Stream(_)
        | Command::Yaw(_)
        | Command::GimbalPitch(_)
        | Command::GimbalRest => command.to_string(),
    };
    let all = [
        Command::PromptRequest,
        Command::Stop,
        Command::RemoteControlStart,
        Command::ChecksumsOff,
        Command::TelemetryRate(10.0),
        Command::DebugTextOff,
        Command::CommitParameter,
        Command::Stream(Stream::GroundStatus),
        Command::Stream(Stream::Attitude),
        Command::Stream(Stream::Position),
        Command::Stream(Stream::FlightStatus),
        Command::Stream(Stream::Gimbal),
        Command::Yaw(rate),
        Command::GimbalPitch(rate),
        Command::GimbalRest,
    ];
    for command in all {
        let text = every(command);
        let first = text.split(' ').next().unwrap_or_default();
        assert!(!never.contains(&first), "{text}");
    }
}
