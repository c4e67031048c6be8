//! Scales and their ticks.

use super::text::format_number;

/// A linear map of values to coordinates on the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// First and last value.
    pub(super) values: (f64, f64),
    /// Their coordinates, units of paper.
    pub(super) paper: (f64, f64),
}

impl Scale {
    /// Coordinate of a value.
    pub(super) fn at(&self, value: f64) -> f64 {
        let ((low, high), (from, to)) = (self.values, self.paper);
        if high > low { from + (value - low) / (high - low) * (to - from) } else { 0.5 * (from + to) }
    }

    /// Units of paper per unit of the value.
    pub(super) fn per_value(&self) -> f64 {
        let ((low, high), (from, to)) = (self.values, self.paper);
        if high > low { ((to - from) / (high - low)).abs() } else { 0.0 }
    }

    /// About `count` ticks within the values.
    pub(super) fn ticks(&self, count: usize) -> Ticks {
        Ticks::within(self.values.0, self.values.1, count)
    }
}

/// Ticks at round values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    /// Values of the ticks.
    pub(super) values: Vec<f64>,
    decimals: usize,
}

impl Ticks {
    /// About `count` ticks, at multiples of 1, 2 or 5 times a power of ten.
    pub(super) fn within(low: f64, high: f64, count: usize) -> Self {
        let rough_step = (high - low) / count.max(1) as f64;
        if !rough_step.is_finite() || rough_step <= 0.0 {
            return Self { values: vec![low], decimals: 1 };
        }
        let (mut power, mut decimals) = (1.0, 0_usize);
        while power > rough_step {
            power /= 10.0;
            decimals += 1;
        }
        while power * 10.0 <= rough_step {
            power *= 10.0;
        }
        let step = [1.0, 2.0, 5.0].iter().map(|by| by * power).find(|step| *step >= rough_step);
        let step = step.unwrap_or(10.0 * power);
        if step >= 10.0 * power {
            decimals = decimals.saturating_sub(1);
        }
        let slack = 1e-9 * step;
        let first = ((low - slack) / step).ceil();
        let steps = ((high + slack) / step).floor() - first;
        let values =
            (0..=steps.clamp(0.0, 100.0) as i64).map(|index| (first + index as f64) * step).collect();
        Self { values, decimals }
    }

    /// The values with their labels.
    pub(super) fn labelled(&self) -> impl Iterator<Item = (f64, String)> {
        self.values.iter().map(|value| (*value, format_number(*value, self.decimals)))
    }
}

#[cfg(test)]
mod tests {
    use super::Ticks;

    #[test]
    fn ticks_are_round_and_within() {
        let check = |low: f64, high: f64, about: usize, expected: &[&str]| {
            let labels: Vec<String> =
                Ticks::within(low, high, about).labelled().map(|(_, label)| label).collect();
            assert_eq!(labels, expected, "{low} to {high}");
        };
        check(0.0, 60.0, 6, &["0", "10", "20", "30", "40", "50", "60"]);
        check(0.0, 3.1, 4, &["0", "1", "2", "3"]);
        check(0.0, 0.9, 4, &["0.0", "0.5"]);
        check(-0.3, 0.3, 3, &["\u{2212}0.2", "0.0", "0.2"]);
        check(-11.0, 2.0, 5, &["\u{2212}10", "\u{2212}5", "0"]);
        check(5.0, 5.0, 5, &["5.0"]);
        check(0.0, f64::NAN, 5, &["0.0"]);
    }
}
