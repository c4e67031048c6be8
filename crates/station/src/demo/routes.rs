//! The HTTP routes of the demo's page.
//!
//! | request | answer |
//! |---|---|
//! | `GET /` | the page, one HTML file |
//! | `GET /video` | the picture with the overlay as MJPEG, always the newest |
//! | `GET /picture.jpg` | one JPEG picture |
//! | `GET /status` | [`super::page::DriveStatus`] as JSON |
//! | `POST /helm` | takes `{"thrust": -1..1, "rudder": -1..1}`: steers for half a second; a positive rudder turns left |
//! | `POST /do` | takes `{"input": "engage"}`, or `stop`, `pause`, `resume`, `helmsman` |
//!
//! No other file is served. A server on a loopback address answers only requests for a name of this machine, so that a
//! foreign site cannot point its own name at the server. Requests from a page of another origin are refused. The body of
//! a request has at most [`MAX_BODY_BYTES`] bytes, and `/video` has at most [`MAX_VIEWERS`] viewers at a time.

use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use barrelman_experiments::drive::DriveInput;
use bytes::Bytes;
use futures_util::stream;
use serde::Deserialize;
use tokio::sync::watch;

use super::page::PageState;

#[cfg(test)]
mod tests;

/// The page.
const PAGE: &str = include_str!("page.html");
/// Longest body of a request, bytes.
const MAX_BODY_BYTES: usize = 512;
/// How many viewers `/video` has at a time.
const MAX_VIEWERS: usize = 8;
/// How long `/picture.jpg` waits for a new picture.
const PICTURE_TIMEOUT: Duration = Duration::from_secs(2);

/// The state of the routes.
pub(super) struct RouteState {
    page: Arc<PageState>,
    /// The values of `Host` that are answered; `None`: any.
    hosts: Option<Vec<String>>,
    picture_timeout: Duration,
    viewers: AtomicUsize,
}

impl RouteState {
    /// The state of a server that listens on `address`.
    pub(super) fn new(page: Arc<PageState>, address: SocketAddr) -> Self {
        let port = address.port();
        let hosts = address.ip().is_loopback().then(|| {
            vec![
                format!("127.0.0.1:{port}"),
                format!("localhost:{port}"),
                format!("[::1]:{port}"),
                address.to_string(),
            ]
        });
        Self { page, hosts, picture_timeout: PICTURE_TIMEOUT, viewers: AtomicUsize::new(0) }
    }
}

/// The router of all routes.
pub(super) fn router(state: RouteState) -> Router {
    let state = Arc::new(state);
    Router::new()
        .route("/", get(page))
        .route("/video", get(video))
        .route("/picture.jpg", get(picture))
        .route("/status", get(status))
        .route("/helm", post(helm))
        .route("/do", post(operator_input))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .layer(from_fn_with_state(Arc::clone(&state), refuse_foreign_requests))
        .with_state(state)
}

/// Refuses requests for a foreign host or from a foreign origin, and sets the security headers of all other answers.
async fn refuse_foreign_requests(
    State(state): State<Arc<RouteState>>,
    request: Request,
    next: Next,
) -> Response {
    if !is_own_request(request.headers(), state.hosts.as_deref()) {
        return (StatusCode::FORBIDDEN, "this page answers to its own address only\n").into_response();
    }
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
}

/// Whether a request is for one of `hosts`, and from the server's own page or from no page (a script).
fn is_own_request(headers: &HeaderMap, hosts: Option<&[String]>) -> bool {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let Some(host) = text(header::HOST) else { return false };
    let is_known = hosts.is_none_or(|hosts| hosts.iter().any(|known| known == host));
    let is_own_origin = match headers.contains_key(header::ORIGIN) {
        true => text(header::ORIGIN).and_then(|origin| origin.strip_prefix("http://")) == Some(host),
        false => true,
    };
    is_known && is_own_origin
}

async fn page() -> Response {
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], PAGE).into_response()
}

async fn status(State(state): State<Arc<RouteState>>) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], state.page.status()).into_response()
}

async fn picture(State(state): State<Arc<RouteState>>) -> Response {
    let mut pictures = state.page.pictures();
    let changed = tokio::time::timeout(state.picture_timeout, pictures.changed()).await;
    let jpeg = pictures.borrow().clone();
    if changed.is_err() && jpeg.is_empty() {
        return (StatusCode::SERVICE_UNAVAILABLE, "there is no picture yet\n").into_response();
    }
    ([(header::CONTENT_TYPE, "image/jpeg")], jpeg).into_response()
}

/// A viewer of the video, counted until dropped.
struct Viewer {
    state: Arc<RouteState>,
    pictures: watch::Receiver<Bytes>,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.state.viewers.fetch_sub(1, Ordering::Relaxed);
    }
}

async fn video(State(state): State<Arc<RouteState>>) -> Response {
    let mut pictures = state.page.pictures();
    // The last picture is sent at once: a world that is paused sends no other.
    if !pictures.borrow().is_empty() {
        pictures.mark_changed();
    }
    if state.viewers.fetch_add(1, Ordering::Relaxed) >= MAX_VIEWERS {
        state.viewers.fetch_sub(1, Ordering::Relaxed);
        return (StatusCode::SERVICE_UNAVAILABLE, "too many viewers; retry later\n").into_response();
    }
    let parts = stream::unfold(Viewer { state, pictures }, |mut viewer| async {
        viewer.pictures.changed().await.ok()?;
        let jpeg = viewer.pictures.borrow_and_update().clone();
        let head = format!("--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n", jpeg.len());
        let part = [head.as_bytes(), jpeg.as_ref(), b"\r\n"].concat();
        Some((Ok::<_, Infallible>(Bytes::from(part)), viewer))
    });
    let kind = "multipart/x-mixed-replace; boundary=picture";
    ([(header::CONTENT_TYPE, kind)], Body::from_stream(parts)).into_response()
}

/// The body of `/helm`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Helm {
    thrust: f64,
    rudder: f64,
}

async fn helm(State(state): State<Arc<RouteState>>, body: Bytes) -> Response {
    let Some(Helm { thrust, rudder }) = serde_json::from_slice(&body)
        .ok()
        .filter(|helm: &Helm| [helm.thrust, helm.rudder].iter().all(|share| (-1.0..=1.0).contains(share)))
    else {
        return bad_request("{\"thrust\": -1..1, \"rudder\": -1..1}\n");
    };
    let percent = |share: f64| (share * 100.0).round() as i8;
    queue_input(&state, DriveInput::Helm { thrust: percent(thrust), rudder: percent(rudder) })
}

async fn operator_input(State(state): State<Arc<RouteState>>, body: Bytes) -> Response {
    match serde_json::from_slice(&body) {
        Ok(DriveInput::Helm { .. }) | Err(_) => {
            bad_request("{\"input\": \"engage\"}, or stop, pause, resume, helmsman\n")
        }
        Ok(input) => queue_input(&state, input),
    }
}

fn bad_request(expected: &str) -> Response {
    (StatusCode::BAD_REQUEST, format!("expected {expected}")).into_response()
}

fn queue_input(state: &RouteState, input: DriveInput) -> Response {
    if state.page.queue_input(input) {
        StatusCode::NO_CONTENT.into_response()
    } else {
        (StatusCode::SERVICE_UNAVAILABLE, "input queue full; retry\n").into_response()
    }
}
