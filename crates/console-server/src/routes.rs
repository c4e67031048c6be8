//! The HTTP routes of the console.
//!
//! | request | answer | needs |
//! |---|---|---|
//! | `GET /` | the page | |
//! | `GET /console/NAME` | a file of the page | |
//! | `GET /help`, `GET /help/NAME` | the operator's manual, and its pictures | |
//! | `GET /trust`, `GET /authority.pem`, `GET /authority.crt` | the certificate authority ([`super::https::trust`]) | |
//! | `GET /healthz` | `ok` | |
//! | `GET /api/v1/access` | what the token permits | token |
//! | `POST /api/v1/login` | a cookie for the token of the page's link | token |
//! | `GET /api/v1/status` | [`super::api::StatusSnapshot`] | token |
//! | `GET /api/v1/picture.jpg` | the newest picture; `?overlay=true`: with box, ellipse and mode | token |
//! | `GET /api/v1/control` | [`super::api::ControlSeat`] | token |
//! | `POST /api/v1/requests` | takes [`RequestBody`], answers [`Answer`] | token |
//! | `GET /api/v1/socket` | the socket of a page ([`super::socket`]) | token |
//! | `GET /metrics` | metrics for Prometheus | token |
//!
//! Those of the recordings are in [`super::library::routes`], those of the links in [`super::link_routes`],
//! those of the map in [`super::map::routes`]. Each request is judged by [`super::guard`]. No other file is
//! served. A test compares the routes with the OpenAPI document (`super::api::schema`).

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, FromRequest as _, Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use bytes::Bytes;
use schemars::JsonSchema;
use serde::Serialize;

use barrelman_vocab::{self as vocab, OperatorRequest};

use super::access::{Access, Role};
use super::admission::{Route, json, may_enter, pass_of, refused, role_shown, text_of};
use super::api::{Answer, RequestBody};
use super::files;
use super::guard::{Hosts, Provenance};
use super::https::trust;
use super::library;
use super::limits::{BODY_TIMEOUT, MAX_MESSAGE_BYTES, SOCKET_REQUESTS};
use super::link_routes;
use super::manual;
use super::map;
use super::metrics::metrics_text;
use super::picture_answer;
use super::places::Place;
use super::requests::{Requester, answer, begin_request};
use super::shared::Console;
use super::socket;
use super::upgrade::upgrade;

type Shared = State<Arc<Console>>;

/// Where requests go. A Stop among too many of them is taken.
const REQUESTS_PATH: &str = "/api/v1/requests";
const SOCKET_PATH: &str = "/api/v1/socket";
/// Headers of which one may come: of two, two readers may take different ones.
static SINGLE_HEADERS: [HeaderName; 7] = [
    header::HOST,
    header::ORIGIN,
    header::AUTHORIZATION,
    header::CONTENT_TYPE,
    HeaderName::from_static("sec-fetch-site"),
    HeaderName::from_static("sec-fetch-mode"),
    HeaderName::from_static("sec-fetch-dest"),
];

/// A request beyond the limit, of which only a Stop is taken.
#[derive(Debug, Clone, Copy)]
struct BeyondLimit;

