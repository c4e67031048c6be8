//! The other end: a Sigma as its API document describes it, for the emulator and the tests. Who controls,
//! what turns until when, and what is refused. Where the document is silent, the stricter reading holds:
//! commands need the control.

use core::time::Duration;

use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use serde_json::{Value, json};

use super::call::Call;
use super::json::CameraInfo;
use crate::http::HttpCall as _;

/// The control lapses when it is not asked for again.
pub const CONTROL_LAPSES: Duration = Duration::from_secs(10);
/// A wish for the control lapses.
pub const WISH_LAPSES: Duration = Duration::from_secs(60);

/// What does not change during a run.
#[derive(Debug, Clone, PartialEq)]
pub struct SigmaSettings {
    /// The token that permits reading and control.
    pub token: String,
    /// A token that permits reading alone.
    pub read_token: String,
    /// The API key that a token is given for.
    pub api_key: String,
    /// Limits of the camera.
    pub camera: CameraInfo,
    /// Address of the video.
    pub rtsp_url: Option<String>,
    /// Horizontal field of view, degrees.
    pub field_of_view_deg: f64,
}

impl SigmaSettings {
    /// The examples of the API document.
    pub fn example() -> Self {
        Self {
            token: "token".to_owned(),
            read_token: "read".to_owned(),
            api_key: "key".to_owned(),
            camera: CameraInfo {
                pan_speed_min: 2.0,
                pan_speed_max: 25.0,
                tilt_speed_min: 2.0,
                tilt_speed_max: 25.0,
            },
            rtsp_url: None,
            field_of_view_deg: 60.0,
        }
    }
}

/// A request as it arrives.
#[derive(Debug, Clone, Copy)]
pub struct Incoming<'a> {
    /// `GET` or `POST`.
    pub method: &'a str,
    /// The path below the base address.
    pub path: &'a str,
    /// The token of the header `Authorization: Bearer`.
    pub token: Option<&'a str>,
    /// The body.
    pub body: &'a [u8],
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// The status of HTTP.
    pub status: u16,
    /// The body, JSON.
    pub body: String,
}

/// Where the camera points, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct View {
    /// Clockwise.
    pub pan_ned: f64,
    /// Downwards.
    pub tilt_ned: f64,
}

/// Who has the control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Client {
    Own { until: Timestamp },
    Other,
}

/// Smallest and largest level of the zoom, and its speed: the change of the level's logarithm in a second.
const MIN_ZOOM: f64 = 1.0;
const MAX_ZOOM: f64 = 32.0;
const ZOOM_PER_S: f64 = 0.3;

/// A Sigma.
#[derive(Debug, Clone)]
pub struct Sigma {
    settings: SigmaSettings,
    control: Option<Client>,
    wish_until: Option<Timestamp>,
    turning: Option<(VehicleRates, Timestamp)>,
    zoom: EmulatedZoom,
    flight_state: &'static str,
    is_ready: bool,
    has_expired: bool,
    shown: String,
    refusals: u64,
}

impl Sigma {
    /// A Sigma that flies; no client controls it.
    pub const fn new(settings: SigmaSettings) -> Self {
        Self {
            settings,
            control: None,
            wish_until: None,
            turning: None,
            zoom: EmulatedZoom { level: MIN_ZOOM, target: MIN_ZOOM, at: Timestamp::ZERO },
            flight_state: "Flying",
            is_ready: true,
            has_expired: false,
            shown: String::new(),
            refusals: 0,
        }
    }

    /// Another client takes the control. What it turned the camera with is not emulated: the camera rests.
    pub fn other_client_takes(&mut self) {
        (self.control, self.turning) = (Some(Client::Other), None);
    }

    /// The other client gives the control up. The one that waits gets it.
    pub fn other_client_releases(&mut self, now: Timestamp) {
        if self.control == Some(Client::Other) {
            let waits = self.wish_until.take().is_some_and(|until| now < until);
            self.control = waits.then(|| Client::Own { until: now.plus(CONTROL_LAPSES) });
        }
    }

