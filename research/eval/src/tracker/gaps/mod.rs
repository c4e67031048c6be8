//! Gaps in the video: whether the track goes on with another object, and whether the target is found again.
//!
//! Each clip is cut at several places. After the cut nothing is received for some seconds, and the picture
//! that follows shows another time, or another part of the scene, with the target in it or without. A frame
//! is *wrong* if a box is reported with a confidence of at least 0.5 that is not on the target: its IoU with
//! the truth is below 0.1, or the target is absent. The target is *taken back* at the first frame that is
//! tracked with an IoU of at least 0.3.

mod gap_sequence;

use anyhow::Result;
use barrelman_vision::Tracker;
use barrelman_vocab::Track;
use serde_json::{Value, json};

use self::gap_sequence::{GapSequence, Scene};
use super::clips::Clip;
use super::options::Options;
use super::requirements::Requirements;
use super::scoring::{Label, iou};
use super::text_table::{Table, cell};
use super::tracker_run::{confidence, state_name};
use super::tracker_under_test::TrackerFactory;
use crate::output::print_line;
use crate::parallel;

/// Cuts of each clip, evenly spread.
const CUTS: usize = 13;
/// Lengths of the gaps, seconds.
const GAPS_S: [f64; 4] = [0.8, 1.3, 2.5, 4.0];
/// From this confidence on a box counts.
const MIN_CONFIDENCE: f64 = 0.5;
/// A box with less IoU is on something else; one with at least this IoU is on the target.
const MAX_WRONG_IOU: f64 = 0.1;
const MIN_RIGHT_IOU: f64 = 0.3;
/// For so long after an absence began without a gap the target may still be reported, seconds.
const GRACE_S: f64 = 0.5;
/// The target is to be taken back within this time, seconds.
const TAKEN_BACK_S: f64 = 1.0;

/// One sequence with a gap, measured.
struct MeasuredGap {
    clip: String,
    scene: Scene,
    cut: usize,
    gap_s: f64,
    /// Labelled frames after the gap that are wrong, and the highest confidence of one.
    wrong: usize,
    wrong_confidence: f64,
    /// Whether a labelled frame after the gap shows the target, and the time until it was taken back,
    /// seconds.
    is_shown: bool,
    taken_back_s: Option<f64>,
    /// State, confidence and IoU of each labelled frame after the gap.
    frames: Value,
}

/// Runs all clips, prints the tables, judges the requirement, and returns the figures.
///
/// # Errors
/// If a clip cannot be used.
pub(crate) fn run(
    options: &Options,
    factory: TrackerFactory<'_>,
    requirements: &mut Requirements,
) -> Result<Value> {
    let mut measured = Vec::new();
    for folder in options.clip_folders()? {
        let clip = folder.load()?;
        let jobs: Vec<(Scene, usize, f64)> = jobs(&clip);
        let results = parallel::map(&jobs, |&(scene, cut, gap_s)| {
            let sequence = GapSequence::new(&clip, cut, gap_s, scene)?;
            let tracker = &mut *factory(&clip.name);
            measure(tracker, &clip, &sequence, (scene, cut, gap_s))
        });
        measured.extend(results.into_iter().flatten());
    }
    print_tables(&measured);
    let wrong = measured.iter().filter(|gap| gap.wrong > 0).count();
    requirements.at_most("gaps: sequences with another object at 0.5 or more", wrong as f64, 0.0);
    Ok(Value::Array(measured.iter().map(MeasuredGap::to_json).collect()))
}

/// The sequences of a clip: scene, cut and length of the gap.
fn jobs(clip: &Clip) -> Vec<(Scene, usize, f64)> {
    let Some(last) = clip.labels.iter().rposition(Option::is_some) else { return Vec::new() };
    let cuts = (1..=CUTS).map(|number| clip.start + number * (last - clip.start) / CUTS);
    let with_gaps = |cut: usize| {
        Scene::ALL.into_iter().flat_map(move |scene| {
            let gaps = if scene == Scene::Leaving { &GAPS_S[..1] } else { &GAPS_S[..] };
            gaps.iter().map(move |gap_s| (scene, cut, *gap_s))
        })
    };
    cuts.flat_map(with_gaps).collect()
}

