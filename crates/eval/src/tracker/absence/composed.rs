//! Sequences cut from real clips, in which the target leaves and comes back: a window that follows the target over a
//! clip played to and fro, slides aside until the target is out of it, rests there, and slides back.
//!
//! Time runs at the clip's own rate. In every other sequence things of the target's mean colour lie where the
//! window rests, never where the target comes. Labels between labelled frames are interpolated.

use std::sync::Arc;

use anyhow::{Context, Result};
use barrelman_vocab::video::{Capture, CaptureQuality, Plane};
use barrelman_vocab::{Picture, PictureSize, PixelBox, PixelPoint, Timestamp, VideoFrame};

use super::judge::Truth;
use super::thing::{Outline, Paint, Thing};
use crate::tracker::chance::Chance;
use crate::tracker::clips::Clip;
use crate::tracker::scoring::Label;

/// Windows, the largest first: the first in which the target can be left out is taken.
const WINDOWS: [PictureSize; 3] =
    [PictureSize::new(640, 480), PictureSize::new(560, 420), PictureSize::new(480, 360)];

/// Times that the target leaves.
const EXCURSIONS: usize = 2;

/// Time before, between and after them, seconds: long enough to be sure that the target was found.
const IN_VIEW_S: f64 = 3.0;

/// How long the window rests aside, seconds.
const AWAY_S: (f64, f64) = (3.0, 7.5);

/// Mean speed of the window's slide over the picture, pixels a second, and its least duration in seconds.
const SLIDE_PX_PER_S: f64 = 250.0;
const LEAST_SLIDE_S: f64 = 1.0;

/// While it follows, the window wanders about the target by this share of its sides, once in so many seconds.
const WANDER: f64 = 0.08;
const WANDER_PERIOD_S: f64 = 5.0;

/// Least distance of the target from the window that rests aside, and of things from the target, pixels.
const CLEAR_PX: f64 = 6.0;

/// Sides of a thing, as a share of the target's mean sides.
const THING_SIZE: (f64, f64) = (0.7, 1.2);

/// Starts that are tried in a clip before a smaller window is taken, and places for a thing.
const STARTS: usize = 12;
const PLACES: usize = 400;

/// A clip to cut from, played to and fro up to a frame.
pub(super) struct Source {
    /// The clip's name.
    pub(super) clip: &'static str,
    /// The frames that are used; all where there is none.
    pub(super) frames: Option<usize>,
}

/// Clips with labels that can be trusted in every frame, and room beside the target.
pub(super) const SOURCES: [Source; 4] = [
    Source { clip: "redboat_overhead", frames: None },
    // A grey bar hides the boat from frame 100 on.
    Source { clip: "stress_redboat_glare_occl", frames: Some(96) },
    Source { clip: "uav123_boat1", frames: None },
    Source { clip: "uav123_person12_1", frames: None },
];

/// One sequence.
pub(super) struct Composed<'a> {
    clip: &'a Clip,
    /// The target's box in every frame that is used.
    boxes: Vec<PixelBox>,
    first: usize,
    frame_s: f64,
    window: PictureSize,
    excursions: Vec<Excursion>,
    things: Vec<Thing>,
    /// Phase of the wandering, radians.
    phase: f64,
}

/// The window's way aside and back.
#[derive(Debug, Clone, Copy)]
struct Excursion {
    leaves_s: f64,
    slide_s: f64,
    away_s: f64,
    /// The window's corner while it rests aside.
    to: PixelPoint,
}

impl Excursion {
    fn over_s(&self) -> f64 {
        self.leaves_s + 2.0 * self.slide_s + self.away_s
    }

    /// How far the window is aside, 0 to 1, starting and ending gently.
    fn share(&self, time_s: f64) -> f64 {
        let out = (time_s - self.leaves_s) / self.slide_s;
        let back = (self.over_s() - time_s) / self.slide_s;
        let share = out.min(back).clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    }
}

impl<'a> Composed<'a> {
    /// The sequence of a clip with this number.
    ///
    /// # Errors
    /// If the target cannot be left out of any window, or there is no room for a thing.
    pub(super) fn new(clip: &'a Clip, source: &Source, number: u64, with_things: bool) -> Result<Self> {
        let boxes = boxes(clip, source.frames);
        let mut chance = Chance::named(source.clip, number);
        for window in WINDOWS {
            for _ in 0..STARTS {
                let mut sequence = Self {
                    clip,
                    boxes: boxes.clone(),
                    first: chance.between(0.0, 2.0 * boxes.len() as f64) as usize,
                    frame_s: frame_s(clip),
                    window,
                    excursions: Vec::new(),
                    things: Vec::new(),
                    phase: chance.between(0.0, std::f64::consts::TAU),
                };
                if sequence.plan(&mut chance) && (!with_things || sequence.add_things(&mut chance)) {
                    return Ok(sequence);
                }
            }
        }
        None.with_context(|| format!("{}: no window leaves the target out", source.clip))
    }

