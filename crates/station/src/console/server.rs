//! The console's server: the thread that runs it, and the connections that it accepts.

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::oneshot;

use super::access::Access;
use super::guard::Hosts;
use super::limits::{HEADER_TIMEOUT, SEND_TIMEOUT};
use super::links::announce;
use super::pictures::{PictureSlot, encode_pictures};
use super::routes;
use super::settings::ConsoleSettings;
use super::shared::{Console, ConsoleParts};
use super::slots::Slots;
use crate::live::event::Event;
use crate::live::threads;

/// Interval at which seats of lost pages are looked at.
const SEAT_INTERVAL: Duration = Duration::from_millis(100);
/// Send buffer of a connection, bytes: bounds how far a slow viewer's video lies behind.
const SEND_BUFFER_BYTES: usize = 256 << 10;

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
        let console = Arc::new(Console::new(parts, on_lost, access, hosts));
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("the console's server cannot be started")?;
        let (end, ended) = oneshot::channel::<()>();
        let thread = threads::spawn("console", events, move || {
            runtime.block_on(async {
                tokio::select! {
                    served = serve(listener, routes::router(Arc::clone(&console))) => {
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
pub(super) async fn serve(listener: TcpListener, router: Router) -> std::io::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let slots = Arc::new(Slots::default());
    loop {
        let (stream, client) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                // A connection that failed before it was accepted, or too many open files: the others go on.
                tracing::warn!("a connection to the console failed: {error}");
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        // Too many connections: the newest is closed at once.
        let Some(slot) = slots.take(client.ip()) else { continue };
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

/// Small messages go out at once, little is buffered, and a client that takes nothing is disconnected.
fn prepare(stream: &TcpStream) {
    let _ = stream.set_nodelay(true);
    let _ = rustix::net::sockopt::set_tcp_user_timeout(stream, SEND_TIMEOUT.as_millis() as u32);
    let _ = rustix::net::sockopt::set_socket_send_buffer_size(stream, SEND_BUFFER_BYTES);
}

#[cfg(test)]
mod tests;
