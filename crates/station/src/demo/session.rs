//! A session of the demo: one drive after the other, with the page, the terminal and the threads that they need.

use std::io::{Write as _, stdout};
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use anyhow::Result;
use barrelman_experiments::drive::{Drive, DriveSetup, DriveWriter};
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_host::output::OutputFile;

use super::live_drive::{DriveEnd, LiveDrive};
use super::observers::{self, DriveObservers};
use super::page::PageState;
use super::page_helm::PageHelm;
use super::page_pictures;
use super::recording;
use super::server::PageServer;
use crate::live::terminal::Terminal;
use crate::live::threads::{self, FaultInjector};

/// Capacity of the queue of events.
const EVENTS: usize = 64;

/// What a session needs.
pub struct DriveSession {
    /// The first drive. Each further drive has the next seed.
    pub setup: DriveSetup,
    /// The listener of the page's server.
    pub listener: TcpListener,
    /// The recording. A session that is recorded or stored has one drive.
    pub record: Option<OutputFile>,
    /// The stored drive.
    pub store: Option<OutputFile>,
    /// How long the session lasts at most.
    pub max_duration: Option<Duration>,
    /// The program's clock.
    pub clock: Clock,
}

impl DriveSession {
    /// Runs drives until the session is ended.
    ///
    /// # Errors
    /// If the world, a thread or the page cannot be started, or a file cannot be written.
    pub fn run(self) -> Result<DriveEnd> {
        let Self { mut setup, listener, mut record, mut store, max_duration, clock } = self;
        let has_one_drive = record.is_some() || store.is_some();
        let threads = RenderThreads::two()?;
        let (events, queue) = sync_channel(EVENTS);
        let terminal = Terminal::watch(events.clone(), clock, FaultInjector::default())?;
        let (page, inputs) = PageState::new();
        let (page, frames) = (Arc::new(page), Arc::new(Latest::default()));
        let renderer = {
            let (frames, page) = (Arc::clone(&frames), Arc::clone(&page));
            let render = move || page_pictures::render_page_pictures(&frames, &page);
            threads::spawn("page-pictures", events.clone(), render)?
        };
        let server = PageServer::start(listener, Arc::clone(&page), events.clone())?;
        drop(events);
        announce(&server, &setup)?;

        let until = max_duration.map(|duration| clock.now().plus(duration));
        let end = loop {
            let mut live = LiveDrive {
                drive: Drive::new(&setup, &threads)?,
                observers: DriveObservers {
                    recorder: recording::begin(record.take(), &setup)?,
                    frames: Some(&frames),
                    shadow: observers::shadow_of(&setup),
                    ..DriveObservers::default()
                },
                store: store.take().map(|file| DriveWriter::begin(file, &setup)).transpose()?,
                page: &page,
                setup: &setup,
                clock,
                helm: PageHelm::default(),
                is_paused: false,
            };
            let end = live.run(&queue, &inputs, until)?;
            live.finish(matches!(end, DriveEnd::Over))?;
            if !matches!(end, DriveEnd::Over) || has_one_drive {
                break end;
            }
            setup.url.seed = setup.url.seed.wrapping_add(1);
            tracing::info!("the drive is over; the next drive has seed {}", setup.url.seed);
        };
        frames.close();
        let _ = renderer.join();
        drop(server);
        drop(terminal);
        Ok(end)
    }
}

/// Prints where the page is. Scripts wait for the first line.
fn announce(server: &PageServer, setup: &DriveSetup) -> Result<()> {
    let mut out = stdout();
    let address = server.address();
    writeln!(out, "steer the boat of {} at http://{address}/", setup.url.scenario)?;
    writeln!(out, "arrow keys steer, p pauses, space stops the camera, e engages it; Ctrl-C quits")?;
    out.flush()?;
    if !address.ip().is_loopback() {
        tracing::warn!("anybody who can reach {address} can steer this simulated boat");
    }
    Ok(())
}
