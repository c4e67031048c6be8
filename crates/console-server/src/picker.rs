//! Lets the operator draw a box in one stored picture: a small server with the page `pick.html`, which ends
//! with the box.
//!
//! | request | answer |
//! |---|---|
//! | `GET /`, `GET /console/NAME` | the page |
//! | `GET /trust`, `GET /authority.pem`, `GET /authority.crt` | as of the console ([`super::https::trust`]) |
//! | `GET /api/v1/access`, `POST /api/v1/login` | as of the console ([`super::routes`]) |
//! | `GET /api/v1/frame` | the picture, JPEG |
//! | `POST /api/v1/selection` | takes `{"box": [left, top, width, height]}`; answers `{"console": LINK}`, the console that follows at the same address, or null |
//!
//! The same guard, tokens and headers as for the console hold. Nothing moves while the page is open.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result, anyhow};
use axum::Router;
use axum::extract::{DefaultBodyLimit, Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{get, post};
use barrelman_host::clock::Clock;
use barrelman_video::jpeg;
use barrelman_vocab::{Picture, PictureSize, PixelBox};
use bytes::Bytes;
use serde::Deserialize;
use serde_json::json;
use tokio::sync::oneshot;

use super::access::{Access, Role};
use super::admission::may_enter;
use super::files;
use super::guard::Hosts;
use super::https::Identity;
use super::https::trust;
use super::limits::MAX_MESSAGE_BYTES;
use super::links::{fingerprint, link_to_page, trust_lines};
use super::routes::{guarded, json_body};
use super::server::{Answering, runtime, serve};
use super::settings::ConsoleSettings;

/// How long the server stays after the box, so that its answer reaches the page.
const LAST_ANSWER: Duration = Duration::from_millis(250);

/// What the routes share.
struct Picker {
    access: Access,
    hosts: Hosts,
    https: Option<Arc<Identity>>,
    size: PictureSize,
    jpeg: Bytes,
    /// The link to the console that follows.
    console: Option<String>,
    picked: Mutex<Option<oneshot::Sender<PixelBox>>>,
}

/// What is served at the picker's address after the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AfterPicking {
    /// Nothing.
    Nothing,
    /// The console, with the same tokens.
    Console,
}

/// Serves the picture until a box is drawn. `announce` gets the page's address once the page can be opened:
/// with the token, unless the token is from a file.
///
/// # Errors
/// If the picture cannot be encoded, or the server not be started.
pub fn pick(
    settings: ConsoleSettings,
    picture: &Picture,
    after: AfterPicking,
    announce: impl FnOnce(&str),
) -> Result<PixelBox> {
    let clock = Clock::start();
    let (origin, entrance) = (settings.origin()?, settings.entrance(clock)?);
    let ConsoleSettings { listener, tokens, kept, https, .. } = settings;
    listener.set_nonblocking(true)?;
    let (sender, picked) = oneshot::channel();
    let control = tokens.get().map(|tokens| tokens.control);
    let link = link_to_page(origin, control.as_deref());
    let picker = Arc::new(Picker {
        access: entrance.access,
        hosts: entrance.hosts,
        https: entrance.https,
        size: picture.size(),
        jpeg: Bytes::from(jpeg::encode(picture).context("the frame cannot be shown in a browser")?),
        console: (after == AfterPicking::Console).then(|| link.clone()),
        picked: Mutex::new(Some(sender)),
    });
    let runtime = runtime().context("the page's server cannot be started")?;
    let shown = if kept.file.is_some() { link_to_page(origin, None) } else { link };
    announce(&shown);
    if let Some(fingerprint) = fingerprint(https.as_deref()) {
        tracing::info!("{}", trust_lines(origin, fingerprint).trim_end());
    }
    let answering = Answering { router: router(picker), https, clock };
    runtime.block_on(async {
        tokio::select! {
            served = serve(listener, answering) => {
                served.context("the page cannot be served")?;
                Err(anyhow!("the page's server has ended"))
            }
            picked = picked => {
                tokio::time::sleep(LAST_ANSWER).await;
                picked.map_err(|_| anyhow!("the page's server has ended"))
            }
        }
    })
}

fn router(picker: Arc<Picker>) -> Router {
    let trust = trust::routes(|picker: &Picker| picker.https.as_deref());
    let router = trust.into_iter().fold(Router::new(), |router, (path, at)| router.route(path, at));
    router
        .route("/", get(|| async { files::response("pick.html") }))
        .route("/console/{name}", get(|Path(name): Path<String>| async move { files::response(&name) }))
        .route("/api/v1/access", get(access))
        .route("/api/v1/login", post(login))
        .route("/api/v1/frame", get(frame))
        .route("/api/v1/selection", post(selection))
        .layer(DefaultBodyLimit::max(MAX_MESSAGE_BYTES))
        .layer(from_fn_with_state(Arc::clone(&picker), guard))
        .with_state(picker)
}

type Shared = State<Arc<Picker>>;

async fn guard(State(picker): Shared, request: Request, next: Next) -> Response {
    guarded(&picker.access, &picker.hosts, request, next).await
}

async fn access(State(picker): Shared, headers: HeaderMap) -> Response {
    match may_enter(&picker.access, &headers) {
        Ok(role) => {
            let body = json!({ "may_control": role == Role::Control }).to_string();
            ([(header::CONTENT_TYPE, "application/json")], body).into_response()
        }
        Err(response) => *response,
    }
}

