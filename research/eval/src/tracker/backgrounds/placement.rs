//! Draws selections of the background of a clip.

use std::time::Duration;

use barrelman_vocab::PixelBox;
use barrelman_vocab::rng::SplitMix64;

use super::target_extent::TargetExtent;
use crate::rng_of_name::rng_of_name;
use crate::tracker::clips::Clip;

/// How long after a selection its track is judged, seconds.
pub(super) const JUDGED_AFTER_S: f64 = 1.0;

/// Sides of a selection, as a share of the target's.
const SIZE: (f64, f64) = (0.7, 2.0);

/// Smallest sides of a selection, pixels.
const MIN_WIDTH_PX: f64 = 8.0;
const MIN_HEIGHT_PX: f64 = 6.0;

/// The target must not meet a box with sides this many times those of the selection.
const CLEARANCE: f64 = 2.0;

/// Places that are tried in a selection's part of the clip, and then in the whole clip.
const MAX_PLACES: usize = 200;
const MAX_PLACES_ANYWHERE: usize = 2000;

/// A selection of the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BackgroundSelection {
    /// The frame in which the box is selected.
    pub(crate) frame: usize,
    pub(crate) bounds: PixelBox,
    /// The frame next to [`JUDGED_AFTER_S`] later.
    pub(super) judged: usize,
}

/// Draws this many selections, spread over the clip: fewer where there is no room beside the target. The same
/// clip and seed give the same selections; those of seed 0 are measured, and no other use takes them.
pub(crate) fn draw_selections(clip: &Clip, count: usize, seed: u64) -> Vec<BackgroundSelection> {
    let extent = TargetExtent::from_clip(clip);
    let candidates: Vec<Candidate> =
        (0..clip.frames.len()).filter_map(|frame| Candidate::new(clip, &extent, frame)).collect();
    let mut rng = rng_of_name(&format!("background of {}", clip.name), seed);
    let mut selections = Vec::with_capacity(count);
    for part in 0..count {
        let part = &candidates[part * candidates.len() / count..(part + 1) * candidates.len() / count];
        let place = |candidates: &[Candidate], rng: &mut SplitMix64| {
            let candidate = *candidates.get(rng.between(0.0, candidates.len() as f64) as usize)?;
            candidate.place(clip, &extent, rng)
        };
        let selection = (0..MAX_PLACES)
            .find_map(|_| place(part, &mut rng))
            .or_else(|| (0..MAX_PLACES_ANYWHERE).find_map(|_| place(&candidates, &mut rng)));
        selections.extend(selection);
    }
    selections
}

/// A frame in which a box may be selected.
#[derive(Clone, Copy)]
struct Candidate {
    frame: usize,
    judged: usize,
    /// The last frame in which the target must stay away.
    last: usize,
}

impl Candidate {
    /// `None` where the clip ends too early, or it is not known where the target is.
    fn new(clip: &Clip, extent: &TargetExtent, frame: usize) -> Option<Self> {
        let at = |frame: usize| clip.frames[frame].capture.at;
        let until = at(frame).plus(Duration::from_secs_f64(JUDGED_AFTER_S));
        // The first frame at that time or later; the one before it may be nearer.
        let after = (frame + 1..clip.frames.len()).find(|later| at(*later) >= until)?;
        let is_earlier_nearer = until.since(at(after - 1)) < at(after).since(until);
        let judged = if is_earlier_nearer { after - 1 } else { after };
        extent.is_known(frame..=after).then_some(Self { frame, judged, last: after })
    }

    /// A box anywhere in the picture; `None` where the target meets its surroundings.
    fn place(self, clip: &Clip, extent: &TargetExtent, rng: &mut SplitMix64) -> Option<BackgroundSelection> {
        let picture = clip.frames[self.frame].picture.size();
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        let factor = rng.between(SIZE.0, SIZE.1);
        let target = extent.size_near(self.frame);
        let (w, h) = ((target.0 * factor).max(MIN_WIDTH_PX), (target.1 * factor).max(MIN_HEIGHT_PX));
        let (u, v) = (rng.uniform() * (width - w), rng.uniform() * (height - h));
        if w > width || h > height {
            return None;
        }
        let bounds = PixelBox { u, v, w, h };
        let is_free = !extent.meets(with_surroundings(bounds), self.frame..=self.last);
        is_free.then_some(BackgroundSelection { frame: self.frame, bounds, judged: self.judged })
    }
}

fn with_surroundings(bounds: PixelBox) -> PixelBox {
    let centre = bounds.centre();
    let (w, h) = (CLEARANCE * bounds.w, CLEARANCE * bounds.h);
    PixelBox { u: centre.u - w / 2.0, v: centre.v - h / 2.0, w, h }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::scoring::Label;
    use crate::tracker::test_clip::test_clip;

    #[test]
    fn selections_lie_beside_the_target_and_spread_over_the_clip() {
        let clip = test_clip();
        let selections = draw_selections(&clip, 6, 0);
        assert_eq!(selections.len(), 6);
        for selection in &selections {
            assert_eq!(selection.judged, selection.frame + 10, "ten frames a second");
            let PixelBox { u, v, w, h } = selection.bounds;
            assert!(u >= 0.0 && v >= 0.0 && u + w <= 1280.0 && v + h <= 720.0, "{selection:?}");
            // The target is 60 x 80 pixels.
            let factor = selection.bounds.w / 60.0;
            assert!((SIZE.0..SIZE.1).contains(&factor), "{selection:?}");
            let surroundings = with_surroundings(selection.bounds);
            for label in &clip.labels[selection.frame..=selection.judged] {
                if let Some(Label::Visible(target)) = label {
                    assert!(target.intersection(surroundings).is_empty(), "{selection:?}");
                }
            }
        }
        assert!(selections.is_sorted_by_key(|selection| selection.frame));
        assert_eq!(selections, draw_selections(&clip, 6, 0));
    }

    #[test]
    fn no_selection_needs_frames_after_the_last_label() {
        let mut clip = test_clip();
        clip.labels[21..].fill(None);
        let selections = draw_selections(&clip, 6, 0);
        assert_eq!(selections.len(), 6);
        assert!(selections.iter().all(|selection| selection.judged <= 20), "{selections:?}");
    }

    #[test]
    fn a_target_that_fills_the_picture_leaves_no_room() {
        let mut clip = test_clip();
        let whole_picture = clip.size().bounds();
        clip.labels.fill(Some(Label::Visible(whole_picture)));
        assert!(draw_selections(&clip, 6, 0).is_empty());
    }
}
