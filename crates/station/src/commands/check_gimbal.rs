//! The check of a MAVLink gimbal: who is heard, what the gimbal has, who has the control. Heartbeats and
//! requests are sent, no claim and no rate.

use std::io;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::MavlinkPeers;
use barrelman_vocab::profile::Protocol;
use barrelman_wire::Signing;
use barrelman_wire::mavlink::gimbal_reader::{Holder, Information};
use barrelman_wire::mavlink::probe::Findings;
use barrelman_wire::mavlink::{Gimbal, Probe};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::check_equipment::equipment_results;
use super::check_result::{CheckResult, Verdict};
use crate::config::Configuration;
use crate::link::port::Port;
use crate::secrets;

/// How long a gimbal manager may take to answer.
const TIMEOUT: Duration = Duration::from_secs(5);
/// How long other gimbals may take to describe themselves.
const LEAST_TIME: Duration = Duration::from_secs(2);
/// Longest wait for a packet.
const WAIT: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };
/// Largest datagram, bytes.
const MAX_READ_BYTES: usize = 2048;

/// Checks the gimbal at an open port. Vehicles of other protocols have nothing to check here.
pub(super) fn check_gimbal(
    port: Port,
    configuration: &Configuration,
    clock: Clock,
    results: &mut Vec<CheckResult>,
) {
    let Protocol::MavlinkGimbal(peers) = configuration.profile.protocol else { return };
    let signing = match secrets::mavlink_signing(configuration.signing_key_file.as_deref(), clock) {
        Ok(signing) => signing,
        Err(error) => {
            results.push(CheckResult::new("signing key", Verdict::Failed, format!("{error:#}")));
            return;
        }
    };
    match look(port, peers, signing) {
        Ok(findings) => {
            results.extend(results_of(&findings));
            results.extend(equipment_results(&findings, peers.camera));
        }
        Err(error) => {
            let details = format!(
                "nobody takes packets there ({error}): is the autopilot's port open for this address?"
            );
            results.push(CheckResult::new("MAVLink", Verdict::Failed, details));
        }
    }
}

fn look(mut port: Port, peers: MavlinkPeers, signing: Option<Signing>) -> io::Result<Findings> {
    let mut probe = Probe::new(peers, signing);
    let began = Instant::now();
    let mut buffer = [0; MAX_READ_BYTES];
    // Other gimbals may describe themselves later than the one that is used.
    while began.elapsed() < TIMEOUT && !(probe.is_complete() && began.elapsed() >= LEAST_TIME) {
        let mut packets = Vec::new();
        probe.poll(Timestamp::ZERO.plus(began.elapsed()), &mut packets);
        for packet in packets {
            port.write_all(&packet)?;
        }
        let is_readable = {
            let mut fds = [PollFd::new(&port, PollFlags::IN)];
            poll(&mut fds, Some(&WAIT)).is_ok_and(|ready| ready > 0)
        };
        if is_readable {
            let read = port.read(&mut buffer)?;
            probe.received(&buffer[..read]);
        }
    }
    Ok(probe.findings())
}

fn results_of(findings: &Findings) -> Vec<CheckResult> {
    let seconds = TIMEOUT.as_secs();
    if findings.components.is_empty() {
        let details = format!(
            "no heartbeat within {seconds} s: are address, port, baud rate, link.vehicle_system and the signing key right, and \
             does the autopilot send MAVLink there?"
        );
        return vec![CheckResult::new("MAVLink", Verdict::Failed, details)];
    }
    let names: Vec<String> = findings.components.iter().map(ToString::to_string).collect();
    let mut results = vec![CheckResult::new(
        "MAVLink",
        Verdict::Ok,
        format!("heard (system/component): {}", names.join(", ")),
    )];
    let Some(gimbal) = findings.gimbal else {
        if findings.choice.is_hopeless() {
            results.push(CheckResult::new("gimbal", Verdict::Failed, findings.choice.to_string()));
            return results;
        }
        let details = format!(
            "no gimbal manager answers within {seconds} s: set up the gimbal in the autopilot (ArduPilot: MNT1_TYPE; PX4: MNT_MODE_IN 4)"
        );
        results.push(CheckResult::new("gimbal", Verdict::Failed, details));
        return results;
    };
    results.push(findings.information.as_ref().map_or_else(|| undescribed(gimbal), gimbal_result));
    results.push(control_result(findings.holder));
    results.push(if findings.has_attitude {
        CheckResult::new("attitude", Verdict::Ok, "the gimbal reports its attitude")
    } else {
        let details = "the gimbal does not report its attitude: the tilt is not known, and a shut-down cannot see that the camera rests";
        CheckResult::new("attitude", Verdict::Warning, details)
    });
    let details = "a gimbal manager reports neither tether nor battery, and no limit of its rates: vehicle.limit_pan_rad_per_s and \
                   vehicle.limit_tilt_rad_per_s hold";
    results.push(CheckResult::new("profile", Verdict::Ok, details));
    results
}

