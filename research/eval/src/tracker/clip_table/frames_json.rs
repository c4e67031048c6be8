//! The tracked frames of a clip as JSON.

use serde_json::{Value, json};

use crate::tracker::clips::Clip;
use crate::tracker::scoring::{Label, iou};
use crate::tracker::tracker_run::{TrackerRun, box_numbers, confidence, state_name};

/// Every tracked frame: track, label, IoU and CPU time.
pub(super) fn frames_to_json(clip: &Clip, run: &TrackerRun) -> Value {
    let mut frames = Vec::new();
    for (index, (track, label)) in run.tracks.iter().zip(clip.tracked_labels()).enumerate() {
        let bounds = track.localisation().map(|localisation| localisation.bounds);
        let truth = match label {
            Some(Label::Visible(truth)) => Some(*truth),
            _ => None,
        };
        frames.push(json!({
            "frame": clip.start + 1 + index,
            "state": state_name(track),
            "confidence": confidence(track),
            "box": bounds.map(box_numbers),
            "truth": truth.map(box_numbers),
            "absent": *label == Some(Label::Absent),
            "iou": truth.map(|truth| iou(truth, bounds, clip.size())),
            "cpu_ms": run.cpu_times.get(index).map(|time| time.as_secs_f64() * 1e3),
        }));
    }
    Value::Array(frames)
}
