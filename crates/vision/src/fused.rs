//! The default tracker: a correlation filter and a colour model, fused into one measure of evidence, with loss and
//! re-detection.
//!
//! The correlation filter works on gradients, brightness and target probability of the colour, restricted to the target
//! and its close surroundings (`correlation`). The colour model compares the colours at the target with those of the
//! ring around it (`colour_model`). Their sum, the *evidence*, is in standard deviations of the response's sidelobes.
//! Where the target's colour resembles its surroundings', the colour is not used.
//!
//! Steps of one frame:
//!
//! 1. *Predict*: a Kalman filter in pixel coordinates predicts the target's position (`prediction`). The camera's motion
//!    comes from the [`MotionPrior`], or else from registration of the background (`background`).
//! 2. *Observe*: the search window is extracted at the coarsest resolution that the target's size allows, rotated and
//!    scaled as the target was (`crop`, `features`). The observation is the peak of the filter's response. If the
//!    prediction is uncertain compared with the window, the neighbouring windows are evaluated too.
//! 3. *Evaluate*: the evidence and the probability of the refined box give the state (`phase`, `evidence`).
//! 4. *Refine*: a network reads a window around the box and answers with its edges and the probability of the box,
//!    which is the confidence (`refinement`). A doubtful target is looked for around it with filters of earlier views
//!    (`reconsidering`). The filter's response at other sizes and rotations corrects both, the moments of the colour
//!    correct centre and axis (`silhouette`), the blob of the paint follows a target that changes its shape (`blob`), and
//!    the path distinguishes bow and stern (`heading`).
//! 5. *Learn*: filter and histograms adapt to the frame if the evidence is good (`learning`).
//!
//! A lost target is searched for by colour in the whole picture (`redetection`), and by the filter at the place of the
//! loss and in one window of a systematic search per frame (`recovery`). A re-detected target is reported after it was
//! confirmed in the following frames, unless an earlier picture shows that it is another thing (`known_scene`).
//!
//! Work per frame: one search window of at most 130 x 130 samples and about nine small patches, for a target of any
//! size; at most eight search windows while it is lost. Memory: less than 3 MiB, and two earlier video frames that are shared
//! with their source; no allocation per frame once the buffers have their size.
//!
//! Not handled: targets that change beyond recognition while hidden, groups of similar targets that cross, targets
//! smaller than about 6 pixels.

mod config;

mod vector;
mod workspace;

mod blob;
mod box_probability;
mod companions;
mod contact;
mod contradicted_box;
mod distractors;
mod exchanged_target;
mod excluded_places;
mod following;
mod identity;
mod known_scene;
mod learning;
mod paint_selection;
mod reconsidering;
mod recovery;
mod refining;
mod shape_following;

mod contradiction;
mod evidence;
mod phase;

mod appearance;
mod extent;
mod filter_views;
mod geometry;
mod loss;
mod observation;
mod prediction;
mod reference_silhouette;
mod surroundings;
mod target;
mod target_paint;

#[cfg(test)]
mod test_target;

use std::sync::Arc;

use barrelman_vocab::{MotionPrior, PixelBox, Track, VideoFrame};