    /// The service starts again: the control is forgotten, and nothing turns the camera.
    pub fn restart(&mut self) {
        (self.control, self.wish_until, self.turning) = (None, None, None);
    }

    /// Sets the state of the flight, as the API names it.
    pub fn set_flight_state(&mut self, state: &'static str) {
        self.flight_state = state;
    }

    /// Whether the service is ready: it answers 503 otherwise.
    pub fn set_ready(&mut self, is_ready: bool) {
        self.is_ready = is_ready;
    }

    /// Whether the tokens have expired.
    pub fn set_expired(&mut self, has_expired: bool) {
        self.has_expired = has_expired;
    }

    /// What the tablet shows of the client.
    pub fn shown(&self) -> &str {
        &self.shown
    }

    /// How many requests were refused as unusable or unknown.
    pub const fn refusals(&self) -> u64 {
        self.refusals
    }

    /// Whether the client of this API has the control.
    pub fn is_controlled(&self, now: Timestamp) -> bool {
        matches!(self.control, Some(Client::Own { until }) if now < until)
    }

    /// The rates that turn the camera, in the vehicle's own signs.
    pub fn rates(&self, now: Timestamp) -> VehicleRates {
        let turning = self.turning.filter(|(_, until)| now < *until);
        turning.map_or(VehicleRates::REST, |(rates, _)| rates).zooming(self.zoom.speed(now))
    }

    /// Answers a call as it arrives from a client with this token.
    pub fn answer_call(&mut self, call: &Call, token: &str, view: View, now: Timestamp) -> Answer {
        let (path, body) = (call.path(), call.body().unwrap_or_default());
        let (method, token, body) = (call.method().name(), Some(token), body.as_bytes());
        self.answer(Incoming { method, path: &path, token, body }, view, now)
    }

    /// Answers a request.
    pub fn answer(&mut self, request: Incoming<'_>, view: View, now: Timestamp) -> Answer {
        if let Some(Client::Own { until }) = self.control
            && until <= now
        {
            self.control = None;
        }
        let answer = self.route(request, view, now).unwrap_or_else(|refused| refused);
        self.refusals += u64::from(matches!(answer.status, 400 | 404 | 405));
        answer
    }

    fn route(&mut self, request: Incoming<'_>, view: View, now: Timestamp) -> Result<Answer, Answer> {
        let route = (request.method, request.path);
        match route {
            ("GET", "/health" | "/v1/health") => {
                return Ok(ok(json!({ "status": "OK", "api_version": "1.1.2" })));
            }
            ("POST", "/v1/auth/token/request") => return self.give_token(request.body),
            _ => {}
        }
        self.admit(request)?;
        match route {
            ("GET", "/v1/camera/info") => Ok(ok(self.camera_info())),
            ("GET", "/v1/camera/state") => Ok(ok(Self::camera_state(view))),
            ("GET", "/v1/flight/state") => {
                Ok(ok(json!({ "flight_state": self.flight_state, "altitude": 10.0 })))
            }
            ("GET", "/v1/system/state") => {
                Ok(ok(json!({ "kite_battery_level": 90.0, "gs_battery_level": 95.0 })))
            }
            ("GET", "/v1/notifications/state") => Ok(ok(json!([]))),
            ("GET", "/v1/videostreams") => Ok(ok(self.video_streams())),
            ("GET", "/v1/videostreams/zoom/state") => {
                let level = self.zoom.level(now);
                let half = (0.5 * self.settings.field_of_view_deg).to_radians();
                let field_of_view = 2.0 * libm::atan(libm::tan(half) / level).to_degrees();
                Ok(ok(json!({
                    "stream_id": "zoom", "is_streaming": true, "fov_horizontal": field_of_view, "zoom_level": level,
                })))
            }
            ("POST", "/v1/videostreams/zoom/control/zoom") => self.start_zooming(request.body, now),
            ("GET", "/v1/handoff/state") => Ok(ok(self.handoff_state())),
            ("POST", "/v1/auth/plugin/update") => {
                let body = object(request.body)?;
                let text = body["self_status_text"].as_str().unwrap_or_default();
                if text.chars().count() > 160 {
                    return Err(error(400, "the text is too long"));
                }
                text.clone_into(&mut self.shown);
                Ok(no_content())
            }
            ("POST", "/v1/handoff/control/request") => {
                let body = object(request.body)?;
                if body["operator_name"].as_str().is_none_or(str::is_empty) {
                    return Err(error(400, "operator_name is missing"));
                }
                Ok(self.hand_over(now))
            }
            ("POST", "/v1/handoff/control/release") => {
                if let Some(Client::Own { .. }) = self.control {
                    self.control = None;
                }
                self.wish_until = None;
                Ok(no_content())
            }
            ("POST", "/v1/camera/control/rotate_with_speed") => self.turn(request.body, now),
            _ => Err(error(404, "there is no such path here")),
        }
    }

