//! How fast a camera turns at its speeds, where those have no unit: short motions at one speed after the
//! other, the slowest first.
//!
//! The pilot commands its low rate each time. A provisional curve makes the wanted speed of it, and the
//! measured rate becomes a point of the real curve. A speed at which the picture does not follow lies in the
//! dead zone. An axis that turns as fast as it will ever be asked to goes on to no higher speed.

use core::fmt;

use barrelman_pilot::NUDGE_RATE_RAD_PER_S;
use barrelman_vocab::AngularRate;
use barrelman_vocab::speed_curve::{AxisSpeeds, SpeedCurve, SpeedPoint};

use super::fit::CannotTell;

/// The speeds, in thousandths.
const SPEEDS: [u16; 11] = [10, 20, 40, 70, 100, 150, 220, 320, 470, 680, 1000];
/// An axis that turns as fast goes on to no higher speed, rad/s.
const FAST_ENOUGH: f64 = 0.5;
/// From this rate on, rad/s, a speed at which the axis is not seen to turn moves the picture too fast to be
/// measured.
const TOO_FAST_TO_TELL: f64 = 0.25;
/// The rates of two points differ at least by this factor.
const LEAST_GROWTH: f64 = 1.05;

/// What the motions at one speed have told: the rates of both axes, rad/s, without their signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredSpeeds {
    /// Pan.
    pub pan: Result<f64, CannotTell>,
    /// Tilt.
    pub tilt: Result<f64, CannotTell>,
}

/// Why the speeds of an axis cannot be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepError {
    /// `pan` or `tilt`.
    pub axis: &'static str,
    /// Why, at the highest speed that was tried.
    pub reason: CannotTell,
}

impl fmt::Display for SweepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.axis, self.reason)
    }
}

impl core::error::Error for SweepError {}

#[derive(Debug, Clone)]
struct Axis {
    name: &'static str,
    /// The place in [`SPEEDS`] that is measured next, or was last.
    at: usize,
    points: Vec<SpeedPoint>,
    is_done: bool,
    refused: CannotTell,
}

impl Axis {
    const fn new(name: &'static str) -> Self {
        Self { name, at: 0, points: Vec::new(), is_done: false, refused: CannotTell::NotMeasured }
    }

    fn speed(&self) -> f64 {
        f64::from(SPEEDS[self.at]) / 1e3
    }

    fn take(&mut self, measured: Result<f64, CannotTell>) -> Result<(), SweepError> {
        if self.is_done {
            return Ok(());
        }
        let fastest = self.points.last().map_or(0.0, |point| point.rate.radians_per_second());
        match measured {
            Ok(rate) => {
                // A slower speed that seemed to turn the axis as fast was measured wrongly, or has the same
                // rate.
                let rises = |point: &SpeedPoint| point.rate.radians_per_second() * LEAST_GROWTH <= rate;
                self.points.retain(rises);
                let rate_there = AngularRate::from_radians_per_second(rate);
                self.points.push(SpeedPoint { speed: self.speed(), rate: rate_there });
                self.is_done = rate >= FAST_ENOUGH;
            }
            // The dead zone, or a picture that moves too fast to be measured.
            Err(reason) => {
                // At the least speed the picture is measured, whether it moves or not.
                let is_hopeless = matches!(reason, CannotTell::Bars(_))
                    || (matches!(reason, CannotTell::NotMeasured) && self.at == 0);
                if is_hopeless {
                    return Err(SweepError { axis: self.name, reason });
                }
                self.refused = reason;
                self.is_done = fastest >= TOO_FAST_TO_TELL;
            }
        }
        if self.at + 1 < SPEEDS.len() && !self.is_done {
            self.at += 1;
        } else {
            self.is_done = true;
        }
        Ok(())
    }

    /// The curve on which the pilot's low rate is the speed that is measured.
    fn provisional(&self) -> SpeedCurve {
        SpeedCurve::linear(AngularRate::from_radians_per_second(NUDGE_RATE_RAD_PER_S / self.speed()))
    }

    fn curve(&self) -> Result<SpeedCurve, SweepError> {
        let told = SpeedCurve::new(self.points.clone());
        told.map_err(|_| SweepError { axis: self.name, reason: self.refused })
    }
}

/// The speeds that have been measured, and the next ones.
#[derive(Debug, Clone)]
pub struct SpeedSweep {
    pan: Axis,
    tilt: Axis,
}

