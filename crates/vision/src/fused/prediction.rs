//! The stage that predicts the target's position: the Kalman filters of both picture axes and the motion of
//! the camera.
//!
//! The camera's motion comes from the [`MotionPrior`], otherwise from registration of the background. Input:
//! the frame and its prior. Output: a [`Prediction`].

use barrelman_vocab::{MotionPrior, Picture, PixelPoint, Timestamp};

use super::geometry::TargetGeometry;
use super::observation::Observation;
use crate::background::BackgroundMotion;
use crate::fourier::Fourier;
use crate::heading::CameraMotionSource;
use crate::motion::AxisFilter;
use crate::tracker::BackgroundShift;
use crate::vector::{Vector, distance};

/// Maximum shift and standard deviation of a plausible prior, pixels.
const MAX_PRIOR_SHIFT_PX: f64 = 1.0e6;

/// Settings of the prediction. The target's acceleration is set by the user: `agility`. Settings without a
/// figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictionSettings {
    /// Lower bound of the predicted time between two frames, seconds.
    min_gap_s: f64,
    /// Upper bound of the same time, seconds. After a longer gap the velocity is not extrapolated further.
    max_gap_s: f64,
    /// Maximum standard deviation of a precise prior, pixels. A coarse prior is used only if background
    /// registration gives no shift.
    precise_prior_std_dev_px: f64,
    /// Maximum distance of a measured background shift from a coarse prior, standard deviations of the prior.
    max_shift_deviations: f64,
    /// Standard deviation of a measured background shift, sizes.
    shift_std_dev_sizes: f64,
    /// Standard deviation of the position at the selection, pixels.
    initial_std_dev_px: f64,
    /// Standard deviation of the velocity at the selection, sizes per second.
    initial_speed_sizes_per_s: f64,
    /// Standard deviation of the position after a re-detection, sizes.
    restart_std_dev_sizes: f64,
    /// Standard deviation of the velocity after a re-detection, sizes per second.
    restart_speed_sizes_per_s: f64,
    /// Standard deviation of a measured position, sizes.
    position_std_dev_sizes: f64,
}

impl Default for PredictionSettings {
    fn default() -> Self {
        Self {
            min_gap_s: 1.0e-3,
            max_gap_s: 2.0,
            precise_prior_std_dev_px: 1.5,
            max_shift_deviations: 4.0,
            shift_std_dev_sizes: 0.05,
            initial_std_dev_px: 1.0,
            initial_speed_sizes_per_s: 2.0,
            restart_std_dev_sizes: 0.1,
            restart_speed_sizes_per_s: 1.0,
            position_std_dev_sizes: 0.05,
        }
    }
}

/// The expected place of the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prediction {
    /// The predicted position, pixels; it may lie outside the picture.
    pub(super) position: Vector,
    /// Standard deviation (the larger of both axes), pixels.
    pub(super) std_dev: f32,
    pub(super) camera_shift: CameraShift,
}

/// Shift of the picture caused by the camera since the last frame, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CameraShift {
    Unknown,
    /// By a coarse prior.
    Coarse(Vector),
    /// By a precise prior, or measured.
    Known(Vector),
}

impl CameraShift {
    /// The best estimate; zero if the shift is unknown.
    pub(super) fn estimate(self) -> Vector {
        match self {
            Self::Unknown => (0.0, 0.0),
            Self::Coarse(shift) | Self::Known(shift) => shift,
        }
    }

    /// The shift, if it is known.
    pub(super) fn known(self) -> Option<Vector> {
        match self {
            Self::Known(shift) => Some(shift),
            Self::Unknown | Self::Coarse(_) => None,
        }
    }
}

/// The motion prior of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Prior {
    /// No prior, or one without information.
    None,
    /// Less precise than background registration.
    Coarse(MotionPrior),
    /// At least as precise as that.
    Precise(MotionPrior),
}

impl Prediction {
    /// Distance of an observation's centre from the predicted one, pixels.
    pub(super) fn distance_of(&self, observation: &Observation) -> f32 {
        distance(observation.centre, self.position)
    }
}

impl PredictionSettings {
    /// Classifies the prior of a frame for a target of this size, pixels.
    fn classify(&self, prior: Option<&MotionPrior>, size_px: f64) -> Prior {
        let Some(prior) = prior else { return Prior::None };
        // Also false for NaN.
        let is_plausible = [prior.shift_u_px, prior.shift_v_px, prior.std_dev_px]
            .iter()
            .all(|pixels| pixels.abs() <= MAX_PRIOR_SHIFT_PX);
        if !is_plausible {
            Prior::None
        } else if prior.std_dev_px <= self.precise_prior_std_dev_px {
            Prior::Precise(*prior)
        } else if prior.std_dev_px <= size_px {
            Prior::Coarse(*prior)
        } else {
            // A prior whose standard deviation exceeds the target's size carries no information.
            Prior::None
        }
    }
}

