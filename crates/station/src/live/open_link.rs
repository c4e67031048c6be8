//! Opens the link of a live run and connects its reports with the loop.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use anyhow::{Context, Result};
use barrelman_host::clock::Clock;
use barrelman_link::guard::message::GuardedVehicle;
use barrelman_link::{VehicleLock, VehicleRole};
use barrelman_link_http::HttpSettings;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, VehicleProfile};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing, RestEvidence, Signing};

use super::event::Event;
use crate::link::url::Endpoint;
use crate::link::{GuardedLink, GuardedLinkSettings, Link, LinkHandle, LinkReport, LinkUrl};
use crate::simulated_source::LiveWorld;

/// What is at the other end of the link.
pub(super) struct LinkedVehicle<'a> {
    pub(super) profile: &'a VehicleProfile,
    pub(super) framing: Framing,
    /// The guard's program; `None`: a thread of this process serves the port.
    pub(super) guard: Option<PathBuf>,
    /// The lock of the vehicle's address.
    pub(super) lock: Option<Arc<VehicleLock>>,
    /// How packets are signed, where they are.
    pub(super) signing: Option<Signing>,
    /// How the vehicle is reached over HTTP; `None`: by bytes.
    pub(super) http: Option<HttpSettings>,
}

/// Opens the link: to the camera of the simulated world, to a port, or none for a dry run.
///
/// # Errors
/// If the port cannot be opened.
pub(super) fn open_link(
    url: Option<&LinkUrl>,
    world: Option<&LiveWorld>,
    vehicle: LinkedVehicle<'_>,
    clock: Clock,
    events: &SyncSender<Event>,
) -> Result<Option<Link>> {
    let events = events.clone();
    match (url, world) {
        (Some(url), Some(world)) if url.endpoint == Endpoint::SimulatedCamera => {
            open_camera_link(url, world, clock, events).map(Some)
        }
        (Some(url), _) => {
            let LinkedVehicle { profile, framing, guard, lock, signing, http } = vehicle;
            let report = move |report| pass_on(report, &events);
            let context = "the link cannot be opened";
            if let Some(http) = http {
                let opened = barrelman_link_http::open_link(http, url.faults.clone(), clock, report);
                return Ok(Some(Link::Expiring(opened.context(context)?)));
            }
            let protocol = ByteProtocolName::of(profile.protocol)
                .context("this vehicle is reached at an address http://... or https://... alone")?;
            let protocol = ByteProtocol { protocol: protocol.signed(signing), framing, baud: url.baud() };
            Ok(Some(match guard {
                Some(guard) => {
                    let limits = profile.largest_rates();
                    let vehicle = GuardedVehicle::Camera {
                        limits,
                        protocol: protocol.protocol,
                        framing: protocol.framing,
                    };
                    let settings =
                        GuardedLinkSettings { guard, url: url.clone(), protocol, vehicle, lock, clock };
                    Link::Guarded(GuardedLink::open(settings, report).context(context)?)
                }
                None => Link::Port(LinkHandle::open(url, protocol, clock, report).context(context)?),
            }))
        }
        (None, _) => {
            tracing::warn!("no link: this is a dry run that sends nothing");
            Ok(None)
        }
    }
}

/// Takes the lock of a vehicle's address: one run commands a vehicle. Waits for the guard of a run that was
/// killed.
///
/// # Errors
/// If another run has the vehicle.
pub(super) fn take_lock(url: &LinkUrl, role: VehicleRole) -> Result<Option<Arc<VehicleLock>>> {
    let waits = |holder: &str| {
        tracing::warn!("waiting for the guard of an earlier run ({holder}), which sends its zeros to {url}");
    };
    Ok(VehicleLock::take(&url.endpoint, role, waits)?.map(Arc::new))
}

/// Passes a report to the loop. What the link says after the loop has ended is logged here. Returns whether
/// there was room.
fn pass_on(report: LinkReport, events: &SyncSender<Event>) -> bool {
    match report {
        LinkReport::Stopped(RestEvidence::AtRest) => {
            tracing::info!("zeros and stop were sent; telemetry shows that the camera rests");
        }
        LinkReport::Stopped(RestEvidence::NoTelemetry) => tracing::warn!(
            "zeros were sent three times, then stop; no telemetry shows whether the camera rests"
        ),
        LinkReport::Stopped(RestEvidence::Moving { rate }) => tracing::error!(
            "zeros were sent for two seconds, then stop, but telemetry still shows motion of {:.2} rad/s: the camera may be \
             turning. Stop it from the ground station itself",
            rate.radians_per_second()
        ),
        report => return events.try_send(Event::Link(report)).is_ok(),
    }
    true
}

fn open_camera_link(
    url: &LinkUrl,
    world: &LiveWorld,
    clock: Clock,
    events: SyncSender<Event>,
) -> Result<Link> {
    let link = world.link();
    link.set_faults(url.faults.clone());
    let up = Telemetry { at: clock.now(), report: Report::Link(LinkState::Up) };
    events.send(Event::Link(LinkReport::Telemetry(up)))?;
    link.on_pose_report(move |pose| {
        let field_of_view = pose.field_of_view.map(Report::FieldOfView);
        let pose = [Report::CameraTilt(pose.tilt), Report::CameraHeight(pose.height_m)];
        for report in pose.into_iter().chain(field_of_view) {
            let report = Telemetry { at: clock.now(), report };
            // The world does not wait for a loop that is held up: without room in the queue, the report is
            // dropped.
            let _ = events.try_send(Event::Link(LinkReport::Telemetry(report)));
        }
    });
    Ok(Link::SimulatedCamera(link))
}