/// Headers of every answer.
const SECURITY_HEADERS: [(HeaderName, &str); 6] = [
    (header::CACHE_CONTROL, "no-cache"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; media-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
];

/// All routes.
fn routes() -> Vec<Route> {
    let mut routes = vec![
        ("/", get(|| async { files::response("index.html") })),
        ("/console/{name}", get(|Path(name): Path<String>| async move { files::response(&name) })),
        ("/help", get(|| async { manual::response() })),
        ("/help/{name}", get(|Path(name): Path<String>| async move { manual::picture(&name) })),
        ("/healthz", get(|| async { "ok\n" })),
        ("/api/v1/access", get(access)),
        ("/api/v1/login", post(login)),
        ("/api/v1/status", get(status)),
        ("/api/v1/picture.jpg", get(picture)),
        ("/api/v1/control", get(control)),
        (REQUESTS_PATH, post(requests)),
        (SOCKET_PATH, get(open_socket)),
        ("/metrics", get(metrics)),
    ];
    routes.extend(trust::routes(|console: &Console| console.https.as_deref()));
    routes.extend(link_routes::routes());
    routes.extend(library::routes::routes());
    routes.extend(map::routes::routes());
    routes
}

/// The router of all routes.
pub(super) fn router(console: Arc<Console>) -> Router {
    let router = routes().into_iter().fold(Router::new(), |router, (path, at)| router.route(path, at));
    router
        .layer(DefaultBodyLimit::max(MAX_MESSAGE_BYTES))
        .layer(from_fn_with_state(Arc::clone(&console), guard))
        .with_state(console)
}

/// Refuses requests of foreign pages and too many requests, and sets the security headers of all answers.
async fn guard(State(console): Shared, request: Request, next: Next) -> Response {
    guarded(&console.access, &console.hosts, request, next).await
}

/// The answer of `next` with the security headers, or the refusal of a request that is ambiguous, of a
/// foreign page, or one of too many.
pub(super) async fn guarded(access: &Access, hosts: &Hosts, mut request: Request, next: Next) -> Response {
    let mut response = match admit(access, hosts, &mut request) {
        Ok(()) => {
            // One request of a connection, then the others have their turn. Who has shown a token keeps the
            // place meanwhile.
            tokio::task::yield_now().await;
            next.run(request).await
        }
        Err(response) => *response,
    };
    for (name, value) in SECURITY_HEADERS {
        // A route may be stricter about what is kept.
        let is_stricter = name == header::CACHE_CONTROL && response.headers().contains_key(&name);
        if !is_stricter {
            response.headers_mut().insert(name, HeaderValue::from_static(value));
        }
    }
    response
}

/// Judges the head of a request.
fn admit(access: &Access, hosts: &Hosts, request: &mut Request) -> Result<(), Box<Response>> {
    let refusal = |status, text: String| Err(Box::new((status, text).into_response()));
    if let Some(name) = ambiguous_header(request.headers()) {
        return refusal(StatusCode::BAD_REQUEST, format!("send the header {name} once, as plain text\n"));
    }
    if let Some(reason) = hosts.refusal(provenance(request)) {
        return refusal(StatusCode::FORBIDDEN, format!("{reason}\n"));
    }
    let (place, now) = (request.extensions().get::<Arc<Place>>(), access.clock().now());
    let is_permitted = match (role_shown(access, request.headers()), place) {
        (Some(role), place) => {
            if let Some(place) = place {
                place.show(role);
            }
            let weight = if request.uri().path() == SOCKET_PATH { SOCKET_REQUESTS } else { 1.0 };
            access.permits_request(role, weight, now)
        }
        (None, Some(place)) => place.permits_request(now),
        (None, None) => true,
    };
    if is_permitted {
        return Ok(());
    }
    if request.method() == Method::POST && request.uri().path() == REQUESTS_PATH {
        request.extensions_mut().insert(BeyondLimit);
        return Ok(());
    }
    Err(too_many())
}

/// A header that comes more than once, or is no text.
fn ambiguous_header(headers: &HeaderMap) -> Option<&'static HeaderName> {
    SINGLE_HEADERS.iter().find(|name| {
        let mut values = headers.get_all(*name).iter();
        let is_text = values.next().is_none_or(|value| value.to_str().is_ok());
        !is_text || values.next().is_some()
    })
}

