//! The published tracker: hue histogram, back projection, mean shift, and size and orientation from the
//! moments.
//!
//! Each frame: the search starts at the last window, shifted by the motion prior if there is one. Mean shift
//! moves the window to the nearest mode of the target's hues. The moments there give the target's box and
//! axes and the next window (equations at [`cam_shift`]). The reported box is the upright box of the ellipse
//! with those axes, plus a margin for the mixed pixels at the edge ([`CamShiftTarget::bounds`]), clipped to
//! the picture. The centre is the centroid. The confidence is the mean weight in the box: 1 where every pixel
//! has the selection's most frequent hue.
//!
//! CamShift itself does not detect a loss: it follows anything of the target's hue in the window. `Lost` is
//! therefore reported only if the search window and its margin contain no weight at all. The window then
//! grows by the margin in every frame until it contains some, up to the whole picture.
//!
//! Work per frame: one table look-up per pixel that the search visits, sums over its windows, and about a
//! microsecond per new pair of chroma samples; at worst, the whole picture. Memory: one byte per pixel of the
//! picture, and the table of weights, at most 16 MiB.
//!
//! Not handled: targets without colour, water of the target's hue, other objects of the same hue, loss and
//! re-detection. The fused tracker handles them.

use barrelman_vocab::{
    Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame, track::Shape,
};

use crate::back_projection::BackProjection;
use crate::config::{CamShiftConfig, CamShiftConfigError};
use crate::explanation::Explanation;
use crate::histogram::HueHistogram;
use crate::hue::{Floors, HUE_CODES, YuvToHue};
use crate::hue_weight_table::HueWeightTable;
use crate::mean_shift::{CamShiftTarget, MOMENT_MARGIN_PX, SearchResult, cam_shift};
use crate::moments::MomentSource;
use crate::tracker::{SelectionError, SelectionReport, Tracker};
use crate::window::{Window, exceeds_picture};

/// Tracks a target by its hue.
///
/// ```
/// use std::sync::Arc;
///
/// use barrelman_vision::{CamShift, CamShiftConfig, Tracker};
/// use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
/// use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame};
///
/// /// A red square of 20 x 20 pixels on blue water, its left edge at `left` (an even number).
/// fn frame(left: usize) -> VideoFrame {
///     let size = PictureSize::new(160, 120);
///     let mut picture = Picture::black(size, ColourEncoding::assumed_for(size));
///     let [y, u, v] = picture.planes_mut();
///     y.fill(90);
///     for (index, (u, v)) in u.iter_mut().zip(v).enumerate() {
///         // A chroma sample covers 2 x 2 pixels.
///         let (column, row) = (2 * (index % 80), 2 * (index / 80));
///         let is_boat = (left..left + 20).contains(&column) && (50..70).contains(&row);
///         (*u, *v) = if is_boat { (90, 240) } else { (190, 100) };
///     }
///     let capture = Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sensor };
///     VideoFrame { sequence: 0, capture, picture: Arc::new(picture) }
/// }
///
/// let mut tracker = CamShift::new(CamShiftConfig::default())?;
/// let selection = PixelBox { u: 40.0, v: 50.0, w: 20.0, h: 20.0 };
/// let report = tracker.select(&frame(40), selection)?;
/// assert_eq!((report.coloured_share, report.surroundings_probability), (1.0, 0.0));
///
/// let Track::Tracking(boat) = tracker.track(&frame(46), None) else { panic!("not found") };
/// assert_eq!(boat.centre.u, 56.0);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CamShift {
    config: CamShiftConfig,
    back_projection: BackProjection,
    target: Option<SelectedTarget>,
}

/// State of the selected target.
#[derive(Debug)]
struct SelectedTarget {
    histogram: HueHistogram,
    weights: HueWeightTable,
    /// Size of the picture in whose pixels `window` is given.
    picture: PictureSize,
    /// Start window of the next search.
    window: Window,
    lost_since: Option<Timestamp>,
}

impl CamShift {
    /// A tracker without a selection.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(config: CamShiftConfig) -> Result<Self, CamShiftConfigError> {
        let config = config.validated()?;
        Ok(Self { config, back_projection: BackProjection::default(), target: None })
    }

    /// The tracker's settings.
    pub const fn config(&self) -> &CamShiftConfig {
        &self.config
    }
}

impl Tracker for CamShift {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        let picture = frame.picture.size();
        let window = Window::from_selection(selection, picture)?;
        let floors = self.config.floors();
        let hue = YuvToHue::new(frame.picture.colour());
        let counts = count_hues(&hue, &frame.picture, window, floors);
        let coloured: u32 = counts.iter().sum();
        let Ok(histogram) = HueHistogram::new(&counts, self.config.bins) else {
            return Err(SelectionError::Colourless {
                selection,
                picture,
                saturation_floor: floors.saturation,
                value_floor: floors.value,
            });
        };

