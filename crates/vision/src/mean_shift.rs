//! Mean shift and CamShift on any map of weights.
//!
//! *Mean shift* moves the search window so that its centre lies on the centroid of the weights in it, (m10,
//! m01) / m00, until it comes to rest. The window moves by whole pixels and stays in the map.
//!
//! *CamShift* (continuously adaptive mean shift; Bradski 1998) then computes the moments over the window and
//! a margin around it, so that a target larger than the window can be measured. The normalised central
//! moments, square pixels, are a = m20/m00 - xc^2, b = m11/m00 - xc yc and c = m02/m00 - yc^2. The variances
//! along the principal axes are
//!
//! ```text
//! ((a + c) ± sqrt(4 b^2 + (a - c)^2)) / 2
//! ```
//!
//! and the major axis is turned by atan2(2 b, a - c) / 2 from the x axis towards the y axis. A uniform
//! ellipse with full axes l and w has the variances (l/4)^2 and (w/4)^2; the reported axes are therefore four
//! standard deviations long.
//!
//! The next search window is upright, centred on the centroid, max(l |cos|, w |sin|) + 2 wide and
//! max(l |sin|, w |cos|) + 2 high, clipped to the map. All this agrees with OpenCV's `CamShift`, which the
//! laboratory used.
//!
//! The *reported* box is the upright box of the ellipse, sqrt((l cos)^2 + (w sin)^2) wide and sqrt((l
//! sin)^2 + (w cos)^2) high about the unrounded centroid, plus [`EDGE_MARGIN_PX`] on every side. The search
//! window is too small for a target at an angle, and the upright box of OpenCV's rotated rectangle is larger
//! than the ellipse.
//!
//! Work: one pass over the first window with a few integer operations per pixel. Each of the at most
//! `max_iterations` steps adds the pixels that enter and leave the window, never more than another pass. Not
//! handled: several targets in one window, and changes of scale between the frames.

use barrelman_vocab::{Angle, PixelBox, PixelPoint};

use crate::moments::{MomentSource, Moments, RunningMoments};
use crate::window::Window;

/// Margin on every side of the window over which size and axis are measured, and by which an empty window
/// grows, pixels. 10 is OpenCV's value, and so the laboratory's.
pub const MOMENT_MARGIN_PX: usize = 10;

/// Margin of the reported box on every side of the ellipse, pixels. The pixels at the target's edge are mixed
/// with the background, and their hues do not count: a chroma sample is two pixels wide, and a sample cut by
/// the edge is lost. On labelled recordings 1 to 2 fit best.
pub const EDGE_MARGIN_PX: f64 = 1.5;

/// When mean shift ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TerminationCriteria {
    /// Maximum number of steps, at least 1.
    pub max_iterations: u32,
    /// Mean shift ends after a step shorter than this, pixels.
    pub epsilon_px: f64,
}

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchResult {
    /// The search window contains weight.
    Found(CamShiftTarget),
    /// No weight in this window: the last search window enlarged by [`MOMENT_MARGIN_PX`].
    NotFound(Window),
}

/// What CamShift found: the ellipse of the weights' moments, and the next search window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CamShiftTarget {
    /// Start window of the search in the next frame.
    pub window: Window,
    /// Centroid of the weights in pixel coordinates: the centre of the first pixel is (0.5, 0.5).
    pub centroid: PixelPoint,
    /// Full length of the major axis, pixels.
    pub major_px: f64,
    /// Full length of the minor axis, pixels.
    pub minor_px: f64,
    /// Direction of the major axis, anticlockwise from image right as seen, 0 (inclusive) to pi (exclusive).
    pub axis: Angle,
}

impl CamShiftTarget {
    /// The upright box around the whole target. It may exceed the picture.
    pub fn bounds(&self) -> PixelBox {
        let (sin, cos) = (libm::sin(self.axis.radians()), libm::cos(self.axis.radians()));
        let reach = |major: f64, minor: f64| {
            let (major, minor) = (self.major_px * major, self.minor_px * minor);
            (major * major + minor * minor).sqrt() + 2.0 * EDGE_MARGIN_PX
        };
        let (w, h) = (reach(cos, sin), reach(sin, cos));
        PixelBox { u: self.centroid.u - w / 2.0, v: self.centroid.v - h / 2.0, w, h }
    }

    /// The target with these moments in a map of this size; `None` if the weights sum to zero.
    pub(crate) fn from_moments(sums: &Moments, width: usize, height: usize) -> Option<Self> {
        EquivalentEllipse::from_moments(sums).map(|ellipse| ellipse.to_target(width, height))
    }
}

