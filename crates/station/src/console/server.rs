//! The console's server: what all its tasks share, and the thread that runs it.

use std::net::{SocketAddr, TcpListener};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, oneshot, watch};

use super::access::{Access, Role};
use super::api::{ControlSeat, Hello, LawName};
use super::guard::Hosts;
use super::limits::{HEADER_TIMEOUT, MAX_CONNECTIONS};
use super::links::announce;
use super::on_lost::OnConsoleLost;
use super::pictures::{PictureSlot, encode_pictures};
use super::routes;
use super::seats::{ClientId, Seats};
use super::session_time::SessionTime;
use super::settings::ConsoleSettings;
use super::video_relay::VideoRelay;
use crate::live::event::Event;
use crate::live::threads;
use crate::operator::Gateway;
use crate::snapshot::{EventLog, Level, SharedSnapshot};

/// Rate of a nudge that the page shows, rad/s.
const NUDGE_RATE: f64 = barrelman_pilot::NUDGE_RATE_RAD_PER_S;
/// Interval at which seats of lost pages are looked at.
const SEAT_INTERVAL: Duration = Duration::from_millis(250);
/// Send buffer of a connection, bytes: bounds how far a slow viewer's video lies behind.
const SEND_BUFFER_BYTES: usize = 256 << 10;

/// What does not change in a session, for the page.
#[derive(Debug, Clone)]
pub struct SessionFacts {
    /// `run` or `demo`.
    pub command: &'static str,
    /// Where the video comes from, without passwords.
    pub source: String,
    /// Where commands go, without passwords; `None`: a dry run.
    pub link: Option<String>,
    /// Name of the vehicle profile.
    pub vehicle: String,
}

/// What a console is made of.
pub struct ConsoleParts {
    /// The session.
    pub facts: SessionFacts,
    /// Where requests go.
    pub gateway: Arc<Gateway>,
    /// The newest snapshot.
    pub snapshots: watch::Receiver<SharedSnapshot>,
    /// The event log.
    pub events: Arc<EventLog>,
    /// The video.
    pub relay: Arc<VideoRelay>,
    /// The pictures.
    pub pictures: Arc<PictureSlot>,
    /// The time of the session.
    pub time: SessionTime,
}

/// What all tasks of a console share.
pub struct Console {
    pub(super) facts: SessionFacts,
    on_lost: OnConsoleLost,
    pub(super) access: Access,
    pub(super) hosts: Hosts,
    pub(super) gateway: Arc<Gateway>,
    pub(super) snapshots: watch::Receiver<SharedSnapshot>,
    pub(super) events: Arc<EventLog>,
    pub(super) relay: Arc<VideoRelay>,
    pub(super) pictures: Arc<PictureSlot>,
    pub(super) time: SessionTime,
    pub(super) seats: Mutex<Seats>,
    pub(super) seat_changes: watch::Sender<ControlSeat>,
    loop_events: SyncSender<Event>,
}

impl Console {
    pub(super) fn new(
        parts: ConsoleParts,
        on_lost: OnConsoleLost,
        access: Access,
        hosts: Hosts,
        loop_events: SyncSender<Event>,
    ) -> Self {
        Self {
            on_lost,
            access,
            hosts,
            facts: parts.facts,
            gateway: parts.gateway,
            snapshots: parts.snapshots,
            events: parts.events,
            relay: parts.relay,
            pictures: parts.pictures,
            time: parts.time,
            seats: Mutex::default(),
            seat_changes: watch::Sender::new(ControlSeat::default()),
            loop_events,
        }
    }

