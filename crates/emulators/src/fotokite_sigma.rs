//! The emulated Fotokite Sigma: wire's [`Sigma`] behind a server of HTTP, a simulated camera mount, and the faults.
//!
//! ```text
//! request -> fault -> Sigma (wire) -> answer
//!                       | rates
//!                       v
//!            camera mount, or the camera of a simulated world -> where the camera points
//! ```
//!
//! The server only carries requests; who controls, and what turns until when, is decided by [`Sigma`].

use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::response::Response;
use axum::routing::get;
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_host::output::OutputFile;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{CameraMount, MountPlant};
use barrelman_vocab::{Angle, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_sigma::Sigma;
pub use barrelman_wire::fotokite_sigma::sigma::SigmaSettings;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, View};
use tokio::sync::oneshot;

use super::sigma_log::SigmaLog;
use crate::camera_link::{CameraLink, Pointing};

/// The path before those of the API.
const BASE_PATH: &str = "/api";
/// Interval of the ticks that end motions, and of the log.
const TICK: Duration = Duration::from_millis(5);
/// Interval between the messages of the WebSocket.
const MESSAGE_INTERVAL: Duration = Duration::from_millis(100);
/// Delay of answers while the fault `delay` is active.
const FAULT_DELAY: Duration = Duration::from_millis(400);
/// Interval at which a request that hangs looks whether the fault is over.
const FAULT_LOOK: Duration = Duration::from_millis(20);
/// Depression of the camera at the start.
const START_DEPRESSION: Angle = Angle::from_degrees(24.0);
/// Height of the camera without a world, metres.
const START_HEIGHT_M: f64 = 10.0;
/// Largest body of a request, bytes.
const MAX_BODY_BYTES: usize = 16 << 10;

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
    shared: Arc<Shared>,
    address: SocketAddr,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    state: Mutex<Emulation>,
    faults: FaultPlan,
    has_websocket: bool,
    clock: Clock,
}

struct Emulation {
    sigma: Sigma,
    mount: CameraMount,
    world: Option<CameraLink>,
    profile: VehicleProfile,
    log: SigmaLog,
    commanded: VehicleRates,
    is_taken: bool,
    is_restarting: bool,
}

impl Emulation {
    fn pointing(&self) -> Pointing {
        let (pan, tilt) = (self.mount.pan.angle(), self.mount.tilt.angle());
        let own = Pointing { pan, tilt, height_m: START_HEIGHT_M };
        self.world.as_ref().and_then(CameraLink::pointing).unwrap_or(own)
    }

    fn view(&self) -> View {
        let Pointing { pan, tilt, .. } = self.pointing();
        let turns = (pan.degrees() / 360.0).round();
        View { pan_ned: pan.degrees() - turns * 360.0, tilt_ned: -tilt.degrees() }
    }

    /// Applies the rates that are in force now.
    fn apply_rates(&mut self, now: Timestamp) -> Result<()> {
        let rates = self.sigma.rates(now);
        if rates == self.commanded {
            return Ok(());
        }
        self.commanded = rates;
        self.mount.command(self.profile.from_vehicle(rates));
        if let Some(world) = &self.world {
            world.send_latched(rates);
        }
        self.log.on_rates(now, rates)
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, Emulation> {
        // A panic of one request must not end the emulation.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_active(&self, kind: FaultKind) -> bool {
        self.faults.is_active(kind, self.clock.now())
    }
}

impl EmulatedSigma {
    /// Starts the server.
    ///
    /// # Errors
    /// If the address cannot be used, or the system has no more threads.
    pub fn start(address: SocketAddr, settings: EmulatedSigmaSettings) -> Result<Self> {
        let EmulatedSigmaSettings { sigma, has_websocket, world, faults, log, clock } = settings;
        let listener = TcpListener::bind(address).with_context(|| format!("cannot listen on {address}"))?;
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let state = Emulation {
            sigma: Sigma::new(sigma),
            mount: CameraMount::at_rest(MountPlant::laboratory(), START_DEPRESSION),
            world,
            profile: VehicleProfile::fotokite_sigma(),
            log: SigmaLog::new(log, clock),
            commanded: VehicleRates::REST,
            is_taken: false,
            is_restarting: false,
        };
        let shared = Arc::new(Shared { state: Mutex::new(state), faults, has_websocket, clock });
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (end, ended) = oneshot::channel::<()>();
        let router = router(Arc::clone(&shared));
        let thread = std::thread::Builder::new().name("sigma".to_owned()).spawn(move || {
            runtime.block_on(async {
                let served = async {
                    let listener = tokio::net::TcpListener::from_std(listener)?;
                    axum::serve(listener, router).await
                };
                tokio::select! {
                    served = served => {
                        if let Err(error) = served {
                            tracing::error!("the emulated vehicle cannot be served: {error}");
                        }
                    }
                    _ = ended => {}
                }
            });
        })?;
        Ok(Self { shared, address, end: Some(end), thread: Some(thread) })
    }

    /// The base address, for `--link`.
    pub fn url(&self) -> String {
        format!("http://{}{BASE_PATH}", self.address)
    }

    /// Whether other machines can reach the server.
    pub fn is_public(&self) -> bool {
        !self.address.ip().is_loopback()
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
            let target = (now.since(started).as_secs_f64() * f64::from(TICKS_PER_SECOND)) as u64;
            while state.mount.tick() < target {
                state.mount.advance();
            }
            state.apply_rates(now)?;
        }
        Ok(())
    }
}

impl Drop for EmulatedSigma {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn router(shared: Arc<Shared>) -> Router {
    let router = Router::new();
    let subscribe = format!("{BASE_PATH}/v1/camera/state/subscribe");
    let router = if shared.has_websocket { router.route(&subscribe, get(on_subscribe)) } else { router };
    router.fallback(on_request).layer(DefaultBodyLimit::max(MAX_BODY_BYTES)).with_state(shared)
}

fn token_of(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::AUTHORIZATION)?.to_str().ok()?.strip_prefix("Bearer ")
}

async fn on_request(
    State(shared): State<Arc<Shared>>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    while shared.is_active(FaultKind::Hang) {
        tokio::time::sleep(FAULT_LOOK).await;
    }
    let mut answer = {
        let now = shared.clock.now();
        let mut state = shared.state();
        let view = state.view();
        let path = uri.path().strip_prefix(BASE_PATH).unwrap_or(uri.path());
        let incoming = Incoming { method: method.as_str(), path, token: token_of(&headers), body: &body };
        let answer = state.sigma.answer(incoming, view, now);
        let logged = state.log.on_request(now, &incoming, answer.status);
        if let Err(error) = logged.and_then(|()| state.apply_rates(now)) {
            tracing::error!("the log cannot be written: {error:#}");
        }
        answer
    };
    while shared.is_active(FaultKind::Silence) {
        tokio::time::sleep(FAULT_LOOK).await;
    }
    if shared.is_active(FaultKind::Delay) {
        tokio::time::sleep(FAULT_DELAY).await;
    }
    if shared.is_active(FaultKind::Corrupt) {
        answer.body = answer.body.replace(['"', ':'], "#");
    }
    let status = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let mut response = Response::new(Body::from(answer.body));
    *response.status_mut() = status;
    response
}

async fn on_subscribe(
    State(shared): State<Arc<Shared>>,
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
    let mut response = Response::new(Body::empty());
    *response.status_mut() = StatusCode::from_u16(status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    response
}

/// Sends the camera's state ten times a second, until the client is gone.
async fn send_states(shared: Arc<Shared>, mut socket: WebSocket) {
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
