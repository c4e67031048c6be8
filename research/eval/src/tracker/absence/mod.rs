//! Targets that leave the picture and return, with and without distractors of the target's colour.
//!
//! Measured on sequences cropped from real clips and on generated scenes, selected by the truth in the first
//! frame. Judged are the number of sequences and absent frames, how soon and how reliably an absence is
//! noticed, how many returns are found in time, and the longest time on a distractor.

mod absence_metrics;

mod cropped_sequence;
mod distractor;
mod target_path;
mod window_path;

use anyhow::Result;
use barrelman_vision::Tracker;
use barrelman_vocab::Track;
use barrelman_water_scene::{SceneKind, SceneScript, SceneTruth};
use serde_json::{Value, json};

use super::clips::list_clips;
use super::options::Options;
use super::requirements::Requirements;
use super::synthetic_scenes::{self, paint_name, paint_of_scene, run_on_scene};
use super::text_table::{Table, cell};
use super::tracker_run::{box_numbers, confidence, state_name};
use super::tracker_under_test::{TrackerConfig, build_tracker};
use crate::output::print_line;
use crate::parallel;
use absence_metrics::{AbsenceMetrics, FrameTruth, GRACE_S, MAX_FIND_S, measure};
use cropped_sequence::{CroppedSequence, SOURCE_CLIPS};

/// Sequences of each real clip, every other with distractors.
const CROPPED_OF_EACH_CLIP: u64 = 4;

/// Generated sequences, every other with distractors of the boat's paint.
const GENERATED: u64 = 20;

/// Duration of a generated sequence, seconds: enough for one or two absences.
const GENERATED_S: f64 = 20.0;

/// Lengths of the hull in consecutive generated sequences, pixels.
const BOATS_PX: [f64; 3] = [40.0, 80.0, 140.0];

const MIN_SEQUENCES: f64 = 30.0;
const MIN_ABSENT_FRAMES: f64 = 3000.0;
const MAX_LATE_REPORTED_SHARE: f64 = 0.02;
const MIN_FOUND_SHARE: f64 = 0.95;
const MAX_ON_DISTRACTOR_S: f64 = 0.5;

/// Runs all sequences, prints the table, judges the requirements, and returns the figures.
///
/// # Errors
/// If a clip cannot be used.
pub(crate) fn run(
    options: &Options,
    config: &TrackerConfig,
    requirements: &mut Requirements,
) -> Result<Value> {
    let mut sequences = run_cropped_sequences(options, config)?;
    sequences.extend(run_generated_sequences(options, config)?);
    let mut total = AbsenceMetrics::default();
    sequences.iter().for_each(|sequence| total.add(&sequence.metrics));
    print_table(&sequences, &total);
    print_line("");
    judge(sequences.len(), &total, requirements);
    Ok(Value::Array(sequences.iter().map(MeasuredSequence::to_json).collect()))
}

/// A sequence with its metrics.
struct MeasuredSequence {
    name: String,
    has_distractors: bool,
    metrics: AbsenceMetrics,
    /// Every frame, for a file.
    frames: Value,
}

impl MeasuredSequence {
    fn measure(name: String, has_distractors: bool, frames: &[(FrameTruth, Track)]) -> Self {
        let rows = frames.iter().map(|(truth, track)| {
            json!({
                "time_s": truth.time_s,
                "visible": truth.visible_share,
                "truth": (!truth.bounds.is_empty()).then(|| box_numbers(truth.bounds)),
                "like_things": truth.distractors.iter().copied().map(box_numbers).collect::<Vec<_>>(),
                "state": state_name(track),
                "confidence": confidence(track),
                "box": track.localisation().map(|localisation| box_numbers(localisation.bounds)),
            })
        });
        Self { name, has_distractors, metrics: measure(frames), frames: rows.collect() }
    }

    fn to_json(&self) -> Value {
        let metrics = &self.metrics;
        json!({
            "sequence": self.name, "like_things": self.has_distractors, "absent": metrics.absent,
            "absent_late": metrics.absent_late, "absent_late_reported": metrics.absent_late_reported,
            "lost_after_s": metrics.lost_after_s, "found_after_s": metrics.found_after_s,
            "on_distractor_s": metrics.on_distractor_s, "shown": metrics.shown,
            "shown_right": metrics.shown_correct, "frames": self.frames,
        })
    }
}

fn run_cropped_sequences(options: &Options, config: &TrackerConfig) -> Result<Vec<MeasuredSequence>> {
    let mut sequences = Vec::new();
    for source in &SOURCE_CLIPS {
        let folders = list_clips(&options.collections()?, &[source.clip.to_owned()])?;
        for folder in folders {
            let clip = folder.load()?;
            let numbers: Vec<u64> = (0..CROPPED_OF_EACH_CLIP).collect();
            let results = parallel::map(&numbers, |&number| {
                let has_distractors = number % 2 == 1;
                let sequence = CroppedSequence::new(&clip, source, number, has_distractors)?;
                let frames = run_on_sequence(build_tracker(config)?.as_mut(), &sequence);
                let name = format!("{} {number}", source.clip);
                anyhow::Ok(MeasuredSequence::measure(name, has_distractors, &frames))
            });
            sequences.extend(results.into_iter().collect::<Result<Vec<_>>>()?);
        }
    }
    Ok(sequences)
}

