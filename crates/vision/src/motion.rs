//! Where the target must be next: a Kalman filter with constant velocity, for each axis of the picture by itself.
//!
//! State per axis: place (pixels) and velocity (pixels per second). Between two frames the velocity drifts as a
//! white acceleration of density q; a measurement has variance r. How the camera's own motion shifts the picture
//! is taken in as a known displacement with its own variance. Everything is in pixel coordinates.

/// One axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    /// Pixels.
    pub(crate) place: f64,
    /// Pixels per second.
    pub(crate) velocity: f64,
    /// Variances of both and their covariance.
    place_variance: f64,
    covariance: f64,
    velocity_variance: f64,
}

impl Axis {
    /// A place known to within `deviation`, a velocity of nothing to within `speed`.
    pub(crate) fn at(place: f64, deviation: f64, speed: f64) -> Self {
        Self {
            place,
            velocity: 0.0,
            place_variance: deviation * deviation,
            covariance: 0.0,
            velocity_variance: speed * speed,
        }
    }

    /// `seconds` later; `shift` pixels of that came from the camera, known to within `shift_deviation`.
    pub(crate) fn predict(
        &mut self,
        seconds: f64,
        acceleration_density: f64,
        shift: f64,
        shift_deviation: f64,
    ) {
        let dt = seconds;
        self.place += self.velocity * dt + shift;
        self.place_variance += 2.0 * dt * self.covariance
            + dt * dt * self.velocity_variance
            + acceleration_density * dt * dt * dt / 3.0
            + shift_deviation * shift_deviation;
        self.covariance += dt * self.velocity_variance + acceleration_density * dt * dt / 2.0;
        self.velocity_variance += acceleration_density * dt;
    }

    /// Takes in a measured place of that standard deviation.
    pub(crate) fn correct(&mut self, measured: f64, deviation: f64) {
        let innovation = measured - self.place;
        let variance = self.place_variance + deviation * deviation;
        let (gain, speed_gain) = (self.place_variance / variance, self.covariance / variance);
        self.place += gain * innovation;
        self.velocity += speed_gain * innovation;
        self.velocity_variance -= speed_gain * self.covariance;
        self.covariance *= 1.0 - gain;
        self.place_variance *= 1.0 - gain;
    }

    /// Moves the place by a shift that was measured to within `deviation`.
    pub(crate) fn shift(&mut self, shift: f64, deviation: f64) {
        self.place += shift;
        self.place_variance += deviation * deviation;
    }

    /// Puts everything into pixels of which `factor` go to one of the old ones.
    pub(crate) fn rescale(&mut self, factor: f64) {
        self.place *= factor;
        self.velocity *= factor;
        self.place_variance *= factor * factor;
        self.covariance *= factor * factor;
        self.velocity_variance *= factor * factor;
    }

    /// Lets a velocity that nothing confirms die away, and keeps the place between 0 and `length`.
    pub(crate) fn slow_down(&mut self, length: f32) {
        self.velocity *= 0.8;
        self.place = self.place.clamp(0.0, f64::from(length));
    }

    /// Standard deviation of the place, pixels.
    pub(crate) fn deviation(&self) -> f64 {
        self.place_variance.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f64 = 0.04;

    #[test]
    fn a_constant_velocity_is_learned() {
        let mut axis = Axis::at(100.0, 1.0, 50.0);
        for step in 1..=50 {
            axis.predict(FRAME_S, 1.0, 0.0, 0.0);
            axis.correct(100.0 + 30.0 * FRAME_S * f64::from(step), 1.0);
        }
        assert!((axis.velocity - 30.0).abs() < 0.5, "{}", axis.velocity);
        axis.predict(1.0, 1.0, 0.0, 0.0);
        assert!((axis.place - 190.0).abs() < 1.0, "{}", axis.place);
    }

    #[test]
    fn the_deviation_grows_without_measurements_and_shrinks_with_one() {
        let mut axis = Axis::at(100.0, 2.0, 10.0);
        assert_eq!(axis.deviation(), 2.0);
        let mut before = axis.deviation();
        for _ in 0..20 {
            axis.predict(FRAME_S, 4.0, 0.0, 0.0);
            assert!(axis.deviation() > before);
            before = axis.deviation();
        }
        axis.correct(100.0, 1.0);
        assert!(axis.deviation() < 1.0, "{}", axis.deviation());
        axis.shift(0.0, 5.0);
        assert!(axis.deviation() > 5.0);
    }

    #[test]
    fn what_the_camera_shifts_is_not_taken_for_velocity() {
        let mut axis = Axis::at(100.0, 1.0, 10.0);
        for step in 1..=20 {
            axis.predict(FRAME_S, 1.0, 7.0, 0.5);
            assert!((axis.place - 100.0 - 7.0 * f64::from(step)).abs() < 1e-9);
            axis.correct(100.0 + 7.0 * f64::from(step), 1.0);
        }
        assert!(axis.velocity.abs() < 1e-9, "{}", axis.velocity);
    }

    #[test]
    fn in_a_picture_of_twice_the_width_everything_is_twice_as_much() {
        let mut axis = Axis::at(100.0, 2.0, 10.0);
        axis.predict(FRAME_S, 4.0, 3.0, 1.0);
        axis.correct(105.0, 1.0);
        let mut doubled = axis;
        doubled.rescale(2.0);
        assert_eq!(doubled.place, 2.0 * axis.place);
        assert_eq!(doubled.velocity, 2.0 * axis.velocity);
        assert!((doubled.deviation() - 2.0 * axis.deviation()).abs() < 1e-12);
    }

    #[test]
    fn a_velocity_that_nothing_confirms_dies_away_within_the_picture() {
        let mut axis = Axis { velocity: 500.0, ..Axis::at(300.0, 1.0, 1.0) };
        for _ in 0..40 {
            axis.predict(FRAME_S, 1.0, 0.0, 0.0);
            axis.slow_down(320.0);
            assert!((0.0..=320.0).contains(&axis.place));
        }
        assert!(axis.velocity < 0.1, "{}", axis.velocity);
    }
}