impl Default for SpeedSweep {
    fn default() -> Self {
        Self { pan: Axis::new("pan"), tilt: Axis::new("tilt") }
    }
}

impl SpeedSweep {
    /// The speeds of pan and tilt, and the curves with which they are measured next; `None`: all have been
    /// measured. An axis that is done turns at its last speed once more.
    pub fn next(&self) -> Option<([f64; 2], AxisSpeeds)> {
        let speeds = [self.pan.speed(), self.tilt.speed()];
        let provisional = || AxisSpeeds { pan: self.pan.provisional(), tilt: self.tilt.provisional() };
        (!self.pan.is_done || !self.tilt.is_done).then(|| (speeds, provisional()))
    }

    /// Takes what was measured at the speeds of [`SpeedSweep::next`].
    ///
    /// # Errors
    /// If a picture like that tells no speed at all.
    pub fn take(&mut self, measured: MeasuredSpeeds) -> Result<(), SweepError> {
        self.pan.take(measured.pan)?;
        self.tilt.take(measured.tilt)
    }

    /// The curves.
    ///
    /// # Errors
    /// If an axis has not turned at any speed.
    pub fn curves(&self) -> Result<AxisSpeeds, SweepError> {
        Ok(AxisSpeeds { pan: self.pan.curve()?, tilt: self.tilt.curve()? })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bars::Bars;
    use super::*;

    /// The sweep of a camera whose axes turn so; what is below 0.01 rad/s is not seen.
    fn sweep(rate: impl Fn(f64) -> f64) -> (SpeedSweep, Vec<f64>) {
        let (mut sweep, mut tried) = (SpeedSweep::default(), Vec::new());
        let rests = Err(CannotTell::NotFollowing { explained: 0.1 });
        let seen = |rate: f64| if rate < 0.01 { rests } else { Ok(rate) };
        while let Some(([pan, tilt], provisional)) = sweep.next() {
            let low = AngularRate::from_radians_per_second(NUDGE_RATE_RAD_PER_S);
            assert!((provisional.pan.speed_for(low) - pan).abs() < 1e-9);
            tried.push(pan);
            sweep.take(MeasuredSpeeds { pan: seen(rate(pan)), tilt: seen(0.5 * rate(tilt)) }).unwrap();
        }
        (sweep, tried)
    }

    #[test]
    fn a_curve_is_found_from_its_dead_zone_to_where_it_is_fast_enough() {
        let (found, tried) = sweep(|speed| if speed < 0.05 { 0.0 } else { 1.2 * speed * speed.sqrt() });
        let curves = found.curves().unwrap();
        let pan = curves.pan.points();
        assert!((pan[0].speed - 0.07).abs() < 1e-9, "{pan:?}");
        assert!(pan.len() >= 5 && curves.pan.largest().radians_per_second() >= 0.5, "{pan:?}");
        assert_eq!(tried.last(), Some(&0.68), "pan goes on to no higher speed: {tried:?}");
        assert!(curves.tilt.points().len() >= 5, "{:?}", curves.tilt);
    }

    #[test]
    fn a_camera_of_one_speed_has_one_point_and_one_that_rests_has_none() {
        let (found, _) = sweep(|speed| if speed < 0.3 { 0.0 } else { 0.2 });
        assert_eq!(found.curves().unwrap().pan.points().len(), 1);
        let (found, tried) = sweep(|_| 0.0);
        assert_eq!((tried.len(), found.curves().unwrap_err().axis), (SPEEDS.len(), "pan"));
    }

    #[test]
    fn a_picture_that_tells_no_speed_ends_the_sweep_at_once() {
        let told = |pan| SpeedSweep::default().take(MeasuredSpeeds { pan, tilt: Ok(0.1) });
        let bars = CannotTell::Bars(Bars { top: 60, bottom: 56, ..Bars::default() });
        for reason in [CannotTell::NotMeasured, bars] {
            assert_eq!(told(Err(reason)), Err(SweepError { axis: "pan", reason }));
        }
        assert_eq!(told(Err(CannotTell::NotFollowing { explained: 0.2 })), Ok(()));
    }

    #[test]
    fn a_fast_camera_is_not_turned_at_its_higher_speeds() {
        let (found, tried) = sweep(|speed| 7.0 * speed);
        assert!(found.curves().unwrap().pan.points().len() >= 5, "{found:?}");
        assert!(tried.iter().all(|speed| 7.0 * speed < 1.2), "{tried:?}");
    }
}
