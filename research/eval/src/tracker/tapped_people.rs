//! Tapped people: a person in a real clip is tapped once, in the first frame, and followed to the end; and so
//! is, by a tracker of its own, each other person whose place is listed.
//!
//! The proposed box is the selection, as for a mark. A clip whose tap is refused counts as lost in every
//! frame. Of the other people only the first place is known (`data/other_people.csv`): for each the table has
//! the share of frames in which its tracker reports a box, that in which both trackers are on one object, and
//! that in which its tracker is on the labelled person. The rule that takes one of two such marks from an
//! object is the pilot's, and is not part of this measurement.

use std::path::Path;

use anyhow::{Context, Result};
use barrelman_vision::{ObjectSizes, Proposer};
use barrelman_vocab::{PixelBox, PixelPoint};

use super::clip_sets::{class_of, is_on_water};
use super::clips::Clip;
use super::labelled_pictures::chosen_clips;
use super::scoring::{Label, Score};
use super::text_table::{Table, cell};
use super::tracker_run::{TrackerRun, run_tracker};
use super::tracker_under_test::{TrackerConfig, build_tracker};
use crate::parallel;
use crate::statistics::mean;

/// Where other people are in the first labelled frame of a clip, pixels.
const OTHER_PEOPLE: &str = include_str!("../../data/other_people.csv");
/// Two boxes with at least this IoU are on one object.
const ONE_OBJECT_IOU: f64 = 0.5;

/// A clip, followed from a tap.
struct Followed {
    name: String,
    /// IoU of the proposal with the label; `None`: refused.
    proposal: Option<f64>,
    tapped: Score,
    /// From the label as the selection.
    selected: Score,
    others: Vec<Other>,
}

/// Another person, followed from a tap: shares of the frames.
struct Other {
    reported: f64,
    on_one_object: f64,
    on_labelled: f64,
}

/// Prints the table of the people in the clips of this folder, or else of all.
///
/// # Errors
/// If a clip cannot be used.
pub(super) fn run(folder: Option<&Path>, names: &[String]) -> Result<bool> {
    let mut clips = chosen_clips(folder, names)?;
    clips.retain(|clip| class_of(&clip.name).is_ok_and(|class| class == "person"));
    let followed = parallel::map(&clips, |clip| follow(&clip.load()?));
    let followed = followed.into_iter().collect::<Result<Vec<_>>>()?;
    print_people(&followed);
    print_others(&followed);
    Ok(true)
}

fn follow(clip: &Clip) -> Result<Followed> {
    let selected = from_box(clip, clip.selection)?.score(clip);
    let (proposal, run) = from_tap(clip, clip.selection.centre())?;
    let others = other_people(&clip.name)?.into_iter().map(|at| other(clip, &run, at));
    let others = others.collect::<Result<_>>()?;
    let proposal = proposal.map(|bounds| bounds.iou(clip.selection));
    Ok(Followed { name: clip.name.clone(), proposal, tapped: run.score(clip), selected, others })
}

fn from_box(clip: &Clip, selection: PixelBox) -> Result<TrackerRun> {
    Ok(run_tracker(build_tracker(&TrackerConfig::default())?.as_mut(), clip, selection))
}

/// The box that is proposed for a tap, and the run from there on.
fn from_tap(clip: &Clip, at: PixelPoint) -> Result<(Option<PixelBox>, TrackerRun)> {
    let sizes = ObjectSizes::in_picture_of_height(clip.size().height);
    let proposed = Proposer::default().propose(&clip.frames[clip.start].picture, at, sizes);
    let bounds = proposed.ok().map(|proposal| proposal.bounds);
    // An empty selection is refused.
    Ok((bounds, from_box(clip, bounds.unwrap_or_default())?))
}

fn other(clip: &Clip, first: &TrackerRun, at: PixelPoint) -> Result<Other> {
    let (_, run) = from_tap(clip, at)?;
    let (first, boxes) = (first.boxes(), run.boxes());
    let share = |is_so: &dyn Fn(usize, PixelBox) -> bool| {
        let count = boxes
            .iter()
            .enumerate()
            .filter(|(frame, bounds)| bounds.is_some_and(|bounds| is_so(*frame, bounds)));
        count.count() as f64 / boxes.len().max(1) as f64
    };
    let labels = clip.tracked_labels();
    Ok(Other {
        reported: share(&|_, _| true),
        on_one_object: share(&|frame, bounds| {
            first[frame].is_some_and(|first| first.iou(bounds) >= ONE_OBJECT_IOU)
        }),
        on_labelled: share(
            &|frame, bounds| matches!(labels[frame], Some(Label::Visible(label)) if label.iou(bounds) >= ONE_OBJECT_IOU),
        ),
    })
}

fn other_people(clip: &str) -> Result<Vec<PixelPoint>> {
    let rows = OTHER_PEOPLE.lines().skip(1).filter_map(|line| line.split_once(','));
    rows.filter(|(name, _)| *name == clip)
        .map(|(_, place)| {
            let (u, v) = place.split_once(',').context("data/other_people.csv has three columns")?;
            Ok(PixelPoint { u: u.parse()?, v: v.parse()? })
        })
        .collect()
}

fn print_people(followed: &[Followed]) {
    let mut table =
        Table::new(&["clip", "IoU of the proposal", "AUC", "P20", "lost", "AUC, selected", "P20", "lost"]);
    let cells = |score: &Score| [cell(score.auc, 3), cell(score.precision, 3), cell(score.lost, 3)];
    for clip in followed {
        let proposal = clip.proposal.map_or("refused".to_owned(), |iou| cell(iou, 2));
        let mut row = vec![clip.name.clone(), proposal];
        row.extend(cells(&clip.tapped));
        row.extend(cells(&clip.selected));
        table.row(row);
    }
    for (set, is_wanted) in [("on water", true), ("elsewhere", false)] {
        let members: Vec<_> = followed.iter().filter(|clip| is_on_water(&clip.name) == is_wanted).collect();
        let of = |score: fn(&Followed) -> &Score, value: fn(&Score) -> f64| {
            cell(mean(&members.iter().map(|clip| value(score(clip))).collect::<Vec<_>>()), 3)
        };
        let mut row = vec![format!("mean: {set} ({})", members.len()), String::new()];
        for score in [(|clip| &clip.tapped) as fn(&Followed) -> &Score, |clip| &clip.selected] {
            row.extend([of(score, |of| of.auc), of(score, |of| of.precision), of(score, |of| of.lost)]);
        }
        table.row(row);
    }
    table.print("People, tapped in the first frame");
}

fn print_others(followed: &[Followed]) {
    let mut table = Table::new(&["beside, in", "reported", "both on one object", "on the labelled person"]);
    for (clip, other) in followed.iter().flat_map(|clip| clip.others.iter().map(move |other| (clip, other))) {
        let shares = [other.reported, other.on_one_object, other.on_labelled];
        table.row([vec![clip.name.clone()], shares.map(|share| cell(share, 3)).to_vec()].concat());
    }
    table.print("Another person, tapped in the same frame: shares of the frames");
}
