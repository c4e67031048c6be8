//! A model of the camera: its pointing at the time of capture of a picture, and its predicted pointing under
//! the commands that are in force.
//!
//! Each axis responds to a command after a dead time, with a first-order lag: `w' = (u - w)/lag`,
//! `angle' = w`. The dead time of a zero command may be longer than that of a non-zero command, as it is on
//! the recorded vehicle. A later command overrides an earlier one that has not taken effect by then. The
//! model therefore keeps the state at *now + start dead time*: it contains every command so far, except for
//! one zero command that may still be pending (the predictor of Smith, 1957). The pointing of a picture is
//! looked up in the history by the time of capture, so that neither frame counts nor the video latency enter.
//!
//! The inputs are commands. If the vehicle reports the gimbal's attitude, [`CameraModel::correct_tilt`]
//! corrects the tilt; if it reports a field of view, [`CameraModel::set_field_of_view`] sets the focal
//! length, which follows the commands to zoom in between. The model does not contain the sway of the kite.
//! The laws take the camera for a pinhole; points on the water are computed with its lens
//! ([`CameraModel::lens_at`]). Work: O(1) per command and query, no allocation after construction.

mod axis;
mod axis_history;
mod focal_history;
mod focal_length;

use barrelman_vocab::profile::{AxisRates, CameraDynamics};
use barrelman_vocab::{
    Angle, CameraCommand, ImagePoint, Lens, MotionPrior, PictureSize, Timestamp, VehicleProfile, ZoomDynamics,
};

use self::axis::AxisModel;
use self::focal_length::FocalLength;
pub use self::focal_length::UnreportedZoom;
use crate::view::View;

/// Standard deviation of a kite's sway in wind, radians per square root of a second: 3 degrees with a time
/// constant of 2 s.
pub const SWAY_RAD_PER_ROOT_S: f64 = 0.05;
/// Relative error of a predicted shift, because dead times and lags differ from the profile.
const SHIFT_ERROR: f64 = 0.5;
/// Share of the tilt error that one report corrects.
const REPORT_SHARE: f64 = 0.2;
/// Valid focal lengths, as shares of the picture's width.
const FOCAL_SHARES: core::ops::RangeInclusive<f64> = 0.1..=20.0;
/// A reported focal length that differs by no more than this share from the calibrated one is that of the
/// calibrated lens: a vehicle states a nominal field of view. More is a zoom, with which the calibration does
/// not hold.
const MAX_CALIBRATED_CHANGE: f64 = 0.05;

/// The focal length of a horizontal field of view, as a share of the picture's width; `None`: no camera has
/// it.
pub fn focal_share_of(field_of_view: Angle) -> Option<f64> {
    let angle = field_of_view.radians();
    let share = 0.5 / libm::tan(0.5 * angle);
    let is_valid = angle > 0.0 && angle < core::f64::consts::PI && FOCAL_SHARES.contains(&share);
    is_valid.then_some(share)
}

/// The lens of a camera whose present focal length is this share of the picture's width: the calibrated one,
/// or a pinhole where there is none, where the camera has zoomed since, or where the picture has another
/// aspect ratio than the calibration.
pub fn lens_in_force(dynamics: &CameraDynamics, focal_share: f64, picture: PictureSize) -> Lens {
    let has_zoomed =
        (focal_share - dynamics.focal_share).abs() > MAX_CALIBRATED_CHANGE * dynamics.focal_share;
    let calibrated = dynamics.lens.filter(|_| !has_zoomed).and_then(|lens| lens.scaled_to(picture));
    calibrated.unwrap_or_else(|| pinhole(focal_share, picture))
}

/// The lens of the video that is followed: a pinhole where the video has a camera of its own, whose focal
/// length is the share `of_other`, or else that of this camera ([`lens_in_force`]).
pub fn lens_of_video(
    dynamics: &CameraDynamics,
    focal_share: f64,
    of_other: Option<f64>,
    picture: PictureSize,
) -> Lens {
    let own = || lens_in_force(dynamics, focal_share, picture);
    of_other.map_or_else(own, |share| pinhole(share, picture))
}

