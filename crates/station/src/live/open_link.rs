//! Opens the link of a live run and connects its reports with the loop.

use std::sync::mpsc::SyncSender;

use anyhow::{Context, Result};
use barrelman_host::clock::Clock;
use barrelman_vocab::Telemetry;
use barrelman_vocab::profile::Protocol;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_wire::{ByteProtocol, Framing};

use super::event::Event;
use crate::link::url::Endpoint;
use crate::link::{Link, LinkHandle, LinkReport, LinkUrl};
use crate::simulated_source::LiveWorld;

/// Opens the link: to the camera of the simulated world, to a port, or none for a dry run.
///
/// # Errors
/// If the port cannot be opened.
pub(super) fn open_link(
    url: Option<&LinkUrl>,
    world: Option<&LiveWorld>,
    (protocol, framing): (Protocol, Framing),
    clock: Clock,
    events: &SyncSender<Event>,
) -> Result<Option<Link>> {
    let events = events.clone();
    match (url, world) {
        (Some(url), Some(world)) if url.endpoint == Endpoint::SimulatedCamera => {
            open_camera_link(url, world, clock, events).map(Some)
        }
        (Some(url), _) => {
            let protocol = ByteProtocol { protocol, framing, baud: url.baud() };
            let report = move |report| events.try_send(Event::Link(report)).is_ok();
            let link = LinkHandle::open(url, protocol, clock, report).context("the link cannot be opened")?;
            Ok(Some(Link::Port(link)))
        }
        (None, _) => {
            tracing::warn!("no link: this is a dry run that sends nothing");
            Ok(None)
        }
    }
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
    link.on_tilt_report(move |tilt| {
        let report = Telemetry { at: clock.now(), report: Report::CameraTilt(tilt) };
        // The world does not wait for a loop that is held up: without room in the queue, the report is dropped.
        let _ = events.try_send(Event::Link(LinkReport::Telemetry(report)));
    });
    Ok(Link::SimulatedCamera(link))
}
