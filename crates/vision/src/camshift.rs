//! The published tracker: hue histogram, back projection, mean shift, and size and direction from the moments.
//!
//! Per frame: the search starts from the last window (moved by the camera's motion where a prior says so), the mean
//! shift brings it onto the nearest mass of the target's hues, and the moments there give the box and the axes of
//! the target and the next window ([`cam_shift`] has the maths). The reported box is the upright box around the
//! ellipse with those axes and a little more for the mixed pixels at the edge ([`Target::bounds`]), cut off at the
//! picture's border. The centre is the centroid of the mass, the confidence the mean likeness in the box: 1 where
//! every pixel has the hue that is most frequent in the selection.
//!
//! CamShift knows no loss of its own: anything of the target's hue in the window is followed. So `Lost` is said only
//! where there is no mass at all in the search window and its margin; the window then grows by the margin in every
//! frame until it meets some, at last over the whole picture.
//!
//! Work per frame: one look-up for every pixel that the search visits, sums over its windows, and about a
//! microsecond for every pair of chroma samples that was not met before; at worst, that of the whole picture. Memory:
//! one byte per pixel of the picture and the table of weights, at most 16 MiB.
//!
//! Not handled: a target without colour, water of the target's hue, a second thing of the same hue, loss and
//! finding again. A later tracker does.

use barrelman_vocab::{
    Localisation, MotionPrior, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame, track::Shape,
};

use crate::back_projection::BackProjection;
use crate::config::{CamShiftConfig, ConfigError};
use crate::explanation::Explanation;
use crate::histogram::HueHistogram;
use crate::hue::{Floors, HUES, HueOfYuv};
use crate::likeness::Likeness;
use crate::mean_shift::{MARGIN, Search, Target, cam_shift};
use crate::moments::Mass;
use crate::tracker::{SelectionError, SelectionReport, Tracker};
use crate::window::{Window, reaches_out};

/// Follows a target by its hue.
#[derive(Debug)]
pub struct CamShift {
    config: CamShiftConfig,
    map: BackProjection,
    target: Option<Followed>,
}

/// What is known of the target.
#[derive(Debug)]
struct Followed {
    histogram: HueHistogram,
    likeness: Likeness,
    /// Size of the picture that `window` counts in.
    picture: PictureSize,
    /// Where the next search starts.
    window: Window,
    lost_since: Option<Timestamp>,
}

impl CamShift {
    /// A tracker with nothing selected.
    ///
    /// # Errors
    /// If a setting lies outside its range.
    pub fn new(config: CamShiftConfig) -> Result<Self, ConfigError> {
        let config = config.validated()?;
        Ok(Self { config, map: BackProjection::default(), target: None })
    }

    /// Its settings.
    pub const fn config(&self) -> &CamShiftConfig {
        &self.config
    }
}

