//! Whether the confidence is calibrated: of the frames reported with a confidence of 0.7, about 70 % should be correct.
//!
//! Measured on the labelled frames of all clips in which the tracker reports a box. A frame is correct where the box
//! has an IoU of at least 0.5 with the label, and incorrect where the target is absent. Judged is the share of correct
//! frames around a confidence of 0.7.

mod curve;
mod plot;

pub(crate) use curve::{Curve, Sample, samples};

use anyhow::Result;

use super::requirements::Requirements;
use super::text_table::{Table, cell};
use crate::svg;
use curve::{Bin, JUDGED_RANGE, MIN_CORRECT_IOU};

/// The range that is required of the share of correct frames in the judged bin.
const REQUIRED_SHARE: (f64, f64) = (0.55, 0.85);

/// Prints the curve.
pub(crate) fn print_table(curve: &Curve) {
    let mut table = Table::new(&["confidence", "frames", "mean", "share right"]);
    let mut row = |bin: &Bin| {
        table.row(vec![
            format!("{:.2} to {:.2}", bin.low, bin.high),
            bin.frames.to_string(),
            cell(bin.mean_confidence(), 3),
            cell(bin.share_correct(), 3),
        ]);
    };
    curve.bins.iter().for_each(&mut row);
    row(&curve.judged);
    table.print(&format!("Confidence of reported frames (right: IoU at least {MIN_CORRECT_IOU})"));
}

/// Judges the bin around 0.7.
pub(crate) fn judge(curve: &Curve, requirements: &mut Requirements) {
    let (low, high) = REQUIRED_SHARE;
    let share = curve.judged.share_correct();
    let name = format!("share right at confidence {} to {}", JUDGED_RANGE.0, JUDGED_RANGE.1);
    requirements.add(&name, share, &format!("{low} to {high}"), (low..=high).contains(&share));
}

/// Plots the curve to `target/acceptance/reliability.svg` in the workspace.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn save_plot(curve: &Curve) -> Result<()> {
    svg::save_plot("reliability.svg", &plot::plot(&curve.bins))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(samples: &[(f64, bool)]) -> Curve {
        let samples: Vec<Sample> =
            samples.iter().map(|&(confidence, is_correct)| Sample { confidence, is_correct }).collect();
        Curve::from_samples(&samples)
    }

    #[test]
    fn too_small_a_share_is_missed() {
        let mut requirements = Requirements::default();
        judge(&curve(&[(0.72, true), (0.68, false)]), &mut requirements);
        assert!(!requirements.finish(), "0.5 is too little");
    }

    #[test]
    fn the_plot_has_a_bar_and_a_mark_for_every_bin_with_frames() {
        let svg = plot::plot(&curve(&[(0.15, true), (0.95, true), (1.0, false)]).bins);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("<circle").count(), 2);
    }
}
