//! The printed tables of clips.

use super::measurement::{ClipMeasurement, MeanCpuMs, mean_score};
use crate::output::print_line;
use crate::statistics::{TimingSummary, mean};
use crate::tracker::csrt::CsrtRun;
use crate::tracker::scoring::Score;
use crate::tracker::text_table::{Table, cell};
use crate::tracker::tracker_under_test;

/// Prints quality and CPU time of each clip and the means, and then the refused selections.
pub(super) fn print_clips(clips: &[ClipMeasurement]) {
    let mut table = Table::new(&[
        "clip",
        "size",
        "scored",
        "AUC",
        "P20",
        "lost",
        "absent",
        "reported",
        "ms median",
        "p99",
        "mean",
    ]);
    let cells = |name: &str, size: String, score: &Score, scored: String, cpu: TimingSummary| {
        vec![
            name.to_owned(),
            size,
            scored,
            cell(score.auc, 3),
            cell(score.precision, 3),
            cell(score.lost, 3),
            score.absent.to_string(),
            cell(score.absent_share().unwrap_or(f64::NAN), 3),
            cell(cpu.median, 3),
            cell(cpu.p99, 3),
            cell(cpu.mean, 3),
        ]
    };
    for clip in clips {
        let cpu = TimingSummary::from_times_ms(&clip.cpu_ms);
        let scored = clip.score.scored.to_string();
        table.row(cells(&clip.name, clip.size.to_string(), &clip.score, scored, cpu));
    }
    let timings: Vec<TimingSummary> = clips
        .iter()
        .filter(|clip| clip.is_timed())
        .map(|clip| TimingSummary::from_times_ms(&clip.cpu_ms))
        .collect();
    let mean_of = |value: fn(&TimingSummary) -> f64| mean(&timings.iter().map(value).collect::<Vec<_>>());
    let means = Score {
        auc: mean_score(clips, |score| score.auc),
        precision: mean_score(clips, |score| score.precision),
        lost: mean_score(clips, |score| score.lost),
        scored: 0,
        absent: clips.iter().map(|clip| clip.score.absent).sum(),
        absent_reported: clips.iter().map(|clip| clip.score.absent_reported).sum(),
    };
    let cpu = TimingSummary {
        median: mean_of(|cpu| cpu.median),
        p99: mean_of(|cpu| cpu.p99),
        mean: mean_of(|cpu| cpu.mean),
    };
    let scored: usize = clips.iter().map(|clip| clip.score.scored).sum();
    table.row(cells("mean over clips", String::new(), &means, scored.to_string(), cpu));
    table.print(&format!(
        "{} on the clips (CPU milliseconds of each tracked frame)",
        tracker_under_test::NAME
    ));
    for clip in clips {
        if let Some(error) = &clip.selection_error {
            print_line(&format!("{}: {error}", clip.name));
        }
    }
}

/// Prints the clips beside OpenCV's CSRT.
pub(super) fn print_beside_csrt(clips: &[ClipMeasurement]) {
    let mut table = Table::new(&[
        "clip",
        "AUC",
        "CSRT",
        "ratio",
        "P20",
        "CSRT",
        "lost",
        "CSRT",
        "ms mean",
        "CSRT",
        "times cheaper",
        "lean CamShift ms",
    ]);
    for clip in clips {
        let Some(csrt) = &clip.csrt else { continue };
        let (ours, theirs) = (mean(&clip.cpu_ms), mean(&csrt.cpu_ms));
        table.row(vec![
            clip.name.clone(),
            cell(clip.score.auc, 3),
            cell(csrt.score.auc, 3),
            cell(clip.score.auc / csrt.score.auc, 2),
            cell(clip.score.precision, 3),
            cell(csrt.score.precision, 3),
            cell(clip.score.lost, 3),
            cell(csrt.score.lost, 3),
            cell(ours, 3),
            cell(theirs, 2),
            cell(theirs / ours, 1),
            cell(mean(&csrt.lean_camshift_cpu_ms), 3),
        ]);
    }
    let csrt_mean = |value: fn(&CsrtRun) -> f64| {
        mean(&clips.iter().filter_map(|clip| clip.csrt.as_ref().map(value)).collect::<Vec<_>>())
    };
    let auc = mean_score(clips, |score| score.auc);
    let csrt_auc = csrt_mean(|csrt| csrt.score.auc);
    let cpu = MeanCpuMs::over_clips(clips, |_| true);
    table.row(vec![
        "mean over clips".to_owned(),
        cell(auc, 3),
        cell(csrt_auc, 3),
        cell(auc / csrt_auc, 2),
        cell(mean_score(clips, |score| score.precision), 3),
        cell(csrt_mean(|csrt| csrt.score.precision), 3),
        cell(mean_score(clips, |score| score.lost), 3),
        cell(csrt_mean(|csrt| csrt.score.lost), 3),
        cell(cpu.tracker, 3),
        cell(cpu.csrt, 2),
        cell(cpu.csrt / cpu.tracker, 1),
        cell(cpu.lean_camshift, 3),
    ]);
    table.print("Beside OpenCV's CSRT (one thread, the same clips and selections, in turn)");
}

/// Prints quality and CPU time of the enlarged clips.
pub(super) fn print_upscaled(clips: &[ClipMeasurement]) {
    let mut table = Table::new(&["clip at 1920x1080", "AUC", "ms median", "p99", "mean"]);
    for clip in clips {
        let Some((score, cpu_ms)) = &clip.upscaled else { continue };
        let cpu = TimingSummary::from_times_ms(cpu_ms);
        table.row(vec![
            clip.name.clone(),
            cell(score.auc, 3),
            cell(cpu.median, 3),
            cell(cpu.p99, 3),
            cell(cpu.mean, 3),
        ]);
    }
    table.print("Clips of 1280x720 enlarged to 1920x1080");
}
