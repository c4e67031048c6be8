//! Taps: how often a tap on a labelled target proposes its box, another object, or nothing.
//!
//! Ten labelled frames of each clip, evenly spread, and the same of generated scenes, are tapped at the
//! target's centre and at eight points a third of its sides beside it. *Right*: the IoU with the label is at
//! least 0.5. *Wrong*: the centre of the box lies outside the label, or the IoU is below 0.1. *Refused*:
//! nothing is proposed. The rest are boxes of a part of the target, or with too much around it.
//!
//! The means are printed over every second recording by name, and over the others, too. The weights of the
//! ranking were fitted to all of them, and so were those of the refinement network: the figures are an upper
//! bound for recordings that neither has seen. (With a ranking that was fitted to the first half alone, 80 %
//! of the second half on water are right and 2 % wrong.)

use std::path::Path;

use anyhow::Result;
use barrelman_vision::{NoProposal, ObjectSizes, Proposal, Proposer};
use barrelman_vocab::{Picture, PixelBox, PixelPoint};

use super::clip_sets::{is_on_water, recording_of};
use super::clips::Clip;
use super::labelled_pictures::{SCENES, chosen_clips, for_scene_pictures, labelled_pictures};
use crate::output::print_line;
use crate::parallel;

/// Offsets of the taps from the target's centre along each axis, as shares of its sides.
const OFFSETS: [f64; 3] = [0.0, -1.0 / 3.0, 1.0 / 3.0];
/// Least IoU of a right proposal, and of one that is not wrong.
const RIGHT_IOU: f64 = 0.5;
const LEAST_IOU: f64 = 0.1;
/// Least share of right proposals, and largest share of wrong ones, that are required on water.
const REQUIRED_RIGHT: f64 = 0.85;
const MAX_WRONG: f64 = 0.02;

/// What the taps on one recording or scene gave.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Taps {
    right: usize,
    wrong: usize,
    refused: usize,
    all: usize,
}

impl Taps {
    fn add(&mut self, proposed: Result<Proposal, NoProposal>, label: PixelBox) {
        self.all += 1;
        let Ok(Proposal { bounds, .. }) = proposed else {
            self.refused += 1;
            return;
        };
        let iou = bounds.iou(label);
        self.right += usize::from(iou >= RIGHT_IOU);
        self.wrong += usize::from(!label.contains(bounds.centre()) || iou < LEAST_IOU);
    }

    /// Shares that are right, wrong and refused.
    fn shares(self) -> [f64; 3] {
        let all = self.all.max(1) as f64;
        [self.right, self.wrong, self.refused].map(|count| count as f64 / all)
    }
}

/// Measures the taps on the clips of these folders, or else of all, and on generated scenes. Returns whether
/// what is required on water holds.
///
/// # Errors
/// If a clip cannot be used.
pub(super) fn run(folder: Option<&Path>, names: &[String], frames: usize) -> Result<bool> {
    let clips = chosen_clips(folder, names)?;
    let measured = parallel::map(&clips, |clip| Ok((clip.name.clone(), tap_clip(&clip.load()?, frames))));
    let measured = measured.into_iter().collect::<Result<Vec<(String, Taps)>>>()?;
    for (name, taps) in &measured {
        print_row(name, taps.shares());
    }
    let scenes: Vec<u64> = (0..SCENES).collect();
    for (name, taps) in parallel::map(&scenes, |number| tap_scene(*number, frames)) {
        print_row(&name, taps.shares());
    }
    let mut recordings: Vec<&str> = measured.iter().map(|(name, _)| recording_of(name)).collect();
    recordings.sort_unstable();
    recordings.dedup();
    let is_first = |name: &str| recordings.iter().step_by(2).any(|first| *first == recording_of(name));
    print_row("on water, first half", mean(&measured, |name| is_on_water(name) && is_first(name)));
    print_row("on water, second half", mean(&measured, |name| is_on_water(name) && !is_first(name)));
    let on_water = mean(&measured, is_on_water);
    print_row("on water", on_water);
    print_row("elsewhere", mean(&measured, |name| !is_on_water(name)));
    Ok(on_water[0] >= REQUIRED_RIGHT && on_water[1] <= MAX_WRONG)
}

/// The mean shares over some of the clips.
fn mean(measured: &[(String, Taps)], is_meant: impl Fn(&str) -> bool) -> [f64; 3] {
    let shares: Vec<[f64; 3]> =
        measured.iter().filter(|(name, _)| is_meant(name)).map(|(_, taps)| taps.shares()).collect();
    core::array::from_fn(|column| {
        shares.iter().map(|row| row[column]).sum::<f64>() / shares.len().max(1) as f64
    })
}

fn print_row(name: &str, shares: [f64; 3]) {
    let [right, wrong, refused] = shares.map(|share| 100.0 * share);
    print_line(&format!("{name:<30} {right:>5.1} % right  {wrong:>5.1} % wrong  {refused:>5.1} % refused"));
}

/// Taps on so many labelled frames of a clip, evenly spread.
fn tap_clip(clip: &Clip, frames: usize) -> Taps {
    let (mut taps, mut proposer) = (Taps::default(), Proposer::default());
    for (picture, label) in labelled_pictures(clip, frames) {
        tap_picture(&mut proposer, picture, label, &mut taps);
    }
    taps
}

/// Taps on so many frames of a generated scene.
fn tap_scene(number: u64, frames: usize) -> (String, Taps) {
    let (mut taps, mut proposer) = (Taps::default(), Proposer::default());
    let name = for_scene_pictures(number, frames, |picture, label| {
        tap_picture(&mut proposer, picture, label, &mut taps);
    });
    (name, taps)
}

/// Taps at the centre of a target and around it.
fn tap_picture(proposer: &mut Proposer, picture: &Picture, label: PixelBox, taps: &mut Taps) {
    let size = picture.size();
    let sizes = ObjectSizes::in_picture_of_height(size.height);
    let centre = label.centre();
    for (across, down) in OFFSETS.into_iter().flat_map(|across| OFFSETS.map(|down| (across, down))) {
        let at = PixelPoint {
            u: (centre.u + across * label.w).clamp(0.0, f64::from(size.width) - 1.0),
            v: (centre.v + down * label.h).clamp(0.0, f64::from(size.height) - 1.0),
        };
        taps.add(proposer.propose(picture, at, sizes), label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proposal_is_right_wrong_refused_or_neither() {
        let label = PixelBox { u: 100.0, v: 100.0, w: 40.0, h: 20.0 };
        let verdict = |proposed: Result<PixelBox, NoProposal>| {
            let mut taps = Taps::default();
            taps.add(proposed.map(|bounds| Proposal { bounds, score: 1.0 }), label);
            [taps.right, taps.wrong, taps.refused]
        };
        assert_eq!(verdict(Ok(label)), [1, 0, 0]);
        assert_eq!(verdict(Ok(PixelBox { w: 15.0, ..label })), [0, 0, 0]);
        assert_eq!(verdict(Ok(PixelBox { w: 3.0, ..label })), [0, 1, 0]);
        assert_eq!(verdict(Ok(PixelBox { u: 141.0, ..label })), [0, 1, 0]);
        assert_eq!(verdict(Err(NoProposal::NothingStandsOut)), [0, 0, 1]);
    }

    #[test]
    fn nine_taps_are_made_on_each_frame() {
        let taps = tap_clip(&super::super::test_clip::test_clip(), 3);
        assert_eq!(taps.all, 27);
    }
}
