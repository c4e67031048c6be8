//! Selections drawn on an earlier video frame, through the pilot: how often the track that is confirmed is
//! the target's.
//!
//! The pilot is stepped with the frames up to the moment of the request; the box is the truth of a frame that
//! is 0.2, 0.5 or 1.0 s old then, or a box that is drawn about the truth by a hand. *Right*: confirmed, and
//! the box overlaps the truth by IoU 0.5 on confirmation and 1 s later. *Refused*: the pilot says that it
//! follows nothing. *Lost*: confirmed, but the pilot says that the target is lost when it is judged. *Wrong*:
//! confirmed, and the box does not overlap the truth. Ten start frames of each clip, evenly spread over those
//! from which the target stays visible until 1 s after the confirmation can come. In a clip with sparse
//! labels the start frames are labelled ones, and the track is judged on the next labelled frame. A target of
//! which more than half is hidden is not visible, whether or not it is labelled: no track can be judged by
//! what cannot be seen.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Result;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_pilot::{Input, Notice, Pilot, PilotSettings};
use barrelman_trial::campaign::hand_drawn_box::drawn_by_hand;
use barrelman_vision::{FusedConfig, FusedTracker};
use barrelman_vocab::{CameraRequest, DrawnSelection, OperatorRequest, PixelBox, Timestamp, VehicleProfile};
use clap::Args;
use serde_json::json;

use super::clip_sets::hidden_frames;
use super::clips::{Clip, list_clips};
use super::scoring::Label;
use super::{candidates, empty_water, tapped_people, taps};
use crate::output::print_line;
use crate::rng_of_name::rng_of_name;
use crate::workspace::path_or_default;

/// Ages of the frame on which the box is drawn, seconds.
const AGES_S: [f64; 3] = [0.2, 0.5, 1.0];
/// Longest time from the request to the confirmation that start frames allow for, seconds.
const CONFIRMED_WITHIN_S: f64 = 0.6;
/// How long after the confirmation the track is judged again, seconds.
const JUDGED_AFTER_S: f64 = 1.0;
/// Least IoU of a right track.
const MIN_IOU: f64 = 0.5;
/// Parts of the names of clips of boats.
const BOATS: [&str; 5] = ["boat", "ship", "raft", "arena", "field"];

/// Options of `selection`.
#[derive(Debug, Args)]
pub(crate) struct SelectionOptions {
    /// The folder of clips: a folder each with video.mp4, and gt.csv or truth.csv (of `barrelman render`)
    /// [default: ../shared/data/clips beside the workspace].
    #[arg(long, value_name = "DIR")]
    clips: Option<PathBuf>,
    /// Only this clip (repeatable).
    #[arg(long, value_name = "NAME")]
    clip: Vec<String>,
    /// Start frames of each clip, for each age of the frame.
    #[arg(long, value_name = "COUNT", default_value_t = 10)]
    starts: usize,
    /// Draw the boxes as a hand does, not exactly: off by up to 0.15 of the target's sides, 0.85 to 1.5 times
    /// as wide and high, at least 8 x 6 pixels. The seed of the boxes.
    #[arg(long, value_name = "SEED")]
    by_hand: Option<u64>,
    /// Instead, tap on labelled targets, and compare the proposed boxes with the labels [default clips: those
    /// of ../shared/data/clips-more, too].
    #[arg(long)]
    taps: bool,
    /// Instead, tap on the people in the clips once, and follow them to the end.
    #[arg(long, conflicts_with = "taps")]
    people: bool,
    /// The objects that are found in single pictures instead: on --starts labelled frames of each clip.
    #[arg(long, conflicts_with_all = ["taps", "people"])]
    candidates: bool,
    /// The candidates on water without any object instead, in --starts rendered seas of each sea state.
    #[arg(long, conflicts_with_all = ["taps", "people", "candidates"])]
    empty_water: bool,
    /// Print each selection that was not right.
    #[arg(long)]
    each: bool,
    /// Write all figures to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// One selection: what became of it, and how well the track overlapped the truth.
#[derive(Debug, Clone)]
struct Selected {
    verdict: Verdict,
    /// IoU on confirmation and when it was judged again.
    ious: [Option<f64>; 2],
    /// What the track said then, and the truth.
    judged: [Option<Judged>; 2],
    /// Confidences of the newest frames, from the first that the track reached to the confirmation.
    confidences: Vec<f64>,
    /// Longest step, milliseconds.
    step_ms: f64,
}

/// The box of a track and the truth, pixels, and the track's confidence.
#[derive(Debug, Clone, Copy)]
struct Judged {
    tracked: PixelBox,
    truth: PixelBox,
    confidence: f64,
}

impl Judged {
    fn json(self) -> serde_json::Value {
        let sides = |PixelBox { u, v, w, h }: PixelBox| [u, v, w, h];
        json!({"tracked": sides(self.tracked), "truth": sides(self.truth), "confidence": self.confidence})
    }
}

/// What became of one selection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Right,
    Refused,
    Lost,
    Wrong,
}

