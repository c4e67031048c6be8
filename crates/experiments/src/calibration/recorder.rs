//! What is recorded of the test motions, and what follows from it.

use barrelman_vision::{PatchShift, PictureMotion};
use barrelman_vocab::profile::{AxisDynamics, GimbalTilt, Sign, VehicleProfile};
use barrelman_vocab::telemetry::{Quaternion, Report};
use barrelman_vocab::{Angle, CameraCommand, PictureSize, Telemetry, TestMotions, Timestamp, VideoFrame};
use core::time::Duration;

use super::bars::BarSearch;
use super::fit::{AngleSample, AxisFit, CannotTell, RateStep, fit_axis, fit_rate};
use super::gimbal_reports::convention;
use super::speeds::MeasuredSpeeds;
use super::turns::Turn;
use barrelman_pilot::NUDGE_RATE_RAD_PER_S;
use barrelman_pilot::calibration::Schedule;

/// Records frames, commands and reports during the test motions.
pub struct CalibrationRecorder {
    focal_share: f64,
    motion: PictureMotion,
    bars: BarSearch,
    /// Sums of the turns so far.
    turned: Turn,
    epoch: u32,
    pans: Vec<AngleSample>,
    tilts: Vec<AngleSample>,
    pan_commands: Vec<RateStep>,
    tilt_commands: Vec<RateStep>,
    reports: Vec<(f64, Quaternion)>,
}

/// What the test motions tell.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationResult {
    /// Pan. The gain is negative where the camera turns the other way.
    pub pan: Result<MeasuredAxis, CannotTell>,
    /// Tilt.
    pub tilt: Result<MeasuredAxis, CannotTell>,
    /// Elevation of the camera's axis during the motions of the pan; `None` without them.
    pub elevation: Option<Angle>,
    /// How the gimbal's reports tell the tilt; `None`: there are none, or none that follow the tilt.
    pub gimbal_tilt: Option<GimbalTilt>,
}

/// The response of an axis, relative to the profile that was in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredAxis {
    /// Achieved rate divided by the commanded one; negative: the sign in the profile is wrong.
    pub gain: f64,
    /// Dead times and lag, seconds.
    pub start_dead_time_s: f64,
    /// The same of a stop.
    pub stop_dead_time_s: f64,
    /// Time constant.
    pub lag_s: f64,
}

impl CalibrationRecorder {
    /// A recorder for a camera of this focal length, as a share of the picture's width.
    pub fn new(focal_share: f64) -> Self {
        Self {
            focal_share,
            motion: PictureMotion::default(),
            bars: BarSearch::default(),
            turned: Turn::default(),
            epoch: 0,
            pans: Vec::new(),
            tilts: Vec::new(),
            pan_commands: Vec::new(),
            tilt_commands: Vec::new(),
            reports: Vec::new(),
        }
    }

    /// A video frame was captured.
    pub fn on_frame(&mut self, frame: &VideoFrame) {
        self.bars.add(&frame.picture);
        let shifts = self.motion.measure(&frame.picture);
        self.on_shifts(&shifts, frame.picture.size(), frame.capture.at);
    }

    /// A picture was captured, whose patches moved so.
    pub fn on_shifts(&mut self, shifts: &[Option<PatchShift>], size: PictureSize, captured: Timestamp) {
        let focal_px = self.focal_share * f64::from(size.width);
        match Turn::from_shifts(shifts, size, focal_px) {
            Some(turn) => {
                self.turned.pan_cos += turn.pan_cos;
                self.turned.pan_sin += turn.pan_sin;
                self.turned.tilt += turn.tilt;
            }
            None => self.epoch += 1,
        }
        let (at_s, epoch) = (captured.as_secs_f64(), self.epoch);
        let Turn { pan_cos, pan_sin, tilt } = self.turned;
        self.pans.push(AngleSample { at_s, epoch, angle: [pan_cos, pan_sin] });
        self.tilts.push(AngleSample { at_s, epoch, angle: [tilt, 0.0] });
    }

    /// A command left.
    pub fn on_command(&mut self, command: CameraCommand, at: Timestamp) {
        let at_s = at.as_secs_f64();
        for (steps, rate) in [(&mut self.pan_commands, command.pan), (&mut self.tilt_commands, command.tilt)]
        {
            let rate = rate.radians_per_second();
            let newest = steps.last().map_or(0.0, |step| step.rate);
            if rate.to_bits() != newest.to_bits() {
                steps.push(RateStep { at_s, rate });
            }
        }
    }

    /// The vehicle reported something.
    pub fn on_telemetry(&mut self, telemetry: &Telemetry) {
        if let Report::GimbalAttitude(attitude) = telemetry.report {
            self.reports.push((telemetry.at.as_secs_f64(), attitude));
        }
    }

