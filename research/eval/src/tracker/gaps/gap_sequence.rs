//! Sequences cut from labelled clips, in which the video has a gap: nothing is received for some seconds, and
//! then the picture goes on elsewhere.

use std::sync::Arc;
use std::time::Duration;

use barrelman_vocab::video::Capture;
use barrelman_vocab::{Picture, PictureSize, PixelBox, VideoFrame};

use crate::tracker::clips::Clip;
use crate::tracker::cropped_picture::crop;
use crate::tracker::scoring::Label;

/// Longest part before the gap, in frames, and the part after it, seconds and frames.
const MAX_FRAMES_BEFORE: usize = 90;
const AFTER_S: f64 = 2.5;
const MAX_FRAMES_AFTER: usize = 60;
/// Fewest frames before the gap, and after it.
const MIN_FRAMES: usize = 8;
/// Size of the window that is cropped where the camera turns, as a share of the picture's.
const WINDOW_SHARE: f64 = 0.6;
/// Duration of the slide of the window where the target leaves without a gap, seconds.
const SLIDE_S: f64 = 1.0;
/// Least distance of an absent target from the window, pixels.
const MIN_DISTANCE_PX: f64 = 6.0;

/// What the video shows after the gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scene {
    /// The clip from its first frame again.
    Rewound,
    /// The clip as it is after the gap: what was captured meanwhile is missing.
    Skipped,
    /// The camera has turned: the target is elsewhere in the picture.
    Turned,
    /// The camera has turned away: the target is out of the picture.
    TurnedAway,
    /// No gap: the camera turns away within a second.
    Leaving,
}

impl Scene {
    pub(super) const ALL: [Self; 5] =
        [Self::Rewound, Self::Skipped, Self::Turned, Self::TurnedAway, Self::Leaving];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Rewound => "rewound",
            Self::Skipped => "skipped",
            Self::Turned => "turned",
            Self::TurnedAway => "turned away",
            Self::Leaving => "leaving, no gap",
        }
    }
}

/// A sequence with a gap.
pub(super) struct GapSequence {
    /// The frames with their labels. The target is selected on the first.
    pub(super) frames: Vec<(VideoFrame, Option<Label>)>,
    /// Index of the first frame after the gap.
    pub(super) resumes: usize,
}

impl GapSequence {
    /// The sequence of a clip that is cut before the frame `cut`, with a gap of this length, seconds; `None`
    /// where the clip does not allow it.
    pub(super) fn new(clip: &Clip, cut: usize, gap_s: f64, scene: Scene) -> Option<Self> {
        let rate = frames_per_second(clip);
        let last = clip.labels.iter().rposition(Option::is_some)?;
        let count = ((AFTER_S * rate) as usize).min(MAX_FRAMES_AFTER);
        let from = match scene {
            Scene::Rewound => clip.start,
            Scene::Skipped => cut + ((gap_s * rate).round() as usize).max(1) - 1,
            Scene::Turned | Scene::TurnedAway | Scene::Leaving => cut,
        };
        let end = (from + count).min(last + 1);
        if end < from + MIN_FRAMES || cut > last {
            return None;
        }
        let windows = Windows::new(clip, cut, from..end, scene)?;
        let start = windows.start(clip, cut)?;
        let mut frames = Vec::new();
        let before_end = clip.frames[cut - 1].capture.at;
        for index in start..cut {
            frames.push(windows.before.apply(clip, index, clip.frames[index].capture));
        }
        let resumes = frames.len();
        let first_at = clip.frames[from].capture.at;
        let pause = if scene == Scene::Leaving { 1.0 / rate } else { gap_s };
        for index in from..end {
            let elapsed = clip.frames[index].capture.at.since(first_at);
            let at = before_end.plus(Duration::from_secs_f64(pause) + elapsed);
            let capture = Capture { at, ..clip.frames[index].capture };
            let share = if scene == Scene::Leaving { elapsed.as_secs_f64() / SLIDE_S } else { 1.0 };
            frames.push(windows.before.towards(&windows.after, share).apply(clip, index, capture));
        }
        Some(Self { frames, resumes })
    }
}

/// The part of the clip's pictures that is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    corner: (f64, f64),
    size: PictureSize,
}

/// The windows before and after the gap.
struct Windows {
    before: Window,
    after: Window,
}

impl Windows {
    fn new(clip: &Clip, cut: usize, shown: std::ops::Range<usize>, scene: Scene) -> Option<Self> {
        let whole = Window { corner: (0.0, 0.0), size: clip.size() };
        let is_away = match scene {
            Scene::Rewound | Scene::Skipped => return Some(Self { before: whole, after: whole }),
            Scene::Turned => false,
            Scene::TurnedAway | Scene::Leaving => true,
        };
        let picture = clip.size();
        let side = |length: u32| (WINDOW_SHARE * f64::from(length)) as u32 & !1;
        let size = PictureSize::new(side(picture.width), side(picture.height));
        let room = (
            f64::from(picture.width) - f64::from(size.width),
            f64::from(picture.height) - f64::from(size.height),
        );
        let target = clip.labels[..cut].iter().rev().find_map(|label| match label {
            Some(Label::Visible(bounds)) => Some(bounds.centre()),
            _ => None,
        })?;
        let corner = |middle: f64, side: u32, room: f64| (middle - 0.5 * f64::from(side)).clamp(0.0, room);
        let before = Window {
            corner: (corner(target.u, size.width, room.0), corner(target.v, size.height, room.1)),
            size,
        };
        let rests = |window: &Window| {
            let resting = if scene == Scene::Leaving { shown.start + shown.len() / 2 } else { shown.start };
            clip.labels[resting..shown.end].iter().flatten().all(|label| match label {
                Label::Absent => is_away,
                Label::Visible(bounds) if is_away => window.misses(*bounds),
                Label::Visible(bounds) => window.contains(*bounds),
            })
        };
        let distance =
            |window: &Window| (window.corner.0 - before.corner.0).hypot(window.corner.1 - before.corner.1);
        let steps = 0..25;
        let candidates = steps.map(|step| Window {
            corner: (room.0 * f64::from(step % 5) / 4.0, room.1 * f64::from(step / 5) / 4.0),
            size,
        });
        let possible = candidates.filter(rests);
        // A turned camera has turned as far as possible, one that turned away no farther than necessary.
        let nearer = |a: &Window, b: &Window| distance(a).total_cmp(&distance(b));
        let after = if is_away { possible.min_by(nearer) } else { possible.max_by(nearer) }?;
        Some(Self { before, after })
    }