/// Searches for the target from the window `start`, which is clipped to the map.
pub fn cam_shift(map: &mut impl MomentSource, start: Window, criteria: TerminationCriteria) -> SearchResult {
    let (width, height) = (map.width(), map.height());
    let mut sums = RunningMoments::new(map);
    let rest = mean_shift(&mut sums, (width, height), start.clipped(width, height), criteria);
    let around = rest.inflated(MOMENT_MARGIN_PX, width, height);
    match CamShiftTarget::from_moments(&sums.moments_over(around), width, height) {
        Some(target) => SearchResult::Found(target),
        None => SearchResult::NotFound(around),
    }
}

/// Moves the window until its centre lies on the centroid of its weights; the final window.
fn mean_shift<M: MomentSource>(
    sums: &mut RunningMoments<'_, M>,
    (width, height): (usize, usize),
    start: Window,
    criteria: TerminationCriteria,
) -> Window {
    let mut window = start;
    for _ in 0..criteria.max_iterations.max(1) {
        let sums = sums.moments_over(window);
        if sums.m00 == 0 {
            break;
        }
        let x = recentred(window.x, window.w, sums.m10, sums.m00, width);
        let y = recentred(window.y, window.h, sums.m01, sums.m00, height);
        let (step_x, step_y) = (x.abs_diff(window.x) as f64, y.abs_diff(window.y) as f64);
        (window.x, window.y) = (x, y);
        if step_x * step_x + step_y * step_y < criteria.epsilon_px * criteria.epsilon_px {
            break;
        }
    }
    window
}

/// Start of an interval of `length` pixels centred on the centroid, within 0..end.
fn recentred(start: usize, length: usize, moment: u64, mass: u64, end: usize) -> usize {
    let centroid = moment as f64 / mass as f64;
    let step = (centroid - start as f64 - length as f64 / 2.0).round_ties_even();
    // The centroid lies in the window, so the sum is small. A cast turns negative numbers into 0.
    ((start as f64 + step) as usize).min(end.saturating_sub(length))
}

/// The uniform ellipse with the same centroid and second moments; x, y in whole pixels, y downwards.
struct EquivalentEllipse {
    x: f64,
    y: f64,
    major: f64,
    minor: f64,
    /// From the x axis towards the y axis, that is clockwise as seen, -pi/2 to pi/2.
    turn: f64,
}

impl EquivalentEllipse {
    fn from_moments(sums: &Moments) -> Option<Self> {
        if sums.m00 == 0 {
            return None;
        }
        let mass = sums.m00 as f64;
        let (x, y) = (sums.m10 as f64 / mass, sums.m01 as f64 / mass);
        let a = sums.m20 as f64 / mass - x * x;
        let b = sums.m11 as f64 / mass - x * y;
        let c = sums.m02 as f64 / mass - y * y;
        let spread = (4.0 * b * b + (a - c) * (a - c)).sqrt();
        // Rounding can give a slightly negative variance where the weights have no extent.
        let axis = |variance: f64| 4.0 * variance.max(0.0).sqrt();
        let turn = libm::atan2(2.0 * b, a - c) / 2.0;
        Some(Self { x, y, major: axis((a + c + spread) / 2.0), minor: axis((a + c - spread) / 2.0), turn })
    }

    fn to_target(&self, width: usize, height: usize) -> CamShiftTarget {
        let (sin, cos) = (libm::sin(self.turn).abs(), libm::cos(self.turn).abs());
        let (x, w) = next_window_span(self.x, (self.major * cos).max(self.minor * sin), width);
        let (y, h) = next_window_span(self.y, (self.major * sin).max(self.minor * cos), height);
        // In the picture the positive direction is clockwise, in the report anticlockwise. Where the turn is
        // slightly above zero, the difference rounds to pi, which is the same axis as 0.
        let upward = if self.turn > 0.0 { core::f64::consts::PI - self.turn } else { -self.turn };
        let axis = if upward >= core::f64::consts::PI { 0.0 } else { upward };
        CamShiftTarget {
            window: Window { x, y, w, h },
            centroid: PixelPoint { u: self.x + 0.5, v: self.y + 0.5 },
            major_px: self.major,
            minor_px: self.minor,
            axis: Angle::from_radians(axis),
        }
    }
}

/// Start and length of the next window along one axis: `reach` plus two pixels around `centroid`, within
/// 0..end.
fn next_window_span(centroid: f64, reach: f64, end: usize) -> (usize, usize) {
    let middle = (centroid.round_ties_even() as usize).min(end.saturating_sub(1));
    let length = (reach.round_ties_even() as usize + 2).min((end - middle) * 2);
    let start = middle.saturating_sub(length / 2);
    (start, length.min(end - start))
}
