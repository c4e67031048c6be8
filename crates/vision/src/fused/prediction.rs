//! Prediction of the target's position: the Kalman filters of both picture axes and the motion of the camera.

use barrelman_vocab::{MotionPrior, Timestamp};

use crate::motion::AxisFilter;

/// Minimum and maximum time between two frames, seconds. A longer gap predicts no more than the maximum does.
const MIN_GAP_S: f64 = 1.0e-3;
const MAX_GAP_S: f64 = 2.0;
/// A prior with a larger shift or standard deviation is ignored, pixels.
const MAX_PRIOR_SHIFT_PX: f64 = 1.0e6;
/// A prior with a larger standard deviation is used only where background registration gives no shift, pixels.
const PRECISE_PRIOR_STD_DEV_PX: f64 = 1.5;
/// Maximum distance of a measured background shift from a coarse prior, in standard deviations of the prior.
const MAX_SHIFT_DEVIATIONS: f64 = 4.0;
/// Standard deviation of a measured background shift, in sizes of the target.
const SHIFT_STD_DEV_SIZES: f64 = 0.05;
/// Standard deviations of the position and the velocity at the selection: pixels, and sizes per second.
const INITIAL_STD_DEV_PX: f64 = 1.0;
const INITIAL_SPEED_SIZES_PER_S: f64 = 2.0;
/// The same after a re-detection: sizes, and sizes per second.
const RESTART_STD_DEV_SIZES: f64 = 0.1;
const RESTART_SPEED_SIZES_PER_S: f64 = 1.0;

/// Predicted motion of the target in the picture.
#[derive(Debug, Clone)]
pub(super) struct TargetMotion {
    /// Filters along u and v.
    axes: (AxisFilter, AxisFilter),
    /// Time of capture of the last frame.
    pub(super) last_capture: Timestamp,
    /// Time between the last two frames, seconds; 0 before the second.
    last_interval_s: f64,
    /// Whether this frame came with a motion prior at least as precise as background registration.
    pub(super) has_precise_prior: bool,
    /// The motion prior of this frame if it is less precise than that.
    coarse_prior: Option<MotionPrior>,
    /// Whether `camera_shift` comes from a precise prior or was measured.
    pub(super) is_camera_shift_known: bool,
    /// Whether a prior, precise or coarse, tells of the camera's motion in this frame.
    pub(super) is_camera_motion_told: bool,
    /// Shift of the picture caused by the camera since the last frame, pixels; zero where nothing is known of it.
    pub(super) camera_shift: (f32, f32),
}

impl TargetMotion {
    /// The motion of a target selected at `centre` (pixels), of unknown velocity.
    pub(super) fn new(now: Timestamp, centre: (f64, f64), size_px: f64) -> Self {
        let speed = INITIAL_SPEED_SIZES_PER_S * size_px;
        let axis = |position: f64| AxisFilter::new(position, INITIAL_STD_DEV_PX, speed);
        Self {
            axes: (axis(centre.0), axis(centre.1)),
            last_capture: now,
            last_interval_s: 0.0,
            has_precise_prior: false,
            coarse_prior: None,
            is_camera_shift_known: false,
            is_camera_motion_told: false,
            camera_shift: (0.0, 0.0),
        }
    }

    /// The predicted position, pixels; it may lie outside the picture.
    pub(super) fn position(&self) -> (f64, f64) {
        (self.axes.0.position, self.axes.1.position)
    }

    /// The same in single precision.
    pub(super) fn position_f32(&self) -> (f32, f32) {
        (self.axes.0.position as f32, self.axes.1.position as f32)
    }

    /// Standard deviation of the prediction (the larger of both axes), pixels.
    pub(super) fn std_dev(&self) -> f32 {
        self.axes.0.std_dev().max(self.axes.1.std_dev()) as f32
    }

    /// Whether a frame that was captured `now` comes after a gap in the video: it is later than the interval of the last two
    /// frames by more than `coast_s`, seconds, and by more than that interval. So a slow video has no gaps.
    pub(super) fn is_after_gap(&self, now: Timestamp, coast_s: f64) -> bool {
        let interval = now.since(self.last_capture).as_secs_f64();
        interval - self.last_interval_s > coast_s.max(self.last_interval_s)
    }