    /// What short motions have told: how fast the axes turned at what was commanded as the low rate.
    pub fn speeds(&self) -> MeasuredSpeeds {
        let rate = |samples: &[AngleSample], commands: &[RateStep]| {
            let between = repetitions(commands, Schedule::of(TestMotions::Speed));
            fit_rate(samples, commands, &between).map(|fit| fit.gain() * NUDGE_RATE_RAD_PER_S)
        };
        if let Some(bars) = self.bars.found() {
            let refused = Err(CannotTell::Bars(bars));
            return MeasuredSpeeds { pan: refused, tilt: refused };
        }
        MeasuredSpeeds {
            pan: rate(&self.pans, &self.pan_commands),
            tilt: rate(&self.tilts, &self.tilt_commands),
        }
    }

    /// What long motions have told.
    pub fn result(&self) -> CalibrationResult {
        if let Some(bars) = self.bars.found() {
            let refused = Err(CannotTell::Bars(bars));
            return CalibrationResult { pan: refused, tilt: refused, elevation: None, gimbal_tilt: None };
        }
        let measured = |samples: &[AngleSample], commands: &[RateStep]| {
            fit_axis(samples, commands, &repetitions(commands, Schedule::of(TestMotions::Axes)))
        };
        let pan = measured(&self.pans, &self.pan_commands);
        let tilt = measured(&self.tilts, &self.tilt_commands);
        let elevation = pan.ok().map(|fit| elevation(&fit));
        let gimbal_tilt = elevation.and_then(|elevation| {
            // The tilt during the motions of the pan is that at their middle.
            let begins = self.pan_commands.first()?.at_s;
            let before = self.tilts.iter().find(|sample| sample.at_s >= begins)?.angle[0];
            let level =
                |sample: &AngleSample| AngleSample { angle: [sample.angle[0] - before, 0.0], ..*sample };
            let tilts: Vec<AngleSample> = self.tilts.iter().map(level).collect();
            convention(&self.reports, &tilts, elevation)
        });
        let measured = |fit: AxisFit, gain: f64| MeasuredAxis {
            gain,
            start_dead_time_s: fit.start_dead_time_s,
            stop_dead_time_s: fit.stop_dead_time_s,
            lag_s: fit.lag_s,
        };
        CalibrationResult {
            pan: pan.map(|fit| measured(fit, pan_sign(&fit) * fit.gain())),
            tilt: tilt.map(|fit| measured(fit, fit.gains[0])),
            elevation,
            gimbal_tilt,
        }
    }
}

/// The sense of the pan. The camera looks below the horizon, or little above it: looking down, the picture
/// turns about its centre.
fn pan_sign(fit: &AxisFit) -> f64 {
    let [cos, sin] = fit.gains;
    if cos.abs() > 0.3 * sin.abs() { cos.signum() } else { -sin.signum() }
}

/// The elevation that explains both shares of the pan.
fn elevation(fit: &AxisFit) -> Angle {
    let sign = pan_sign(fit);
    Angle::from_radians(libm::atan2(sign * fit.gains[1], sign * fit.gains[0]))
}

/// The times of the repetitions: to and fro.
fn repetitions(commands: &[RateStep], schedule: Schedule) -> Vec<(f64, f64)> {
    let Some(first) = commands.first() else { return Vec::new() };
    let lasts_s = 2.0 * schedule.part().as_secs_f64();
    let begin = |index: u32| first.at_s - 0.2 + f64::from(index) * lasts_s;
    (0..schedule.repetitions).map(|index| (begin(index), begin(index + 1))).collect()
}

impl CalibrationResult {
    /// Whether both axes are told.
    pub const fn is_complete(&self) -> bool {
        self.pan.is_ok() && self.tilt.is_ok()
    }

    /// The profile with what was measured; what cannot be told stays as it is.
    #[must_use]
    pub fn applied_to(&self, profile: &VehicleProfile) -> VehicleProfile {
        let mut profile = profile.clone();
        if let Ok(pan) = &self.pan {
            profile.signs.yaw = turned(profile.signs.yaw, pan.gain);
            pan.apply_to(&mut profile.camera.pan);
        }
        if let Ok(tilt) = &self.tilt {
            profile.signs.pitch = turned(profile.signs.pitch, tilt.gain);
            tilt.apply_to(&mut profile.camera.tilt);
        }
        if let Some(elevation) = self.elevation {
            profile.camera.initial_tilt = elevation;
        }
        profile.gimbal_tilt = self.gimbal_tilt.or(profile.gimbal_tilt);
        profile
    }
}

impl MeasuredAxis {
    fn apply_to(&self, axis: &mut AxisDynamics) {
        let duration = |seconds: f64| Duration::from_secs_f64(libm::round(seconds * 1e3) / 1e3);
        axis.gain = libm::round(axis.gain * self.gain.abs() * 1e4) / 1e4;
        axis.start_dead_time = duration(self.start_dead_time_s);
        // A stop that takes effect before a start would have is a fault of the measurement.
        axis.stop_dead_time = duration(self.stop_dead_time_s).max(axis.start_dead_time);
        axis.lag = duration(self.lag_s);
    }
}

fn turned(sign: Sign, gain: f64) -> Sign {
    match (sign, gain < 0.0) {
        (sign, false) => sign,
        (Sign::Same, true) => Sign::Opposite,
        (Sign::Opposite, true) => Sign::Same,
    }
}