    fn give_token(&self, body: &[u8]) -> Result<Answer, Answer> {
        let body = object(body)?;
        if body["grant_type"] != "client_credentials" {
            return Err(error(400, "grant_type"));
        }
        if body["client_secret"] != self.settings.api_key.as_str() {
            return Err(error(401, "the key is not known"));
        }
        Ok(ok(json!({ "id": "1", "scopes": ["read", "control"], "access_token": self.settings.token })))
    }

    fn admit(&self, request: Incoming<'_>) -> Result<(), Answer> {
        let is_control = request.method == "POST" && request.path != "/v1/auth/plugin/update";
        match request.token {
            _ if self.has_expired => Err(error(401, "the token has expired")),
            Some(token) if token == self.settings.token => Ok(()),
            Some(token) if token == self.settings.read_token && !is_control => Ok(()),
            Some(token) if token == self.settings.read_token => {
                Err(error(403, "the token has no scope control"))
            }
            _ => Err(error(401, "the token is not known")),
        }?;
        if self.is_ready { Ok(()) } else { Err(error(503, "the service is not ready")) }
    }

    fn camera_info(&self) -> Value {
        let CameraInfo { pan_speed_min, pan_speed_max, tilt_speed_min, tilt_speed_max } =
            self.settings.camera;
        json!({
            "model": "emulated", "pan_speed_min": pan_speed_min, "pan_speed_max": pan_speed_max,
            "tilt_speed_min": tilt_speed_min, "tilt_speed_max": tilt_speed_max,
            "tilt_min": -11, "tilt_max": 80, "roll_min": 0, "roll_max": 0,
        })
    }

    /// The state of the camera, as it is read and as the WebSocket tells it.
    pub fn camera_state(view: View) -> Value {
        json!({
            "online_state": "Online", "pan_ned": view.pan_ned, "tilt_ned": view.tilt_ned, "roll_ned": 0.0,
        })
    }

    fn video_streams(&self) -> Value {
        json!([{
            "stream_id": "zoom", "type": "Color", "frame_width": 1920, "frame_height": 1080, "zoom_min": MIN_ZOOM,
            "zoom_max": MAX_ZOOM, "codec": "H.264", "rtsp_url": self.settings.rtsp_url,
        }, {
            "stream_id": "thermal", "type": "Thermal", "frame_width": 320, "frame_height": 240, "codec": "H.264",
            "rtsp_url": self.settings.rtsp_url,
        }])
    }

    fn handoff_state(&self) -> Value {
        let controlling = match self.control {
            None => Value::Null,
            Some(Client::Own { .. }) => json!({ "plugin_id": "1", "operator_name": "Barrelman" }),
            Some(Client::Other) => json!({ "plugin_id": "2", "operator_name": "another client" }),
        };
        json!({ "controlling_client": controlling, "requesting_clients": [] })
    }