/// The shift of a prior, pixels right and down.
fn shift_of(prior: &MotionPrior) -> Vector {
    (prior.shift_u_px as f32, prior.shift_v_px as f32)
}

/// Motion of the target in the picture.
#[derive(Debug, Clone)]
pub(super) struct TargetMotion {
    settings: PredictionSettings,
    /// Root of the acceleration's spectral density, in sizes of the target.
    agility: f64,
    background: BackgroundMotion,
    fourier: Fourier,
    /// Filters along u and v.
    axes: (AxisFilter, AxisFilter),
    /// Time of capture of the last frame.
    pub(super) last_capture: Timestamp,
    /// Time between the last two frames, seconds; 0 before the second.
    last_interval_s: f64,
    /// The motion prior of this frame.
    prior: Prior,
    camera_shift: CameraShift,
}

impl TargetMotion {
    pub(super) fn new(agility: f64) -> Self {
        let unknown = AxisFilter::new(0.0, 0.0, 0.0);
        Self {
            settings: PredictionSettings::default(),
            agility,
            background: BackgroundMotion::new(),
            fourier: Fourier::new(),
            axes: (unknown, unknown),
            last_capture: Timestamp::ZERO,
            last_interval_s: 0.0,
            prior: Prior::None,
            camera_shift: CameraShift::Unknown,
        }
    }

    /// Begins with a target that is selected at `centre` (pixels), of unknown velocity.
    pub(super) fn select(&mut self, now: Timestamp, centre: (f64, f64), size_px: f64) {
        let speed = self.settings.initial_speed_sizes_per_s * size_px;
        let axis = |position: f64| AxisFilter::new(position, self.settings.initial_std_dev_px, speed);
        self.axes = (axis(centre.0), axis(centre.1));
        (self.last_capture, self.last_interval_s) = (now, 0.0);
        (self.prior, self.camera_shift) = (Prior::None, CameraShift::Unknown);
    }

    /// Starts a frame, in which no shift of the background has been measured yet.
    pub(super) fn begin_frame(&mut self) {
        self.background.forget_measurement();
    }

    /// Predicts to the time of capture `now`. Returns the time since the last frame, seconds.
    pub(super) fn predict(
        &mut self,
        now: Timestamp,
        prior: Option<&MotionPrior>,
        geometry: &TargetGeometry,
    ) -> f64 {
        let settings = self.settings;
        let size_px = f64::from(geometry.size_px());
        self.last_interval_s = now.since(self.last_capture).as_secs_f64();
        let seconds = self.last_interval_s.clamp(settings.min_gap_s, settings.max_gap_s);
        self.last_capture = now;
        let place = PixelPoint { u: self.axes.0.position, v: self.axes.1.position };
        let prior = prior.map(|prior| prior.at(place, geometry.picture));
        self.prior = settings.classify(prior.as_ref(), size_px);
        let (u, v, std_dev) = match self.prior {
            Prior::Precise(prior) => (prior.shift_u_px, prior.shift_v_px, prior.std_dev_px),
            Prior::None | Prior::Coarse(_) => (0.0, 0.0, 0.0),
        };
        self.camera_shift = match self.prior {
            Prior::Precise(prior) => CameraShift::Known(shift_of(&prior)),
            Prior::None | Prior::Coarse(_) => CameraShift::Unknown,
        };
        let density = self.agility * size_px;
        self.axes.0.predict(seconds, density * density, u, std_dev);
        self.axes.1.predict(seconds, density * density, v, std_dev);
        seconds
    }

    /// Measures the shift of the background, unless a precise prior gives it, and adds the shift to the
    /// prediction.
    pub(super) fn measure_shift(&mut self, picture: &Picture, geometry: &TargetGeometry) -> Prediction {
        let measured = match self.prior {
            Prior::Precise(_) => None,
            Prior::None | Prior::Coarse(_) => self.background.measure_shift(picture.y(), &mut self.fourier),
        };
        self.add_camera_shift(measured, f64::from(geometry.size_px()));
        self.prediction()
    }

    /// The same for a lost target, whose velocity decays. Only the first frame after a gap has a reference.
    pub(super) fn predict_lost(&mut self, picture: &Picture, geometry: &TargetGeometry) -> Prediction {
        self.measure_shift(picture, geometry);
        self.background.clear_reference();
        self.background.forget_measurement();
        let (width, height) = geometry.picture_size();
        self.axes.0.decay_velocity(width);
        self.axes.1.decay_velocity(height);
        self.prediction()
    }

    /// Predicts the position of a target that is not looked for. The shift of the background is not measured.
    pub(super) fn predict_unseen(
        &mut self,
        now: Timestamp,
        prior: Option<&MotionPrior>,
        geometry: &TargetGeometry,
    ) {
        self.predict(now, prior, geometry);
        self.add_camera_shift(None, f64::from(geometry.size_px()));
    }

