//! How long, how wide and which way the target lies, and the upright box that follows from it.
//!
//! The operator gives an upright box. Where the colour shows an elongated silhouette in it, that is the target's
//! axis, and length and breadth are those whose upright box is the operator's. Where it does not but the box is
//! clearly longer than wide, the target is taken to lie along the box. Else the target has no axis that is known, and
//! its box does not turn with it.
//!
//! The upright box of a target of length L and breadth B whose axis is at the angle a: a rectangle's would be
//! L |cos a| + B |sin a| wide, an ellipse's the root of the sum of squares; hulls lie between, and so does the
//! exponent [`ROUNDING`] of the norm.

use crate::colour_model::Region;
use crate::silhouette::Silhouette;

/// 1 for rectangles, 2 for ellipses.
const ROUNDING: f32 = 1.25;
/// Silhouettes rounder than this have no axis.
const ROUND: f32 = 0.75;
/// Boxes less elongated than this have no axis.
const ELONGATED: f32 = 1.4;
/// What the silhouette says of the box may differ from the operator's by this factor.
const MISFIT: f32 = 1.25;

/// A target's proportions, at the size of the selection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Extent {
    /// An upright box that does not turn, pixels.
    Box { width: f32, height: f32 },
    /// Length and breadth, pixels, the axis at the selection (radians clockwise from image right), and by what the
    /// upright box differs from what would follow from them.
    Hull { length: f32, breadth: f32, axis: f32, stretch: (f32, f32) },
}

impl Extent {
    /// Of a selection of that width and height.
    pub(crate) fn of_selection((width, height): (f32, f32), silhouette: Option<&Silhouette>) -> Self {
        if let Some(seen) = silhouette.filter(|seen| seen.roundness() < ROUND) {
            let roundness = seen.roundness().max(0.15);
            let unit = upright(1.0, roundness, seen.axis);
            let length = (width * height / (unit.0 * unit.1)).sqrt();
            let stretch = (width / (length * unit.0), height / (length * unit.1));
            if stretch.0 < MISFIT && stretch.1 < MISFIT {
                return Self::Hull { length, breadth: length * roundness, axis: seen.axis, stretch };
            }
        }
        if width > ELONGATED * height {
            Self::Hull { length: width, breadth: height, axis: 0.0, stretch: (1.0, 1.0) }
        } else if height > ELONGATED * width {
            let axis = core::f32::consts::FRAC_PI_2;
            Self::Hull { length: height, breadth: width, axis, stretch: (1.0, 1.0) }
        } else {
            Self::Box { width, height }
        }
    }

    /// Width and height of the upright box of a target that is `scale` times as large and whose axis is `axis`.
    pub(crate) fn upright(&self, scale: f32, axis: f32) -> (f32, f32) {
        match *self {
            Self::Box { width, height } => (scale * width, scale * height),
            Self::Hull { length, breadth, axis: first, stretch } => {
                let (w, h) = upright(scale * length, scale * breadth, axis);
                // The stretch belongs to the view at the selection: turned by 90 degrees it is the other way around.
                let turned = libm::sinf(axis - first);
                let share = turned * turned;
                let of = |along: f32, across: f32| along + (across - along) * share;
                (w * of(stretch.0, stretch.1), h * of(stretch.1, stretch.0))
            }
        }
    }

    /// Makes a hull longer and wider by these factors.
    pub(crate) fn stretch(&mut self, longer: f32, wider: f32) {
        if let Self::Hull { length, breadth, .. } = self {
            *length *= longer;
            *breadth *= wider;
        }
    }

    /// Half axes of the ellipse that stands for the target, along and across its axis.
    pub(crate) fn half_axes(&self, scale: f32) -> (f32, f32) {
        match *self {
            Self::Box { width, height } => (0.5 * scale * width, 0.5 * scale * height),
            Self::Hull { length, breadth, .. } => (0.5 * scale * length, 0.5 * scale * breadth),
        }
    }

    /// What the colours of a target are counted in that is `scale` times as large and whose axis is `axis`.
    pub(crate) fn region(&self, scale: f32, axis: f32) -> Region {
        let upright = self.upright(scale, axis);
        match *self {
            Self::Box { .. } => Region::upright(upright),
            Self::Hull { .. } => Region { upright, half: self.half_axes(scale), angle: axis },
        }
    }

    /// The axis at the selection, if there is one.
    pub(crate) fn axis(&self) -> Option<f32> {
        match *self {
            Self::Box { .. } => None,
            Self::Hull { axis, .. } => Some(axis),
        }
    }
}

fn upright(length: f32, breadth: f32, axis: f32) -> (f32, f32) {
    let (c, s) = (libm::cosf(axis).abs(), libm::sinf(axis).abs());
    let norm = |a: f32, b: f32| libm::powf(libm::powf(a, ROUNDING) + libm::powf(b, ROUNDING), 1.0 / ROUNDING);
    (norm(length * c, breadth * s), norm(length * s, breadth * c))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(axis: f32, major: f32, minor: f32) -> Silhouette {
        Silhouette { area: 0.0, centroid: (0.0, 0.0), middle: (0.0, 0.0), axis, major, minor }
    }

    fn check(selection: (f32, f32), silhouette: Option<Silhouette>, axis_expected: Option<f32>) {
        let extent = Extent::of_selection(selection, silhouette.as_ref());
        assert_eq!(extent.axis(), axis_expected, "{selection:?} {silhouette:?}");
        let axis = extent.axis().unwrap_or(0.0);
        let (w, h) = extent.upright(1.0, axis);
        assert!(
            (w - selection.0).abs() < 0.02 * w && (h - selection.1).abs() < 0.02 * h,
            "{selection:?}: {w} x {h}"
        );
        let (w, h) = extent.upright(2.0, axis);
        assert!((w - 2.0 * selection.0).abs() < 0.04 * w && (h - 2.0 * selection.1).abs() < 0.04 * h);
    }

    #[test]
    fn the_selections_box_comes_out_again() {
        check((40.0, 38.0), None, None);
        check((80.0, 30.0), None, Some(0.0));
        check((30.0, 80.0), None, Some(core::f32::consts::FRAC_PI_2));
        check((50.0, 50.0), Some(seen(0.8, 60.0, 20.0)), Some(0.8));
        check((50.0, 50.0), Some(seen(0.8, 60.0, 55.0)), None);
        // A silhouette that contradicts the box is not believed.
        check((90.0, 30.0), Some(seen(1.5, 60.0, 20.0)), Some(0.0));
    }

    #[test]
    fn a_hull_that_turns_has_its_box_turned() {
        let extent = Extent::of_selection((90.0, 30.0), None);
        let (w, h) = extent.upright(1.0, core::f32::consts::FRAC_PI_2);
        assert!((w - 30.0).abs() < 0.01 && (h - 90.0).abs() < 0.01, "{w} x {h}");
    }
}
