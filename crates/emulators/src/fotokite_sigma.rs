//! The emulated Fotokite Sigma: wire's [`Sigma`] behind a server of HTTP, a simulated camera mount, and the
//! faults.
//!
//! ```text
//! request -> fault -> Sigma (wire) -> answer
//!                       | rates
//!                       v
//!            camera mount, or the camera of a simulated world -> where the camera points
//! ```
//!
//! The server only carries requests; who controls, and what turns until when, is decided by [`Sigma`].

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, Method, Uri, header};
use axum::response::Response;
use axum::routing::get;
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_host::output::OutputFile;
use barrelman_vocab::{Timestamp, VehicleProfile};
use barrelman_wire::fotokite_sigma::Sigma;
pub use barrelman_wire::fotokite_sigma::sigma::SigmaSettings;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, View};

use super::http_log::{HttpLog, LoggedRequest};
use crate::camera_link::{CameraLink, Pointing};
use crate::http_server::{HttpServer, response};
use crate::moved_camera::MovedCamera;
use crate::shared_emulation::{MAX_BODY_BYTES, Shared, TICK};

/// The path before those of the API.
const BASE_PATH: &str = "/api";
/// Interval between the messages of the WebSocket.
const MESSAGE_INTERVAL: Duration = Duration::from_millis(100);

/// The faults that the emulator has.
pub const SIGMA_FAULTS: [FaultKind; 7] = [
    FaultKind::Takeover,
    FaultKind::Reboot,
    FaultKind::Hang,
    FaultKind::Silence,
    FaultKind::Delay,
    FaultKind::Corrupt,
    FaultKind::Expire,
];

/// What an emulated Sigma is made of.
pub struct EmulatedSigmaSettings {
    /// What the vehicle says and permits.
    pub sigma: SigmaSettings,
    /// Whether there is a WebSocket.
    pub has_websocket: bool,
    /// The simulated world whose camera the emulator moves.
    pub world: Option<CameraLink>,
    /// The faults.
    pub faults: FaultPlan,
    /// The file of the log.
    pub log: Option<OutputFile>,
    /// The clock.
    pub clock: Clock,
}

/// An emulated Sigma. Dropping it ends its server.
pub struct EmulatedSigma {
    shared: Arc<Shared<Emulation>>,
    server: HttpServer,
}

struct Emulation {
    sigma: Sigma,
    camera: MovedCamera,
    log: HttpLog,
    is_taken: bool,
    is_restarting: bool,
}

impl Emulation {
    fn view(&self) -> View {
        let Pointing { pan, tilt, .. } = self.camera.pointing();
        let turns = (pan.degrees() / 360.0).round();
        View { pan_ned: pan.degrees() - turns * 360.0, tilt_ned: -tilt.degrees() }
    }

    /// Applies the rates that are in force now.
    fn apply_rates(&mut self, now: Timestamp) -> Result<()> {
        let rates = self.sigma.rates(now);
        if self.camera.turn(rates) { self.log.on_rates(now, rates) } else { Ok(()) }
    }
}

impl EmulatedSigma {
    /// Starts the server.
    ///
    /// # Errors
    /// If the address cannot be used, or the system has no more threads.
    pub fn start(address: SocketAddr, settings: EmulatedSigmaSettings) -> Result<Self> {
        let EmulatedSigmaSettings { sigma, has_websocket, world, faults, log, clock } = settings;
        let state = Emulation {
            sigma: Sigma::new(sigma),
            camera: MovedCamera::at_rest(VehicleProfile::fotokite_sigma(), world),
            log: HttpLog::new(log, clock),
            is_taken: false,
            is_restarting: false,
        };
        let shared = Arc::new(Shared::new(state, faults, clock));
        let server = HttpServer::start(address, "sigma", |_| router(Arc::clone(&shared), has_websocket))?;
        Ok(Self { shared, server })
    }

    /// The base address, for `--link`.
    pub fn url(&self) -> String {
        format!("http://{}{BASE_PATH}", self.server.address())
    }

