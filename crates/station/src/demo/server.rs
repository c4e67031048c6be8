//! The web server of a demo: one page, its pictures, its status, and what is asked for on it.
//!
//! | request | does |
//! |---|---|
//! | `GET /` | the page, one file |
//! | `GET /video` | the picture with the overlay, as MJPEG: each the newest when it goes out |
//! | `GET /picture.jpg` | one of them |
//! | `GET /status` | [`super::page::DriveStatus`] as JSON |
//! | `POST /helm` | `{"thrust": -1..1, "rudder": -1..1}`: steers for half a second; rudder to the left above 0 |
//! | `POST /do` | `{"input": "engage"}`, or `stop`, `pause`, `resume`, `helmsman` |
//!
//! Nothing else is served, and no file is read. It listens on loopback unless it is told otherwise, answers there only
//! those who ask for it by a name of this machine (so that no foreign site's name can be pointed at it), and takes
//! nothing from a page of another origin. Bodies are at most [`MAX_BODY_BYTES`] bytes long, and [`MAX_VIEWERS`] can look at
//! the video at a time. What it moves is a simulated boat.

use std::convert::Infallible;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use bytes::Bytes;
use futures_util::stream;
use serde::Deserialize;
use tokio::sync::{oneshot, watch};

use super::page::PageState;
use crate::live::event::Event;
use crate::live::threads;
use barrelman_experiments::drive::DriveInput;

/// The page.
const PAGE: &str = include_str!("page.html");
/// Longest body of a request, bytes.
const MAX_BODY_BYTES: usize = 512;
/// How many can look at the video at a time.
const MAX_VIEWERS: usize = 8;
/// How long one picture is waited for.
const PICTURE_TIMEOUT: Duration = Duration::from_secs(2);

/// A running server; it ends when dropped.
pub struct PageServer {
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Served {
    state: Arc<PageState>,
    /// The names that it answers to; `None`: any.
    names: Option<Vec<String>>,
    viewers: AtomicUsize,
}

impl PageServer {
    /// Begins to serve.
    ///
    /// # Errors
    /// If the system has no more threads, or the socket cannot be used.
    pub fn start(listener: TcpListener, state: Arc<PageState>, events: SyncSender<Event>) -> Result<Self> {
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let port = address.port();
        let names = address.ip().is_loopback().then(|| {
            vec![
                format!("127.0.0.1:{port}"),
                format!("localhost:{port}"),
                format!("[::1]:{port}"),
                address.to_string(),
            ]
        });
        let served = Arc::new(Served { state, names, viewers: AtomicUsize::new(0) });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("the page's server cannot be started")?;
        let (end, ended) = oneshot::channel::<()>();
        let thread = threads::spawn("page", events, move || {
            runtime.block_on(async {
                let listener = match tokio::net::TcpListener::from_std(listener) {
                    Ok(listener) => listener,
                    Err(error) => return tracing::error!("the page cannot be served: {error}"),
                };
                // Videos never end by themselves: at the end they are dropped with everything else.
                tokio::select! {
                    served = axum::serve(listener, router(served)).into_future() => {
                        if let Err(error) = served {
                            tracing::error!("the page cannot be served: {error}");
                        }
                    }
                    _ = ended => {}
                }
            });
        })?;
        Ok(Self { address, end: Some(end), thread: Some(thread) })
    }

    /// Where it listens.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn router(served: Arc<Served>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/video", get(video))
        .route("/picture.jpg", get(picture))
        .route("/status", get(status))
        .route("/helm", post(helm))
        .route("/do", post(act))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .layer(from_fn_with_state(Arc::clone(&served), guard))
        .with_state(served)
}

/// Answers only those who ask for this machine by its name, from a page of its own.
async fn guard(State(served): State<Arc<Served>>, request: Request, next: Next) -> Response {
    if is_ours(request.headers(), served.names.as_deref()) {
        let mut response = next.run(request).await;
        let headers = response.headers_mut();
        for (name, value) in [
            (header::CACHE_CONTROL, "no-store"),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (
                header::CONTENT_SECURITY_POLICY,
                "default-src 'none'; img-src 'self' data:; connect-src 'self'; style-src 'unsafe-inline'; \
                 script-src 'unsafe-inline'; frame-ancestors 'none'",
            ),
        ] {
            headers.insert(name, header::HeaderValue::from_static(value));
        }
        response
    } else {
        (StatusCode::FORBIDDEN, "this page answers to its own address only\n").into_response()
    }
}

fn is_ours(headers: &HeaderMap, names: Option<&[String]>) -> bool {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let Some(host) = text(header::HOST) else { return false };
    let known = names.is_none_or(|names| names.iter().any(|name| name == host));
    let own = match headers.contains_key(header::ORIGIN) {
        true => text(header::ORIGIN).and_then(|origin| origin.strip_prefix("http://")) == Some(host),
        false => true,
    };
    known && own
}

async fn page() -> Response {
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], PAGE).into_response()
}

