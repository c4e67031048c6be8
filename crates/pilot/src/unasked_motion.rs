//! Motion of the camera that nobody commands: a stop that did not arrive, or a camera that something else
//! turns.
//!
//! Zero is commanded, and the vehicle reports that its camera turns: the operator has to know at once, as the
//! zeros may not reach the camera at all. The camera of a command that has just ended turns on for its dead
//! time, and then slower and slower; only what is faster than that counts, and faster than what the signal
//! shows of a camera at rest:
//!
//! ```text
//!                    rate in force
//!   allowed rate  ------------------\ dead time            threshold of the window
//!                                    \____ lag ____-------------------------------
//! ```
//!
//! | vehicle | signal | a camera at rest shows |
//! |---|---|---|
//! | MAVLink gimbal | pan and tilt in the frame in which the gimbal holds them | the noise of its sensors: [`HELD`] |
//! | Fotokite Sigma | pan from north, tilt from the horizon | the sway of the kite: [`SWAYING`] |
//! | Fotokite Pro | yaw of the flight unit, attitude of the gimbal | the same |
//!
//! A sway goes to and fro: over six seconds little of it is left, so that a slow motion in one direction is
//! found, too. Nothing is judged while another client has the control, and of the signals with sway nothing
//! while the vehicle does not fly: it may be carried. What must not be here: anything that commands the
//! camera.

use core::time::Duration;
use std::collections::VecDeque;

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::profile::{CameraDynamics, MotionReports};
use barrelman_vocab::telemetry::{ControlState, EulerAxis, FlightState, LinkState, Quaternion, Report};
use barrelman_vocab::{AngularRate, CameraCommand, Telemetry, Timestamp, VehicleProfile};

/// From a command to the report of its effect, beside the camera's own dead time: the ways there and back.
const WAY: Duration = Duration::from_millis(100);
/// A camera may be slower to stop than its profile says by this share of its rate.
const SLACK: f64 = 0.1;
/// A camera that runs out also sways, mostly by less than the threshold: by this share of it.
const SWAY_SHARE: f64 = 1.0 / 3.0;
/// Attitudes are kept if they were reported at least this far apart.
const SPACING: Duration = Duration::from_millis(90);
/// Number of attitudes that are kept: of seven seconds.
const KEPT: usize = 80;
/// A turn slower than this, rad/s, over the shortest window is rest.
const REST_RAD_PER_S: f64 = 0.05;

/// A time over which a signal is compared, and the rate above which it shows motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Length.
    pub span: Duration,
    /// Threshold, rad/s.
    pub rad_per_s: f64,
}

/// Of a camera that is held still by its gimbal.
pub const HELD: [Window; 2] = [window(300, 0.05), window(1_000, 0.05)];
/// Of a camera that sways with its kite.
pub const SWAYING: [Window; 2] = [window(400, 0.15), window(6_000, 0.05)];

const fn window(ms: u64, rad_per_s: f64) -> Window {
    Window { span: Duration::from_millis(ms), rad_per_s }
}

/// The last motion that was commanded, as far as the camera may still make it.
#[derive(Debug, Clone, Copy)]
struct RunOut {
    dead_time: Duration,
    lag: Duration,
    /// The rate, rad/s, and until when it was in force.
    last: Option<(f64, Timestamp)>,
}

impl RunOut {
    fn new(camera: &CameraDynamics) -> Self {
        Self {
            dead_time: camera.pan.stop_dead_time.max(camera.tilt.stop_dead_time),
            lag: camera.pan.lag.max(camera.tilt.lag),
            last: None,
        }
    }

    /// The rate at which the camera may still turn at a time, rad/s.
    fn rate_at(&self, at: Timestamp) -> f64 {
        let Some((rate, until)) = self.last else { return 0.0 };
        let after = at.since(until).saturating_sub(self.dead_time.saturating_add(WAY));
        let lags = after.as_secs_f64() / self.lag.as_secs_f64().max(0.01);
        rate * (1.0 + SLACK) * libm::exp(-lags)
    }