fn run_generated_sequences(options: &Options, config: &TrackerConfig) -> Result<Vec<MeasuredSequence>> {
    let numbers: Vec<u64> = (0..GENERATED.min(options.scenes.unwrap_or(GENERATED))).collect();
    let results = parallel::map(&numbers, |&number| {
        let has_distractors = number % 2 == 1;
        let boat_px = BOATS_PX[(number / 2 % BOATS_PX.len() as u64) as usize];
        let kind =
            if has_distractors { SceneKind::ExitAndReturnWithDistractor } else { SceneKind::ExitAndReturn };
        // Each paint occurs with and without distractors.
        let target = paint_of_scene(number / 2);
        let size = synthetic_scenes::SIZE;
        let script = SceneScript { kind, size, boat_px, seconds: GENERATED_S, target };
        let frames: Vec<(FrameTruth, Track)> = run_on_scene(build_tracker(config)?, script, number)
            .into_iter()
            .map(|(truth, track)| (frame_truth(&truth), track))
            .collect();
        let name = format!("generated {number}: {}, {boat_px} px", paint_name(target));
        anyhow::Ok(MeasuredSequence::measure(name, has_distractors, &frames))
    });
    results.into_iter().collect()
}

fn frame_truth(scene: &SceneTruth) -> FrameTruth {
    FrameTruth {
        time_s: scene.time_s,
        bounds: scene.bounds,
        visible_share: scene.visible_share,
        distractors: scene.distractors.into_iter().filter(|bounds| !bounds.is_empty()).collect(),
    }
}

/// Runs a tracker over a sequence. Returns truth and track of each frame after the first.
fn run_on_sequence(tracker: &mut dyn Tracker, sequence: &CroppedSequence<'_>) -> Vec<(FrameTruth, Track)> {
    let (first, truth) = sequence.render(0);
    let is_selected = tracker.select(&first, truth.bounds).is_ok();
    let mut results = Vec::with_capacity(sequence.frames());
    for frame in 1..sequence.frames() {
        let (picture, truth) = sequence.render(frame);
        let track = if is_selected { tracker.track(&picture, None) } else { Track::Unseeded };
        results.push((truth, track));
    }
    results
}

fn print_table(sequences: &[MeasuredSequence], total: &AbsenceMetrics) {
    let mut table = Table::new(&[
        "sequence",
        "like objects",
        "absent frames",
        "lost after s",
        "reported late",
        "returns",
        "found",
        "slowest s",
        "on a like object s",
        "right in view",
    ]);
    let cells = |name: &str, distractors: &str, metrics: &AbsenceMetrics| {
        let slowest = metrics.found_after_s.iter().flatten().copied().fold(f64::NAN, f64::max);
        vec![
            name.to_owned(),
            distractors.to_owned(),
            metrics.absent.to_string(),
            cell(metrics.slowest_loss_s(), 2),
            cell(metrics.late_reported_share(), 3),
            metrics.found_after_s.len().to_string(),
            metrics.found_returns().to_string(),
            cell(slowest, 2),
            cell(metrics.on_distractor_s, 2),
            cell(metrics.shown_correct as f64 / metrics.shown as f64, 3),
        ]
    };
    for MeasuredSequence { name, has_distractors, metrics, .. } in sequences {
        table.row(cells(name, if *has_distractors { "yes" } else { "no" }, metrics));
    }
    let with_distractors = sequences.iter().filter(|sequence| sequence.has_distractors).count();
    table.row(cells("all", &format!("{with_distractors} of {}", sequences.len()), total));
    table.print("Targets that leave the picture and come back");
}

fn judge(sequences: usize, total: &AbsenceMetrics, requirements: &mut Requirements) {
    requirements.at_least("exit and return: sequences", sequences as f64, MIN_SEQUENCES);
    requirements.at_least("exit and return: absent frames", total.absent as f64, MIN_ABSENT_FRAMES);
    requirements.at_most(
        "seconds until a target that left is first lost, worst",
        total.slowest_loss_s(),
        GRACE_S,
    );
    let name = format!("share of absent frames reported, later than {GRACE_S} s");
    requirements.at_most(&name, total.late_reported_share(), MAX_LATE_REPORTED_SHARE);
    let found = total.found_returns() as f64 / total.found_after_s.len() as f64;
    let name = format!("share of returns found within {MAX_FIND_S} s");
    requirements.at_least(&name, found, MIN_FOUND_SHARE);
    let name = "longest seconds on end on an object of the same colour";
    requirements.at_most(name, total.on_distractor_s, MAX_ON_DISTRACTOR_S);
}