    /// The present prediction.
    pub(super) fn prediction(&self) -> Prediction {
        Prediction {
            position: self.position(),
            std_dev: self.axes.0.std_dev().max(self.axes.1.std_dev()) as f32,
            camera_shift: self.camera_shift,
        }
    }

    /// The predicted position, pixels; it may lie outside the picture.
    pub(super) fn position(&self) -> (f32, f32) {
        (self.axes.0.position as f32, self.axes.1.position as f32)
    }

    /// Whether the predicted position lies in the picture.
    pub(super) fn is_in_picture(&self, geometry: &TargetGeometry) -> bool {
        let picture = geometry.picture_size();
        (0.0..=f64::from(picture.0)).contains(&self.axes.0.position)
            && (0.0..=f64::from(picture.1)).contains(&self.axes.1.position)
    }

    /// Whether a frame that was captured `now` comes after a gap in the video: the time since the last frame
    /// exceeds the interval before by more than `coast_s`, seconds, and by more than that interval. A slow
    /// video therefore has no gaps.
    pub(super) fn is_after_gap(&self, now: Timestamp, coast_s: f64) -> bool {
        let interval = now.since(self.last_capture).as_secs_f64();
        interval - self.last_interval_s > coast_s.max(self.last_interval_s)
    }

    /// Adds the camera's shift, unless a precise prior gave it: the measured background shift, otherwise the
    /// coarse prior.
    fn add_camera_shift(&mut self, measured: Option<(f32, f32)>, size_px: f64) {
        let settings = self.settings;
        let coarse = match self.prior {
            Prior::Coarse(prior) => Some(prior),
            Prior::None | Prior::Precise(_) => None,
        };
        // A measurement that contradicts the coarse prior is wrong.
        let is_consistent = |(u, v): &(f32, f32)| {
            coarse.is_none_or(|prior| {
                let distance =
                    libm::hypot(f64::from(*u) - prior.shift_u_px, f64::from(*v) - prior.shift_v_px);
                distance <= settings.max_shift_deviations * prior.std_dev_px
            })
        };
        if let Some((u, v)) = measured.filter(is_consistent) {
            self.axes.0.add_shift(f64::from(u), settings.shift_std_dev_sizes * size_px);
            self.axes.1.add_shift(f64::from(v), settings.shift_std_dev_sizes * size_px);
            self.camera_shift = CameraShift::Known((u, v));
        } else if let Some(prior) = coarse {
            self.axes.0.add_shift(prior.shift_u_px, prior.std_dev_px);
            self.axes.1.add_shift(prior.shift_v_px, prior.std_dev_px);
            self.camera_shift = CameraShift::Coarse(shift_of(&prior));
        }
    }

    /// Corrects the prediction by the target's measured centre. Makes the frame the reference of the next
    /// registration, unless there is a precise prior.
    pub(super) fn correct(&mut self, picture: &Picture, geometry: &TargetGeometry) {
        let std_dev = self.settings.position_std_dev_sizes * f64::from(geometry.size_px());
        self.axes.0.correct(f64::from(geometry.centre.0), std_dev);
        self.axes.1.correct(f64::from(geometry.centre.1), std_dev);
        match self.prior {
            Prior::Precise(_) => {}
            Prior::None | Prior::Coarse(_) => self.set_background_reference(picture, geometry),
        }
    }

    /// Makes this frame the reference of background registration.
    pub(super) fn set_background_reference(&mut self, picture: &Picture, geometry: &TargetGeometry) {
        let blanked = geometry.blanked_side_px();
        self.background.set_reference(picture.y(), &mut self.fourier, geometry.centre, blanked);
    }

    /// Drops the reference of background registration.
    pub(super) fn clear_background_reference(&mut self) {
        self.background.clear_reference();
    }

    /// The shift of the background that was measured in this frame.
    pub(super) const fn background_shift(&self) -> Option<BackgroundShift> {
        self.background.measured()
    }

    /// The source of the camera's motion in this frame.
    pub(super) const fn camera_motion_source(&self) -> CameraMotionSource {
        match self.prior {
            Prior::Coarse(_) | Prior::Precise(_) => CameraMotionSource::Told,
            Prior::None => CameraMotionSource::Measured,
        }
    }

    /// Restarts at another position, pixels.
    pub(super) fn restart_at(&mut self, centre: (f32, f32), geometry: &TargetGeometry) {
        let (settings, size_px) = (&self.settings, f64::from(geometry.size_px()));
        let axis = |position: f32| {
            AxisFilter::new(
                f64::from(position),
                settings.restart_std_dev_sizes * size_px,
                settings.restart_speed_sizes_per_s * size_px,
            )
        };
        self.axes = (axis(centre.0), axis(centre.1));
    }

    /// Converts to pixels of a picture that is larger by these factors.
    pub(super) fn rescale(&mut self, (u, v): (f32, f32)) {
        self.axes.0.rescale(f64::from(u));
        self.axes.1.rescale(f64::from(v));
        self.background.clear_reference();
    }
}
