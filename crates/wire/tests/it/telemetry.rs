//! The telemetry that a session reads from received bytes.

use barrelman_vocab::telemetry::{ControlState, FlightState, Report};
use barrelman_vocab::{Angle, Timestamp};
use barrelman_wire::fotokite_pro::{FotokiteProSession, SessionSettings};
use barrelman_wire::{Framing, Session as _};

use crate::transcript::{fixture, meaningful, unescaped};

const FLAGS: [&str; 13] = [
    "MISSED_TICK",
    "I2C_ERROR",
    "CRIT_LOW_BATT",
    "NO_SYNC_CMDS",
    "LOW_LAUNCH_ANGLE",
    "MOTOR_ERROR",
    "LOW_BATT",
    "LOW_BACKUP_BATT",
    "EMERGENCY_LAND",
    "NO_TETHER_DETECTED",
    "HARD_KILL",
    "OPTOFORCE_TEMP_INVALID",
    "FLYAWAY_CANDIDATE",
];

/// The report that a transcript's words describe; `None` for a prompt, which is not telemetry.
fn meaning(text: &str) -> Option<Report> {
    let mut words = text.split(' ');
    let kind = words.next().unwrap_or_default();
    let fields: Vec<(&str, &str)> = words.map(|word| word.split_once('=').expect("name=value")).collect();
    let field = |name: &str| fields.iter().find(|(found, _)| *found == name).expect("a field").1;
    let number = |name: &str| field(name).parse::<f64>().expect("a number");
    let quaternion = || barrelman_vocab::telemetry::Quaternion {
        w: number("w"),
        x: number("x"),
        y: number("y"),
        z: number("z"),
    };
    Some(match kind {
        "prompt" => return None,
        "ground-status" => Report::Ground {
            control: match field("mode") {
                "REMOTE_CONTROLLED" => ControlState::Ours,
                _ => ControlState::Elsewhere,
            },
            uptime_s: number("run_time_s"),
            battery_v: number("battery_v"),
            tether_m: number("tether_m"),
        },
        "attitude" => Report::VehicleAttitude(quaternion()),
        "gimbal" => Report::GimbalAttitude(quaternion()),
        "position" => Report::Tether {
            elevation: Angle::from_radians(number("elevation_rad")),
            azimuth: Angle::from_radians(number("azimuth_rad")),
            altitude_m: number("altitude_m"),
        },
        "flight-status" => Report::Flight {
            state: match field("mode") {
                "IDLE" => FlightState::Idle,
                "ANGLE" | "ANGLE_RATE" => FlightState::Flying,
                "MOTOR_LOW_LEVEL" => FlightState::Other(5),
                number if number.parse::<u32>().is_ok() => {
                    FlightState::Other(number.parse().expect("a mode number"))
                }
                _ => FlightState::Emergency,
            },
            on_time_s: number("on_time_s"),
            backup_battery_v: number("backup_battery_v"),
            warnings: flags(field("flags")),
            is_battery_low: ["_BATT", "BATTERY"]
                .iter()
                .any(|part| field("flags").contains(part) || field("mode").contains(part)),
        },
        other => panic!("unknown meaning {other:?}"),
    })
}

fn flags(text: &str) -> u32 {
    let bit = |name: &str| match name.strip_prefix("bit") {
        Some(number) => number.parse().expect("a bit number"),
        None => FLAGS.iter().position(|flag| *flag == name).expect("a known flag"),
    };
    if text == "none" { 0 } else { text.split('+').map(|name| 1_u32 << bit(name)).sum() }
}

fn same(heard: &Report, expected: &Report) -> bool {
    match (heard, expected) {
        (
            Report::Ground { tether_m, control, uptime_s, battery_v },
            Report::Ground { tether_m: other_m, control: c, uptime_s: u, battery_v: b },
        ) => (tether_m - other_m).abs() < 1e-9 && (control, uptime_s, battery_v) == (c, u, b),
        _ => heard == expected,
    }
}

#[test]
fn received_bytes_mean_what_the_transcript_says() {
    let text = fixture("telemetry.txt");
    let mut compared = 0;
    for line in meaningful(&text) {
        let (reads, expected) = line.rsplit_once(" -> ").expect("READS -> MEANING");
        let mut session =
            FotokiteProSession::open(SessionSettings::for_baud(Framing::LineFeed, 115_200), Timestamp::ZERO);
        let mut heard = Vec::new();
        for read in reads.split(" | ") {
            session
                .received(&unescaped(read), Timestamp::ZERO, &mut |telemetry| heard.push(telemetry.report));
        }
        let expected: Vec<Report> = match expected {
            "nothing" => Vec::new(),
            some => some.split(" ; ").filter_map(meaning).collect(),
        };
        let equal = heard.len() == expected.len() && heard.iter().zip(&expected).all(|(a, b)| same(a, b));
        assert!(equal, "{line}\nheard {heard:?}");
        compared += 1;
    }
    assert!(compared > 150, "only {compared} lines compared");
}