fn pinhole(focal_share: f64, picture: PictureSize) -> Lens {
    Lens::pinhole(picture, focal_share * f64::from(picture.width))
}

/// The camera with both axes.
#[derive(Debug, Clone)]
pub struct CameraModel {
    dynamics: CameraDynamics,
    pan: AxisModel,
    tilt: AxisModel,
    focal_length: FocalLength,
}

impl CameraModel {
    /// A camera at rest, with the initial tilt of the profile.
    pub fn new(dynamics: CameraDynamics, limits: AxisRates, zoom: Option<ZoomDynamics>) -> Self {
        let (low, high) = dynamics.tilt_stops;
        let stops = (low.radians(), high.radians());
        let tilt = dynamics.initial_tilt.radians().clamp(stops.0, stops.1);
        Self {
            pan: AxisModel::new(dynamics.pan, limits.pan.radians_per_second(), 0.0, None),
            tilt: AxisModel::new(dynamics.tilt, limits.tilt.radians_per_second(), tilt, Some(stops)),
            focal_length: FocalLength::new(dynamics.focal_share, zoom),
            dynamics,
        }
    }

    /// The camera of a vehicle.
    pub fn of(profile: &VehicleProfile) -> Self {
        Self::new(profile.camera, profile.limits, profile.zoom)
    }

    /// The dynamics that the model was built with.
    pub const fn dynamics(&self) -> &CameraDynamics {
        &self.dynamics
    }

    /// Advances the model to `now` without a new command.
    pub fn advance_to(&mut self, now: Timestamp) {
        let now_s = now.as_secs_f64();
        for axis in [&mut self.pan, &mut self.tilt] {
            axis.advance(now_s + axis.start_s());
        }
        self.focal_length.advance(now);
    }

    /// Puts a command in force from `now` on.
    pub fn apply_command(&mut self, command: CameraCommand, now: Timestamp) {
        let now_s = now.as_secs_f64();
        self.pan.command(command.pan.radians_per_second(), now_s);
        self.tilt.command(command.tilt.radians_per_second(), now_s);
        self.focal_length.command(command.zoom, now);
    }

    /// Corrects the tilt with the gimbal's report at the time `at`. A value that is not finite is ignored.
    pub fn correct_tilt(&mut self, tilt: Angle, at: Timestamp) {
        self.approach_tilt(tilt, at, REPORT_SHARE);
    }

    /// Takes over a tilt that the gimbal reports for the time `at`: the tilt so far was that of the profile.
    /// A value that is not finite is ignored.
    pub fn set_tilt(&mut self, tilt: Angle, at: Timestamp) {
        self.approach_tilt(tilt, at, 1.0);
    }

    fn approach_tilt(&mut self, tilt: Angle, at: Timestamp, share: f64) {
        let error = tilt.radians() - self.tilt.at(at.as_secs_f64()).angle;
        if error.is_finite() {
            self.tilt.shift(share * error);
        }
    }

    /// Takes a report of the horizontal field of view at the time `at`. Impossible values are ignored.
    pub fn set_field_of_view(&mut self, angle: Angle, at: Timestamp) {
        if let Some(share) = focal_share_of(angle) {
            self.focal_length.report(share, at);
        }
    }

    /// The pictures are those of another video from `at` on. `Some`: of a camera of its own with this
    /// horizontal field of view, which turns with this one and does not zoom. An impossible one counts as
    /// that of this camera.
    pub fn change_video(&mut self, field_of_view: Option<Angle>, at: Timestamp) {
        self.focal_length.change_video(field_of_view.and_then(focal_share_of), at);
    }

    /// Whether the pictures are those of a camera of its own, which does not zoom.
    pub const fn is_of_other(&self) -> bool {
        self.focal_length.of_other().is_some()
    }

    /// How the camera zooms at a time; `None`: it does not zoom by command, or reports its field of view.
    pub fn unreported_zoom(&self, at: Timestamp) -> Option<UnreportedZoom> {
        self.focal_length.unreported_zoom(at)
    }

    /// Takes the growth of the picture between two times of capture, the logarithm of its scale.
    pub fn on_growth(&mut self, growth: f64, from: Timestamp, to: Timestamp) {
        self.focal_length.grow(growth, from, to);
    }

