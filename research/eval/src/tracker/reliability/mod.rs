//! Whether the confidence is calibrated: of the frames reported with a confidence of 0.7, about 70 % should
//! be correct.
//!
//! Measured on the labelled frames of all clips after the selection's, from the label as selection; for
//! comparison also from loose selections. A frame is correct where the reported box has an IoU of at
//! least 0.5 with the label. Judged are how often the track is sure and wrong, how often a correct one is
//! sure, how well the confidence tells correct frames from the others, and the difference of share and
//! confidence in each tenth of the confidence.

mod calibration;
mod curve;
mod labelled_frame;
mod plot;

pub(crate) use curve::Curve;
pub(crate) use labelled_frame::{LabelledFrame, labelled_frames};

use std::collections::BTreeMap;

use anyhow::Result;
use serde_json::{Value, json};

use super::clip_sets::recording_of;
use super::requirements::Requirements;
use super::text_table::{Table, cell};
use crate::output::print_line;
use crate::svg;
use calibration::{Calibration, MAX_CALIBRATION_ERROR};
use curve::Bin;
use labelled_frame::{MIN_CORRECT_IOU, MIN_TARGET_IOU, SURE};

/// Largest share of the labelled frames that are sure and wrong.
const MAX_SURE_AND_WRONG: f64 = 0.01;
/// Least share of the correct frames that are sure.
const MIN_CORRECT_SURE: f64 = 0.6;
const MIN_AUROC: f64 = 0.85;

/// The labelled frames of a clip.
pub(crate) struct ClipFrames<'a> {
    pub(crate) clip: &'a str,
    /// With the label as selection.
    pub(crate) exact: &'a [LabelledFrame],
    /// With loose selections, where these were measured.
    pub(crate) loose: Option<&'a [LabelledFrame]>,
}