    /// How many frames it has.
    pub(super) fn frames(&self) -> usize {
        (self.length_s() / self.frame_s) as usize
    }

    fn length_s(&self) -> f64 {
        self.excursions.last().map_or(0.0, Excursion::over_s) + IN_VIEW_S
    }

    /// One frame, and what is true of it.
    pub(super) fn draw(&self, frame: usize) -> (VideoFrame, Truth) {
        let time_s = frame as f64 * self.frame_s;
        let corner = self.corner(time_s);
        let from = &self.clip.frames[self.clip.start + self.clip_frame(time_s)].picture;
        let mut picture = cut(from, corner, self.window);
        let shifted = |bounds: PixelBox| PixelBox {
            u: bounds.u - corner.0 as f64,
            v: bounds.v - corner.1 as f64,
            ..bounds
        };
        let mut distractors = Vec::new();
        for thing in &self.things {
            let bounds = shifted(thing.bounds);
            Thing { bounds, ..*thing }.draw(&mut picture);
            let shown = bounds.clipped(self.window);
            if !shown.is_empty() {
                distractors.push(shown);
            }
        }
        let whole = shifted(self.target(time_s));
        let bounds = whole.clipped(self.window);
        let visible = bounds.area() / whole.area();
        let capture = Capture { at: Timestamp::from_secs_f64(time_s), quality: CaptureQuality::Sender };
        let frame = VideoFrame { sequence: frame as u64, capture, picture: Arc::new(picture) };
        (frame, Truth { time_s, bounds, visible, distractors })
    }

    /// The frame of the clip, counted from its start, at a time: to and fro.
    fn clip_frame(&self, time_s: f64) -> usize {
        let last = self.boxes.len() - 1;
        // Half a frame on, so that rounding does not repeat one.
        let at = (self.first + (time_s / self.frame_s + 0.5) as usize) % (2 * last).max(1);
        if at > last { 2 * last - at } else { at }
    }

    fn target(&self, time_s: f64) -> PixelBox {
        self.boxes[self.clip_frame(time_s)]
    }

    /// The window's corner while it follows the target.
    fn following(&self, time_s: f64) -> PixelPoint {
        let centre = self.target(time_s).centre();
        let angle = self.phase + std::f64::consts::TAU * time_s / WANDER_PERIOD_S;
        let (w, h) = (f64::from(self.window.width), f64::from(self.window.height));
        let room = self.room();
        PixelPoint {
            u: (centre.u - w * (0.5 + WANDER * angle.sin())).clamp(0.0, room.u),
            v: (centre.v - h * (0.5 + WANDER * (1.3 * angle).cos())).clamp(0.0, room.v),
        }
    }

    /// The corner that is farthest to the lower right.
    fn room(&self) -> PixelPoint {
        let picture = self.clip.size();
        PixelPoint {
            u: f64::from(picture.width - self.window.width),
            v: f64::from(picture.height - self.window.height),
        }
    }

    /// The window's corner, on even pixels, so that the chroma samples stay what they were.
    fn corner(&self, time_s: f64) -> (usize, usize) {
        let mut at = self.following(time_s);
        for excursion in &self.excursions {
            let share = excursion.share(time_s);
            at.u += (excursion.to.u - at.u) * share;
            at.v += (excursion.to.v - at.v) * share;
        }
        (at.u as usize & !1, at.v as usize & !1)
    }