/// Runs a tracker over a sequence; `None` where the selection is refused or the target is lost before the
/// gap.
fn measure(
    tracker: &mut dyn Tracker,
    clip: &Clip,
    sequence: &GapSequence,
    (scene, cut, gap_s): (Scene, usize, f64),
) -> Option<MeasuredGap> {
    let (first, label) = sequence.frames.first()?;
    let Some(Label::Visible(selection)) = label else { return None };
    tracker.select(first, *selection).ok()?;
    let tracks: Vec<Track> =
        sequence.frames[1..].iter().map(|(frame, _)| tracker.track(frame, None)).collect();
    let size = first.picture.size();
    let judged = |index: usize| {
        let (frame, label) = &sequence.frames[index];
        let bounds = tracks[index - 1].localisation().map(|seen| seen.bounds);
        let overlap = match label {
            Some(Label::Visible(truth)) => Some(iou(*truth, bounds, size)),
            Some(Label::Absent) => Some(0.0),
            None => None,
        };
        (frame.capture.at, *label, overlap)
    };
    let is_on_target_before = (1..sequence.resumes)
        .rev()
        .find_map(|index| judged(index).2)
        .is_none_or(|overlap| overlap >= MIN_RIGHT_IOU);
    if !is_on_target_before {
        return None;
    }
    let resumed_at = sequence.frames[sequence.resumes].0.capture.at;
    let mut gap = MeasuredGap {
        clip: clip.name.clone(),
        scene,
        cut,
        gap_s,
        wrong: 0,
        wrong_confidence: 0.0,
        is_shown: false,
        taken_back_s: None,
        frames: Value::Null,
    };
    let (mut rows, mut absent_since) = (Vec::new(), None);
    for index in sequence.resumes..sequence.frames.len() {
        let (at, Some(label), Some(overlap)) = judged(index) else { continue };
        let track = &tracks[index - 1];
        let reported = track.localisation().map_or(0.0, |seen| seen.confidence);
        let is_excused = scene == Scene::Leaving
            && match label {
                Label::Visible(_) => true,
                Label::Absent => at.since(*absent_since.get_or_insert(at)).as_secs_f64() <= GRACE_S,
            };
        if reported >= MIN_CONFIDENCE && overlap < MAX_WRONG_IOU && !is_excused {
            gap.wrong += 1;
            gap.wrong_confidence = gap.wrong_confidence.max(reported);
        }
        if scene != Scene::Leaving && matches!(label, Label::Visible(_)) {
            gap.is_shown = true;
            if matches!(track, Track::Tracking(_)) && overlap >= MIN_RIGHT_IOU {
                gap.taken_back_s.get_or_insert(at.since(resumed_at).as_secs_f64());
            }
        }
        rows.push(json!([state_name(track), confidence(track), overlap]));
    }
    gap.frames = Value::Array(rows);
    Some(gap)
}

impl MeasuredGap {
    fn to_json(&self) -> Value {
        json!({
            "clip": self.clip, "scene": self.scene.name(), "cut": self.cut, "gap_s": self.gap_s,
            "wrong": self.wrong, "wrong_confidence": self.wrong_confidence, "shown": self.is_shown,
            "taken_back_s": self.taken_back_s, "frames": self.frames,
        })
    }
}

fn print_tables(measured: &[MeasuredGap]) {
    for gap in measured.iter().filter(|gap| gap.wrong > 0) {
        print_line(&format!(
            "  {}, cut {}, {} s, {}: {} frames wrong, up to {:.2}",
            gap.clip,
            gap.cut,
            gap.gap_s,
            gap.scene.name(),
            gap.wrong,
            gap.wrong_confidence
        ));
    }
    let mut table =
        Table::new(&["after the gap", "gap s", "sequences", "wrong", "shown", "taken back", "median s"]);
    for scene in Scene::ALL {
        for gap_s in GAPS_S {
            let of: Vec<&MeasuredGap> =
                measured.iter().filter(|gap| gap.scene == scene && gap.gap_s == gap_s).collect();
            if of.is_empty() {
                continue;
            }
            let shown = of.iter().filter(|gap| gap.is_shown).count();
            let mut times: Vec<f64> = of.iter().filter_map(|gap| gap.taken_back_s).collect();
            times.sort_by(f64::total_cmp);
            let within = times.iter().filter(|after_s| **after_s <= TAKEN_BACK_S).count();
            table.row(vec![
                scene.name().to_owned(),
                if scene == Scene::Leaving { "-".to_owned() } else { gap_s.to_string() },
                of.len().to_string(),
                of.iter().filter(|gap| gap.wrong > 0).count().to_string(),
                shown.to_string(),
                within.to_string(),
                cell(times.get(times.len() / 2).copied().unwrap_or(f64::NAN), 2),
            ]);
        }
    }
    table.print(&format!("Gaps in the video (taken back within {TAKEN_BACK_S} s)"));
}