    /// Predicts to the time of capture `now`, with a precise prior if there is one. The time since the last frame,
    /// seconds.
    ///
    /// `agility` is the root of the acceleration's spectral density, in sizes of the target.
    pub(super) fn predict(
        &mut self,
        now: Timestamp,
        prior: Option<&MotionPrior>,
        agility: f64,
        size_px: f64,
    ) -> f64 {
        self.last_interval_s = now.since(self.last_capture).as_secs_f64();
        let seconds = self.last_interval_s.clamp(MIN_GAP_S, MAX_GAP_S);
        self.last_capture = now;
        // Also false for NaN.
        let is_plausible = |p: &&MotionPrior| {
            [p.shift_u_px, p.shift_v_px, p.std_dev_px].iter().all(|pixels| pixels.abs() <= MAX_PRIOR_SHIFT_PX)
        };
        let prior = prior.filter(is_plausible);
        let is_precise = |p: &&MotionPrior| p.std_dev_px <= PRECISE_PRIOR_STD_DEV_PX;
        // A prior whose standard deviation exceeds the target's size carries no information.
        self.coarse_prior = prior.filter(|p| !is_precise(p) && p.std_dev_px <= size_px).copied();
        let prior = prior.filter(is_precise);
        self.has_precise_prior = prior.is_some();
        self.is_camera_motion_told = self.has_precise_prior || self.coarse_prior.is_some();
        let (u, v, std_dev) = prior.map_or((0.0, 0.0, 0.0), |p| (p.shift_u_px, p.shift_v_px, p.std_dev_px));
        self.camera_shift = (u as f32, v as f32);
        self.is_camera_shift_known = self.has_precise_prior;
        let density = agility * size_px;
        self.axes.0.predict(seconds, density * density, u, std_dev);
        self.axes.1.predict(seconds, density * density, v, std_dev);
        seconds
    }

    /// Adds the camera's shift where no precise prior gave it: the measured background shift, or else the coarse
    /// prior.
    pub(super) fn add_camera_shift(&mut self, measured: Option<(f32, f32)>, size_px: f64) {
        let coarse = self.coarse_prior.take();
        // A measurement that contradicts the coarse prior is wrong.
        let is_consistent = |(u, v): &(f32, f32)| {
            coarse.is_none_or(|prior| {
                let distance =
                    libm::hypot(f64::from(*u) - prior.shift_u_px, f64::from(*v) - prior.shift_v_px);
                distance <= MAX_SHIFT_DEVIATIONS * prior.std_dev_px
            })
        };
        if let Some((u, v)) = measured.filter(is_consistent) {
            self.axes.0.add_shift(f64::from(u), SHIFT_STD_DEV_SIZES * size_px);
            self.axes.1.add_shift(f64::from(v), SHIFT_STD_DEV_SIZES * size_px);
            self.camera_shift = (u, v);
            self.is_camera_shift_known = true;
        } else if let Some(prior) = coarse {
            self.axes.0.add_shift(prior.shift_u_px, prior.std_dev_px);
            self.axes.1.add_shift(prior.shift_v_px, prior.std_dev_px);
            self.camera_shift = (prior.shift_u_px as f32, prior.shift_v_px as f32);
        }
    }

    /// Corrects the prediction by a measured position of this standard deviation, pixels.
    pub(super) fn correct(&mut self, measured: (f32, f32), std_dev: f64) {
        self.axes.0.correct(f64::from(measured.0), std_dev);
        self.axes.1.correct(f64::from(measured.1), std_dev);
    }

    /// Starts again at a re-detected position, pixels.
    pub(super) fn restart_at(&mut self, centre: (f32, f32), size_px: f64) {
        let axis = |position: f32| {
            AxisFilter::new(
                f64::from(position),
                RESTART_STD_DEV_SIZES * size_px,
                RESTART_SPEED_SIZES_PER_S * size_px,
            )
        };
        self.axes = (axis(centre.0), axis(centre.1));
    }

    /// Converts to pixels of a picture that is larger by these factors.
    pub(super) fn rescale(&mut self, (u, v): (f32, f32)) {
        self.axes.0.rescale(f64::from(u));
        self.axes.1.rescale(f64::from(v));
    }

    /// Lets the velocity decay and keeps the position within the picture (width, height), while the target is lost.
    pub(super) fn decay(&mut self, picture: (f32, f32)) {
        self.axes.0.decay_velocity(picture.0);
        self.axes.1.decay_velocity(picture.1);
    }
}
