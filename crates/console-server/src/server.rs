//! The console's server: the thread that runs it, and the connections that it accepts.

use std::convert::Infallible;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Router;
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use barrelman_host::clock::Clock;
use barrelman_host::threads;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{HttpService, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tower::ServiceExt as _;

use super::https::{Accepted, Identity, accept};
use super::left_moving::LeftMoving;
use super::limited_stream::{Bytes, LimitedStream};
use super::limits::{BYTES, HEADER_TIMEOUT, SEND_TIMEOUT};
use super::links::{announce, fingerprint};
use super::pictures::{PictureSlot, encode_pictures};
use super::places::{Place, Places};
use super::routes;
use super::settings::ConsoleSettings;
use super::shared::{Console, ConsoleParts};

/// Interval at which seats of lost pages are looked at.
const SEAT_INTERVAL: Duration = Duration::from_millis(100);
/// Send buffer of a connection, bytes: bounds how far a slow viewer's video lies behind.
const SEND_BUFFER_BYTES: usize = 256 << 10;
/// Bytes of a request's head, at most.
const HEAD_BYTES: usize = 16 << 10;
/// Connections that wait to be accepted. A flood of connections that fills this queue delays the operator's
/// by a second.
const BACKLOG: i32 = 4096;
/// Connections that are accepted before the others have their turn.
const ACCEPTED_IN_A_TURN: u64 = 4;
/// Tasks that run before the sockets are looked at again: a Stop that arrives during a flood waits for no
/// more.
const TASKS_BETWEEN_LOOKS: u32 = 8;

/// A running console. Dropping it ends the server and all its connections, as [`ConsoleServer::end`] does.
pub struct ConsoleServer {
    address: SocketAddr,
    end: Option<oneshot::Sender<LeftMoving>>,
    thread: Option<JoinHandle<()>>,
    encoders: Vec<JoinHandle<()>>,
    pictures: Vec<Arc<PictureSlot>>,
}

impl ConsoleServer {
    /// Starts the server, and the thread that encodes pictures for it, and prints its links.
    /// `on_panic` receives the name of a thread that panics.
    ///
    /// # Errors
    /// If the system has no more threads, or the socket or the standard output cannot be used.
    pub fn open(
        settings: ConsoleSettings,
        parts: ConsoleParts,
        on_panic: impl Fn(String) + Clone + Send + 'static,
    ) -> Result<Self> {
        let clock = parts.time.program_clock();
        let (origin, entrance) = (settings.origin()?, settings.entrance(clock)?);
        let ConsoleSettings { listener, tokens, kept, map, on_lost, https, .. } = settings;
        listener.set_nonblocking(true)?;
        let pictures: Vec<_> = parts.videos.iter().map(|(_, outlet)| Arc::clone(&outlet.pictures)).collect();
        let encoders = pictures.iter().map(|slot| {
            let slot = Arc::clone(slot);
            threads::spawn("pictures", on_panic.clone(), move || encode_pictures(&slot))
        });
        let encoders = encoders.collect::<std::io::Result<Vec<_>>>()?;
        let console = Arc::new(Console::new(parts, map, on_lost, entrance));
        console.links.publish(tokens.get())?;
        let runtime = runtime().context("the console's server cannot be started")?;
        let (end, ended) = oneshot::channel();
        let fingerprint = fingerprint(https.as_deref()).map(str::to_owned);
        let thread = threads::spawn("console", on_panic, move || {
            runtime.block_on(async {
                let answering = Answering { router: routes::router(Arc::clone(&console)), https, clock };
                tokio::select! {
                    served = serve(listener, answering) => {
                        if let Err(error) = served {
                            tracing::error!("the console cannot be served: {error}");
                        }
                    }
                    () = watch_seats(&console) => {}
                    () = watch_tokens(&console) => {}
                    left = ended => console.end(left.unwrap_or(LeftMoving::NOT_KNOWN)).await,
                }
            });
            // Closes all connections. Work on recordings that goes on is not waited for.
            runtime.shutdown_background();
        })?;
        announce(origin, tokens.get().as_ref(), kept.file.as_deref(), fingerprint.as_deref())?;
        Ok(Self { address: origin.address, end: Some(end), thread: Some(thread), encoders, pictures })
    }

    /// The address that the server listens on.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Ends the server, and tells the pages what may still move. A server that is dropped tells that nothing
    /// is known.
    pub fn end(mut self, left: LeftMoving) {
        if let Some(end) = self.end.take() {
            let _ = end.send(left);
        }
    }
}

impl Drop for ConsoleServer {
    fn drop(&mut self) {
        drop(self.end.take());
        self.pictures.iter().for_each(|pictures| pictures.close());
        for thread in self.thread.take().into_iter().chain(self.encoders.drain(..)) {
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

/// Renews the tokens when they are too old. The pages stay that are connected, or were a moment ago.
async fn watch_tokens(console: &Arc<Console>) {
    loop {
        let now = console.access.clock().now();
        let Some(due) = console.token_renewal(now) else { return std::future::pending().await };
        let wait = due.since(now);
        if wait > Duration::ZERO {
            tokio::time::sleep(wait).await;
            // A page may have renewed them meanwhile.
            continue;
        }
        let worker = Arc::clone(console);
        let pages = move || worker.passes_of_pages(worker.time.clock());
        let worker = Arc::clone(console);
        let renewal = move || worker.links.renew_by_age(&worker.access, pages);
        match tokio::task::spawn_blocking(renewal).await {
            Ok(Ok(())) => tracing::info!("the console's tokens were renewed; the pages that are open stay"),
            Ok(Err(error)) => tracing::warn!("{error:#}"),
            Err(error) => tracing::warn!("the console's tokens cannot be renewed: {error}"),
        }
    }
}

/// The runtime of a server: one thread.
pub(super) fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread().enable_all().event_interval(TASKS_BETWEEN_LOOKS).build()
}

/// What answers connections.
#[derive(Clone)]
pub(super) struct Answering {
    pub(super) router: Router,
    /// The certificate; `None`: the connections are not encrypted.
    pub(super) https: Option<Arc<Identity>>,
    pub(super) clock: Clock,
}

/// Accepts connections, a bounded number at a time.
pub(super) async fn serve(listener: TcpListener, answering: Answering) -> std::io::Result<()> {
    let _ = rustix::net::listen(&listener, BACKLOG);
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let places = Arc::new(Places::new(answering.clock));
    for number in 1_u64.. {
        let (stream, client) = match listener.accept().await {
            Ok(accepted) => accepted,
            Err(error) => {
                // A connection that failed before it was accepted, or too many open files: the others go on.
                tracing::warn!("a connection to the console failed: {error}");
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            }
        };
        tokio::spawn(serve_connection(stream, places.take(client.ip()), answering.clone()));
        // The others have their turn, also while one connection follows the other.
        if number.is_multiple_of(ACCEPTED_IN_A_TURN) {
            tokio::task::yield_now().await;
        }
    }
    Ok(())
}

/// Answers the requests of one connection, until it ends or has to give way. A socket takes the connection's
/// place over.
async fn serve_connection(stream: TcpStream, place: Place, answering: Answering) {
    prepare(&stream);
    let place = Arc::new(place);
    tokio::select! {
        () = answer(stream, Arc::clone(&place), answering) => {}
        () = place.gives_way() => {}
    }
}

/// An error of one connection (broken off, too slow, not HTTP, a device that does not trust the certificate)
/// concerns nobody else.
async fn answer(stream: TcpStream, place: Arc<Place>, Answering { router, https, clock }: Answering) {
    let to_router = service_fn(|mut request: Request<Incoming>| {
        request.extensions_mut().insert(Arc::clone(&place));
        router.clone().oneshot(request)
    });
    let Some(identity) = https else {
        return converse(LimitedStream::new(stream, Bytes, BYTES, clock), to_router).await;
    };
    match accept(stream, &identity, clock).await {
        Ok(Accepted::Encrypted(stream)) => converse(stream, to_router).await,
        Ok(Accepted::Plain(stream)) => converse(stream, service_fn(use_https)).await,
        Err(_) => {}
    }
}

/// The answer to a request without TLS.
async fn use_https(_: Request<Incoming>) -> Result<Response, Infallible> {
    let close = [(header::CONNECTION, "close")];
    let text = "this console is encrypted: use https:// in place of http://\n";
    Ok((StatusCode::BAD_REQUEST, close, text).into_response())
}

/// HTTP on a connection.
async fn converse<S, A>(stream: S, service: A)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    A: HttpService<Incoming, ResBody = Body, Error = Infallible>,
{
    let _ = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .max_buf_size(HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades()
        .await;
}

/// Small messages go out at once, little is buffered, and a client that takes nothing is disconnected.
pub(super) fn prepare(stream: &TcpStream) {
    let _ = stream.set_nodelay(true);
    let _ = rustix::net::sockopt::set_tcp_user_timeout(stream, SEND_TIMEOUT.as_millis() as u32);
    let _ = rustix::net::sockopt::set_socket_send_buffer_size(stream, SEND_BUFFER_BYTES);
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod https_tests;