    fn hand_over(&mut self, now: Timestamp) -> Answer {
        if self.control == Some(Client::Other) {
            self.wish_until = Some(now.plus(WISH_LAPSES));
            return Answer { status: 202, body: "{}".to_owned() };
        }
        self.control = Some(Client::Own { until: now.plus(CONTROL_LAPSES) });
        Answer { status: 201, body: "{}".to_owned() }
    }

    fn start_zooming(&mut self, body: &[u8], now: Timestamp) -> Result<Answer, Answer> {
        if !self.is_controlled(now) {
            return Err(error(403, "another client controls, or nobody"));
        }
        let level =
            object(body)?["zoom_level"].as_f64().filter(|level| (MIN_ZOOM..=MAX_ZOOM).contains(level));
        let target = level.ok_or_else(|| error(400, "zoom_level"))?;
        self.zoom = EmulatedZoom { level: self.zoom.level(now), target, at: now };
        Ok(Answer { status: 202, body: "{}".to_owned() })
    }

    fn turn(&mut self, body: &[u8], now: Timestamp) -> Result<Answer, Answer> {
        if !self.is_controlled(now) {
            return Err(error(403, "another client controls, or nobody"));
        }
        if !matches!(self.flight_state, "Flying" | "StandBy") {
            return Err(error(409, "not in this flight state"));
        }
        let body = object(body)?;
        let CameraInfo { pan_speed_min, pan_speed_max, tilt_speed_min, tilt_speed_max } =
            self.settings.camera;
        let pan = speed(&body, "pan_speed", pan_speed_min, pan_speed_max)?;
        let tilt = speed(&body, "tilt_speed", tilt_speed_min, tilt_speed_max)?;
        let duration = body["duration"].as_f64().filter(|s| (0.1..=10.0).contains(s));
        let duration = duration.ok_or_else(|| error(400, "duration: 0.1 to 10 s"))?;
        let rates = VehicleRates::turning(pan, tilt);
        self.turning = (!rates.is_rest()).then(|| (rates, now.plus(Duration::from_secs_f64(duration))));
        Ok(Answer { status: 202, body: "{}".to_owned() })
    }
}

/// A zoom on its way to a level.
#[derive(Debug, Clone, Copy)]
struct EmulatedZoom {
    level: f64,
    target: f64,
    /// When it was at `level`.
    at: Timestamp,
}

impl EmulatedZoom {
    /// How far it still has to go, and how far it goes until then: logarithms of the level.
    fn way(&self, now: Timestamp) -> (f64, f64) {
        let way = libm::log(self.target / self.level);
        let gone = ZOOM_PER_S * now.since(self.at).as_secs_f64();
        (way, way.clamp(-gone, gone))
    }

    fn level(&self, now: Timestamp) -> f64 {
        let (_, gone) = self.way(now);
        self.level * libm::exp(gone)
    }

    /// -1 to 1 of its largest speed.
    fn speed(&self, now: Timestamp) -> f64 {
        let (way, gone) = self.way(now);
        if (way - gone).abs() < 1e-9 { 0.0 } else { way.signum() }
    }
}

fn speed(body: &Value, key: &str, least: f64, largest: f64) -> Result<AngularRate, Answer> {
    let speed = match &body[key] {
        Value::Null => 0.0,
        value => value.as_f64().ok_or_else(|| error(400, key))?,
    };
    if speed != 0.0 && !(least..=largest).contains(&speed.abs()) {
        return Err(error(400, &format!("{key}: 0, or {least} to {largest}")));
    }
    Ok(AngularRate::from_radians_per_second(speed.to_radians()))
}

fn object(body: &[u8]) -> Result<Value, Answer> {
    let value: Option<Value> = serde_json::from_slice(body).ok();
    value.filter(Value::is_object).ok_or_else(|| error(400, "the body is no JSON object"))
}

fn ok(body: Value) -> Answer {
    Answer { status: 200, body: body.to_string() }
}

fn no_content() -> Answer {
    Answer { status: 204, body: String::new() }
}

fn error(status: u16, message: &str) -> Answer {
    Answer { status, body: json!({ "code": status.to_string(), "message": message }).to_string() }
}
