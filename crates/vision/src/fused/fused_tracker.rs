//! The tracker: selections, frames and rejections.

use std::sync::Arc;

use barrelman_vocab::{MotionPrior, PixelBox, PixelPoint, Track, VideoFrame};

use super::config::{FusedConfig, FusedConfigError};
use super::detector::Detector;
use super::distractors::Distractors;
use super::follower::{Follower, SelectedTarget};
use super::learned_target::LearnedTarget;
use super::phase::Phase;
use crate::explanation::Explanation;
use crate::refinement::{RefinementWeights, RefinementWindow};
use crate::tracker::{BackgroundShift, SelectionError, SelectionReport, Tracker};
use crate::window::{Window, exceeds_picture};

/// Minimum width and height of a selection, pixels.
const MIN_SELECTION_PX: (usize, usize) = (6, 4);

/// Tracks a target by its pattern and its colour.
///
/// ```
/// use std::sync::Arc;
///
/// use barrelman_vision::{FusedConfig, FusedTracker, Tracker};
/// use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
/// use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame};
///
/// /// A patterned red boat of 40 x 24 pixels on patterned blue water. `left`: its left edge, an even number.
/// fn frame(sequence: u64, left: usize) -> VideoFrame {
///     let size = PictureSize::new(240, 160);
///     let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
///     let is_boat = |column, row| (left..left + 40).contains(&column) && (60..84).contains(&row);
///     // Brightness of blocks of 4 x 4 pixels.
///     let pattern = |column: usize, row: usize| ((column / 4 * 7 + row / 4 * 13) * 29 % 64) as u8;
///     let [y, u, v] = picture.planes_mut();
///     for (index, y) in y.iter_mut().enumerate() {
///         let (column, row) = (index % 240, index / 240);
///         *y = if is_boat(column, row) {
///             50 + 2 * pattern(column - left, row)
///         } else {
///             80 + pattern(row, column)
///         };
///     }
///     for (index, (u, v)) in u.iter_mut().zip(v).enumerate() {
///         (*u, *v) = if is_boat(2 * (index % 120), 2 * (index / 120)) { (90, 240) } else { (190, 100) };
///     }
///     let at = Timestamp::from_nanos(sequence * 33_000_000);
///     let capture = Capture { at, quality: CaptureQuality::Sensor };
///     VideoFrame { sequence, capture, picture: Arc::new(picture) }
/// }
///
/// let mut tracker = FusedTracker::new(FusedConfig::default())?;
/// tracker.select(&frame(0, 60), PixelBox { u: 60.0, v: 60.0, w: 40.0, h: 24.0 })?;
/// for sequence in 1..=10 {
///     let left = 60 + 4 * sequence;
///     let track = tracker.track(&frame(sequence as u64, left), None);
///     let Track::Tracking(boat) = track else { panic!("{track:?}") };
///     assert!(boat.bounds.iou(PixelBox { u: left as f64, v: 60.0, w: 40.0, h: 24.0 }) > 0.75);
/// }
/// // The boat leaves the picture: the track coasts, and is lost.
/// let last = (11..40).map(|sequence| tracker.track(&frame(sequence, 1000), None)).last();
/// assert!(matches!(last, Some(Track::Lost { .. })));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FusedTracker {
    /// The stages. They are kept while nothing is followed, for their buffers.
    follower: Follower,
    /// The target at the selection, which is searched for after a rejection. `None` before a selection.
    selected: Option<LearnedTarget>,
    distractors: Distractors,
}

