//! Sequences cropped from real clips, in which the target leaves the picture and returns.
//!
//! Time runs at the clip's frame rate; the clip is played forwards and backwards in turn. In every other
//! sequence distractors of the target's mean colour lie where the window rests aside, never where the target
//! is. Labels are interpolated between labelled frames.

use std::sync::Arc;

use anyhow::{Context, Result};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, VideoFrame};

use super::absence_metrics::FrameTruth;
use super::distractor::{Distractor, Outline, Paint};
use super::target_path::TargetPath;
use super::window_path::{MIN_DISTANCE_PX, WindowPath};
use crate::rng_of_name::rng_of_name;
use crate::tracker::clips::Clip;
use crate::tracker::cropped_picture::crop;

/// Sizes of the window, the largest first: the first that can leave the target out is used.
const WINDOWS: [PictureSize; 3] =
    [PictureSize::new(640, 480), PictureSize::new(560, 420), PictureSize::new(480, 360)];

/// Sides of a distractor, as a share of the target's mean sides.
const DISTRACTOR_SIZE: (f64, f64) = (0.7, 1.2);

/// Starting frames that are tried before a smaller window is used, and places for a distractor.
const MAX_STARTS: usize = 12;
const MAX_PLACES: usize = 400;

/// A clip to crop from.
pub(super) struct SourceClip {
    pub(super) clip: &'static str,
    /// How many frames are used; `None` for all.
    pub(super) max_frames: Option<usize>,
}

/// Clips with reliable labels in every frame, and room beside the target.
pub(super) const SOURCE_CLIPS: [SourceClip; 4] = [
    SourceClip { clip: "redboat_overhead", max_frames: None },
    // A grey bar hides the boat from frame 100 on.
    SourceClip { clip: "stress_redboat_glare_occl", max_frames: Some(96) },
    SourceClip { clip: "uav123_boat1", max_frames: None },
    SourceClip { clip: "uav123_person12_1", max_frames: None },
];

/// One sequence.
pub(super) struct CroppedSequence<'a> {
    clip: &'a Clip,
    path: WindowPath,
    distractors: Vec<Distractor>,
}

impl<'a> CroppedSequence<'a> {
    /// The sequence of a clip with this number.
    ///
    /// # Errors
    /// If the target cannot be left out of any window, or there is no room for a distractor.
    pub(super) fn new(
        clip: &'a Clip,
        source: &SourceClip,
        number: u64,
        has_distractors: bool,
    ) -> Result<Self> {
        let target = TargetPath::from_clip(clip, source.max_frames);
        let mut rng = rng_of_name(source.clip, number);
        for window in WINDOWS {
            for _ in 0..MAX_STARTS {
                let first = rng.between(0.0, 2.0 * target.frames() as f64) as usize;
                let path = WindowPath::plan(target.starting_at(first), clip.size(), window, &mut rng);
                let Some(path) = path else { continue };
                let mut sequence = Self { clip, path, distractors: Vec::new() };
                if !has_distractors || sequence.add_distractors(&mut rng) {
                    return Ok(sequence);
                }
            }
        }
        None.with_context(|| format!("{}: no window leaves the target out", source.clip))
    }

    /// How many frames the sequence has.
    pub(super) fn frames(&self) -> usize {
        (self.path.duration_s() / self.path.target.frame_s) as usize
    }

    fn time_s(&self, frame: usize) -> f64 {
        frame as f64 * self.path.target.frame_s
    }

    /// The clip's picture at a time.
    fn source_picture(&self, time_s: f64) -> &Picture {
        &self.clip.frames[self.clip.start + self.path.target.clip_frame(time_s)].picture
    }

    /// Renders a frame. Returns the frame with its truth.
    pub(super) fn render(&self, frame: usize) -> (VideoFrame, FrameTruth) {
        let time_s = self.time_s(frame);
        let window = self.path.window;
        let mut picture = crop(self.source_picture(time_s), self.path.corner(time_s), window);
        let mut distractors = Vec::new();
        for distractor in &self.distractors {
            let bounds = self.path.to_window(distractor.bounds, time_s);
            Distractor { bounds, ..*distractor }.render(&mut picture);
            let visible = bounds.clipped(window);
            if !visible.is_empty() {
                distractors.push(visible);
            }
        }
        let truth = FrameTruth {
            time_s,
            bounds: self.path.to_window(self.path.target.at(time_s), time_s).clipped(window),
            visible_share: self.path.visible_share(time_s),
            distractors,
        };
        let capture = Capture { at: Timestamp::from_secs_f64(time_s), quality: CaptureQuality::Sender };
        (VideoFrame { sequence: frame as u64, capture, picture: Arc::new(picture) }, truth)
    }

