//! Kalman filter with constant velocity, one for each axis of the picture.
//!
//! State: position (pixels) and velocity (pixels per second). Between frames, a white acceleration of
//! spectral density q acts on the velocity; a measured position has the variance r. The camera's motion
//! enters as a known displacement with its own variance.

/// Filter of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisFilter {
    /// Position, pixels.
    pub(crate) position: f64,
    /// Velocity, pixels per second.
    pub(crate) velocity: f64,
    /// Covariance matrix of position and velocity.
    position_variance: f64,
    covariance: f64,
    velocity_variance: f64,
}

impl AxisFilter {
    /// A filter at a position with this standard deviation, and at velocity zero with the standard deviation
    /// `speed`.
    pub(crate) fn new(position: f64, std_dev: f64, speed: f64) -> Self {
        Self {
            position,
            velocity: 0.0,
            position_variance: std_dev * std_dev,
            covariance: 0.0,
            velocity_variance: speed * speed,
        }
    }

    /// Predicts by `seconds`. `acceleration_density` is q, pixels squared per second cubed; `shift` is the
    /// displacement by the camera, pixels, with its standard deviation.
    pub(crate) fn predict(
        &mut self,
        seconds: f64,
        acceleration_density: f64,
        shift: f64,
        shift_std_dev: f64,
    ) {
        let dt = seconds;
        self.position += self.velocity * dt + shift;
        self.position_variance += 2.0 * dt * self.covariance
            + dt * dt * self.velocity_variance
            + acceleration_density * dt * dt * dt / 3.0
            + shift_std_dev * shift_std_dev;
        self.covariance += dt * self.velocity_variance + acceleration_density * dt * dt / 2.0;
        self.velocity_variance += acceleration_density * dt;
    }

    /// Corrects the state by a measured position with this standard deviation, pixels.
    pub(crate) fn correct(&mut self, measured: f64, std_dev: f64) {
        let innovation = measured - self.position;
        let variance = self.position_variance + std_dev * std_dev;
        let (gain, speed_gain) = (self.position_variance / variance, self.covariance / variance);
        self.position += gain * innovation;
        self.velocity += speed_gain * innovation;
        self.velocity_variance -= speed_gain * self.covariance;
        self.covariance *= 1.0 - gain;
        self.position_variance *= 1.0 - gain;
    }

    /// Adds a measured displacement with this standard deviation, pixels.
    pub(crate) fn add_shift(&mut self, shift: f64, std_dev: f64) {
        self.position += shift;
        self.position_variance += std_dev * std_dev;
    }

    /// Converts to pixels of a picture that is larger by `factor`.
    pub(crate) fn rescale(&mut self, factor: f64) {
        self.position *= factor;
        self.velocity *= factor;
        self.position_variance *= factor * factor;
        self.covariance *= factor * factor;
        self.velocity_variance *= factor * factor;
    }

    /// Reduces a velocity that no measurement confirms, and keeps the position between 0 and `length`.
    pub(crate) fn decay_velocity(&mut self, length: f32) {
        self.velocity *= 0.8;
        self.position = self.position.clamp(0.0, f64::from(length));
    }

    /// Standard deviation of the position, pixels.
    pub(crate) fn std_dev(&self) -> f64 {
        self.position_variance.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_S: f64 = 0.04;

    #[test]
    fn a_constant_velocity_is_learned() {
        let mut axis = AxisFilter::new(100.0, 1.0, 50.0);
        for step in 1..=50 {
            axis.predict(FRAME_S, 1.0, 0.0, 0.0);
            axis.correct(100.0 + 30.0 * FRAME_S * f64::from(step), 1.0);
        }
        assert!((axis.velocity - 30.0).abs() < 0.5, "{}", axis.velocity);
        axis.predict(1.0, 1.0, 0.0, 0.0);
        assert!((axis.position - 190.0).abs() < 1.0, "{}", axis.position);
    }

    #[test]
    fn the_deviation_grows_without_measurements_and_shrinks_with_one() {
        let mut axis = AxisFilter::new(100.0, 2.0, 10.0);
        assert_eq!(axis.std_dev(), 2.0);
        let mut before = axis.std_dev();
        for _ in 0..20 {
            axis.predict(FRAME_S, 4.0, 0.0, 0.0);
            assert!(axis.std_dev() > before);
            before = axis.std_dev();
        }
        axis.correct(100.0, 1.0);
        assert!(axis.std_dev() < 1.0, "{}", axis.std_dev());
        axis.add_shift(0.0, 5.0);
        assert!(axis.std_dev() > 5.0);
    }

    #[test]
    fn what_the_camera_shifts_is_not_taken_for_velocity() {
        let mut axis = AxisFilter::new(100.0, 1.0, 10.0);
        for step in 1..=20 {
            axis.predict(FRAME_S, 1.0, 7.0, 0.5);
            assert!((axis.position - 100.0 - 7.0 * f64::from(step)).abs() < 1e-9);
            axis.correct(100.0 + 7.0 * f64::from(step), 1.0);
        }
        assert!(axis.velocity.abs() < 1e-9, "{}", axis.velocity);
    }

    #[test]
    fn in_a_picture_of_twice_the_width_everything_is_twice_as_much() {
        let mut axis = AxisFilter::new(100.0, 2.0, 10.0);
        axis.predict(FRAME_S, 4.0, 3.0, 1.0);
        axis.correct(105.0, 1.0);
        let mut doubled = axis;
        doubled.rescale(2.0);
        assert_eq!(doubled.position, 2.0 * axis.position);
        assert_eq!(doubled.velocity, 2.0 * axis.velocity);
        assert!((doubled.std_dev() - 2.0 * axis.std_dev()).abs() < 1e-12);
    }

    #[test]
    fn a_velocity_that_nothing_confirms_dies_away_within_the_picture() {
        let mut axis = AxisFilter { velocity: 500.0, ..AxisFilter::new(300.0, 1.0, 1.0) };
        for _ in 0..40 {
            axis.predict(FRAME_S, 1.0, 0.0, 0.0);
            axis.decay_velocity(320.0);
            assert!((0.0..=320.0).contains(&axis.position));
        }
        assert!(axis.velocity < 0.1, "{}", axis.velocity);
    }
}
