//! Whether the confidence means what it says: of the frames reported with a confidence of 0.7, about seven in ten
//! should be right.
//!
//! A frame is right where its IoU with the label is at least 0.5; one in which an absent target is reported is wrong.
//! Frames without a label do not count.

use anyhow::Result;

use super::clips::Clip;
use super::follow::Followed;
use super::report::{Requirements, Table, cell};
use super::scoring::{Label, overlap};
use crate::svg;

mod plot;

/// Overlap from which on a box is right: the usual one of detection benchmarks.
const RIGHT_FROM: f64 = 0.5;

/// Bins of 0.1 over 0 to 1.
const BINS: usize = 10;

/// The confidence at which a pilot decides, in the middle of the bin that is judged.
const JUDGED: (f64, f64) = (0.65, 0.75);

/// What the share of right frames may be there.
const WANTED: (f64, f64) = (0.55, 0.85);

/// One reported frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    confidence: f64,
    right: bool,
}

/// Frames with a confidence in one range.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bin {
    low: f64,
    high: f64,
    frames: usize,
    right: usize,
    confidence_sum: f64,
}

impl Bin {
    fn of(samples: &[Sample], low: f64, high: f64) -> Self {
        let mut bin = Self { low, high, frames: 0, right: 0, confidence_sum: 0.0 };
        // The last bin holds 1 itself.
        let within = |confidence: f64| confidence >= low && (confidence < high || high >= 1.0);
        for sample in samples.iter().filter(|sample| within(sample.confidence)) {
            bin.frames += 1;
            bin.right += usize::from(sample.right);
            bin.confidence_sum += sample.confidence;
        }
        bin
    }

    /// Share of right frames; not a number where there are none.
    fn share(&self) -> f64 {
        self.right as f64 / self.frames as f64
    }

    fn confidence(&self) -> f64 {
        self.confidence_sum / self.frames as f64
    }
}

/// The reliability curve.
pub(crate) struct Curve {
    bins: Vec<Bin>,
    judged: Bin,
}

/// The reported frames of one run.
pub(crate) fn samples(clip: &Clip, followed: &Followed) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (track, label) in followed.tracks.iter().zip(clip.tracked_labels()) {
        let (Some(seen), Some(label)) = (track.localisation(), label) else { continue };
        let right = match label {
            Label::There(truth) => overlap(*truth, Some(seen.bounds), clip.size()) >= RIGHT_FROM,
            Label::Absent => false,
        };
        samples.push(Sample { confidence: seen.confidence, right });
    }
    samples
}

/// Counts them.
pub(crate) fn curve(samples: &[Sample]) -> Curve {
    let edge = |bin: usize| bin as f64 / BINS as f64;
    Curve {
        bins: (0..BINS).map(|bin| Bin::of(samples, edge(bin), edge(bin + 1))).collect(),
        judged: Bin::of(samples, JUDGED.0, JUDGED.1),
    }
}

/// Prints the curve.
pub(crate) fn say_table(curve: &Curve) {
    let mut table = Table::new(&["confidence", "frames", "mean", "share right"]);
    let mut row = |bin: &Bin| {
        table.row(vec![
            format!("{:.2} to {:.2}", bin.low, bin.high),
            bin.frames.to_string(),
            cell(bin.confidence(), 3),
            cell(bin.share(), 3),
        ]);
    };
    curve.bins.iter().for_each(&mut row);
    row(&curve.judged);
    table.say(&format!("Confidence of reported frames (right: IoU at least {RIGHT_FROM})"));
}

/// Judges the bin around 0.7.
pub(crate) fn judge(curve: &Curve, requirements: &mut Requirements) {
    let (low, high) = WANTED;
    let share = curve.judged.share();
    let name = format!("share right at confidence {} to {}", JUDGED.0, JUDGED.1);
    requirements.add(&name, share, &format!("{low} to {high}"), (low..=high).contains(&share));
}

/// Draws the curve to `target/acceptance/reliability.svg` in the workspace.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn draw(curve: &Curve) -> Result<()> {
    svg::keep("reliability.svg", &plot::svg(&curve.bins))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(confidence: f64, right: bool) -> Sample {
        Sample { confidence, right }
    }

    #[test]
    fn every_confidence_lies_in_one_bin() {
        let samples: Vec<Sample> =
            (0..=100).map(|step| sample(f64::from(step) / 100.0, step >= 50)).collect();
        let curve = curve(&samples);
        let frames: Vec<usize> = curve.bins.iter().map(|bin| bin.frames).collect();
        assert_eq!(frames, [10, 10, 10, 10, 10, 10, 10, 10, 10, 11]);
        assert_eq!((curve.bins[4].share(), curve.bins[5].share()), (0.0, 1.0));
        assert_eq!(curve.judged.frames, 10);
    }

    #[test]
    fn a_bin_without_frames_has_no_share() {
        let curve = curve(&[sample(0.72, true), sample(0.68, false)]);
        assert!(curve.bins[0].share().is_nan());
        assert_eq!((curve.judged.share(), curve.judged.frames), (0.5, 2));
        let mut requirements = Requirements::default();
        judge(&curve, &mut requirements);
        assert!(!requirements.finish(), "0.5 is too little");
    }

    #[test]
    fn the_plot_has_a_bar_and_a_mark_for_every_bin_with_frames() {
        let drawn = plot::svg(&curve(&[sample(0.15, true), sample(0.95, true), sample(1.0, false)]).bins);
        assert!(drawn.starts_with("<svg") && drawn.trim_end().ends_with("</svg>"));
        assert_eq!(drawn.matches("<circle").count(), 2);
    }
}
