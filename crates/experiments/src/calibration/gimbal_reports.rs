//! The convention of the reported tilt: which angle of the gimbal's attitude follows the tilt that the
//! picture shows.

use barrelman_vocab::Angle;
use barrelman_vocab::profile::{GimbalTilt, Sign};
use barrelman_vocab::telemetry::{EulerAxis, Quaternion};

use super::fit::AngleSample;

/// A report counts with the sample that lies at most so far off, seconds.
const MAX_OFFSET_S: f64 = 0.1;
/// Slopes of the angle over the tilt that count as "the same motion".
const SLOPES: core::ops::RangeInclusive<f64> = 0.7..=1.3;
/// Least share of the angle's variance that the tilt explains.
const MIN_EXPLAINED: f64 = 0.9;
/// Least number of reports during the motions of the tilt.
const MIN_REPORTS: usize = 20;

/// The convention under which the reports tell the tilt; `None`: no angle of them follows the tilt. `tilt` is
/// the tilt at the first sample.
pub(super) fn convention(
    reports: &[(f64, Quaternion)],
    tilts: &[AngleSample],
    tilt: Angle,
) -> Option<GimbalTilt> {
    let mut found = None;
    for axis in [EulerAxis::X, EulerAxis::Y, EulerAxis::Z] {
        let pairs: Vec<(f64, f64)> =
            reports.iter().filter_map(|(at_s, attitude)| pair(*at_s, *attitude, axis, tilts)).collect();
        if pairs.len() < MIN_REPORTS {
            continue;
        }
        let count = pairs.len() as f64;
        let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / count;
        let (turned, angle) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let moment = |value: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>();
        let xx = moment(&|pair| (pair.0 - turned) * (pair.0 - turned));
        let xy = moment(&|pair| (pair.0 - turned) * (pair.1 - angle));
        let yy = moment(&|pair| (pair.1 - angle) * (pair.1 - angle));
        if xx <= 0.0 || yy <= 0.0 {
            continue;
        }
        let (slope, explained) = (xy / xx, xy * xy / (xx * yy));
        if SLOPES.contains(&slope.abs()) && explained >= MIN_EXPLAINED {
            let sign = if slope > 0.0 { Sign::Same } else { Sign::Opposite };
            let zero = tilt.radians() + turned - slope.signum() * angle;
            let convention = GimbalTilt { axis, sign, zero: Angle::from_radians(zero) };
            found = match found {
                None => Some((explained, convention)),
                Some((best, _)) if explained > best => Some((explained, convention)),
                better => better,
            };
        }
    }
    found.map(|(_, convention)| convention)
}

/// The tilt since the first sample, and the reported angle, at the time of a report.
fn pair(at_s: f64, attitude: Quaternion, axis: EulerAxis, tilts: &[AngleSample]) -> Option<(f64, f64)> {
    let index = tilts.partition_point(|sample| sample.at_s < at_s);
    let sample = tilts.get(index).filter(|sample| sample.at_s - at_s <= MAX_OFFSET_S)?;
    Some((sample.angle[0], attitude.angle_about(axis)?.radians()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilts() -> Vec<AngleSample> {
        let at = |index: i32| f64::from(index) / 30.0;
        (0..300)
            .map(|index| AngleSample { at_s: at(index), angle: [0.2 * libm::sin(at(index)), 0.0], epoch: 0 })
            .collect()
    }

    #[test]
    fn the_angle_that_follows_the_tilt_is_found_with_its_sign_and_zero() {
        for (axis, slope, zero) in [(0, 1.0, 0.0), (1, -1.0, 0.1), (1, 1.0, -0.4), (2, -1.0, 0.0)] {
            let reports: Vec<(f64, Quaternion)> = (0..90)
                .map(|index| {
                    let at_s = f64::from(index) * 0.1;
                    let tilt = -0.4 + 0.2 * libm::sin(at_s);
                    let half = 0.5 * slope * (tilt - zero);
                    let mut part = [0.0; 3];
                    part[axis] = libm::sin(half);
                    (at_s, Quaternion { w: libm::cos(half), x: part[0], y: part[1], z: part[2] })
                })
                .collect();
            let found = convention(&reports, &tilts(), Angle::from_radians(-0.4)).unwrap();
            assert_eq!(found.axis, [EulerAxis::X, EulerAxis::Y, EulerAxis::Z][axis]);
            assert_eq!(found.sign, if slope > 0.0 { Sign::Same } else { Sign::Opposite });
            assert!((found.zero.radians() - zero).abs() < 0.01, "{found:?}");
            let (_, attitude) = reports[17];
            let tilt = found.tilt(attitude).unwrap().radians();
            assert!((tilt + 0.4 - 0.2 * libm::sin(1.7)).abs() < 0.01, "{tilt}");
        }
    }

    #[test]
    fn reports_that_do_not_follow_the_tilt_confirm_nothing() {
        let still = Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 };
        let reports: Vec<_> = (0..90).map(|index| (f64::from(index) * 0.1, still)).collect();
        assert_eq!(convention(&reports, &tilts(), Angle::ZERO), None);
        assert_eq!(convention(&[], &tilts(), Angle::ZERO), None);
    }
}
