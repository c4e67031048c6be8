//! The prediction that the optimal law decides by: where the target will be in the picture.

use barrelman_vocab::ImagePoint;

use super::framing::HeldRegion;
use super::mean_bearing::ExpectedReturn;
use crate::bearing::{Bearing, BearingFilter, BearingNoise, Propagation};
use crate::camera_model::CameraModel;
use crate::law_input::LawInput;
use crate::transfer::{Pair, Transfer};
use crate::view::View;

/// An axis rests if its end stop limits its rate to less than this, rad/s.
pub(super) const MIN_RATE_TO_STOP: f64 = 0.01;

/// The predicted view at one moment.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedView {
    view: View,
    /// Predicted position of the target in the picture.
    pub(super) point: ImagePoint,
    /// Change of the bearing per unit of bearing rate until then, seconds. The rate decays in the meantime.
    rate_gain_s: f64,
    sway_decay: f64,
}

/// The prediction of one step. Durations count from the *effect time*, at which a command given now takes
/// effect.
pub(super) struct Prediction<'a> {
    pub(super) camera: &'a CameraModel,
    /// The camera at the picture's time of capture.
    pub(super) view: View,
    pub(super) focal_px: f64,
    /// Where the target is held.
    pub(super) region: HeldRegion,
    pub(super) bearing: Bearing,
    pub(super) noise: BearingNoise,
    /// From the time of the bearing to the effect time.
    pub(super) until_effect: Propagation,
    /// The longer of both axes' start dead times, seconds.
    pub(super) start_s: f64,
    /// What the target is expected to return to, if anything.
    pub(super) expected_return: Option<ExpectedReturn>,
}

/// What a movement is to reach: the camera turns within the horizon so that the target is in the aim ellipse
/// `look_ahead_s` after it.
#[derive(Debug, Clone, Copy)]
pub(super) struct TransferGoal {
    /// Seconds.
    pub(super) horizon_s: f64,
    /// Seconds.
    pub(super) look_ahead_s: f64,
    /// Semi-axes of the region.
    pub(super) aim: f64,
}

impl<'a> Prediction<'a> {
    /// The prediction of a step: the filter observes the input first. `None` without an estimate of the
    /// target.
    pub(super) fn observed(
        bearings: &mut BearingFilter,
        noise: BearingNoise,
        input: &LawInput<'_>,
        camera: &'a CameraModel,
    ) -> Option<Self> {
        let view = bearings.observe(input, camera);
        let (measured_at, bearing) = bearings.estimate()?;
        let start_s = camera.axes().map(|axis| axis.start_s()).into_iter().fold(0.0, f64::max);
        let age_s = input.now.since(*measured_at).as_secs_f64() + start_s;
        Some(Self {
            camera,
            view,
            focal_px: camera.focal_px(input.now, input.picture),
            region: HeldRegion::whole(input.region),
            bearing: *bearing,
            noise,
            until_effect: Propagation::new(age_s, &noise),
            start_s,
            expected_return: None,
        })
    }

    /// The same prediction for a target that is held in a part of the region.
    pub(super) fn held_in(self, region: HeldRegion) -> Self {
        Self { region, ..self }
    }

    /// The same prediction for a target that returns to its mean direction.
    pub(super) fn with_return(self, expected: ExpectedReturn) -> Self {
        Self { expected_return: Some(expected), ..self }
    }

    /// The view at a time after the effect time if the camera is told to rest now.
    pub(super) fn view_at_rest(&self, after: &Propagation) -> PredictedView {
        let angles = self
            .camera
            .axes()
            .map(|axis| axis.angle_if_rested(after.duration_s + self.start_s - axis.start_s()));
        self.predicted_view(after, angles)
    }

    /// Turning that moves the target from this view to the middle of its region, relative to the turning that
    /// a level camera needs: at least 1, and at most 4 where pan has no effect.
    pub(super) fn turning_effort(&self, PredictedView { view, point, .. }: &PredictedView) -> f64 {
        const MIN_GAIN: f64 = 0.25;
        let jacobian = view.jacobian(*point);
        let point = self.region.relative_to_centre(*point);
        let across = point.x * self.focal_px / jacobian.pan[0].abs().max(MIN_GAIN * self.focal_px);
        let along = point.y * self.focal_px / jacobian.tilt[1].abs().max(MIN_GAIN * self.focal_px);
        let level = (point.x * point.x + point.y * point.y).max(1.0);
        libm::sqrt(((across * across + along * along) / level).max(1.0))
    }

