//! The HTTP routes of the console.
//!
//! | request | answer | needs |
//! |---|---|---|
//! | `GET /` | the page | |
//! | `GET /console/NAME` | a file of the page | |
//! | `GET /healthz` | `ok` | |
//! | `GET /api/v1/access` | what the token permits | token |
//! | `POST /api/v1/login` | a cookie for the token of the page's link | token |
//! | `GET /api/v1/status` | [`super::api::StatusSnapshot`] | token |
//! | `POST /api/v1/requests` | takes [`RequestBody`], answers [`Answer`] | token |
//! | `GET /api/v1/socket` | the socket of a page ([`super::socket`]) | token |
//! | `GET /metrics` | metrics for Prometheus | token |
//!
//! Each request is judged by [`super::guard`]. No other file is served.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, FromRequest as _, Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use bytes::Bytes;
use serde::Serialize;

use super::access::{Access, Role};
use super::api::{Answer, RequestBody};
use super::files;
use super::guard::{Hosts, Provenance};
use super::limits::{BODY_TIMEOUT, MAX_MESSAGE_BYTES};
use super::metrics::metrics_text;
use super::requests::{Requester, answer, begin_request};
use super::shared::Console;
use super::socket;
use super::status::status_of;

type Shared = State<Arc<Console>>;

