//! Length, breadth and axis of the target, and the upright box that follows from them.
//!
//! The operator selects an upright box. If the colour shows an elongated silhouette in it, the silhouette
//! gives the target's axis, and length and breadth are those whose upright box is the operator's. Otherwise a
//! clearly elongated box gives the axis. Otherwise the axis is unknown, and the box does not turn with the
//! target.
//!
//! The target has the length L and the breadth B, and its axis the angle a. The width of the upright box of a
//! rectangle is the sum of L |cos a| and B |sin a|, that of an ellipse the root of the sum of their squares.
//! Hulls lie between the two, and so does the exponent of the norm, [`NORM_EXPONENT`].

use crate::colour_model::TargetEllipse;
use crate::silhouette::Silhouette;
use crate::vector::Rotation;

/// Exponent of the norm: 1 for rectangles, 2 for ellipses.
const NORM_EXPONENT: f32 = 1.25;
/// Settings of the axis of a selection. Settings without a figure were not measured individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExtentSettings {
    /// Maximum ratio of minor to major axis of a silhouette that gives the axis, 0 to 1.
    max_roundness: f32,
    /// Lower bound of the ratio of breadth to length, 0 to 1.
    min_roundness: f32,
    /// Minimum ratio of the sides of a box that gives the axis, above 1.
    min_elongation: f32,
    /// Maximum ratio of a side of the operator's box to that of the silhouette's upright box.
    max_stretch: f32,
}

impl Default for ExtentSettings {
    fn default() -> Self {
        Self { max_roundness: 0.75, min_roundness: 0.15, min_elongation: 1.4, max_stretch: 1.25 }
    }
}

/// A target's proportions, at the size of the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Extent {
    /// A target without a known axis: an upright box, pixels.
    Box { width: f32, height: f32 },
    /// Length and breadth, pixels; the axis at the selection, radians clockwise from image right; and the
    /// factors by which the operator's box is wider and higher than the upright box of length and breadth.
    Hull { length: f32, breadth: f32, axis: f32, stretch: (f32, f32) },
}

impl Extent {
    /// The extent of a selection with this width and height, pixels.
    pub(super) fn from_selection((width, height): (f32, f32), silhouette: Option<&Silhouette>) -> Self {
        let settings = ExtentSettings::default();
        if let Some(seen) = silhouette.filter(|seen| seen.roundness() < settings.max_roundness) {
            let roundness = seen.roundness().max(settings.min_roundness);
            let unit = upright_box_of(1.0, roundness, seen.axis);
            let length = (width * height / (unit.0 * unit.1)).sqrt();
            let stretch = (width / (length * unit.0), height / (length * unit.1));
            if stretch.0 < settings.max_stretch && stretch.1 < settings.max_stretch {
                return Self::Hull { length, breadth: length * roundness, axis: seen.axis, stretch };
            }
        }
        if width > settings.min_elongation * height {
            Self::Hull { length: width, breadth: height, axis: 0.0, stretch: (1.0, 1.0) }
        } else if height > settings.min_elongation * width {
            let axis = core::f32::consts::FRAC_PI_2;
            Self::Hull { length: height, breadth: width, axis, stretch: (1.0, 1.0) }
        } else {
            Self::Box { width, height }
        }
    }

    /// Width and height of the upright box, pixels, of a target `scale` times as large with its axis at
    /// `axis`.
    pub(super) fn upright_box(&self, scale: f32, axis: f32) -> (f32, f32) {
        match *self {
            Self::Box { width, height } => (scale * width, scale * height),
            Self::Hull { length, breadth, axis: first, stretch } => {
                let (w, h) = upright_box_of(scale * length, scale * breadth, axis);
                // The stretch holds for the axis at the selection; at 90 degrees to it, the factors are
                // exchanged.
                let turned = libm::sinf(axis - first);
                let share = turned * turned;
                let blend = |along: f32, across: f32| along + (across - along) * share;
                (w * blend(stretch.0, stretch.1), h * blend(stretch.1, stretch.0))
            }
        }
    }

