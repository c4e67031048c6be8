//! The far end of the line: what takes rates and moves the camera, of any vehicle.

use barrelman_vocab::VehicleRates;

use super::line::Line;

/// The length of a tick of the campaign, seconds.
pub(super) const TICK_S: f64 = 0.001;

/// The far end of the line, with its camera.
pub(super) trait Station {
    /// Lets a millisecond pass. `trace` takes what is received.
    fn advance(&mut self, line: &mut Line, at_ms: u64, trace: &mut dyn FnMut(&str));

    /// The rates in force.
    fn rates(&self) -> VehicleRates;

    /// Where the camera points: to the right, radians.
    fn pan_rad(&self) -> f64;

    /// Whether another commander commands the camera, so that the rates in force are its own.
    fn is_anothers(&self) -> bool {
        false
    }

    /// Whether this program commanded the camera in the newest millisecond though another commander has the
    /// control.
    fn is_meddled_with(&self) -> bool {
        false
    }
}
