//! Opens the link to the boat of a live run and connects its reports with the loop.

use std::cell::Cell;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use anyhow::{Context, Result, bail};
use barrelman_host::clock::Clock;
use barrelman_link::VehicleLock;
use barrelman_link::guard::message::GuardedVehicle;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, VesselCommand, VesselProfile};
use barrelman_wire::VesselProtocol;

use super::event::Event;
use crate::config::vessel::{SIMULATED, VesselConfig};
use crate::link::url::Endpoint;
use crate::link::vessel_link::Boat;
use crate::link::{GuardedLink, GuardedLinkSettings, LinkHandle, LinkReport, LinkUrl};
use crate::simulated_source::LiveWorld;

/// Opens the link to the boat: to that of the simulated world, or to a port, behind the guard unless there is
/// none.
///
/// # Errors
/// If there is no such boat, or the port cannot be opened.
pub(super) fn open_vessel(
    config: &VesselConfig,
    world: Option<&LiveWorld>,
    (guard, lock): (Option<PathBuf>, Option<Arc<VehicleLock>>),
    clock: Clock,
    events: &SyncSender<Event>,
) -> Result<Boat> {
    if config.url == SIMULATED {
        let Some(world) = world else {
            bail!("--vessel sim: is the boat of a simulated world: give --video sim:SCENARIO with it");
        };
        let up = Telemetry { at: clock.now(), report: Report::Link(LinkState::Up) };
        events.send(Event::Vessel(LinkReport::Telemetry(up)))?;
        return Ok(Boat::Simulated(world.boat()));
    }
    let url = LinkUrl::parse(&config.url).context("vessel.url")?;
    let protocol = protocol_of(&config.profile)?.with_vehicle(config.vehicle);
    match &url.endpoint {
        Endpoint::Udp { .. } => {}
        Endpoint::Tcp { .. } | Endpoint::Serial { .. } if protocol.takes_streams() => {}
        _ if protocol.takes_streams() => bail!(
            "a boat is reached at --vessel udp://HOST:PORT, tcp://HOST:PORT or serial:/dev/ttyACM0?baud=57600"
        ),
        _ => bail!("the boat {} takes datagrams: give --vessel udp://HOST:5007", config.profile.name),
    }
    let events = events.clone();
    // A boat repeats what it says; the log names each change.
    let told = Cell::new(None);
    let report = move |report| match report {
        LinkReport::Stopped(_) => {
            tracing::info!("neutral was sent to the boat; the boat does not answer whether it arrived");
            true
        }
        LinkReport::Telemetry(Telemetry { report: Report::Acceptance(said), .. }) => {
            let before = told.replace(Some(said));
            if let Some(text) = protocol.acceptance_text(said).filter(|_| before != Some(said)) {
                tracing::info!("{text}");
            }
            events.try_send(Event::Vessel(report)).is_ok()
        }
        report => events.try_send(Event::Vessel(report)).is_ok(),
    };
    let context = "the link to the boat cannot be opened";
    Ok(match guard {
        Some(guard) => {
            let vehicle = GuardedVehicle::Vessel { limits: largest(&config.profile), protocol };
            let settings = GuardedLinkSettings { guard, url, protocol, vehicle, lock, clock };
            Boat::Guarded(GuardedLink::open(settings, report).context(context)?)
        }
        None => Boat::Port(LinkHandle::open(&url, protocol, clock, report).context(context)?),
    })
}

/// The protocol of a vessel.
///
/// # Errors
/// If this program does not speak it.
fn protocol_of(profile: &VesselProfile) -> Result<VesselProtocol> {
    VesselProtocol::of_profile(profile.name).with_context(|| {
        format!(
            "the vessel {} has no port: give --vessel-profile mavlink-rover, mavlink-rover-manual or lab-udp",
            profile.name
        )
    })
}

/// The largest throttle and rudder that the guard lets pass.
fn largest(profile: &VesselProfile) -> VesselCommand {
    let limits = profile.limits;
    VesselCommand { throttle: limits.ahead.max(limits.astern).max(profile.hand_throttle), rudder: 1.0 }
}
