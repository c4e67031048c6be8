//! Targets that leave the picture and come back, with and without things of the same colour.

use anyhow::Result;
use barrelman_sim::water_scene::{SceneKind, SceneScript, SceneTruth};
use barrelman_vision::Tracker;
use barrelman_vocab::Track;
use serde_json::{Value, json};

use super::Options;
use super::clips;
use super::follow::{confidence_of, corners, state_of};
use super::generated;
use super::parallel;
use super::report::{Requirements, Table, cell};
use super::under_test::{self, Config};

mod judge;

mod composed;
mod thing;

use composed::{Composed, SOURCES};
use judge::{FIND_WITHIN_S, GRACE_S, Judged, Truth, judge};

/// Sequences of each real clip, every other with things of the target's colour.
const COMPOSED_OF_EACH: u64 = 4;

/// Generated sequences, every other with things of the boat's paint.
const GENERATED: u64 = 20;

/// Their length, seconds: room for one or two absences.
const GENERATED_S: f64 = 20.0;

/// Lengths of the hull, pixels, one after the other.
const BOATS_PX: [f64; 3] = [40.0, 80.0, 140.0];

const SEQUENCES_WANTED: f64 = 30.0;
const ABSENT_FRAMES_WANTED: f64 = 3000.0;
const LATE_SHARE_WANTED: f64 = 0.02;
const FOUND_SHARE_WANTED: f64 = 0.95;
const ON_DISTRACTOR_S_WANTED: f64 = 0.5;

/// Runs all sequences, prints the table, judges the requirements, and returns the figures.
///
/// # Errors
/// If a clip cannot be used.
pub(crate) fn run(options: &Options, config: &Config, requirements: &mut Requirements) -> Result<Value> {
    let mut sequences = composed_ones(options, config)?;
    sequences.extend(generated_ones(options, config)?);
    Ok(say_table(&sequences, requirements))
}

/// One sequence and what became of it.
struct Sequence {
    name: String,
    like_things: bool,
    judged: Judged,
    /// Every frame of it, for a file.
    frames: Value,
}

impl Sequence {
    fn of(name: String, like_things: bool, frames: &[(Truth, Track)]) -> Self {
        let rows = frames.iter().map(|(truth, track)| {
            json!({
                "time_s": truth.time_s,
                "visible": truth.visible,
                "truth": (!truth.bounds.is_empty()).then(|| corners(truth.bounds)),
                "like_things": truth.distractors.iter().copied().map(corners).collect::<Vec<_>>(),
                "state": state_of(track),
                "confidence": confidence_of(track),
                "box": track.localisation().map(|seen| corners(seen.bounds)),
            })
        });
        Self { name, like_things, judged: judge(frames), frames: rows.collect() }
    }
}

fn composed_ones(options: &Options, config: &Config) -> Result<Vec<Sequence>> {
    let mut sequences = Vec::new();
    for source in &SOURCES {
        let folders = clips::list(&options.clips_folder()?, &[source.clip.to_owned()])?;
        for folder in folders {
            let clip = folder.load()?;
            let numbers: Vec<u64> = (0..COMPOSED_OF_EACH).collect();
            let done = parallel::map(&numbers, |&number| {
                let like_things = number % 2 == 1;
                let sequence = Composed::new(&clip, source, number, like_things)?;
                let frames = watch(under_test::make(config)?.as_mut(), &sequence);
                anyhow::Ok(Sequence::of(format!("{} {number}", source.clip), like_things, &frames))
            });
            sequences.extend(done.into_iter().collect::<Result<Vec<_>>>()?);
        }
    }
    Ok(sequences)
}

fn generated_ones(options: &Options, config: &Config) -> Result<Vec<Sequence>> {
    let numbers: Vec<u64> = (0..GENERATED.min(options.scenes.unwrap_or(GENERATED))).collect();
    let done = parallel::map(&numbers, |&number| {
        let like_things = number % 2 == 1;
        let boat_px = BOATS_PX[(number / 2 % BOATS_PX.len() as u64) as usize];
        let kind =
            if like_things { SceneKind::ExitAndReturnWithDistractor } else { SceneKind::ExitAndReturn };
        // Each paint with and without things like it.
        let target = generated::paint(number / 2);
        let script = SceneScript { kind, size: generated::SIZE, boat_px, seconds: GENERATED_S, target };
        let said = generated::watch(under_test::make(config)?, script, number);
        let frames: Vec<(Truth, Track)> =
            said.into_iter().map(|(truth, track)| (truth_of(&truth), track)).collect();
        let name = format!("generated {number}: {}, {boat_px} px", generated::name_of(target));
        anyhow::Ok(Sequence::of(name, like_things, &frames))
    });
    done.into_iter().collect()
}

