//! Motion against the command: the picture turns the other way than the camera was told to.
//!
//! The usual cause is a wrong sign in the vehicle profile: the camera then turns away from the target, faster
//! and faster. The tracker measures the shift of the background between two video frames; the camera model
//! tells, from the commands and their dead times and lags, which part of a shift each axis makes. Two
//! hypotheses are compared for each axis: the axis makes no shift, or it makes the opposite one. With the
//! measured shift m, the predicted shifts s of the axis and o of the other axis, and a variance v of what
//! turns the camera besides the commands,
//!
//! ```text
//!   log likelihood ratio = (|m - o|^2 - |m - o + s|^2) / (2 v),     v = (sway x focal length)^2 x interval + noise^2
//! ```
//! The sum of the ratios, never below zero, is a CUSUM test (Page, Biometrika 41, 1954). Sway that happens to
//! look like the opposite motion is rare: with a camera that turns as it was told, the sum passes
//! [`EVIDENCE`] with a probability of about exp(-3 x EVIDENCE) in one motion. A camera that does not turn at
//! all gives no evidence.
//!
//! The noise of this test is that of a windy day, so that it takes its time. Where the picture was calm while
//! the camera rested ([`crate::sway_estimate`]), a second test needs [`OPPOSED_FOR`] alone: in each frame of
//! that time the picture turned by more than half of the predicted rate the other way, and by more than
//! [`CALM_FACTOR`] times the sway.
//!
//! Not handled: rates below [`LEAST_RATE`], a picture without a background that can be registered, and a
//! vehicle that is carried by the wind faster than it is told to turn.

use core::time::Duration;

use barrelman_control::{CameraModel, camera_model::SWAY_RAD_PER_ROOT_S};
use barrelman_vision::BackgroundShift;
use barrelman_vocab::{PictureSize, StopCause, Timestamp};

use crate::sway_estimate::SwayEstimate;

/// Evidence that stops the camera.
const EVIDENCE: f64 = 5.0;
/// The shortest time of opposite motion that stops the camera.
const OPPOSED_FOR: Duration = Duration::from_millis(300);
/// Standard deviation of a measured shift, pixels, and of a predicted one, as a share of the shift.
const SHIFT_NOISE_PX: f64 = 1.5;
const PREDICTION_ERROR: f64 = 0.3;
/// Predicted rates below this say nothing, rad/s.
const LEAST_RATE: f64 = 0.05;
/// The axis must have turned in the predicted direction for this time: dead times and lags differ from the
/// profile.
const STEADY_FOR: Duration = Duration::from_millis(200);
/// The second test: least predicted rate, rad/s, and least opposite rate as a multiple of the sway's standard
/// deviation.
const CALM_LEAST_RATE: f64 = 0.15;
const CALM_FACTOR: f64 = 4.0;
/// Both axes together turn slower than this where the camera rests, rad/s.
const REST_RATE: f64 = 0.002;
/// Frames that lie further apart are not compared.
const MAX_INTERVAL: Duration = Duration::from_millis(250);
/// Time constant in which evidence is forgotten, seconds.
const FORGETTING_S: f64 = 5.0;

/// The evidence of both axes.
#[derive(Debug, Clone, Default)]
pub(crate) struct OpposedMotion {
    pan: AxisEvidence,
    tilt: AxisEvidence,
    sway: SwayEstimate,
}

#[derive(Debug, Clone, Copy, Default)]
struct AxisEvidence {
    sum: f64,
    /// Time of opposite motion since the sum was zero, seconds.
    opposed_s: f64,
    /// Time of opposite motion without a break, by the second test, seconds.
    unbroken_s: f64,
}

impl AxisEvidence {
    fn add(&mut self, ratio: f64, interval_s: f64) {
        if !ratio.is_finite() {
            return;
        }
        self.sum = (self.sum * libm::exp(-interval_s / FORGETTING_S) + ratio).max(0.0);
        if self.sum == 0.0 {
            self.opposed_s = 0.0;
        } else if ratio > 0.0 {
            self.opposed_s += interval_s;
        }
    }

    fn add_unbroken(&mut self, is_opposed: bool, interval_s: f64) {
        self.unbroken_s = if is_opposed { self.unbroken_s + interval_s } else { 0.0 };
    }

    fn is_opposed(self) -> bool {
        let opposed_for = OPPOSED_FOR.as_secs_f64();
        (self.sum >= EVIDENCE && self.opposed_s >= opposed_for) || self.unbroken_s >= opposed_for
    }
}