        let mut weights = HueWeightTable::new(hue, floors, *histogram.weight_by_hue());
        self.back_projection.reset(picture);
        let mut map = self.back_projection.lazy(&frame.picture, &mut weights, self.config.search_margin_px);
        let within = map.moments(window);
        let ring = window.w.min(window.h).div_ceil(2);
        let around = window.inflated(ring, map.width(), map.height());
        let surroundings_probability =
            mean_weight(map.weight_sum(around) - within.m00, around.area() - window.area());
        let used = window.to_pixel_box();
        let localisation = Localisation {
            captured: frame.capture.at,
            picture,
            centre: used.centre(),
            bounds: used,
            shape: CamShiftTarget::from_moments(&within, map.width(), map.height()).map(shape_of),
            heading: None,
            confidence: mean_weight(within.m00, window.area()),
        };
        let report = SelectionReport {
            used,
            is_clipped: exceeds_picture(selection, picture),
            is_refined: false,
            coloured_share: f64::from(coloured) / window.area() as f64,
            surroundings_probability,
            localisation,
        };
        self.target = Some(SelectedTarget { histogram, weights, picture, window, lost_since: None });
        Ok(report)
    }

    fn track(&mut self, frame: &VideoFrame, prior: Option<&MotionPrior>) -> Track {
        let Some(target) = &mut self.target else {
            return Track::Unseeded;
        };
        let picture = frame.picture.size();
        let mut start = rescaled(target.window, target.picture, picture);
        if let Some(prior) = prior {
            start = shifted(start, prior, picture);
        }
        if start.area() <= 1 {
            start = start.inflated(MOMENT_MARGIN_PX, picture.width as usize, picture.height as usize);
        }
        if target.weights.hue().colour() != frame.picture.colour() {
            target.weights.set_encoding(YuvToHue::new(frame.picture.colour()));
        }
        self.back_projection.reset(picture);
        let mut map =
            self.back_projection.lazy(&frame.picture, &mut target.weights, self.config.search_margin_px);
        target.picture = picture;
        match cam_shift(&mut map, start, self.config.termination_criteria()) {
            SearchResult::Found(found) => {
                let bounds = found.bounds().clipped(picture);
                // The centroid lies in the picture, and so does part of the box.
                let inside = Window::rounded_from(bounds, picture).unwrap_or(found.window);
                let sum = map.weight_sum(inside);
                target.window = found.window;
                target.lost_since = None;
                Track::Tracking(Localisation {
                    captured: frame.capture.at,
                    picture,
                    centre: found.centroid,
                    bounds,
                    shape: Some(shape_of(found)),
                    heading: None,
                    confidence: mean_weight(sum, inside.area()),
                })
            }
            SearchResult::NotFound(window) => {
                target.window = window;
                let since = *target.lost_since.get_or_insert(frame.capture.at);
                Track::Lost { since, confidence: 0.0 }
            }
        }
    }

    fn forget(&mut self) {
        self.target = None;
    }

    /// CamShift cannot tell two objects of one hue apart, and does not search: it forgets the target.
    fn reject(&mut self) -> bool {
        self.target.take().is_some()
    }

    fn explain(&self, out: &mut Explanation) {
        out.clear();
        let Some(target) = &self.target else {
            return;
        };
        out.search_window = Some(target.window.to_pixel_box());
        out.histogram.extend_from_slice(target.histogram.weights());
        let computed = self.back_projection.computed();
        let grey = &mut out.back_projection;
        grey.bounds = computed.to_pixel_box();
        (grey.width, grey.height) = (computed.w, computed.h);
        for row in computed.y..computed.bottom() {
            grey.samples.extend_from_slice(self.back_projection.computed_row(row));
        }
    }
}

/// Number of pixels of each hue code in the window.
fn count_hues(
    hue: &YuvToHue,
    picture: &Picture,
    window: Window,
    floors: Floors,
) -> [u32; HUE_CODES as usize] {
    let mut counts = [0; HUE_CODES as usize];
    for row in window.y..window.bottom() {
        let (ys, us, vs) = (picture.y().row(row), picture.u().row(row / 2), picture.v().row(row / 2));
        for column in window.x..window.right() {
            let code = hue.hue_code([ys[column], us[column / 2], vs[column / 2]], floors);
            if let Some(count) = counts.get_mut(usize::from(code)) {
                *count += 1;
            }
        }
    }
    counts
}

fn shape_of(target: CamShiftTarget) -> Shape {
    Shape { major_px: target.major_px, minor_px: target.minor_px, axis: target.axis }
}

/// Mean weight over an area in pixels, 0 to 1; 0 for an empty area.
fn mean_weight(mass: u64, area: usize) -> f64 {
    if area == 0 { 0.0 } else { mass as f64 / (area as f64 * 255.0) }
}

/// Converts a window to a picture of another size with the same field of view.
fn rescaled(window: Window, from: PictureSize, to: PictureSize) -> Window {
    if from == to {
        return window;
    }
    let scale_u = f64::from(to.width) / f64::from(from.width.max(1));
    let scale_v = f64::from(to.height) / f64::from(from.height.max(1));
    let PixelBox { u, v, w, h } = window.to_pixel_box();
    let scaled = PixelBox { u: u * scale_u, v: v * scale_v, w: w * scale_u, h: h * scale_v };
    Window::rounded_from(scaled, to).unwrap_or(Window::full(to.width as usize, to.height as usize))
}

/// Shifts the window by the prior, in whole pixels, and keeps it in the picture. A prior that is not finite,
/// or whose standard deviation exceeds the window's size, is ignored.
fn shifted(window: Window, prior: &MotionPrior, picture: PictureSize) -> Window {
    let prior = prior.at(window.to_pixel_box().centre(), picture);
    let known = prior.std_dev_px <= window.w.max(window.h) as f64;
    if !(known && prior.shift_u_px.is_finite() && prior.shift_v_px.is_finite()) {
        return window;
    }
    // A cast turns negative numbers into 0.
    let along = |start: usize, shift: f64, length: usize, end: u32| {
        ((start as f64 + shift.round_ties_even()) as usize).min((end as usize).saturating_sub(length))
    };
    Window {
        x: along(window.x, prior.shift_u_px, window.w, picture.width),
        y: along(window.y, prior.shift_v_px, window.h, picture.height),
        ..window
    }
}