/// Counts of verdicts.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    right: usize,
    refused: usize,
    lost: usize,
    wrong: usize,
}

impl Tally {
    fn add(&mut self, verdict: Verdict) {
        *match verdict {
            Verdict::Right => &mut self.right,
            Verdict::Refused => &mut self.refused,
            Verdict::Lost => &mut self.lost,
            Verdict::Wrong => &mut self.wrong,
        } += 1;
    }

    fn plus(self, other: Self) -> Self {
        Self {
            right: self.right + other.right,
            refused: self.refused + other.refused,
            lost: self.lost + other.lost,
            wrong: self.wrong + other.wrong,
        }
    }

    const fn count(self) -> usize {
        self.right + self.refused + self.lost + self.wrong
    }

    fn text(self) -> String {
        let all = self.count().max(1) as f64;
        let share = |count: usize| 100.0 * count as f64 / all;
        format!(
            "{:>4} right ({:>5.1} %)  {:>3} refused ({:>4.1} %)  {:>3} lost  {:>3} wrong ({:>4.1} %)",
            self.right,
            share(self.right),
            self.refused,
            share(self.refused),
            self.lost,
            self.wrong,
            share(self.wrong)
        )
    }
}

/// Measures selections on earlier frames. Returns whether clips of boats hold what is required: 95 % right,
/// at most 5 % refused, none wrong.
///
/// # Errors
/// If a clip or the output file cannot be used.
pub(crate) fn run(options: &SelectionOptions) -> Result<bool> {
    if options.people {
        return tapped_people::run(options.clips.as_deref(), &options.clip);
    }
    if options.candidates {
        return candidates::run(options.clips.as_deref(), &options.clip, options.starts);
    }
    if options.empty_water {
        return empty_water::run(options.starts);
    }
    if options.taps {
        return taps::run(options.clips.as_deref(), &options.clip, options.starts);
    }
    let folder = path_or_default(options.clips.as_ref(), "../shared/data/clips")?;
    let (mut boats, mut all) = (Tally::default(), Tally::default());
    let (mut figures, mut selections) = (Vec::new(), Vec::new());
    let mut slowest_ms: f64 = 0.0;
    for clip in list_clips(&[folder], &options.clip)? {
        let clip = clip.load()?;
        let truth = visible(&clip);
        let mut tallies = [Tally::default(); AGES_S.len()];
        for (tally, age_s) in tallies.iter_mut().zip(AGES_S) {
            for start in starts(&clip, &truth, age_s, options.starts) {
                let exact = truth[start].unwrap_or_default();
                let drawn = match options.by_hand {
                    None => exact,
                    Some(seed) => {
                        let number =
                            seed.wrapping_mul(1 << 32) + ((start as u64) << 8) + (10.0 * age_s) as u64;
                        let mut rng = rng_of_name(&clip.name, number);
                        drawn_by_hand(exact, clip.size(), |_, (low, high)| rng.between(low, high))
                    }
                };
                let selected = select(&clip, &truth, (start, drawn), age_s)?;
                slowest_ms = slowest_ms.max(selected.step_ms);
                tally.add(selected.verdict);
                let Selected { verdict, ious, judged, confidences, .. } = selected;
                if options.each && verdict != Verdict::Right {
                    print_line(&format!(
                        "  {} from frame {start}, {age_s} s: {verdict:?}, IoU {ious:.2?}, confidences {confidences:.2?}",
                        clip.name
                    ));
                }
                selections.push(json!({"clip": clip.name, "start": start, "age_s": age_s, "verdict": format!("{verdict:?}").to_lowercase(), "ious": ious, "judged": judged.map(|judged| judged.map(Judged::json)), "confidences": confidences}));
            }
        }
        let sum = tallies.into_iter().fold(Tally::default(), Tally::plus);
        let is_boat = BOATS.iter().any(|part| clip.name.contains(part));
        print_line(&format!("{:<30} {}  {}", clip.name, if is_boat { "boat" } else { "    " }, sum.text()));
        all = all.plus(sum);
        if is_boat {
            boats = boats.plus(sum);
        }
        for (tally, age_s) in tallies.iter().zip(AGES_S) {
            figures.push(json!({"clip": clip.name, "age_s": age_s, "right": tally.right, "refused": tally.refused, "lost": tally.lost, "wrong": tally.wrong}));
        }
    }
    print_line(&format!("{:<36} {}", "boats", boats.text()));
    print_line(&format!("{:<36} {}", "all clips", all.text()));
    print_line(&format!("longest step of the pilot with a selection: {slowest_ms:.1} ms"));
    if let Some(path) = &options.json {
        std::fs::write(
            path,
            json!({"clips": figures, "selections": selections, "longest_step_ms": slowest_ms}).to_string()
                + "\n",
        )?;
    }
    let count = boats.count();
    Ok(boats.wrong == 0 && 20 * boats.refused <= count && 20 * boats.right >= 19 * count)
}

