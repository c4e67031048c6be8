//! The table that `compare` prints, at most 80 columns wide.

use std::fmt::{self, Display, Formatter};
use std::path::Path;

use barrelman_trial::campaign::statistics::Interval;
use barrelman_trial::campaign::{CampaignComparison, MeanOfAll, PairedMetric, SettingDifference};

/// Significant digits of a mean, and of an interval.
const DIGITS: (usize, usize) = (4, 3);

/// A comparison of two files.
pub(super) struct ComparisonTable<'a> {
    pub(super) comparison: &'a CampaignComparison,
    pub(super) files: (&'a Path, &'a Path),
    /// The settings in which the campaigns differ by choice.
    pub(super) choices: &'a [SettingDifference],
}

impl ComparisonTable<'_> {
    /// The mark of a figure that does not rest on all pairs.
    fn mark(&self, figure: &PairedMetric) -> &'static str {
        if figure.pairs < self.comparison.pairs { "*" } else { "" }
    }

    fn write_heading(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let described = |values: &dyn Fn(&SettingDifference) -> String| {
            let words: Vec<String> =
                self.choices.iter().map(|choice| format!("{} {}", choice.setting, values(choice))).collect();
            if words.is_empty() { String::new() } else { format!(" ({})", words.join("; ")) }
        };
        writeln!(f, "A: {}{}", self.files.0.display(), described(&|choice| choice.first.clone()))?;
        writeln!(f, "B: {}{}", self.files.1.display(), described(&|choice| choice.second.clone()))?;
        writeln!(f, "{} trials in both; 95 % intervals, pairs resampled", self.comparison.pairs)?;
        writeln!(f, "\n{:32} {:>5} {:>8} {:>8} {:>22}", "mean of", "pairs", "A", "B", "B / A")
    }

    fn write_row(&self, f: &mut Formatter<'_>, figure: &PairedMetric) -> fmt::Result {
        let name = match figure.unit {
            "" => figure.metric.to_owned(),
            unit => format!("{}, {unit}", figure.metric),
        };
        let change = match (&figure.ratio, &figure.difference) {
            (Some(ratio), _) => interval(ratio, ""),
            (None, Some(difference)) if difference.value != 0.0 => interval(difference, "+ "),
            (None, _) => "-".to_owned(),
        };
        let (pairs, mark) = (figure.pairs, self.mark(figure));
        let (first, second) = (significant(figure.first, DIGITS.0), significant(figure.second, DIGITS.0));
        // The mark stands beside the column of numbers.
        writeln!(f, "{name:32} {pairs:>5}{mark:1}{first:>8} {second:>8} {change:>22}")
    }

    /// The figures of fewer pairs beside the means over all trials of each file.
    fn write_marked(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let marked = self.comparison.metrics.iter().filter(|figure| !self.mark(figure).is_empty());
        let marked = marked.map(|f| (f.metric, Some(f.first_of_all), Some(f.second_of_all)));
        let unpaired = self.comparison.unpaired.iter().map(|f| (f.metric, f.first_of_all, f.second_of_all));
        let mut rows = marked.chain(unpaired).peekable();
        if rows.peek().is_none() {
            return Ok(());
        }
        writeln!(
            f,
            "\n* Not of all {} pairs, or of none: of those in which both trials have the\n  figure (without a complete excursion a \
             trial has no h, b, s). Over all trials\n  that have it, as metrics and report count:",
            self.comparison.pairs
        )?;
        for (metric, first, second) in rows {
            let of_all = |mean: Option<MeanOfAll>| {
                mean.map_or_else(
                    || "- (no trial)".to_owned(),
                    |mean| format!("{} ({} trials)", significant(mean.mean, DIGITS.0), mean.trials),
                )
            };
            writeln!(f, "  {metric:27} A {:<22} B {}", of_all(first), of_all(second))?;
        }
        Ok(())
    }
}

impl Display for ComparisonTable<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.write_heading(f)?;
        for figure in &self.comparison.metrics {
            self.write_row(f, figure)?;
        }
        let is_difference = |figure: &PairedMetric| {
            figure.ratio.is_none() && figure.difference.is_some_and(|difference| difference.value != 0.0)
        };
        if self.comparison.metrics.iter().any(is_difference) {
            writeln!(f, "\nA sign before the value: B - A, where A is 0.")?;
        }
        self.write_marked(f)
    }
}

/// A value with its interval.
fn interval(interval: &Interval, sign: &str) -> String {
    let number = |value| significant(value, DIGITS.1);
    format!("{sign}{} ({} to {})", number(interval.value), number(interval.low), number(interval.high))
}

/// A number with about this many significant digits, without an exponent.
fn significant(value: f64, digits: usize) -> String {
    let magnitude = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    // From four digits before the point on to four after it.
    let decimals = (digits as f64 - 1.0 - magnitude).clamp(0.0, digits as f64) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn numbers_have_few_digits_and_no_exponent() {
        for (value, expected) in [
            (0.0, "0.000"),
            (1612.34, "1612"),
            (16.1234, "16.12"),
            (1.0, "1.000"),
            (0.263_18, "0.2632"),
            (0.012_345, "0.0123"),
            (-0.55, "-0.5500"),
            (123_456.0, "123456"),
        ] {
            assert_eq!(significant(value, 4), expected, "{value}");
        }
    }
}