fn truth_of(scene: &SceneTruth) -> Truth {
    Truth {
        time_s: scene.time_s,
        bounds: scene.bounds,
        visible: scene.visible_share,
        distractors: scene.distractors.into_iter().filter(|thing| !thing.is_empty()).collect(),
    }
}

/// Shows a tracker all frames of a sequence, selected by the truth in the first.
fn watch(tracker: &mut dyn Tracker, sequence: &Composed<'_>) -> Vec<(Truth, Track)> {
    let (first, truth) = sequence.draw(0);
    let selected = tracker.select(&first, truth.bounds).is_ok();
    let mut said = Vec::with_capacity(sequence.frames());
    for frame in 1..sequence.frames() {
        let (picture, truth) = sequence.draw(frame);
        let track = if selected { tracker.track(&picture, None) } else { Track::Unseeded };
        said.push((truth, track));
    }
    said
}

fn say_table(sequences: &[Sequence], requirements: &mut Requirements) -> Value {
    let mut table = Table::new(&[
        "sequence",
        "like things",
        "absent frames",
        "lost after s",
        "reported late",
        "returns",
        "found",
        "slowest s",
        "on a like thing s",
        "right in view",
    ]);
    let row = |name: &str, like: &str, judged: &Judged| {
        let slowest = judged.found_after_s.iter().flatten().copied().fold(f64::NAN, f64::max);
        vec![
            name.to_owned(),
            like.to_owned(),
            judged.absent.to_string(),
            cell(judged.slowest_loss_s(), 2),
            cell(judged.late_share(), 3),
            judged.found_after_s.len().to_string(),
            judged.found().to_string(),
            cell(slowest, 2),
            cell(judged.on_distractor_s, 2),
            cell(judged.shown_right as f64 / judged.shown as f64, 3),
        ]
    };
    let mut total = Judged::default();
    for Sequence { name, like_things, judged, .. } in sequences {
        table.row(row(name, if *like_things { "yes" } else { "no" }, judged));
        total.add(judged);
    }
    let with_things = sequences.iter().filter(|sequence| sequence.like_things).count();
    table.row(row("all", &format!("{with_things} of {}", sequences.len()), &total));
    table.say("Targets that leave the picture and come back");
    crate::say("");
    requirements.at_least("exit and return: sequences", sequences.len() as f64, SEQUENCES_WANTED);
    requirements.at_least("exit and return: absent frames", total.absent as f64, ABSENT_FRAMES_WANTED);
    requirements.at_most(
        "seconds until a target that left is first lost, worst",
        total.slowest_loss_s(),
        GRACE_S,
    );
    let name = format!("share of absent frames reported, later than {GRACE_S} s");
    requirements.at_most(&name, total.late_share(), LATE_SHARE_WANTED);
    let found = total.found() as f64 / total.found_after_s.len() as f64;
    let name = format!("share of returns found within {FIND_WITHIN_S} s");
    requirements.at_least(&name, found, FOUND_SHARE_WANTED);
    let name = "longest seconds on end on a thing of the same colour";
    requirements.at_most(name, total.on_distractor_s, ON_DISTRACTOR_S_WANTED);
    let rows = sequences.iter().map(|Sequence { name, like_things, judged, frames }| {
        json!({
            "sequence": name, "like_things": like_things, "absent": judged.absent, "absent_late": judged.absent_late,
            "absent_late_reported": judged.absent_late_reported, "lost_after_s": judged.lost_after_s,
            "found_after_s": judged.found_after_s, "on_distractor_s": judged.on_distractor_s,
            "shown": judged.shown, "shown_right": judged.shown_right, "frames": frames,
        })
    });
    Value::Array(rows.collect())
}