/// The truth of each frame that is labelled as visible, and in which at most half of the target is hidden.
fn visible(clip: &Clip) -> Vec<Option<PixelBox>> {
    let hidden = hidden_frames(&clip.name);
    let bounds = |(frame, label): (usize, &Option<Label>)| match label {
        Some(Label::Visible(bounds)) if !hidden.contains(&frame) => Some(*bounds),
        _ => None,
    };
    clip.labels.iter().enumerate().map(bounds).collect()
}

/// Evenly spread start frames: labelled, followed by enough labels, and with the target visible in all of
/// them.
fn starts(clip: &Clip, truth: &[Option<PixelBox>], age_s: f64, count: usize) -> Vec<usize> {
    let at = |index: usize| clip.frames[index].capture.at;
    let needed = Duration::from_secs_f64(age_s + CONFIRMED_WITHIN_S + JUDGED_AFTER_S);
    let is_possible = |start: usize| {
        let until = at(start).plus(needed);
        let end =
            (start..clip.frames.len()).find(|index| at(*index) >= until && clip.labels[*index].is_some());
        let is_visible = |index: usize| clip.labels[index].is_none() || truth[index].is_some();
        truth[start].is_some() && end.is_some_and(|end| (start..=end).all(is_visible))
    };
    let possible: Vec<usize> = (0..clip.frames.len()).filter(|start| is_possible(*start)).collect();
    let count = possible.len().min(count);
    (0..count).map(|index| possible[index * possible.len() / count]).collect()
}

/// Makes one selection.
fn select(
    clip: &Clip,
    truth: &[Option<PixelBox>],
    (start, bounds): (usize, PixelBox),
    age_s: f64,
) -> Result<Selected> {
    let settings =
        PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawChoice::OPTIMAL.settings() };
    let tracker = FusedTracker::new(FusedConfig::default())?;
    let mut pilot = Pilot::new(settings, Box::new(tracker)).keeping_frames();
    let drawn_at = clip.frames[start].capture.at;
    let requested_at = drawn_at.plus(Duration::from_secs_f64(age_s));
    let (mut confirmed_at, mut is_requested): (Option<Timestamp>, bool) = (None, false);
    // A selection that is not confirmed counts as refused.
    let mut selected = Selected {
        verdict: Verdict::Refused,
        ious: [None; 2],
        judged: [None; 2],
        confidences: Vec::new(),
        step_ms: 0.0,
    };
    for (index, frame) in clip.frames.iter().enumerate().skip(start) {
        let now = frame.capture.at;
        let begin = Instant::now();
        let outcome = pilot.step(Input::Frame(frame), now);
        if outcome.is_confirming || is_requested {
            selected.step_ms = selected.step_ms.max(begin.elapsed().as_secs_f64() * 1e3);
        }
        if is_requested
            && confirmed_at.is_none()
            && let Some(seen) = outcome.track.localisation()
        {
            selected.confidences.push(seen.confidence);
        }
        match &outcome.notice {
            Some(Notice::SelectionConfirmed(_)) => confirmed_at = Some(now),
            Some(
                Notice::RequestRefused(_) | Notice::SelectionRefused(_) | Notice::SelectionUnconfirmed(_),
            ) => return Ok(selected),
            _ => {}
        }
        if let (Some(confirmed), Some(truth)) = (confirmed_at, truth[index]) {
            let seen = outcome.track.localisation();
            let iou = seen.map(|seen| seen.bounds.iou(truth));
            let is_second = now.since(confirmed).as_secs_f64() >= JUDGED_AFTER_S;
            if selected.ious[0].is_none() || is_second {
                selected.ious[usize::from(is_second)] = iou;
                selected.judged[usize::from(is_second)] =
                    seen.map(|seen| Judged { tracked: seen.bounds, truth, confidence: seen.confidence });
                selected.verdict = match iou {
                    Some(iou) if iou >= MIN_IOU => Verdict::Right,
                    Some(_) => Verdict::Wrong,
                    None => Verdict::Lost,
                };
                if is_second || selected.verdict != Verdict::Right {
                    return Ok(selected);
                }
            }
        }
        if !is_requested && now >= requested_at {
            is_requested = true;
            let selection = DrawnSelection { bounds, captured_ns: drawn_at };
            pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::Select(selection))), now);
        }
    }
    Ok(selected)
}