    /// Plans the excursions; false where the target cannot be left out.
    fn plan(&mut self, chance: &mut Chance) -> bool {
        for _ in 0..EXCURSIONS {
            let leaves_s = self.length_s();
            let away_s = chance.between(AWAY_S.0, AWAY_S.1);
            let from = self.following(leaves_s);
            let room = self.room();
            let mut nearest: Option<(f64, Excursion)> = None;
            for place in (0..9).filter(|place| *place != 4) {
                let to = PixelPoint {
                    u: room.u * f64::from(place % 3) / 2.0,
                    v: room.v * f64::from(place / 3) / 2.0,
                };
                let way_px = (to.u - from.u).hypot(to.v - from.v);
                let slide_s = (way_px / SLIDE_PX_PER_S).max(LEAST_SLIDE_S);
                let excursion = Excursion { leaves_s, slide_s, away_s, to };
                if self.leaves_out(&excursion) && nearest.is_none_or(|(nearest_px, _)| way_px < nearest_px) {
                    nearest = Some((way_px, excursion));
                }
            }
            let Some((_, excursion)) = nearest else { return false };
            self.excursions.push(excursion);
        }
        // The selection is dragged around a target that is wholly in the picture.
        self.draw(0).1.visible >= 1.0
    }

    /// Whether the target stays out of the window while that rests aside.
    fn leaves_out(&self, excursion: &Excursion) -> bool {
        let window = PixelBox {
            u: excursion.to.u - CLEAR_PX,
            v: excursion.to.v - CLEAR_PX,
            w: f64::from(self.window.width) + 2.0 * CLEAR_PX,
            h: f64::from(self.window.height) + 2.0 * CLEAR_PX,
        };
        let from_s = excursion.leaves_s + excursion.slide_s;
        let frames = (excursion.away_s / self.frame_s) as usize;
        (0..=frames)
            .all(|frame| self.target(from_s + frame as f64 * self.frame_s).intersection(window).is_empty())
    }

    /// Puts a thing where the window rests in each excursion; false where there is no room.
    fn add_things(&mut self, chance: &mut Chance) -> bool {
        let paint =
            Paint::of(&self.clip.frames[self.clip.start + self.clip_frame(0.0)].picture, self.target(0.0));
        let targets: Vec<PixelBox> =
            (0..self.frames()).map(|frame| self.target(frame as f64 * self.frame_s)).collect();
        let mean = |side: fn(&PixelBox) -> f64| targets.iter().map(side).sum::<f64>() / targets.len() as f64;
        let (mean_w, mean_h) = (mean(|target| target.w), mean(|target| target.h));
        for index in 0..self.excursions.len() {
            let to = self.excursions[index].to;
            let place = (0..PLACES).find_map(|_| {
                let w = mean_w * chance.between(THING_SIZE.0, THING_SIZE.1);
                let h = mean_h * chance.between(THING_SIZE.0, THING_SIZE.1);
                let bounds = PixelBox {
                    u: to.u + chance.between(0.0, (f64::from(self.window.width) - w).max(1.0)),
                    v: to.v + chance.between(0.0, (f64::from(self.window.height) - h).max(1.0)),
                    w,
                    h,
                };
                let around = PixelBox {
                    u: bounds.u - CLEAR_PX,
                    v: bounds.v - CLEAR_PX,
                    w: w + 2.0 * CLEAR_PX,
                    h: h + 2.0 * CLEAR_PX,
                };
                targets.iter().all(|target| target.intersection(around).is_empty()).then_some(bounds)
            });
            let Some(bounds) = place else { return false };
            let outline = if chance.between(0.0, 1.0) < 0.5 { Outline::Ellipse } else { Outline::Rectangle };
            self.things.push(Thing { bounds, outline, paint, seed: chance.between(0.0, 1e9) as u32 });
        }
        true
    }
}

/// Seconds from frame to frame.
fn frame_s(clip: &Clip) -> f64 {
    let at = |frame: &VideoFrame| frame.capture.at.as_secs_f64();
    match &clip.frames[..] {
        [first, .., last] => (at(last) - at(first)) / (clip.frames.len() - 1) as f64,
        _ => 1.0,
    }
}

/// The target's box in every frame from the first to the last labelled one, or to the limit.
fn boxes(clip: &Clip, frames: Option<usize>) -> Vec<PixelBox> {
    let mut boxes: Vec<PixelBox> = Vec::new();
    for (index, label) in clip.labels[clip.start..].iter().enumerate() {
        let Some(Label::There(bounds)) = *label else { continue };
        if let Some(last) = boxes.last().copied() {
            let steps = index + 1 - boxes.len();
            for step in 1..=steps {
                boxes.push(between(last, bounds, step as f64 / steps as f64));
            }
        } else {
            boxes.push(bounds);
        }
    }
    boxes.truncate(frames.unwrap_or(usize::MAX));
    boxes
}

fn between(a: PixelBox, b: PixelBox, share: f64) -> PixelBox {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    PixelBox { u: mix(a.u, b.u), v: mix(a.v, b.v), w: mix(a.w, b.w), h: mix(a.h, b.h) }
}