    /// The frame of the selection: the earliest from which on the target is wholly in the window up to the
    /// cut.
    fn start(&self, clip: &Clip, cut: usize) -> Option<usize> {
        let is_in_view = |label: &Option<Label>| match label {
            None => true,
            Some(Label::Absent) => false,
            Some(Label::Visible(bounds)) => self.before.contains(*bounds),
        };
        let shown = clip.labels[..cut].iter().rev().take_while(|label| is_in_view(label)).count();
        let from = cut - shown.min(MAX_FRAMES_BEFORE);
        let start = from + clip.labels[from..cut].iter().position(Option::is_some)?;
        (start + MIN_FRAMES <= cut).then_some(start)
    }
}

impl Window {
    fn bounds(&self) -> PixelBox {
        PixelBox {
            u: self.corner.0,
            v: self.corner.1,
            w: f64::from(self.size.width),
            h: f64::from(self.size.height),
        }
    }

    fn contains(&self, bounds: PixelBox) -> bool {
        bounds.intersection(self.bounds()).area() > 0.98 * bounds.area()
    }

    fn misses(&self, bounds: PixelBox) -> bool {
        let around = PixelBox {
            u: bounds.u - MIN_DISTANCE_PX,
            v: bounds.v - MIN_DISTANCE_PX,
            w: bounds.w + 2.0 * MIN_DISTANCE_PX,
            h: bounds.h + 2.0 * MIN_DISTANCE_PX,
        };
        around.intersection(self.bounds()).is_empty()
    }

    /// The window at this share of the way to another.
    fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * share.clamp(0.0, 1.0);
        Self {
            corner: (mix(self.corner.0, other.corner.0), mix(self.corner.1, other.corner.1)),
            size: self.size,
        }
    }

    /// The part of a frame in the window, with its label.
    fn apply(&self, clip: &Clip, index: usize, capture: Capture) -> (VideoFrame, Option<Label>) {
        let source = &clip.frames[index];
        let corner = (self.corner.0 as usize & !1, self.corner.1 as usize & !1);
        let picture: Arc<Picture> = if self.size == source.picture.size() {
            Arc::clone(&source.picture)
        } else {
            Arc::new(crop(&source.picture, corner, self.size))
        };
        let label = clip.labels[index].map(|label| match label {
            Label::Absent => Label::Absent,
            Label::Visible(bounds) => {
                let moved =
                    PixelBox { u: bounds.u - corner.0 as f64, v: bounds.v - corner.1 as f64, ..bounds };
                let shown = moved.clipped(self.size);
                if shown.is_empty() { Label::Absent } else { Label::Visible(shown) }
            }
        });
        (VideoFrame { sequence: index as u64, capture, picture }, label)
    }
}

/// Mean frame rate of a clip, Hz.
fn frames_per_second(clip: &Clip) -> f64 {
    let at = |index: usize| clip.frames[index].capture.at.as_secs_f64();
    let last = clip.frames.len() - 1;
    if last == 0 { 1.0 } else { last as f64 / (at(last) - at(0)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::test_clip::test_clip;

    /// Sequences of a clip whose target is near the left border: a camera can turn away from it.
    fn sequence(scene: Scene) -> GapSequence {
        let mut clip = test_clip();
        for label in clip.labels.iter_mut().flatten() {
            if let Label::Visible(bounds) = label {
                bounds.u -= 540.0;
            }
        }
        GapSequence::new(&clip, 20, 1.3, scene).unwrap_or_else(|| panic!("{scene:?} is not possible"))
    }

    #[test]
    fn the_gap_is_where_the_video_pauses() {
        for scene in Scene::ALL {
            let GapSequence { frames, resumes } = sequence(scene);
            let pause = frames[resumes].0.capture.at.since(frames[resumes - 1].0.capture.at).as_secs_f64();
            let expected = if scene == Scene::Leaving { 0.1 } else { 1.3 };
            assert!((pause - expected).abs() < 0.02, "{scene:?}: {pause}");
        }
    }

    #[test]
    fn the_target_is_where_the_scene_says() {
        for scene in Scene::ALL {
            let GapSequence { frames, resumes } = sequence(scene);
            let label =
                |range: &[(VideoFrame, Option<Label>)]| range.iter().rev().find_map(|(_, label)| *label);
            let (before, after) = (label(&frames[..resumes]), label(&frames[resumes..]));
            let Some(Label::Visible(before)) = before else { panic!("{scene:?}: {before:?}") };
            match after {
                Some(Label::Absent) => {
                    assert!(matches!(scene, Scene::TurnedAway | Scene::Leaving), "{scene:?}")
                }
                Some(Label::Visible(after)) => {
                    assert!(!matches!(scene, Scene::TurnedAway | Scene::Leaving), "{scene:?}");
                    assert!(before.u != after.u, "{scene:?}");
                }
                None => panic!("{scene:?}: no label"),
            }
        }
    }
}