    /// Focal length at a time, as a share of the picture's width.
    pub fn focal_share_at(&self, at: Timestamp) -> f64 {
        self.focal_length.at(at)
    }

    /// Focal length at a time for a picture of this size, pixels.
    pub fn focal_px(&self, at: Timestamp, picture: PictureSize) -> f64 {
        self.focal_share_at(at) * f64::from(picture.width)
    }

    /// The lens at a time for a picture of this size ([`lens_in_force`]).
    pub fn lens_at(&self, at: Timestamp, picture: PictureSize) -> Lens {
        lens_of_video(&self.dynamics, self.focal_length.at(at), self.focal_length.of_other(), picture)
    }

    /// Pan (relative to the initial direction; unbounded) and tilt at a time, radians. The history covers at
    /// least 1.5 s; later times are predicted.
    pub fn angles_at(&self, at: Timestamp) -> (f64, f64) {
        let at_s = at.as_secs_f64();
        (self.pan.at(at_s).angle, self.tilt.at(at_s).angle)
    }

    /// Pan rate and tilt rate at a time, rad/s, including pending commands.
    pub fn rates_at(&self, at: Timestamp) -> (f64, f64) {
        let at_s = at.as_secs_f64();
        (self.pan.at(at_s).rate, self.tilt.at(at_s).rate)
    }

    /// Shift of a stationary object at the picture's centre between two pictures due to camera motion, and
    /// the zoom, with the shift's standard deviation. The deviation covers the kite's sway and differences
    /// between vehicle and profile.
    pub fn motion_prior(&self, from: Timestamp, to: Timestamp, picture: PictureSize) -> MotionPrior {
        let (focal_px, focal_px_before) = (self.focal_px(to, picture), self.focal_px(from, picture));
        let interval = to.since(from);
        if self.focal_length.is_changed_by_another(from, to) {
            // By how much, is not known of each picture in between: the shift is unknown.
            let std_dev_px = f64::from(picture.width);
            return MotionPrior { shift_u_px: 0.0, shift_v_px: 0.0, std_dev_px, scale: 1.0, interval };
        }
        let ((pan, tilt), (pan_before, tilt_before)) = (self.angles_at(to), self.angles_at(from));
        let centre =
            View::new(focal_px_before, pan_before, tilt_before).unproject(ImagePoint { x: 0.0, y: 0.0 });
        let shift = View::new(focal_px, pan, tilt).project(centre);
        let sway = focal_px * SWAY_RAD_PER_ROOT_S * libm::sqrt(interval.as_secs_f64());
        MotionPrior {
            shift_u_px: shift.x,
            shift_v_px: -shift.y,
            std_dev_px: libm::hypot(sway, SHIFT_ERROR * libm::hypot(shift.x, shift.y)),
            scale: focal_px / focal_px_before,
            interval,
        }
    }

    /// Displacement `[x, y]` of a stationary object at an image point between two pictures, pixels: by the
    /// pan alone, and by the tilt alone. `None`: the camera zoomed in between.
    pub fn shifts_by_axis(
        &self,
        point: ImagePoint,
        from: Timestamp,
        to: Timestamp,
        picture: PictureSize,
    ) -> Option<[[f64; 2]; 2]> {
        let focal_px = self.focal_px(to, picture);
        if self.focal_px(from, picture).to_bits() != focal_px.to_bits() {
            return None;
        }
        let ((pan, tilt), (pan_before, tilt_before)) = (self.angles_at(to), self.angles_at(from));
        let before = View::new(focal_px, pan_before, tilt_before);
        let direction = before.unproject(point);
        let displacement = |view: View| {
            let seen = view.project(direction);
            [seen.x - point.x, seen.y - point.y]
        };
        Some([
            displacement(before.with_pointing(focal_px, pan, tilt_before)),
            displacement(before.with_pointing(focal_px, pan_before, tilt)),
        ])
    }

    pub(crate) const fn axes(&self) -> [&AxisModel; 2] {
        [&self.pan, &self.tilt]
    }
}
