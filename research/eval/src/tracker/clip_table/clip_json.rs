//! The figures of a clip as JSON.

use serde_json::{Value, json};

use super::measurement::ClipMeasurement;
use crate::statistics::TimingSummary;
use crate::tracker::opencv::OpencvRun;
use crate::tracker::scoring::Score;
use crate::tracker::tracker_run::box_numbers;

/// The figures of a clip.
pub(super) fn clip_to_json(clip: ClipMeasurement) -> Value {
    let cpu = |times: &[f64]| {
        let cpu = TimingSummary::from_times_ms(times);
        json!({ "median": cpu.median, "p99": cpu.p99, "mean": cpu.mean })
    };
    let score = |score: &Score| {
        json!({
            "auc": score.auc, "precision": score.precision, "lost": score.lost, "scored": score.scored,
            "absent": score.absent, "absent_reported": score.absent_reported,
        })
    };
    let run = |run: &OpencvRun| {
        json!({
            "score": score(&run.score),
            "cpu_ms": cpu(&run.cpu_ms),
            "boxes": run.boxes.iter().map(|bounds| bounds.map(box_numbers)).collect::<Vec<_>>(),
        })
    };
    json!({
        "clip": clip.name,
        "folder": clip.collection,
        "width": clip.size.width,
        "height": clip.size.height,
        "score": score(&clip.score),
        "cpu_ms": cpu(&clip.cpu_ms),
        "refused": clip.selection_error.map(|error| error.to_string()),
        "opencv": clip.opencv.map(|opencv| json!({
            "csrt": run(&opencv.csrt),
            "nanotrack": run(&opencv.nanotrack),
            "lean_camshift_cpu_ms": cpu(&opencv.lean_camshift_cpu_ms),
        })),
        "jittered": clip.perturbed.map(|scores| scores.iter().map(score).collect::<Vec<_>>()),
        "upscaled": clip.upscaled.map(|(upscaled, times)| json!({ "score": score(&upscaled), "cpu_ms": cpu(&times) })),
        "frames": clip.frames,
    })
}