    /// Standard deviation of the predicted position due to the target's motion, in semi-axes of the region
    /// (the smaller one).
    pub(super) fn position_std_dev(&self, predicted: &PredictedView) -> f64 {
        self.in_semi_axes(self.bearing.predicted_std_dev(predicted.rate_gain_s, predicted.sway_decay))
    }

    /// A small angle in semi-axes of the region (the smaller one), near the picture's centre.
    pub(super) fn in_semi_axes(&self, angle: f64) -> f64 {
        let [a, b] = self.region.semi_axes_px();
        self.focal_px * angle / a.min(b)
    }

    fn predicted_view(&self, after: &Propagation, [pan, tilt]: Pair) -> PredictedView {
        let Propagation { duration_s, rate_decay, sway_decay } = self.until_effect.then(after);
        let rate_gain_s = self.noise.rate_time_constant_s * (1.0 - rate_decay);
        let view = self.view.with_pointing(self.focal_px, pan, tilt);
        let onwards = self.bearing.apparent_direction_after(rate_gain_s, sway_decay);
        let direction = self.expected_return.map_or(onwards, |expected| {
            let share = expected.share_after(duration_s);
            let target = self.bearing.direction();
            [0, 1, 2].map(|i| onwards[i] + share * (expected.mean[i] - target[i]))
        });
        let point = view.project(direction);
        PredictedView { view, point, rate_gain_s, sway_decay }
    }

    /// The rates, limited so that each axis can be stopped before the end stop that it turns to; 0 where
    /// little is left.
    pub(super) fn stoppable_rates(&self, rates: Pair) -> Pair {
        let axes = self.camera.axes();
        [0, 1].map(|index| {
            let (axis, rate) = (axes[index], rates[index]);
            let way = axis
                .range_to_stops(axis.angle_coasting(0.0))
                .map(|(below, above)| if rate < 0.0 { below } else { above });
            let limit = way.map_or(f64::INFINITY, |way| way / axis.stopping_s());
            if limit < MIN_RATE_TO_STOP { 0.0 } else { rate.clamp(-limit, limit) }
        })
    }

    /// The problem of reaching a goal.
    pub(super) fn transfer(&self, goal: &TransferGoal, limits: Pair) -> Transfer {
        let TransferGoal { horizon_s, look_ahead_s, aim } = *goal;
        let (mut gain_s, mut angles) = ([0.0; 2], [0.0; 2]);
        let (mut min_rates, mut max_rates) = (limits.map(|limit| -limit), limits);
        for (index, axis) in self.camera.axes().into_iter().enumerate() {
            let duration_s = horizon_s + self.start_s - axis.start_s();
            let decay = axis.rate_decay(duration_s);
            gain_s[index] = duration_s - axis.lag_s() * (1.0 - decay);
            angles[index] = axis.angle_coasting(decay);
            if let Some((below, above)) = axis.range_to_stops(angles[index]) {
                min_rates[index] = min_rates[index].max(-below / gain_s[index]);
                max_rates[index] = max_rates[index].min(above / gain_s[index]);
            }
        }
        let coasting = self.predicted_view(&Propagation::new(horizon_s + look_ahead_s, &self.noise), angles);
        let jacobian = coasting.view.jacobian(coasting.point);
        let [a, b] = self.region.semi_axes_px();
        let offset = self.region.relative_to_centre(coasting.point);
        Transfer {
            offset: [offset.x / a, offset.y / b],
            pan: [jacobian.pan[0] * gain_s[0] / a, jacobian.pan[1] * gain_s[0] / b],
            tilt: [jacobian.tilt[0] * gain_s[1] / a, jacobian.tilt[1] * gain_s[1] / b],
            aim,
            min_rates,
            max_rates,
        }
    }
}
