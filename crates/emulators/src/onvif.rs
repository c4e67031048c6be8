//! The emulated ONVIF camera: wire's [`PtzCamera`] behind a server of HTTP, a simulated camera mount, and the
//! faults.
//!
//! ```text
//! request -> fault -> PtzCamera (wire) -> answer
//!                       | velocity
//!                       v
//!            its speeds -> rates -> camera mount, or the camera of a simulated world -> position
//! ```

use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::Result;
use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::response::Response;
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_host::output::OutputFile;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve, SpeedPoint};
use barrelman_vocab::{AngularRate, Timestamp, VehicleProfile, VehicleRates};
pub use barrelman_wire::onvif::{CameraFaults, CameraSettings, FullSpeeds};
use barrelman_wire::onvif::{PtzCamera, SpeedShares};

use crate::camera_link::CameraLink;
use crate::digest;
use crate::http_log::{HttpLog, LoggedRequest};
use crate::http_server::{HttpServer, response};
use crate::moved_camera::MovedCamera;
use crate::shared_emulation::{MAX_BODY_BYTES, Shared, TICK};

/// The faults that the emulator has.
pub const ONVIF_FAULTS: [FaultKind; 6] = [
    FaultKind::Reboot,
    FaultKind::Hang,
    FaultKind::Silence,
    FaultKind::Delay,
    FaultKind::Corrupt,
    FaultKind::Expire,
];

/// What an emulated camera is made of.
pub struct EmulatedCameraSettings {
    /// What the camera says and permits. Its base address is that of the server.
    pub camera: CameraSettings,
    /// What it does wrong all the time.
    pub habits: CameraFaults,
    /// How fast it turns at its speeds.
    pub speeds: AxisSpeeds,
    /// Whether it asks for HTTP's digest, and does not read the proof in the message.
    pub wants_http_digest: bool,
    /// The simulated world whose camera the emulator moves.
    pub world: Option<CameraLink>,
    /// The faults.
    pub faults: FaultPlan,
    /// The file of the log.
    pub log: Option<OutputFile>,
    /// The clock.
    pub clock: Clock,
}

/// The speeds of a camera with a dead zone, whose rate rises faster than its speed.
pub fn example_speeds() -> AxisSpeeds {
    let points = |turns: f64| {
        let point = |(speed, rate): (f64, f64)| SpeedPoint {
            speed,
            rate: AngularRate::from_radians_per_second(rate * turns),
        };
        let points = [(0.05, 0.02), (0.2, 0.1), (0.5, 0.3), (0.8, 0.7), (1.0, 1.2)].map(point).to_vec();
        SpeedCurve::new(points).expect("speeds and rates rise")
    };
    AxisSpeeds { pan: points(1.0), tilt: points(0.8) }
}

/// An emulated camera. Dropping it ends its server.
pub struct EmulatedCamera {
    shared: Arc<Shared<Emulation>>,
    server: HttpServer,
}

struct Emulation {
    ptz: PtzCamera,
    habits: CameraFaults,
    wants_http_digest: bool,
    speeds: AxisSpeeds,
    camera: MovedCamera,
    log: HttpLog,
    is_restarting: bool,
}

impl Emulation {
    /// Where its motors have turned it, -1 to 1: half a turn, and a quarter.
    fn position(&self) -> (f64, f64) {
        let (pan, tilt) = self.camera.mount_angles();
        let turns = (pan.degrees() / 360.0).round();
        (pan.degrees() / 180.0 - 2.0 * turns, tilt.degrees() / 90.0)
    }

    /// Turns as the camera's velocity is now.
    fn apply_velocity(&mut self, now: Timestamp) -> Result<()> {
        let SpeedShares { pan, tilt, zoom } = self.ptz.velocity(now);
        let rates =
            VehicleRates::turning(self.speeds.pan.rate_at(pan), self.speeds.tilt.rate_at(tilt)).zooming(zoom);
        if self.camera.turn(rates) { self.log.on_rates(now, rates) } else { Ok(()) }
    }
}

impl EmulatedCamera {
    /// Starts the server.
    ///
    /// # Errors
    /// If the address cannot be used, or the system has no more threads.
    pub fn start(address: SocketAddr, settings: EmulatedCameraSettings) -> Result<Self> {
        let EmulatedCameraSettings { camera, habits, speeds, wants_http_digest, world, faults, log, clock } =
            settings;
        let mut shared = None;
        let server = HttpServer::start(address, "onvif", |address| {
            let mut ptz = PtzCamera::new(CameraSettings { base: format!("http://{address}"), ..camera });
            ptz.set_faults(habits);
            let state = Emulation {
                ptz,
                habits,
                wants_http_digest,
                speeds,
                camera: MovedCamera::at_rest(VehicleProfile::onvif_ptz(), world),
                log: HttpLog::new(log, clock),
                is_restarting: false,
            };
            let made = Arc::new(Shared::new(state, faults, clock));
            router(Arc::clone(shared.insert(made)))
        })?;
        let shared = shared.expect("a server that started has made its router");
        Ok(Self { shared, server })
    }

    /// The address, for `--link`.
    pub fn url(&self) -> String {
        format!("onvif://{}", self.server.address())
    }

    /// Whether other machines can reach the server.
    pub const fn is_public(&self) -> bool {
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
            let is_restarting = shared.is_active(FaultKind::Reboot);
            let refuses_login = shared.is_active(FaultKind::Expire);
            let mut state = shared.state();
            let habits = state.habits;
            state
                .ptz
                .set_faults(CameraFaults { refuses_login: habits.refuses_login || refuses_login, ..habits });
            if is_restarting && !state.is_restarting {
                state.ptz.restart();
            }
            state.is_restarting = is_restarting;
            state.camera.advance_to(now.since(started));
            state.apply_velocity(now)?;
        }
        Ok(())
    }
}

fn router(shared: Arc<Shared<Emulation>>) -> Router {
    Router::new().fallback(on_request).layer(DefaultBodyLimit::max(MAX_BODY_BYTES)).with_state(shared)
}

async fn on_request(
    State(shared): State<Arc<Shared<Emulation>>>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    shared.way_there().await;
    if shared.is_active(FaultKind::Reboot) {
        return response(503, String::new());
    }
    let answer = {
        let now = shared.clock.now();
        let mut state = shared.state();
        let proof = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        let is_proved = state.ptz.login().is_some_and(|login| {
            proof.is_some_and(|proof| digest::proves(proof, login, method.as_str(), uri.path()))
        });
        let text = String::from_utf8_lossy(&body);
        let asks_time = text.contains("GetSystemDateAndTime");
        if state.wants_http_digest && state.ptz.login().is_some() && !is_proved && !asks_time {
            return unauthorised();
        }
        let position = state.position();
        let answer = state.ptz.answer(&body, position, is_proved, now);
        // What proves who asks is in the header of the message.
        let asked = text.split_once("Body>").map_or("", |(_, asked)| asked);
        let logged = LoggedRequest { method: method.as_str(), path: uri.path(), body: asked };
        let logged = state.log.on_request(now, logged, answer.status);
        if let Err(error) = logged.and_then(|()| state.apply_velocity(now)) {
            tracing::error!("the log cannot be written: {error:#}");
        }
        answer
    };
    response(answer.status, shared.way_back(answer.body, ['<', '"']).await)
}

fn unauthorised() -> Response {
    let mut refusal = response(401, String::new());
    if let Ok(challenge) = HeaderValue::from_str(&digest::challenge()) {
        refusal.headers_mut().insert(header::WWW_AUTHENTICATE, challenge);
    }
    // As many cameras do, which take the proof on a new connection.
    refusal.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    refusal
}