    fn on_command(&mut self, rate: f64, now: Timestamp) {
        // An earlier, faster motion may last longer.
        if rate * (1.0 + SLACK) >= self.rate_at(now) {
            self.last = Some((rate, now));
        }
    }
}

/// The attitudes of the last seconds about one axis, and what they show.
#[derive(Debug, Clone)]
struct Turn {
    newest: VecDeque<(Timestamp, Quaternion)>,
    /// The rate that nobody commands, rad/s; 0: none.
    unasked_rad_per_s: f64,
}

impl Turn {
    fn new() -> Self {
        Self { newest: VecDeque::with_capacity(KEPT), unasked_rad_per_s: 0.0 }
    }

    fn forget(&mut self) {
        self.newest.clear();
        self.unasked_rad_per_s = 0.0;
    }

    /// Takes an attitude. Returns whether it is kept.
    fn on_attitude(&mut self, attitude: Quaternion, at: Timestamp) -> bool {
        match self.newest.back() {
            Some((last, _)) if at < *last => self.newest.clear(),
            Some((last, _)) if at.since(*last) < SPACING => return false,
            _ => {}
        }
        if self.newest.len() == KEPT {
            self.newest.pop_front();
        }
        self.newest.push_back((at, attitude));
        true
    }

    /// The rate over the last `span`, rad/s, and the time from which it counts. `None`: there is no attitude
    /// of that time.
    fn rate_over(&self, span: Duration) -> Option<(f64, Timestamp)> {
        let (at, attitude) = self.newest.back()?;
        let (from, before) = self.newest.iter().rev().find(|(from, _)| at.since(*from) >= span)?;
        let elapsed = at.since(*from);
        // After a gap the camera may have turned and come back.
        (elapsed <= span * 2).then(|| (before.angle_to(*attitude) / elapsed.as_secs_f64(), *from))
    }

    /// The slower rate of the last two steps, rad/s: a leap of the attitude, as at a restart, is one step.
    fn steady_rate(&self) -> f64 {
        let mut newest = self.newest.iter().rev().take(3);
        let (Some(third), Some(second), Some(first)) = (newest.next(), newest.next(), newest.next()) else {
            return 0.0;
        };
        let rate = |(from, before): &(Timestamp, Quaternion), (to, after): &(Timestamp, Quaternion)| {
            before.angle_to(*after) / to.since(*from).as_secs_f64().max(1e-3)
        };
        rate(first, second).min(rate(second, third))
    }
}

/// Compares what the vehicle reports with a command of zero.
#[derive(Debug, Clone)]
pub(crate) struct UnaskedMotion {
    reports: MotionReports,
    windows: [Window; 2],
    run_out: RunOut,
    pan: Turn,
    tilt: Turn,
    is_rest_commanded: bool,
    is_anothers: bool,
    is_flying: bool,
    turning: Option<AngularRate>,
}

impl UnaskedMotion {
    pub(crate) fn new(profile: &VehicleProfile) -> Self {
        let reports = profile.protocol.motion_reports();
        Self {
            reports,
            windows: if reports == MotionReports::Held { HELD } else { SWAYING },
            run_out: RunOut::new(&profile.camera),
            pan: Turn::new(),
            tilt: Turn::new(),
            is_rest_commanded: true,
            is_anothers: false,
            is_flying: true,
            turning: None,
        }
    }

    /// The rate of a camera that turns although zero is commanded.
    pub(crate) const fn turning(&self) -> Option<AngularRate> {
        self.turning
    }

    /// A command is in force from now on.
    pub(crate) fn on_command(&mut self, command: CameraCommand, now: Timestamp) {
        // A camera that zooms shows a turn as one that rests does.
        self.is_rest_commanded = command.pan.is_zero() && command.tilt.is_zero();
        if !self.is_rest_commanded {
            let (pan, tilt) =
                (command.pan.radians_per_second().abs(), command.tilt.radians_per_second().abs());
            self.run_out.on_command(pan.max(tilt), now);
            (self.pan.unasked_rad_per_s, self.tilt.unasked_rad_per_s) = (0.0, 0.0);
            self.turning = None;
        }
    }