/// The answer to a request beyond the limit. The connection ends.
fn too_many() -> Box<Response> {
    let close = [(header::CONNECTION, "close"), (header::RETRY_AFTER, "1")];
    Box::new(
        (StatusCode::TOO_MANY_REQUESTS, close, "too many requests; retry after a second\n").into_response(),
    )
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

/// What a token permits.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Access")]
pub(super) struct AccessBody {
    /// Whether the token permits more than watching and stopping.
    may_control: bool,
    /// Whether a stop is taken. With the status 401: a renewal by age has ended the page's cookie, which may
    /// stop and nothing else.
    may_stop: bool,
}

async fn access(State(console): Shared, headers: HeaderMap) -> Response {
    match may_enter(&console.access, &headers) {
        Ok(role) => json(&AccessBody { may_control: role == Role::Control, may_stop: true }),
        Err(_) if console.access.may_still_stop(text_of(&headers, header::COOKIE)) => {
            let body = json(&AccessBody { may_control: false, may_stop: true });
            (StatusCode::UNAUTHORIZED, body).into_response()
        }
        Err(response) => *response,
    }
}

async fn login(State(console): Shared, headers: HeaderMap) -> Response {
    log_in(&console.access, &headers)
}

/// A cookie for the token of a request.
pub(super) fn log_in(access: &Access, headers: &HeaderMap) -> Response {
    // A token that is not known is said so, whatever the cookie permits.
    let role = match text_of(headers, header::AUTHORIZATION) {
        Some(token) if access.asks_for_tokens() => access.bearer_role(token).ok_or_else(refused),
        _ => may_enter(access, headers),
    };
    let role = match role {
        Ok(role) => role,
        Err(response) => return *response,
    };
    // The watch link, opened in the operator's own browser, does not take the control from the pages that are
    // open there.
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
    match may_enter(&console.access, &headers) {
        Ok(role) => {
            console.hear_program(role);
            json(&console.status())
        }
        Err(response) => *response,
    }
}

/// Who controls, for programs: pages are told on their sockets.
async fn control(State(console): Shared, headers: HeaderMap) -> Response {
    match may_enter(&console.access, &headers) {
        Ok(_) => json(&console.with_seats(|seats| seats.state())),
        Err(response) => *response,
    }
}

async fn picture(State(console): Shared, request: Request) -> Response {
    match may_enter(&console.access, request.headers()) {
        Ok(_) => picture_answer::picture(&console, request.uri().query()).await,
        Err(response) => *response,
    }
}

async fn metrics(State(console): Shared, headers: HeaderMap) -> Response {
    if let Err(response) = may_enter(&console.access, &headers) {
        return *response;
    }
    let status = console.status();
    let clients = console.with_seats(|seats| seats.state().clients.len());
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], metrics_text(&status, clients)).into_response()
}

/// Requires a body of JSON: a page of another origin can send text without asking first, but not JSON.
fn require_json(headers: &HeaderMap) -> Result<(), Box<Response>> {
    let kind = text_of(headers, header::CONTENT_TYPE).unwrap_or_default();
    // Parameters may follow, such as the character set.
    let kind = kind.split(';').next().unwrap_or_default().trim();
    if kind.eq_ignore_ascii_case("application/json") {
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
    let is_beyond_limit = request.extensions().get::<BeyondLimit>().is_some();
    let cookies = text_of(request.headers(), header::COOKIE);
    let role = match may_enter(&console.access, request.headers()) {
        Ok(role) => Some(role),
        Err(_) if console.access.may_still_stop(cookies) => None,
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
    let is_stop = matches!(body.request, vocab::Request::Operator(OperatorRequest::Stop(_)));
    if is_beyond_limit && !is_stop {
        return *too_many();
    }
    let Some(role) = role.or(is_stop.then_some(Role::Watch)) else { return *refused() };
    let pending = begin_request(&console, Requester { role, client: None, stops_taken: None }, body.request);
    let (answer, reason) = answer(&console, pending).await;
    let mut response = json(&Answer { id: body.id, answer, reason });
    if is_beyond_limit {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

async fn open_socket(State(console): Shared, request: Request) -> Response {
    let pass = match pass_of(&console.access, request.headers()) {
        Ok(pass) => pass,
        Err(response) => return *response,
    };
    let place = request.extensions().get::<Arc<Place>>().cloned();
    let query = request.uri().query().unwrap_or_default();
    let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    // The page's own name, which a reload keeps.
    let name = pairs.filter(|(key, _)| *key == "client").map(|(_, value)| value).next().unwrap_or_default();
    let name: String = name.chars().filter(char::is_ascii_hexdigit).take(32).collect();
    upgrade(request, move |stream| socket::serve(console, stream, pass, name, place))
}

#[cfg(test)]
mod tests;