pub use self::config::{FusedConfig, FusedConfigError, FusedSetting};
use self::distractors::Distractors;
use self::phase::Phase;
use self::target::Target;
use self::workspace::Workspace;
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
/// /// A patterned red boat of 40 x 24 pixels, its left edge at `left` (an even number), on patterned blue water.
/// fn frame(sequence: u64, left: usize) -> VideoFrame {
///     let size = PictureSize::new(240, 160);
///     let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
///     let is_boat = |column, row| (left..left + 40).contains(&column) && (60..84).contains(&row);
///     // Brightness of blocks of 4 x 4 pixels.
///     let pattern = |column: usize, row: usize| ((column / 4 * 7 + row / 4 * 13) * 29 % 64) as u8;
///     let [y, u, v] = picture.planes_mut();
///     for (index, y) in y.iter_mut().enumerate() {
///         let (column, row) = (index % 240, index / 240);
///         *y = if is_boat(column, row) { 50 + 2 * pattern(column - left, row) } else { 80 + pattern(row, column) };
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
///     let Track::Tracking(boat) = tracker.track(&frame(sequence as u64, left), None) else { panic!("not found") };
///     assert!(boat.bounds.iou(PixelBox { u: left as f64, v: 60.0, w: 40.0, h: 24.0 }) > 0.75);
/// }
/// // The boat leaves the picture: the track coasts, and is lost.
/// let last = (11..40).map(|sequence| tracker.track(&frame(sequence, 1000), None)).last();
/// assert!(matches!(last, Some(Track::Lost { .. })));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FusedTracker {
    config: FusedConfig,
    workspace: Workspace,
    target: Option<Target>,
    /// The target as it was selected: what is searched for after a rejection.
    selected: Option<Target>,
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
        Ok(Self {
            config,
            workspace: Workspace::new(&config, weights),
            target: None,
            selected: None,
            distractors: Distractors::default(),
        })
    }

    /// The window that the refinement network read in the last frame; `None` where the target was searched for.
    pub fn refinement_window(&self) -> Option<&RefinementWindow> {
        let is_followed = |target: &Target| !matches!(target.phase, Phase::Lost { .. });
        self.target.as_ref().is_some_and(is_followed).then_some(&self.workspace.window)
    }

    /// Measures the window of the last frame anew, around another box than the tracker's: for training samples. The
    /// centre is moved by `shift` sizes of the target, the sides are multiplied by `factors`.
    pub fn measure_other_window(&mut self, shift: (f32, f32), factors: (f32, f32)) {
        let Some(target) = &self.target else { return };
        let geometry = &target.geometry;
        let ((u, v), (w, h), size) = (geometry.centre, geometry.upright_box(), geometry.size_px());
        let centre = (u + shift.0 * size, v + shift.1 * size);
        self.workspace.measure_window(target, (u, v), centre, (w * factors.0, h * factors.1));
    }

    /// The tracker's settings.
    pub const fn config(&self) -> &FusedConfig {
        &self.config
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
        let (target, colours, used) = self.workspace.learn_selection(&self.config, frame, dragged);
        let localisation = target.localisation(frame, used, 1.0);
        self.selected = Some(target.clone());
        self.target = Some(target);
        self.distractors.clear();
        Ok(SelectionReport {
            used,
            is_clipped: exceeds_picture(selection, picture),
            is_refined: used != dragged,
            coloured_share: colours.coloured_share,
            surroundings_probability: colours.surroundings_probability,
            localisation,
        })
    }

    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        let Some(target) = &mut self.target else {
            return Track::Unseeded;
        };
        self.workspace.background.forget_measurement();
        if !self.distractors.is_empty() {
            target.loss.excluded = self.distractors.advance(&self.config, frame, prior);
        }
        target.lose_in_gap(&self.config, frame.capture.at);
        self.workspace.advance(&self.config, target, frame, prior)
    }

    fn forget(&mut self) {
        (self.target, self.selected) = (None, None);
        self.distractors.clear();
    }

    fn reject(&mut self) -> bool {
        let is_followed =
            |target: &mut Target| matches!(target.phase, Phase::Tracking | Phase::Coasting { .. });
        let (Some(target), Some(selected)) = (self.target.take_if(is_followed), &self.selected) else {
            return false;
        };
        let mut search = selected.clone();
        search.begin_search(&target);
        self.distractors.add(&self.config, self.workspace.weights(), target);
        search.loss.excluded = self.distractors.places();
        self.target = Some(search);
        true
    }

    fn background_shift(&self) -> Option<BackgroundShift> {
        self.workspace.background.measured()
    }

    fn explain(&self, out: &mut Explanation) {
        out.clear();
        if let Some(target) = &self.target {
            self.workspace.explain(target, out);
        }
    }
}