impl Tracker for CamShift {
    fn select(&mut self, frame: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        let picture = frame.picture.size();
        let window = Window::of_selection(selection, picture)?;
        let floors = self.config.floors();
        let hue = HueOfYuv::new(frame.picture.colour());
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

        let mut likeness = Likeness::new(hue, floors, *histogram.of_hue());
        self.map.restart(picture);
        let mut map = self.map.look(&frame.picture, &mut likeness, self.config.search_margin_px);
        let within = map.moments(window);
        let ring = window.w.min(window.h).div_ceil(2);
        let around = window.inflated(ring, map.width(), map.height());
        let surroundings = mean_weight(map.mass(around) - within.m00, around.area() - window.area());
        let used = window.in_pixels();
        let localisation = Localisation {
            captured: frame.capture.at,
            picture,
            centre: used.centre(),
            bounds: used,
            shape: Target::of(&within, map.width(), map.height()).map(shape),
            heading: None,
            confidence: mean_weight(within.m00, window.area()),
        };
        let report = SelectionReport {
            used,
            clipped: reaches_out(selection, picture),
            coloured: f64::from(coloured) / window.area() as f64,
            surroundings,
            localisation,
        };
        self.target = Some(Followed { histogram, likeness, picture, window, lost_since: None });
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
            start = start.inflated(MARGIN, picture.width as usize, picture.height as usize);
        }
        if target.likeness.hue().colour() != frame.picture.colour() {
            target.likeness.turn_to(HueOfYuv::new(frame.picture.colour()));
        }
        self.map.restart(picture);
        let mut map = self.map.look(&frame.picture, &mut target.likeness, self.config.search_margin_px);
        target.picture = picture;
        match cam_shift(&mut map, start, self.config.criteria()) {
            Search::Found(found) => {
                let bounds = found.bounds().clipped(picture);
                // The centroid lies in the picture, and so part of the box.
                let inside = Window::nearest(bounds, picture).unwrap_or(found.window);
                let mass = map.mass(inside);
                target.window = found.window;
                target.lost_since = None;
                Track::Tracking(Localisation {
                    captured: frame.capture.at,
                    picture,
                    centre: found.centroid,
                    bounds,
                    shape: Some(shape(found)),
                    heading: None,
                    confidence: mean_weight(mass, inside.area()),
                })
            }
            Search::Nothing(window) => {
                target.window = window;
                let since = *target.lost_since.get_or_insert(frame.capture.at);
                Track::Lost { since, confidence: 0.0 }
            }
        }
    }

    fn explain(&self, out: &mut Explanation) {
        out.clear();
        let Some(target) = &self.target else {
            return;
        };
        out.search_window = Some(target.window.in_pixels());
        out.histogram.extend_from_slice(target.histogram.weights());
        let known = self.map.known();
        let grey = &mut out.back_projection;
        grey.bounds = known.in_pixels();
        (grey.width, grey.height) = (known.w, known.h);
        for row in known.y..known.bottom() {
            grey.samples.extend_from_slice(self.map.known_row(row));
        }
    }
}

/// How many pixels of the window have each hue.
fn count_hues(hue: &HueOfYuv, picture: &Picture, window: Window, floors: Floors) -> [u32; HUES as usize] {
    let mut counts = [0; HUES as usize];
    for row in window.y..window.bottom() {
        let (ys, us, vs) = (picture.y().row(row), picture.u().row(row / 2), picture.v().row(row / 2));
        for column in window.x..window.right() {
            let code = hue.code([ys[column], us[column / 2], vs[column / 2]], floors);
            if let Some(count) = counts.get_mut(usize::from(code)) {
                *count += 1;
            }
        }
    }
    counts
}

fn shape(target: Target) -> Shape {
    Shape { major_px: target.major_px, minor_px: target.minor_px, axis: target.axis }
}

/// Mean of the weights over an area in pixels, 0 to 1; 0 where there is none.
fn mean_weight(mass: u64, area: usize) -> f64 {
    if area == 0 { 0.0 } else { mass as f64 / (area as f64 * 255.0) }
}

/// A window of one picture on a picture of another size that shows the same.
fn rescaled(window: Window, from: PictureSize, to: PictureSize) -> Window {
    if from == to {
        return window;
    }
    let scale_u = f64::from(to.width) / f64::from(from.width.max(1));
    let scale_v = f64::from(to.height) / f64::from(from.height.max(1));
    let PixelBox { u, v, w, h } = window.in_pixels();
    let scaled = PixelBox { u: u * scale_u, v: v * scale_v, w: w * scale_u, h: h * scale_v };
    Window::nearest(scaled, to).unwrap_or(Window::whole(to.width as usize, to.height as usize))
}

/// The window moved with the picture, by whole pixels, and kept in it. A prior that is not finite, or does not know the
/// shift to within the window's size, is passed over.
fn shifted(window: Window, prior: &MotionPrior, picture: PictureSize) -> Window {
    let known = prior.std_dev_px <= window.w.max(window.h) as f64;
    if !(known && prior.shift_u_px.is_finite() && prior.shift_v_px.is_finite()) {
        return window;
    }
    // A cast of what is negative gives 0.
    let along = |start: usize, shift: f64, length: usize, end: u32| {
        ((start as f64 + shift.round_ties_even()) as usize).min((end as usize).saturating_sub(length))
    };
    Window {
        x: along(window.x, prior.shift_u_px, window.w, picture.width),
        y: along(window.y, prior.shift_v_px, window.h, picture.height),
        ..window
    }
}