    /// Multiplies length and breadth by these factors. A box stays as it is.
    pub(super) fn stretch(&mut self, longer: f32, wider: f32) {
        if let Self::Hull { length, breadth, .. } = self {
            *length *= longer;
            *breadth *= wider;
        }
    }

    /// Half axes of the target's ellipse, along and across its axis, pixels, at this scale.
    pub(super) fn half_axes(&self, scale: f32) -> (f32, f32) {
        match *self {
            Self::Box { width, height } => (0.5 * scale * width, 0.5 * scale * height),
            Self::Hull { length, breadth, .. } => (0.5 * scale * length, 0.5 * scale * breadth),
        }
    }

    /// The ellipse in which the colours of a target `scale` times as large with its axis at `axis` are
    /// counted.
    pub(super) fn ellipse(&self, scale: f32, axis: f32) -> TargetEllipse {
        let box_size = self.upright_box(scale, axis);
        match *self {
            Self::Box { .. } => TargetEllipse::inscribed_in(box_size),
            Self::Hull { .. } => TargetEllipse { box_size, half: self.half_axes(scale), angle: axis },
        }
    }

    /// The axis at the selection, radians clockwise from image right, if it is known.
    pub(super) fn axis(&self) -> Option<f32> {
        match *self {
            Self::Box { .. } => None,
            Self::Hull { axis, .. } => Some(axis),
        }
    }
}

/// Width and height of the upright box of a hull.
pub(super) fn upright_box_of(length: f32, breadth: f32, axis: f32) -> (f32, f32) {
    let Rotation { cos, sin } = Rotation::by(axis);
    let (c, s) = (cos.abs(), sin.abs());
    let norm = |a: f32, b: f32| {
        libm::powf(libm::powf(a, NORM_EXPONENT) + libm::powf(b, NORM_EXPONENT), 1.0 / NORM_EXPONENT)
    };
    (norm(length * c, breadth * s), norm(length * s, breadth * c))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(axis: f32, major: f32, minor: f32) -> Silhouette {
        Silhouette { area: 0.0, centroid: (0.0, 0.0), midpoint: (0.0, 0.0), axis, major, minor }
    }

    fn check(selection: (f32, f32), silhouette: Option<Silhouette>, axis_expected: Option<f32>) {
        let extent = Extent::from_selection(selection, silhouette.as_ref());
        assert_eq!(extent.axis(), axis_expected, "{selection:?} {silhouette:?}");
        let axis = extent.axis().unwrap_or(0.0);
        let (w, h) = extent.upright_box(1.0, axis);
        assert!(
            (w - selection.0).abs() < 0.02 * w && (h - selection.1).abs() < 0.02 * h,
            "{selection:?}: {w} x {h}"
        );
        let (w, h) = extent.upright_box(2.0, axis);
        assert!((w - 2.0 * selection.0).abs() < 0.04 * w && (h - 2.0 * selection.1).abs() < 0.04 * h);
    }

    #[test]
    fn the_selections_box_comes_out_again() {
        check((40.0, 38.0), None, None);
        check((80.0, 30.0), None, Some(0.0));
        check((30.0, 80.0), None, Some(core::f32::consts::FRAC_PI_2));
        check((50.0, 50.0), Some(seen(0.8, 60.0, 20.0)), Some(0.8));
        check((50.0, 50.0), Some(seen(0.8, 60.0, 55.0)), None);
        // A silhouette that contradicts the box is ignored.
        check((90.0, 30.0), Some(seen(1.5, 60.0, 20.0)), Some(0.0));
    }

    #[test]
    fn a_hull_that_turns_has_its_box_turned() {
        let extent = Extent::from_selection((90.0, 30.0), None);
        let (w, h) = extent.upright_box(1.0, core::f32::consts::FRAC_PI_2);
        assert!((w - 30.0).abs() < 0.01 && (h - 90.0).abs() < 0.01, "{w} x {h}");
    }
}