    /// Uses the seats. Does not wait: nobody holds them across a wait.
    pub(super) fn with_seats<T>(&self, f: impl FnOnce(&mut Seats) -> T) -> T {
        f(&mut self.seats.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Tells all pages who controls, and the loop whether somebody does.
    pub(super) fn publish_seats(&self) {
        let state = self.with_seats(|seats| seats.state());
        if state.holder.is_some() {
            let _ = self.loop_events.try_send(Event::ConsoleLost(false));
        }
        self.seat_changes.send_replace(state);
    }

    /// Frees the seat of a page that was lost for too long, and does what the session says for that case.
    fn expire_seats(&self) {
        if !self.with_seats(|seats| seats.expire(self.time.clock())) {
            return;
        }
        let now = self.time.now();
        let is_engaged = super::status::status_of(&self.snapshots.borrow(), false).mode.engaged;
        if self.on_lost == OnConsoleLost::Stop {
            self.events.add(now, Level::Alarm, "console-lost", "the controlling page is gone: stopped");
            self.gateway.stop();
        } else {
            let text = if is_engaged { "; the camera stays engaged" } else { "" };
            let text = format!("the controlling page is gone{text}");
            self.events.add(now, Level::Warning, "console-lost", text);
        }
        let _ = self.loop_events.try_send(Event::ConsoleLost(true));
        self.publish_seats();
    }

    /// The first message to a page.
    pub(super) fn hello(&self, client: ClientId, role: Role) -> Hello {
        let since_start = Duration::from_nanos(self.time.now().as_nanos());
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Hello {
            client,
            may_control: role == Role::Control,
            version: env!("CARGO_PKG_VERSION"),
            command: self.facts.command,
            source: self.facts.source.clone(),
            link: self.facts.link.clone(),
            vehicle: self.facts.vehicle.clone(),
            laws: vec![LawName::MinimumEnergy, LawName::TimeFuel, LawName::Eco, LawName::Schema],
            nudge_rate: NUDGE_RATE,
            on_console_lost: if self.on_lost == OnConsoleLost::Stop { "stop" } else { "stay" },
            start_unix_ms: unix.saturating_sub(since_start).as_secs_f64() * 1e3,
        }
    }
}

/// A running console. Dropping it ends the server and all its connections.
pub struct ConsoleServer {
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    encoder: Option<JoinHandle<()>>,
    pictures: Arc<PictureSlot>,
}

impl ConsoleServer {
    /// Starts the server, and the thread that encodes pictures for it, and prints its links.
    ///
    /// # Errors
    /// If the system has no more threads, or the socket or the standard output cannot be used.
    pub fn open(settings: ConsoleSettings, parts: ConsoleParts, events: SyncSender<Event>) -> Result<Self> {
        let ConsoleSettings { listener, tokens, host_names, on_lost } = settings;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let (access, hosts) = (Access::new(tokens.clone(), address.port()), Hosts::new(address, host_names));
        let pictures = Arc::clone(&parts.pictures);
        let encoder = {
            let slot = Arc::clone(&pictures);
            threads::spawn("pictures", events.clone(), move || encode_pictures(&slot))?
        };
        let console = Arc::new(Console::new(parts, on_lost, access, hosts, events.clone()));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("the console's server cannot be started")?;
        let (end, ended) = oneshot::channel::<()>();
        let thread = threads::spawn("console", events, move || {
            runtime.block_on(async {
                tokio::select! {
                    served = serve(listener, &console) => {
                        if let Err(error) = served {
                            tracing::error!("the console cannot be served: {error}");
                        }
                    }
                    () = watch_seats(&console) => {}
                    _ = ended => {}
                }
            });
            // Dropping the runtime closes all connections.
        })?;
        announce(address, tokens.as_ref())?;
        Ok(Self { address, end: Some(end), thread: Some(thread), encoder: Some(encoder), pictures })
    }

    /// The address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for ConsoleServer {
    fn drop(&mut self) {
        drop(self.end.take());
        self.pictures.close();
        for thread in [self.thread.take(), self.encoder.take()].into_iter().flatten() {
            let _ = thread.join();
        }
    }
}

async fn watch_seats(console: &Console) {
    let mut interval = tokio::time::interval(SEAT_INTERVAL);
    loop {
        interval.tick().await;
        console.expire_seats();
    }
}

/// Accepts connections, a bounded number at a time.
async fn serve(listener: TcpListener, console: &Arc<Console>) -> std::io::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let router = routes::router(Arc::clone(console));
    let slots = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                // A connection that failed before it was accepted, or too many open files: the others go on.
                tracing::warn!("a connection to the console failed: {error}");
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        // Too many connections: the newest is closed at once.
        let Ok(slot) = Arc::clone(&slots).try_acquire_owned() else { continue };
        let router = router.clone();
        tokio::spawn(async move {
            prepare(&stream);
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(HEADER_TIMEOUT)
                .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
                .with_upgrades();
            // An error of one connection (broken off, too slow, not HTTP) concerns nobody else.
            let _ = connection.await;
            drop(slot);
        });
    }
}

/// Small messages go out at once, and little is buffered.
fn prepare(stream: &TcpStream) {
    let _ = stream.set_nodelay(true);
    let _ = rustix::net::sockopt::set_socket_send_buffer_size(stream, SEND_BUFFER_BYTES);
}

#[cfg(test)]
mod tests;