    /// Takes a report.
    pub(crate) fn on_telemetry(&mut self, telemetry: &Telemetry) {
        let at = telemetry.at;
        match (telemetry.report, self.reports) {
            (Report::Link(LinkState::Opening), _) => self.forget(),
            (Report::Control { control, .. } | Report::Ground { control, .. }, _) => {
                self.excuse(control == ControlState::Elsewhere);
            }
            (Report::Acceptance(said), _) => {
                self.excuse(said.is_elsewhere() || said == Acceptance::FlightState);
            }
            (Report::Flight { state, .. } | Report::FlightState { state, .. }, _) => {
                self.is_flying = state == FlightState::Flying;
            }
            (Report::CameraPan(pan), MotionReports::Held | MotionReports::Swaying) => {
                self.on_pan(Quaternion::about(EulerAxis::Z, pan), at);
            }
            (Report::CameraTilt(tilt), MotionReports::Held | MotionReports::Swaying) => {
                self.on_tilt(Quaternion::about(EulerAxis::Y, tilt), at);
            }
            (Report::VehicleAttitude(attitude), MotionReports::Attitudes) => {
                if let Some(yaw) = attitude.angle_about(EulerAxis::Z) {
                    self.on_pan(Quaternion::about(EulerAxis::Z, yaw), at);
                }
            }
            (Report::GimbalAttitude(attitude), MotionReports::Attitudes) => self.on_tilt(attitude, at),
            _ => {}
        }
    }

    /// Another client may turn the camera as it wishes.
    fn excuse(&mut self, is_anothers: bool) {
        self.is_anothers = is_anothers;
        if is_anothers {
            self.forget();
            self.turning = None;
        }
    }

    fn forget(&mut self) {
        self.pan.forget();
        self.tilt.forget();
    }

    fn on_pan(&mut self, attitude: Quaternion, at: Timestamp) {
        if self.pan.on_attitude(attitude, at) {
            self.pan.unasked_rad_per_s = self.unasked(&self.pan);
            self.judge();
        }
    }

    fn on_tilt(&mut self, attitude: Quaternion, at: Timestamp) {
        if self.tilt.on_attitude(attitude, at) {
            self.tilt.unasked_rad_per_s = self.unasked(&self.tilt);
            self.judge();
        }
    }

    fn judge(&mut self) {
        let is_carried = self.reports != MotionReports::Held && !self.is_flying;
        if !self.is_rest_commanded || self.is_anothers || is_carried {
            self.turning = None;
            return;
        }
        let fastest = self.pan.unasked_rad_per_s.max(self.tilt.unasked_rad_per_s);
        if fastest > 0.0 {
            self.turning = Some(AngularRate::from_radians_per_second(fastest));
        } else if self.turning.is_some() && self.is_at_rest(&self.pan) && self.is_at_rest(&self.tilt) {
            // The windows begin anew: they still hold the motion that has ended.
            self.forget();
            self.turning = None;
        }
    }

    /// The rate of an axis that turns faster than it may, rad/s; 0: it does not.
    fn unasked(&self, turn: &Turn) -> f64 {
        let exceeds = |window: &Window| {
            let (rate, from) = turn.rate_over(window.span)?;
            let is_steady = turn.steady_rate() > window.rad_per_s / 2.0;
            let allowed = window.rad_per_s.max(self.run_out.rate_at(from) + SWAY_SHARE * window.rad_per_s);
            (is_steady && rate > allowed).then_some(rate)
        };
        self.windows.iter().filter_map(exceeds).fold(0.0, f64::max)
    }

    /// Whether an axis rests. One that is not reported does not count.
    fn is_at_rest(&self, turn: &Turn) -> bool {
        let rate = turn.rate_over(self.windows[0].span);
        turn.newest.is_empty() || rate.is_some_and(|(rate, _)| rate <= REST_RAD_PER_S)
    }
}