impl FusedTracker {
    /// A tracker without a selection.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(config: FusedConfig) -> Result<Self, FusedConfigError> {
        Self::with_weights(config, RefinementWeights::built_in())
    }

    /// The same with other weights of the refinement network.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn with_weights(
        config: FusedConfig,
        weights: Arc<RefinementWeights>,
    ) -> Result<Self, FusedConfigError> {
        let config = config.validated()?;
        let follower = Follower::new(&config, weights);
        Ok(Self { follower, selected: None, distractors: Distractors::default() })
    }

    /// The window that the refinement network read last; `None` while the target is searched for.
    pub fn refinement_window(&self) -> Option<&RefinementWindow> {
        let is_searched = matches!(self.follower.phase, Phase::Lost { .. });
        (self.selected.is_some() && !is_searched).then_some(&self.follower.detector.refiner.window)
    }

    /// Measures the window of the last frame again, around another box than the tracker's, for training
    /// samples. The centre is moved by `shift` sizes of the target, the sides are multiplied by `factors`.
    pub fn measure_other_window(&mut self, shift: (f32, f32), factors: (f32, f32)) {
        let Follower { target, detector, .. } = &mut self.follower;
        let geometry = &target.geometry;
        let ((u, v), (w, h), size) = (geometry.centre, geometry.upright_box(), geometry.size_px());
        let centre = (u + shift.0 * size, v + shift.1 * size);
        let box_size = (w * factors.0, h * factors.1);
        let Detector { observer, refiner, .. } = detector;
        refiner.measure_window(&mut observer.crop, target, (u, v), centre, box_size);
    }

    /// What is followed now cannot be the target: the target is searched for, everywhere and as it was
    /// learned. Unlike after [`Tracker::reject`], that object may be taken again.
    pub fn lose(&mut self) {
        if self.selected.is_some() && self.follower.phase.is_followed() {
            self.follower.mark_lost(true);
            self.follower.phase = Phase::Lost { since: self.follower.motion.last_capture };
        }
    }

    /// A lost target is expected at this place of the next frame, which is searched first. Without effect on
    /// a target that is not lost.
    pub fn expect_lost_at(&mut self, PixelPoint { u, v }: PixelPoint) {
        if matches!(self.follower.phase, Phase::Lost { .. }) {
            self.follower.motion.restart_at((u as f32, v as f32), &self.follower.target.geometry);
        }
    }

    /// The tracker's settings.
    pub const fn config(&self) -> &FusedConfig {
        &self.follower.config
    }
}

impl Tracker for FusedTracker {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        let picture = frame.picture.size();
        let window = Window::from_selection(selection, picture)?;
        let dragged = window.to_pixel_box();
        if window.w < MIN_SELECTION_PX.0 || window.h < MIN_SELECTION_PX.1 {
            let (width, height) = MIN_SELECTION_PX;
            return Err(SelectionError::TooSmall { selection, width, height });
        }
        let SelectedTarget { used, colours, .. } = self.follower.select(frame, dragged);
        self.selected = Some(self.follower.learned());
        self.distractors.clear();
        Ok(SelectionReport {
            used,
            is_clipped: exceeds_picture(selection, picture),
            is_refined: used != dragged,
            coloured_share: colours.coloured_share,
            surroundings_probability: colours.surroundings_probability,
            localisation: self.follower.localisation(frame, used, 1.0),
        })
    }

    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        if self.selected.is_none() {
            return Track::Unseeded;
        }
        self.follower.motion.begin_frame();
        if !self.distractors.is_empty() {
            self.follower.search.excluded = self.distractors.advance(frame, prior);
        }
        self.follower.lose_in_gap(frame.capture.at);
        self.follower.advance(frame, prior)
    }

    fn set_bow_first(&mut self, may_be: bool) {
        self.follower.heading.set_bow_first(may_be);
    }

    fn forget(&mut self) {
        self.selected = None;
        self.distractors.clear();
    }

    fn reject(&mut self) -> bool {
        let Some(selected) = self.selected.as_ref().filter(|_| self.follower.phase.is_followed()) else {
            return false;
        };
        self.distractors.add(self.follower.begin_search(selected));
        self.follower.search.excluded = self.distractors.places();
        true
    }

    fn background_shift(&self) -> Option<BackgroundShift> {
        // Without a target nothing is measured.
        self.selected.as_ref().and_then(|_| self.follower.motion.background_shift())
    }

    fn explain(&self, out: &mut Explanation) {
        out.clear();
        if self.selected.is_some() {
            self.follower.explain(out);
        }
    }
}