/// The part of a picture at a corner on even pixels.
fn cut(from: &Picture, (left, top): (usize, usize), size: PictureSize) -> Picture {
    let mut to = Picture::black(size, from.colour());
    let (width, chroma) = (size.width as usize, to.chroma_size().width as usize);
    let copy = |from: Plane<'_>, to: &mut [u8], width: usize, left: usize, top: usize| {
        for (row, out) in to.chunks_exact_mut(width).enumerate() {
            out.copy_from_slice(&from.row(top + row)[left..left + width]);
        }
    };
    let [y, u, v] = to.planes_mut();
    copy(from.y(), y, width, left, top);
    copy(from.u(), u, chroma, left / 2, top / 2);
    copy(from.v(), v, chroma, left / 2, top / 2);
    to
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::ColourEncoding;

    use super::*;

    const SIZE: PictureSize = PictureSize::new(1280, 720);
    const SOURCE: Source = Source { clip: "test", frames: None };

    /// Fifty frames at ten a second; the target, lighter than the rest, drifts to the right. Every fifth is labelled.
    fn clip() -> Clip {
        let target = |frame: usize| PixelBox { u: 560.0 + 2.0 * frame as f64, v: 300.0, w: 60.0, h: 80.0 };
        let frame = |index: usize| {
            let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
            let bounds = target(index);
            let [y, _, _] = picture.planes_mut();
            for row in 300..380 {
                y[row * 1280 + bounds.u as usize..][..60].fill(180);
            }
            let capture = Capture {
                at: Timestamp::from_secs_f64(index as f64 / 10.0),
                quality: CaptureQuality::Sender,
            };
            VideoFrame { sequence: index as u64, capture, picture: Arc::new(picture) }
        };
        let labels = (0..50).map(|index| (index % 5 == 0).then(|| Label::There(target(index)))).collect();
        Clip {
            name: "test".to_owned(),
            frames: (0..50).map(frame).collect(),
            labels,
            start: 0,
            selection: target(0),
        }
    }

    #[test]
    fn labels_are_interpolated_up_to_the_last() {
        let boxes = boxes(&clip(), None);
        assert_eq!((boxes.len(), boxes[3].u, boxes[45].u), (46, 566.0, 650.0));
        assert_eq!(super::boxes(&clip(), Some(20)).len(), 20);
    }

    #[test]
    fn the_target_leaves_twice_for_three_to_ten_seconds() {
        let clip = clip();
        let sequence = Composed::new(&clip, &SOURCE, 1, false).unwrap();
        let absent: Vec<bool> =
            (0..sequence.frames()).map(|frame| sequence.draw(frame).1.visible <= 0.0).collect();
        let lengths: Vec<usize> =
            absent.chunk_by(|a, b| a == b).filter(|part| part[0]).map(<[bool]>::len).collect();
        assert_eq!(lengths.len(), EXCURSIONS);
        // 3.0 to 7.5 s of rest, and some of both slides.
        assert!(lengths.iter().all(|frames| (30..105).contains(frames)), "{lengths:?}");
    }

    #[test]
    fn the_truth_is_where_the_target_is_drawn() {
        let clip = clip();
        let sequence = Composed::new(&clip, &SOURCE, 2, true).unwrap();
        for frame in 0..sequence.frames() {
            let (drawn, truth) = sequence.draw(frame);
            let light = |bounds: PixelBox| {
                let y = drawn.picture.y();
                let row = y.row(bounds.centre().v as usize);
                row[bounds.centre().u as usize] > 150
            };
            assert!(truth.bounds.is_empty() || light(truth.bounds), "frame {frame}: {truth:?}");
            for distractor in truth.distractors {
                assert!(distractor.intersection(truth.bounds).is_empty(), "frame {frame}");
                // An ellipse cut off at the border need not reach the middle of what is left of its box.
                if distractor.area() > 3000.0 {
                    assert!(light(distractor), "frame {frame}: {distractor}");
                }
            }
        }
    }

    #[test]
    fn a_thing_lies_where_the_window_rests() {
        let clip = clip();
        let sequence = Composed::new(&clip, &SOURCE, 3, true).unwrap();
        for excursion in &sequence.excursions {
            let resting_s = excursion.leaves_s + excursion.slide_s + excursion.away_s / 2.0;
            let (_, truth) = sequence.draw((resting_s / sequence.frame_s) as usize);
            assert!(!truth.distractors.is_empty());
        }
    }
}