    /// Adds a distractor where the window rests in each excursion; false where there is no room.
    fn add_distractors(&mut self, rng: &mut SplitMix64) -> bool {
        let paint = Paint::sample(self.source_picture(0.0), self.path.target.at(0.0));
        let targets: Vec<PixelBox> =
            (0..self.frames()).map(|frame| self.path.target.at(self.time_s(frame))).collect();
        let mean = |side: fn(&PixelBox) -> f64| targets.iter().map(side).sum::<f64>() / targets.len() as f64;
        let (mean_w, mean_h) = (mean(|target| target.w), mean(|target| target.h));
        let window = self.path.window;
        for excursion in &self.path.excursions {
            let corner = excursion.resting_corner;
            let free_place = (0..MAX_PLACES).find_map(|_| {
                let w = mean_w * rng.between(DISTRACTOR_SIZE.0, DISTRACTOR_SIZE.1);
                let h = mean_h * rng.between(DISTRACTOR_SIZE.0, DISTRACTOR_SIZE.1);
                let bounds = PixelBox {
                    u: corner.u + rng.between(0.0, (f64::from(window.width) - w).max(1.0)),
                    v: corner.v + rng.between(0.0, (f64::from(window.height) - h).max(1.0)),
                    w,
                    h,
                };
                let surroundings = PixelBox {
                    u: bounds.u - MIN_DISTANCE_PX,
                    v: bounds.v - MIN_DISTANCE_PX,
                    w: w + 2.0 * MIN_DISTANCE_PX,
                    h: h + 2.0 * MIN_DISTANCE_PX,
                };
                targets.iter().all(|target| target.intersection(surroundings).is_empty()).then_some(bounds)
            });
            let Some(bounds) = free_place else { return false };
            let outline = if rng.uniform() < 0.5 { Outline::Ellipse } else { Outline::Rectangle };
            let seed = rng.between(0.0, 1e9) as u32;
            self.distractors.push(Distractor { bounds, outline, paint, seed });
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::window_path::EXCURSIONS;
    use super::*;
    use crate::tracker::test_clip::test_clip;

    const SOURCE: SourceClip = SourceClip { clip: "test", max_frames: None };

    #[test]
    fn the_target_leaves_twice_for_three_to_ten_seconds() {
        let clip = test_clip();
        let sequence = CroppedSequence::new(&clip, &SOURCE, 1, false).unwrap();
        let absent: Vec<bool> =
            (0..sequence.frames()).map(|frame| sequence.render(frame).1.visible_share <= 0.0).collect();
        let lengths: Vec<usize> =
            absent.chunk_by(|a, b| a == b).filter(|part| part[0]).map(<[bool]>::len).collect();
        assert_eq!(lengths.len(), EXCURSIONS);
        // 3.0 to 7.5 s of rest, and part of both slides.
        assert!(lengths.iter().all(|frames| (30..105).contains(frames)), "{lengths:?}");
    }

    #[test]
    fn the_truth_is_where_the_target_is_rendered() {
        let clip = test_clip();
        let sequence = CroppedSequence::new(&clip, &SOURCE, 2, true).unwrap();
        for frame in 0..sequence.frames() {
            let (rendered, truth) = sequence.render(frame);
            let is_light = |bounds: PixelBox| {
                let y = rendered.picture.y();
                let row = y.row(bounds.centre().v as usize);
                row[bounds.centre().u as usize] > 150
            };
            assert!(truth.bounds.is_empty() || is_light(truth.bounds), "frame {frame}: {truth:?}");
            for distractor in truth.distractors {
                assert!(distractor.intersection(truth.bounds).is_empty(), "frame {frame}");
                // An ellipse cut off at the border need not reach the middle of the rest of its box.
                if distractor.area() > 3000.0 {
                    assert!(is_light(distractor), "frame {frame}: {distractor}");
                }
            }
        }
    }

    #[test]
    fn a_distractor_lies_where_the_window_rests() {
        let clip = test_clip();
        let sequence = CroppedSequence::new(&clip, &SOURCE, 3, true).unwrap();
        for excursion in &sequence.path.excursions {
            let frame = (excursion.middle_s() / sequence.path.target.frame_s) as usize;
            assert!(!sequence.render(frame).1.distractors.is_empty());
        }
    }
}
