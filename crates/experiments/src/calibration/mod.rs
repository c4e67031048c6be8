//! Measures the axes of a camera from its test motions: sign, gain, dead times and lag of each axis, and the
//! convention of the reported tilt.
//!
//! [`CalibrationRecorder`] takes the video frames, the commands that left, and the reports of the gimbal
//! during the test motions of `barrelman_pilot::calibration`. [`CalibrationRecorder::result`] fits each axis
//! ([`fit`]) to the picture's own motion ([`turns`]). An axis whose repetitions do not agree is not told:
//! [`CannotTell`]; neither is any in a picture with black bars ([`bars`]). Where a vehicle's speeds have no
//! unit, short motions come before, at one speed after the other ([`SpeedSweep`]).

pub mod fit;

mod bars;
mod gimbal_reports;
mod recorder;
mod speeds;
mod turns;

pub use bars::Bars;
pub use fit::{AxisFit, CannotTell};
pub use recorder::{CalibrationRecorder, CalibrationResult, MeasuredAxis};
pub use speeds::{MeasuredSpeeds, SpeedSweep, SweepError};