/// Headers of every answer.
const SECURITY_HEADERS: [(HeaderName, &str); 6] = [
    (header::CACHE_CONTROL, "no-cache"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
];

/// The router of all routes.
pub(super) fn router(console: Arc<Console>) -> Router {
    Router::new()
        .route("/", get(|| async { files::response("index.html") }))
        .route("/console/{name}", get(|Path(name): Path<String>| async move { files::response(&name) }))
        .route("/healthz", get(|| async { "ok\n" }))
        .route("/api/v1/access", get(access))
        .route("/api/v1/login", post(login))
        .route("/api/v1/status", get(status))
        .route("/api/v1/requests", post(requests))
        .route("/api/v1/socket", get(open_socket))
        .route("/metrics", get(metrics))
        .layer(DefaultBodyLimit::max(MAX_MESSAGE_BYTES))
        .layer(from_fn_with_state(Arc::clone(&console), guard))
        .with_state(console)
}

/// Refuses requests of foreign pages, and sets the security headers of all answers.
async fn guard(State(console): Shared, request: Request, next: Next) -> Response {
    guarded(&console.hosts, request, next).await
}

/// The answer of `next` with the security headers, or the refusal of a foreign page's request.
pub(super) async fn guarded(hosts: &Hosts, request: Request, next: Next) -> Response {
    let mut response = match hosts.refusal(provenance(&request)) {
        Some(reason) => (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response(),
        None => next.run(request).await,
    };
    for (name, value) in SECURITY_HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

fn provenance(request: &Request) -> Provenance<'_> {
    let text = |name: &str| text_of(request.headers(), name);
    let is_navigation =
        text("sec-fetch-mode") == Some("navigate") && text("sec-fetch-dest") == Some("document");
    Provenance {
        host: text("host"),
        origin: text("origin"),
        fetch_site: text("sec-fetch-site"),
        opens_page: request.method() == Method::GET && request.uri().path() == "/" && is_navigation,
    }
}

/// What a request may do; an answer with 401 where it may do nothing.
fn role_of(console: &Console, headers: &HeaderMap) -> Result<Role, Box<Response>> {
    may_enter(&console.access, headers)
}

/// What the token or the cookie of a request permits; an answer with 401 where it permits nothing.
pub(super) fn may_enter(access: &Access, headers: &HeaderMap) -> Result<Role, Box<Response>> {
    access.role(text_of(headers, header::AUTHORIZATION), text_of(headers, header::COOKIE)).ok_or_else(refused)
}

/// The text of a header; `None` where it is missing, or no text.
fn text_of(headers: &HeaderMap, name: impl header::AsHeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// The answer to a request that nothing is permitted to.
fn refused() -> Box<Response> {
    let body = "a token is needed: open the link that the program printed, or send `Authorization: Bearer`\n";
    Box::new((StatusCode::UNAUTHORIZED, [(header::WWW_AUTHENTICATE, "Bearer")], body).into_response())
}

fn json(value: &impl Serialize) -> Response {
    match serde_json::to_vec(value) {
        Ok(body) => ([(header::CONTENT_TYPE, "application/json")], Body::from(body)).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, format!("{error}\n")).into_response(),
    }
}

#[derive(Serialize)]
struct AccessBody {
    may_control: bool,
}

async fn access(State(console): Shared, headers: HeaderMap) -> Response {
    match role_of(&console, &headers) {
        Ok(role) => json(&AccessBody { may_control: role == Role::Control }),
        Err(response) => *response,
    }
}

async fn login(State(console): Shared, headers: HeaderMap) -> Response {
    log_in(&console.access, &headers)
}

/// A cookie for the token of a request.
pub(super) fn log_in(access: &Access, headers: &HeaderMap) -> Response {
    // A token that is not known is said so, whatever the cookie permits.
    let role = match (access.tokens(), text_of(headers, header::AUTHORIZATION)) {
        (Some(_), Some(token)) => access.bearer_role(token).ok_or_else(refused),
        _ => may_enter(access, headers),
    };
    let role = match role {
        Ok(role) => role,
        Err(response) => return *response,
    };
    // The watch link, opened in the operator's own browser, does not take the control from the pages that are open there.
    if role == Role::Watch && access.role(None, text_of(headers, header::COOKIE)) == Some(Role::Control) {
        return StatusCode::NO_CONTENT.into_response();
    }
    match access.new_cookie(role) {
        Ok(cookie) => (StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response(),
        Err(error) => {
            (StatusCode::INTERNAL_SERVER_ERROR, format!("no random numbers: {error}\n")).into_response()
        }
    }
}

async fn status(State(console): Shared, headers: HeaderMap) -> Response {
    match role_of(&console, &headers) {
        Ok(_) => json(&status_of(&console.snapshots.borrow(), console.relay.has_h264())),
        Err(response) => *response,
    }
}

async fn metrics(State(console): Shared, headers: HeaderMap) -> Response {
    if let Err(response) = role_of(&console, &headers) {
        return *response;
    }
    let status = status_of(&console.snapshots.borrow(), console.relay.has_h264());
    let clients = console.with_seats(|seats| seats.state().clients.len());
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], metrics_text(&status, clients)).into_response()
}

/// Requires a body of JSON: a page of another origin can send text without asking first, but not JSON.
fn require_json(headers: &HeaderMap) -> Result<(), Box<Response>> {
    let kind = text_of(headers, header::CONTENT_TYPE).unwrap_or_default();
    if kind.starts_with("application/json") {
        return Ok(());
    }
    let text = "send Content-Type: application/json\n";
    Err(Box::new((StatusCode::UNSUPPORTED_MEDIA_TYPE, text).into_response()))
}

/// The JSON text of a request, which must come in time. The caller has checked before who makes the request.
pub(super) async fn json_body(request: Request) -> Result<Bytes, Box<Response>> {
    require_json(request.headers())?;
    body_within(request, BODY_TIMEOUT).await
}

/// The body of a request. A body that is too long or too slow ends the connection with an answer.
async fn body_within(request: Request, limit: Duration) -> Result<Bytes, Box<Response>> {
    match tokio::time::timeout(limit, Bytes::from_request(request, &())).await {
        Ok(body) => body.map_err(|rejection| Box::new(rejection.into_response())),
        Err(_) => {
            let (close, text) = ([(header::CONNECTION, "close")], "the body did not come in time\n");
            Err(Box::new((StatusCode::REQUEST_TIMEOUT, close, text).into_response()))
        }
    }
}

async fn requests(State(console): Shared, request: Request) -> Response {
    let role = match role_of(&console, request.headers()) {
        Ok(role) => role,
        Err(response) => return *response,
    };
    let body = match json_body(request).await {
        Ok(body) => body,
        Err(response) => return *response,
    };
    let body: RequestBody = match serde_json::from_slice(&body) {
        Ok(body) => body,
        Err(error) => {
            let text = format!("the request cannot be read: {error}; see `barrelman config api`\n");
            return (StatusCode::BAD_REQUEST, text).into_response();
        }
    };
    let pending = begin_request(&console, Requester { role, client: None }, body.request);
    let (answer, reason) = answer(&console, pending).await;
    json(&Answer { id: body.id, answer, reason })
}

async fn open_socket(
    State(console): Shared,
    headers: HeaderMap,
    uri: Uri,
    upgrade: WebSocketUpgrade,
) -> Response {
    let role = match role_of(&console, &headers) {
        Ok(role) => role,
        Err(response) => return *response,
    };
    let pairs = uri.query().unwrap_or_default().split('&').filter_map(|pair| pair.split_once('='));
    // The page's own name, which a reload keeps.
    let name = pairs.filter(|(key, _)| *key == "client").map(|(_, value)| value).next().unwrap_or_default();
    let name: String = name.chars().filter(char::is_ascii_hexdigit).take(32).collect();
    upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES)
        .on_upgrade(move |socket| socket::serve(console, socket, role, name))
}

#[cfg(test)]
mod tests;