/// The shift of the background between two video frames.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrameShift {
    pub(crate) shift: BackgroundShift,
    pub(crate) picture: PictureSize,
    /// Times of capture.
    pub(crate) from: Timestamp,
    pub(crate) to: Timestamp,
}

impl FrameShift {
    /// The time between the frames; `None`: too long, or none.
    fn interval(&self) -> Option<Duration> {
        let interval = self.to.since(self.from);
        (!interval.is_zero() && interval <= MAX_INTERVAL).then_some(interval)
    }
}

impl OpposedMotion {
    /// Takes a measured shift, whether or not the camera may move: a camera that rests shows the sway.
    pub(crate) fn observe_rest(&mut self, seen: &FrameShift, camera: &CameraModel) {
        let Some(interval) = seen.interval() else { return };
        let rates = [camera.rates_at(seen.from), camera.rates_at(seen.to)];
        if rates.iter().all(|(pan, tilt)| pan.abs() + tilt.abs() < REST_RATE) {
            let focal_px = camera.focal_px(seen.to, seen.picture);
            self.sway.add([seen.shift.u_px / focal_px, seen.shift.v_px / focal_px], interval);
        }
    }

    /// Takes a measured shift. Returns why the camera must stop.
    pub(crate) fn add(&mut self, seen: &FrameShift, camera: &CameraModel) -> Option<StopCause> {
        let interval = seen.interval()?;
        let point = seen.shift.centre.in_image(seen.picture);
        let [by_pan, by_tilt] = camera.shifts_by_axis(point, seen.from, seen.to, seen.picture)?;
        let measured = [seen.shift.u_px, -seen.shift.v_px];
        let interval_s = interval.as_secs_f64();
        let focal_px = camera.focal_px(seen.to, seen.picture);
        let sway_px = SWAY_RAD_PER_ROOT_S * focal_px;
        let predicted_px = libm::hypot(by_pan[0] + by_tilt[0], by_pan[1] + by_tilt[1]);
        let noise_px = libm::hypot(SHIFT_NOISE_PX, PREDICTION_ERROR * predicted_px);
        let variance = sway_px * sway_px * interval_s + noise_px * noise_px;
        let ratio = |own: [f64; 2], other: [f64; 2]| {
            let rest = [measured[0] - other[0], measured[1] - other[1]];
            let opposed = [rest[0] + own[0], rest[1] + own[1]];
            (square(rest) - square(opposed)) / (2.0 * variance)
        };
        let (pan_turns, tilt_turns) = steady_axes(camera, seen);
        self.pan.add(if pan_turns { ratio(by_pan, by_tilt) } else { 0.0 }, interval_s);
        self.tilt.add(if tilt_turns { ratio(by_tilt, by_pan) } else { 0.0 }, interval_s);
        if let Some(sway) = self.sway.rate_rad_per_s() {
            let per_s = focal_px * interval_s;
            let is_opposed = |own: [f64; 2], other: [f64; 2]| {
                let predicted = libm::hypot(own[0], own[1]);
                let along = (measured[0] - other[0]) * own[0] + (measured[1] - other[1]) * own[1];
                let opposite = -along / predicted / per_s;
                predicted >= CALM_LEAST_RATE * per_s
                    && opposite > (0.5 * predicted / per_s).max(CALM_FACTOR * sway)
            };
            self.pan.add_unbroken(pan_turns && is_opposed(by_pan, by_tilt), interval_s);
            self.tilt.add_unbroken(tilt_turns && is_opposed(by_tilt, by_pan), interval_s);
        }
        if self.pan.is_opposed() {
            Some(StopCause::PanOpposed)
        } else {
            self.tilt.is_opposed().then_some(StopCause::TiltOpposed)
        }
    }

    /// Forgets the evidence, and keeps what is known of the sway.
    pub(crate) fn clear(&mut self) {
        (self.pan, self.tilt) = Default::default();
    }
}

fn square([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}

/// Whether pan and tilt turn steadily by the model, fast enough to be told from sway.
fn steady_axes(camera: &CameraModel, seen: &FrameShift) -> (bool, bool) {
    let (pan, tilt) = camera.rates_at(seen.to);
    let (pan_before, tilt_before) = camera.rates_at(seen.from.minus(STEADY_FOR));
    let is_steady =
        |now: f64, before: f64| now.abs() >= LEAST_RATE && before.abs() >= LEAST_RATE && now * before > 0.0;
    (is_steady(pan, pan_before), is_steady(tilt, tilt_before))
}