/// Prints the figures and plots the curve to `target/acceptance/reliability.svg` in the workspace, judges the
/// exact selections if `is_judged`, and returns the figures.
///
/// # Errors
/// If the plot cannot be written.
pub(crate) fn report(
    clips: &[ClipFrames<'_>],
    is_judged: bool,
    requirements: &mut Requirements,
) -> Result<Value> {
    let exact: Vec<LabelledFrame> = clips.iter().flat_map(|clip| clip.exact).copied().collect();
    let exact = Calibration::from_frames(&exact);
    let loose: Vec<LabelledFrame> = clips.iter().filter_map(|clip| clip.loose).flatten().copied().collect();
    let loose = (!loose.is_empty()).then(|| Calibration::from_frames(&loose));
    print_figures(&exact, loose.as_ref());
    print_curve(&exact.curve);
    let recordings = print_recordings(clips);
    print_line("");
    if is_judged {
        judge(&exact, requirements);
    }
    svg::save_plot("reliability.svg", &plot::plot(&exact, loose.as_ref()))?;
    Ok(json!({
        "exact": exact.to_json(),
        "loose": loose.as_ref().map(Calibration::to_json),
        "recordings": recordings,
    }))
}

fn print_figures(exact: &Calibration, loose: Option<&Calibration>) {
    let mut table = Table::new(&[
        "selections",
        "labelled",
        "reported",
        "sure and wrong",
        "share",
        "right that are sure",
        "AUROC",
        "largest error of a tenth",
    ]);
    for (name, figures) in
        [("exact", Some(exact)), ("loose", loose)].into_iter().filter_map(|(n, f)| Some((n, f?)))
    {
        let largest = figures.judged_bins().map(Bin::calibration_error).fold(f64::NAN, f64::max);
        table.row(vec![
            name.to_owned(),
            figures.labelled.to_string(),
            figures.reported.to_string(),
            figures.sure_and_wrong.to_string(),
            cell(figures.sure_and_wrong_share(), 4),
            cell(figures.correct_sure_share, 3),
            cell(figures.auroc, 3),
            cell(largest, 3),
        ]);
    }
    table.print(&format!(
        "Confidence on labelled frames (sure: at least {SURE}; wrong: IoU below {MIN_TARGET_IOU}; right: at least \
         {MIN_CORRECT_IOU})"
    ));
}

/// Prints the curve.
pub(crate) fn print_curve(curve: &Curve) {
    let mut table = Table::new(&["confidence", "frames", "mean", "share right"]);
    for bin in &curve.bins {
        table.row(vec![
            format!("{:.1} to {:.1}", bin.low, bin.high),
            bin.frames.to_string(),
            cell(bin.mean_confidence(), 3),
            cell(bin.share_correct(), 3),
        ]);
    }
    table.print(&format!("Confidence of reported frames (right: IoU at least {MIN_CORRECT_IOU})"));
}

/// Prints for each recording how many labelled frames are sure and wrong, and returns the figures.
fn print_recordings(clips: &[ClipFrames<'_>]) -> Value {
    let mut recordings: BTreeMap<&str, (Vec<LabelledFrame>, Vec<LabelledFrame>)> = BTreeMap::new();
    for clip in clips {
        let (exact, loose) = recordings.entry(recording_of(clip.clip)).or_default();
        exact.extend(clip.exact);
        loose.extend(clip.loose.unwrap_or_default());
    }
    let mut table = Table::new(&["recording", "labelled", "sure and wrong", "share", "loose: share"]);
    let mut json = Vec::new();
    for (recording, (exact, loose)) in recordings {
        let wrong = exact.iter().filter(|frame| frame.is_sure_and_wrong()).count();
        let share = wrong as f64 / exact.len() as f64;
        let loose_wrong = loose.iter().filter(|frame| frame.is_sure_and_wrong()).count();
        let loose_share = loose_wrong as f64 / loose.len() as f64;
        table.row(vec![
            recording.to_owned(),
            exact.len().to_string(),
            wrong.to_string(),
            cell(share, 4),
            cell(loose_share, 4),
        ]);
        json.push(json!({
            "recording": recording, "labelled": exact.len(), "sure_and_wrong": wrong,
            "loose_labelled": loose.len(), "loose_sure_and_wrong": loose_wrong,
        }));
    }
    table.print("Sure and wrong by recording");
    Value::Array(json)
}

fn judge(figures: &Calibration, requirements: &mut Requirements) {
    let share = figures.sure_and_wrong_share();
    requirements.at_most("confidence: share of frames sure and wrong", share, MAX_SURE_AND_WRONG);
    let name = format!("confidence: share of right frames with at least {SURE}");
    requirements.at_least(&name, figures.correct_sure_share, MIN_CORRECT_SURE);
    requirements.at_least("confidence: AUROC", figures.auroc, MIN_AUROC);
    for bin in figures.judged_bins() {
        let name = format!("confidence {:.1} to {:.1}: error of the share right", bin.low, bin.high);
        requirements.at_most(&name, bin.calibration_error(), MAX_CALIBRATION_ERROR);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hundred frames with a confidence of 0.95, this many of them correct, and the rest with this IoU.
    fn frames(correct: usize, other_iou: f64) -> Vec<LabelledFrame> {
        let iou = |index| if index < correct { 0.8 } else { other_iou };
        (0..100).map(|index| LabelledFrame { confidence: Some(0.95), iou: iou(index) }).collect()
    }

    fn missed(frames: &[LabelledFrame]) -> Vec<String> {
        let mut requirements = Requirements::default();
        judge(&Calibration::from_frames(frames), &mut requirements);
        let rows = requirements.to_json();
        let missed = rows.as_array().unwrap().iter().filter(|row| row["holds"] == false);
        missed.map(|row| row["name"].as_str().unwrap().to_owned()).collect()
    }

    #[test]
    fn confident_mistakes_are_missed() {
        let frames = [frames(98, 0.0), vec![LabelledFrame { confidence: Some(0.1), iou: 0.3 }; 99]].concat();
        assert_eq!(missed(&frames), ["confidence: share of frames sure and wrong"]);
    }

    #[test]
    fn a_tenth_with_too_small_a_share_is_missed() {
        let frames = [frames(80, 0.3), vec![LabelledFrame { confidence: Some(0.1), iou: 0.3 }; 99]].concat();
        assert_eq!(missed(&frames), ["confidence 0.9 to 1.0: error of the share right"]);
    }

    #[test]
    fn the_plot_has_a_bar_and_a_mark_for_every_bin_with_frames() {
        let frame = |confidence, iou| LabelledFrame { confidence: Some(confidence), iou };
        let exact = Calibration::from_frames(&[frame(0.15, 0.9), frame(0.95, 0.9), frame(1.0, 0.0)]);
        let svg = plot::plot(&exact, None);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("<circle").count(), 2);
        assert_eq!(plot::plot(&exact, Some(&exact)).matches("<circle").count(), 4);
    }
}
