//! The printed tables of clips.

use super::measurement::{ClipMeasurement, mean_score, members};
use crate::output::print_line;
use crate::statistics::{TimingSummary, mean};
use crate::tracker::clip_sets::{ClipSet, count_recordings};
use crate::tracker::scoring::Score;
use crate::tracker::text_table::{Table, cell};
use crate::tracker::tracker_under_test;

/// Prints quality and CPU time of each clip, folder by folder, and then the refused selections.
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
    for collection in clips.chunk_by(|a, b| a.collection == b.collection) {
        table.row(vec![format!("{}:", collection[0].collection)]);
        for clip in collection {
            let cpu = TimingSummary::from_times_ms(&clip.cpu_ms);
            table.row(vec![
                clip.name.clone(),
                clip.size.to_string(),
                clip.score.scored.to_string(),
                cell(clip.score.auc, 3),
                cell(clip.score.precision, 3),
                cell(clip.score.lost, 3),
                clip.score.absent.to_string(),
                cell(clip.score.absent_share().unwrap_or(f64::NAN), 3),
                cell(cpu.median, 3),
                cell(cpu.p99, 3),
                cell(cpu.mean, 3),
            ]);
        }
    }
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

/// Prints the means over each set of clips, over its clips and over its recordings.
pub(super) fn print_means(clips: &[ClipMeasurement], sets: &[ClipSet]) {
    let mut table = Table::new(&[
        "mean over",
        "clips",
        "AUC",
        "P20",
        "lost",
        "recordings",
        "AUC",
        "P20",
        "lost",
        "absent",
        "reported",
        "ms median",
        "p99",
        "mean",
    ]);
    for set in sets {
        let members = members(set, clips);
        let values: [fn(&Score) -> f64; 3] = [|score| score.auc, |score| score.precision, |score| score.lost];
        let means = values.map(|value| mean_score(&members, value));
        let recordings = count_recordings(members.iter().map(|clip| clip.name.as_str()));
        let absent = Score {
            absent: members.iter().map(|clip| clip.score.absent).sum(),
            absent_reported: members.iter().map(|clip| clip.score.absent_reported).sum(),
            ..Score::default()
        };
        let timings: Vec<TimingSummary> = members
            .iter()
            .filter(|clip| clip.is_timed())
            .map(|clip| TimingSummary::from_times_ms(&clip.cpu_ms))
            .collect();
        let cpu =
            |value: fn(&TimingSummary) -> f64| cell(mean(&timings.iter().map(value).collect::<Vec<_>>()), 3);
        let mut row = vec![set.name.clone(), set.len().to_string()];
        row.extend(means.map(|mean| cell(mean.over_clips, 3)));
        row.push(recordings.to_string());
        row.extend(means.map(|mean| cell(mean.over_recordings, 3)));
        row.extend([absent.absent.to_string(), cell(absent.absent_share().unwrap_or(f64::NAN), 3)]);
        row.extend([cpu(|cpu| cpu.median), cpu(|cpu| cpu.p99), cpu(|cpu| cpu.mean)]);
        table.row(row);
    }
    table.print("Means (a recording counts once, with the mean of its clips)");
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