fn undescribed(gimbal: Gimbal) -> CheckResult {
    let details = format!(
        "manager {} does not say which axes and end stops its gimbal has: commands go to device {}",
        gimbal.manager, gimbal.device
    );
    CheckResult::new("gimbal", Verdict::Warning, details)
}

fn gimbal_result(information: &Information) -> CheckResult {
    let stops = |stops: Option<(f64, f64)>| {
        stops.map_or_else(
            || "no end stops stated".to_owned(),
            |(low, high)| format!("from {:.0} to {:.0} degrees", low.to_degrees(), high.to_degrees()),
        )
    };
    let axis = |name: &str, is_there: bool, end_stops: Option<(f64, f64)>| {
        if is_there { format!("{name} {}", stops(end_stops)) } else { format!("no {name} axis") }
    };
    let gimbal = information.gimbal;
    let details = format!(
        "manager {}, device {}: {}; {}",
        gimbal.manager,
        gimbal.device,
        axis("pitch", information.has_pitch, information.pitch_stops),
        axis("yaw", information.has_yaw, information.yaw_stops),
    );
    let is_whole = information.has_pitch && information.has_yaw;
    CheckResult::new("gimbal", if is_whole { Verdict::Ok } else { Verdict::Warning }, details)
}

fn control_result(holder: Option<Holder>) -> CheckResult {
    let (verdict, details) = match holder {
        Some(Holder::Nobody) => (Verdict::Ok, "nobody has the control of the gimbal".to_owned()),
        Some(Holder::Us) => (Verdict::Ok, "this program's address has the control of the gimbal".to_owned()),
        Some(Holder::Other(other)) => (
            Verdict::Warning,
            format!(
                "{other} has the control of the gimbal: `run` leaves the gimbal alone until the operator engages"
            ),
        ),
        None => (
            Verdict::Warning,
            "the gimbal manager does not say who has the control: another commander is not noticed"
                .to_owned(),
        ),
    };
    CheckResult::new("control", verdict, details)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::mavlink::Address;

    use super::*;

    #[track_caller]
    fn check(findings: Findings, subject: &str, verdict: Verdict, part: &str) {
        let results = results_of(&findings);
        let found = results.iter().find(|result| result.subject == subject).expect("a result");
        assert_eq!(found.verdict, verdict);
        assert!(found.details.contains(part), "{}", found.details);
    }

    #[test]
    fn each_finding_has_its_verdict_and_its_remedy() {
        let nothing = Findings::default();
        let manager = Address::new(1, 1);
        let heard = Findings { components: vec![manager], ..nothing.clone() };
        let gimbal = Gimbal { manager, device: 1 };
        let information = Information {
            gimbal,
            has_pitch: true,
            has_yaw: true,
            has_roll: false,
            pitch_stops: Some((-core::f64::consts::FRAC_PI_2, 0.3491)),
            yaw_stops: None,
        };
        let secretive = Findings { gimbal: Some(gimbal), ..heard.clone() };
        let found = Findings { information: Some(information), ..secretive.clone() };
        let other = Findings { holder: Some(Holder::Other(Address::new(255, 190))), ..found.clone() };
        let fixed = Information { has_yaw: false, ..information };
        check(nothing, "MAVLink", Verdict::Failed, "no heartbeat");
        check(heard.clone(), "MAVLink", Verdict::Ok, "1/1");
        check(heard, "gimbal", Verdict::Failed, "MNT1_TYPE");
        check(found.clone(), "gimbal", Verdict::Ok, "pitch from -90 to 20 degrees; yaw no end stops stated");
        check(secretive.clone(), "gimbal", Verdict::Warning, "does not say which axes");
        check(Findings { information: Some(fixed), ..secretive }, "gimbal", Verdict::Warning, "no yaw axis");
        check(other, "control", Verdict::Warning, "255/190 has the control");
        check(found.clone(), "control", Verdict::Warning, "does not say");
        check(Findings { has_attitude: true, ..found.clone() }, "attitude", Verdict::Ok, "reports");
        check(found, "attitude", Verdict::Warning, "the tilt is not known");
    }
}
