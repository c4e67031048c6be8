//! The clips beside OpenCV's CSRT and NanoTrack: quality and CPU time.

use super::measurement::{ClipMeasurement, members};
use crate::statistics::{mean, quantile};
use crate::tracker::clip_sets::ClipSet;
use crate::tracker::opencv::OpencvRuns;
use crate::tracker::scoring::Score;
use crate::tracker::text_table::{Table, cell};

/// The median CPU time of a tracked frame over the frames of clips, milliseconds; NaN of no frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MedianCpuMs {
    pub(super) tracker: f64,
    pub(super) csrt: f64,
    pub(super) nanotrack: f64,
    pub(super) lean_camshift: f64,
}

impl MedianCpuMs {
    /// Over the frames of the timed clips.
    pub(super) fn over_frames(clips: &[&ClipMeasurement]) -> Self {
        let timed: Vec<&ClipMeasurement> = clips.iter().copied().filter(|clip| clip.is_timed()).collect();
        let ours: Vec<f64> = timed.iter().flat_map(|clip| clip.cpu_ms.iter().copied()).collect();
        let theirs = |times: fn(&OpencvRuns) -> &[f64]| {
            let runs = timed.iter().filter_map(|clip| clip.opencv.as_ref());
            quantile(&runs.flat_map(times).copied().collect::<Vec<_>>(), 0.5)
        };
        Self {
            tracker: quantile(&ours, 0.5),
            csrt: theirs(|runs| &runs.csrt.cpu_ms),
            nanotrack: theirs(|runs| &runs.nanotrack.cpu_ms),
            lean_camshift: theirs(|runs| &runs.lean_camshift_cpu_ms),
        }
    }

    /// How many times as much CPU time CSRT takes.
    pub(super) fn times_cheaper_than_csrt(&self) -> f64 {
        self.csrt / self.tracker
    }

    /// How many times as much CPU time NanoTrack takes.
    pub(super) fn times_cheaper_than_nanotrack(&self) -> f64 {
        self.nanotrack / self.tracker
    }
}

/// The scores of the three trackers: this one, NanoTrack, CSRT.
type Scores = [Score; 3];

fn scores(clip: &ClipMeasurement) -> Option<Scores> {
    clip.opencv.as_ref().map(|opencv| [clip.score, opencv.nanotrack.score, opencv.csrt.score])
}

/// Prints each clip, and then the means over each set of clips; CPU times of a set are medians over its
/// frames.
pub(super) fn print(clips: &[ClipMeasurement], sets: &[ClipSet]) {
    let mut table = Table::new(&[
        "clip",
        "AUC",
        "Nano",
        "CSRT",
        "P20",
        "Nano",
        "CSRT",
        "lost",
        "Nano",
        "CSRT",
        "ms",
        "Nano",
        "CSRT",
        "Nano/ms",
        "CSRT/ms",
        "lean CamShift ms",
    ]);
    for clip in clips {
        if let Some(scores) = scores(clip) {
            table.row(cells(&clip.name, &[scores], MedianCpuMs::over_frames(&[clip])));
        }
    }
    for set in sets {
        let members = members(set, clips);
        let scores: Vec<Scores> = members.iter().filter_map(|clip| scores(clip)).collect();
        let name = format!("mean: {} ({})", set.name, set.len());
        table.row(cells(&name, &scores, MedianCpuMs::over_frames(&members)));
    }
    table.print(
        "Beside OpenCV's NanoTrack and CSRT (the same clips and selections, in turn, one thread; medians of CPU \
         milliseconds)",
    );
}

fn cells(name: &str, scores: &[Scores], cpu: MedianCpuMs) -> Vec<String> {
    let mut cells = vec![name.to_owned()];
    let values: [fn(&Score) -> f64; 3] = [|score| score.auc, |score| score.precision, |score| score.lost];
    for value in values {
        for tracker in 0..3 {
            let of_clips: Vec<f64> = scores.iter().map(|scores| value(&scores[tracker])).collect();
            cells.push(cell(mean(&of_clips), 3));
        }
    }
    cells.extend([
        cell(cpu.tracker, 3),
        cell(cpu.nanotrack, 2),
        cell(cpu.csrt, 2),
        cell(cpu.times_cheaper_than_nanotrack(), 1),
        cell(cpu.times_cheaper_than_csrt(), 1),
        cell(cpu.lean_camshift, 3),
    ]);
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_names_ours_nanotrack_and_csrt_in_turn() {
        let score = |auc| Score { auc, ..Score::default() };
        let cpu = MedianCpuMs { tracker: 0.5, csrt: 20.0, nanotrack: 6.0, lean_camshift: 1.0 };
        let scores = [[score(0.7), score(0.8), score(0.5)], [score(0.9), score(0.6), score(0.7)]];
        let cells = cells("clip", &scores, cpu);
        assert_eq!(cells[1..4], ["0.800", "0.700", "0.600"]);
        assert_eq!(cells[10..], ["0.500", "6.00", "20.00", "12.0", "40.0", "1.000"]);
    }
}