async fn status(State(served): State<Arc<Served>>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], served.state.status()).into_response()
}

async fn picture(State(served): State<Arc<Served>>) -> Response {
    let mut pictures = served.state.pictures();
    let fresh = tokio::time::timeout(PICTURE_TIMEOUT, pictures.changed()).await;
    let jpeg = pictures.borrow().clone();
    if fresh.is_err() && jpeg.is_empty() {
        return (StatusCode::SERVICE_UNAVAILABLE, "there is no picture yet\n").into_response();
    }
    ([(header::CONTENT_TYPE, "image/jpeg")], jpeg).into_response()
}

/// Somebody who looks at the video, counted until gone.
struct Viewer {
    served: Arc<Served>,
    pictures: watch::Receiver<Bytes>,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.served.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

async fn video(State(served): State<Arc<Served>>) -> Response {
    let mut pictures = served.state.pictures();
    // One that was drawn before is shown at once: of a world that is paused nothing else comes.
    if !pictures.borrow().is_empty() {
        pictures.mark_changed();
    }
    if served.viewers.fetch_add(1, Ordering::Relaxed) >= MAX_VIEWERS {
        served.viewers.fetch_sub(1, Ordering::Relaxed);
        return (StatusCode::SERVICE_UNAVAILABLE, "too many look at the video already\n").into_response();
    }
    let parts = stream::unfold(Viewer { served, pictures }, |mut viewer| async {
        viewer.pictures.changed().await.ok()?;
        let jpeg = viewer.pictures.borrow_and_update().clone();
        let head = format!("--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n", jpeg.len());
        let part = [head.as_bytes(), jpeg.as_ref(), b"\r\n"].concat();
        Some((Ok::<_, Infallible>(Bytes::from(part)), viewer))
    });
    let kind = "multipart/x-mixed-replace; boundary=picture";
    ([(header::CONTENT_TYPE, kind)], Body::from_stream(parts)).into_response()
}

/// What is posted to `/helm`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Helm {
    thrust: f64,
    rudder: f64,
}

async fn helm(State(served): State<Arc<Served>>, body: Bytes) -> Response {
    let Some(Helm { thrust, rudder }) = serde_json::from_slice(&body)
        .ok()
        .filter(|helm: &Helm| [helm.thrust, helm.rudder].iter().all(|share| (-1.0..=1.0).contains(share)))
    else {
        return refusal("{\"thrust\": -1..1, \"rudder\": -1..1}\n");
    };
    let percent = |share: f64| (share * 100.0).round() as i8;
    ask(&served, DriveInput::Helm { thrust: percent(thrust), rudder: percent(rudder) })
}

async fn act(State(served): State<Arc<Served>>, body: Bytes) -> Response {
    match serde_json::from_slice(&body) {
        Ok(DriveInput::Helm { .. }) | Err(_) => {
            refusal("{\"input\": \"engage\"}, or stop, pause, resume, helmsman\n")
        }
        Ok(input) => ask(&served, input),
    }
}

fn refusal(expected: &str) -> Response {
    (StatusCode::BAD_REQUEST, format!("expected {expected}")).into_response()
}

fn ask(served: &Served, input: DriveInput) -> Response {
    if served.state.queue_input(input) {
        StatusCode::NO_CONTENT.into_response()
    } else {
        (StatusCode::SERVICE_UNAVAILABLE, "input queue full; retry\n").into_response()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A request with these headers, to a server that answers to `127.0.0.1:8480` only.
    #[track_caller]
    fn check(headers: &[(header::HeaderName, &'static str)], answered: bool) {
        let names = ["127.0.0.1:8480".to_owned(), "localhost:8480".to_owned()];
        let headers: HeaderMap = headers
            .iter()
            .map(|(name, value)| (name.clone(), header::HeaderValue::from_static(value)))
            .collect();
        assert_eq!(is_ours(&headers, Some(&names)), answered, "{headers:?}");
    }

    #[test]
    fn only_its_own_page_and_scripts_of_this_machine_are_answered() {
        check(&[(header::HOST, "127.0.0.1:8480")], true);
        check(&[(header::HOST, "localhost:8480"), (header::ORIGIN, "http://localhost:8480")], true);
        check(&[], false);
        check(&[(header::HOST, "rebound.example:8480")], false);
        check(&[(header::HOST, "127.0.0.1:8480"), (header::ORIGIN, "http://evil.example")], false);
        check(&[(header::HOST, "127.0.0.1:8480"), (header::ORIGIN, "null")], false);
        check(&[(header::HOST, "127.0.0.1:8480"), (header::ORIGIN, "http://127.0.0.1:9999")], false);
    }
}