    /// Whether other machines can reach the server.
    pub fn is_public(&self) -> bool {
        !self.server.address().ip().is_loopback()
    }

    /// Ends motions and applies faults until `is_ended` returns true.
    ///
    /// # Errors
    /// If the log cannot be written.
    pub fn run(&self, mut is_ended: impl FnMut() -> bool) -> Result<()> {
        let shared = &self.shared;
        let started = shared.clock.now();
        while !is_ended() {
            std::thread::sleep(TICK);
            let now = shared.clock.now();
            let (is_taken, is_restarting) =
                (shared.is_active(FaultKind::Takeover), shared.is_active(FaultKind::Reboot));
            let has_expired = shared.is_active(FaultKind::Expire);
            let mut state = shared.state();
            match (std::mem::replace(&mut state.is_taken, is_taken), is_taken) {
                (false, true) => state.sigma.other_client_takes(),
                (true, false) => state.sigma.other_client_releases(now),
                _ => {}
            }
            if is_restarting && !state.is_restarting {
                state.sigma.restart();
            }
            state.is_restarting = is_restarting;
            state.sigma.set_ready(!is_restarting);
            state.sigma.set_expired(has_expired);
            state.camera.advance_to(now.since(started));
            state.apply_rates(now)?;
        }
        Ok(())
    }
}

fn router(shared: Arc<Shared<Emulation>>, has_websocket: bool) -> Router {
    let router = Router::new();
    let subscribe = format!("{BASE_PATH}/v1/camera/state/subscribe");
    let router = if has_websocket { router.route(&subscribe, get(on_subscribe)) } else { router };
    router.fallback(on_request).layer(DefaultBodyLimit::max(MAX_BODY_BYTES)).with_state(shared)
}

fn token_of(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::AUTHORIZATION)?.to_str().ok()?.strip_prefix("Bearer ")
}

async fn on_request(
    State(shared): State<Arc<Shared<Emulation>>>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    shared.way_there().await;
    let answer = {
        let now = shared.clock.now();
        let mut state = shared.state();
        let view = state.view();
        let path = uri.path().strip_prefix(BASE_PATH).unwrap_or(uri.path());
        let incoming = Incoming { method: method.as_str(), path, token: token_of(&headers), body: &body };
        let answer = state.sigma.answer(incoming, view, now);
        // A request for a token holds the API key.
        let text = if path.contains("/token/") { "".into() } else { String::from_utf8_lossy(&body) };
        let logged = LoggedRequest { method: method.as_str(), path, body: &text };
        let logged = state.log.on_request(now, logged, answer.status);
        if let Err(error) = logged.and_then(|()| state.apply_rates(now)) {
            tracing::error!("the log cannot be written: {error:#}");
        }
        answer
    };
    response(answer.status, shared.way_back(answer.body, ['"', ':']).await)
}

async fn on_subscribe(
    State(shared): State<Arc<Shared<Emulation>>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let now = shared.clock.now();
    let status = {
        let mut state = shared.state();
        let view = state.view();
        // Admitted as the reading of the same state.
        let incoming =
            Incoming { method: "GET", path: "/v1/camera/state", token: token_of(&headers), body: &[] };
        state.sigma.answer(incoming, view, now).status
    };
    if status == 200 {
        return upgrade.on_upgrade(|socket| send_states(shared, socket));
    }
    response(status, String::new())
}

/// Sends the camera's state ten times a second, until the client is gone.
async fn send_states(shared: Arc<Shared<Emulation>>, mut socket: WebSocket) {
    loop {
        tokio::time::sleep(MESSAGE_INTERVAL).await;
        if [FaultKind::Hang, FaultKind::Silence].iter().any(|kind| shared.is_active(*kind)) {
            continue;
        }
        let state = Sigma::camera_state(shared.state().view()).to_string();
        if socket.send(Message::Text(state.into())).await.is_err() {
            return;
        }
    }
}