async fn login(State(picker): Shared, headers: HeaderMap) -> Response {
    super::routes::log_in(&picker.access, &headers)
}

async fn frame(State(picker): Shared, headers: HeaderMap) -> Response {
    match may_enter(&picker.access, &headers) {
        Ok(_) => ([(header::CONTENT_TYPE, "image/jpeg")], picker.jpeg.clone()).into_response(),
        Err(response) => *response,
    }
}

/// A drawn box: left, top, width, height in pixels of the picture.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Selection {
    #[serde(rename = "box")]
    place: [f64; 4],
}

async fn selection(State(picker): Shared, request: Request) -> Response {
    match may_enter(&picker.access, request.headers()) {
        Ok(Role::Control) => {}
        Ok(Role::Watch) => {
            return (StatusCode::FORBIDDEN, "this token may only watch\n").into_response();
        }
        Err(response) => return *response,
    }
    let body = match json_body(request).await {
        Ok(body) => body,
        Err(response) => return *response,
    };
    let selection: Selection = match serde_json::from_slice(&body) {
        Ok(selection) => selection,
        Err(error) => {
            return (StatusCode::BAD_REQUEST, format!("the selection cannot be read: {error}\n"))
                .into_response();
        }
    };
    let [u, v, w, h] = selection.place.map(f64::round);
    let (width, height) = (f64::from(picker.size.width), f64::from(picker.size.height));
    let is_inside = u >= 0.0 && v >= 0.0 && w >= 1.0 && h >= 1.0 && u + w <= width && v + h <= height;
    if !is_inside {
        let text = format!("the box must lie within the {} picture\n", picker.size);
        return (StatusCode::BAD_REQUEST, text).into_response();
    }
    let sender = picker.picked.lock().unwrap_or_else(PoisonError::into_inner).take();
    match sender.map(|sender| sender.send(PixelBox { u, v, w, h })) {
        // The page has shown that it may control: the link tells it nothing new.
        Some(Ok(())) => {
            let body = json!({ "console": picker.console }).to_string();
            ([(header::CONTENT_TYPE, "application/json")], body).into_response()
        }
        _ => (StatusCode::CONFLICT, "a box was drawn already\n").into_response(),
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::{SocketAddr, TcpStream};
    use std::sync::mpsc::channel;

    use barrelman_vocab::video::ColourEncoding;

    use super::super::settings::ConsoleAddress;
    use super::super::tokens::KeptTokens;
    use super::*;

    /// The status and the body of an answer.
    fn ask(address: SocketAddr, method: &str, path: &str, host: &str, body: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(address).unwrap();
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Content-Length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let head = String::from_utf8_lossy(&answer);
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let start = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap() + 4;
        (status, answer[start..].to_vec())
    }

    #[test]
    fn the_box_that_is_drawn_is_the_selection() {
        let nothing = json!({ "console": null });
        assert_eq!(draw_a_box(AfterPicking::Nothing), (nothing, None));
        let (answer, link) = draw_a_box(AfterPicking::Console);
        assert_eq!(answer["console"].as_str(), link.as_deref());
        assert!(link.is_some());
    }

    /// Draws a box. Returns the answer to it, and the link that was announced where a console follows.
    fn draw_a_box(after: AfterPicking) -> (serde_json::Value, Option<String>) {
        let picture = Picture::black(PictureSize::new(64, 48), ColourEncoding::JPEG);
        let at = ConsoleAddress { listen: Some("127.0.0.1:0".parse().unwrap()), ..ConsoleAddress::default() };
        let settings = ConsoleSettings::without_tokens_on_loopback(at, KeptTokens::default()).unwrap();
        let address = settings.listener.local_addr().unwrap();
        let (sender, announced) = channel();
        let server = std::thread::spawn(move || {
            pick(settings, &picture, after, |link| sender.send(link.to_owned()).unwrap())
        });
        let own = address.to_string();
        let link = announced.recv().unwrap();
        assert_eq!(link, format!("http://{own}/"));
        let page = ask(address, "GET", "/", &own, "");
        assert!(page.0 == 200 && String::from_utf8_lossy(&page.1).contains("pick.js"));
        let frame = ask(address, "GET", "/api/v1/frame", &own, "");
        assert!(frame.0 == 200 && frame.1.starts_with(&[0xff, 0xd8]), "a JPEG file");
        assert_eq!(ask(address, "GET", "/", "evil.example", "").0, 403);
        for (body, status) in [
            ("{\"box\": [60, 10, 20, 20]}", 400),
            ("{\"box\": [10, 10, 0, 20]}", 400),
            ("{\"box\": [1, 2, 3]}", 400),
        ] {
            assert_eq!(ask(address, "POST", "/api/v1/selection", &own, body).0, status, "{body}");
        }
        let drawn = ask(address, "POST", "/api/v1/selection", &own, "{\"box\": [10.4, 9.6, 20, 20]}");
        assert_eq!(drawn.0, 200);
        assert_eq!(server.join().unwrap().unwrap(), PixelBox { u: 10.0, v: 10.0, w: 20.0, h: 20.0 });
        (serde_json::from_slice(&drawn.1).unwrap(), (after == AfterPicking::Console).then_some(link))
    }
}
