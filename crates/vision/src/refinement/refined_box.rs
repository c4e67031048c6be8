//! The box by the refinement network.

use barrelman_vocab::PixelBox;

/// Minimum side of a refined box, pixels.
const MIN_SIDE_PX: f32 = 1.0;

/// The answer of the network.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RefinedBox {
    /// Left, top, right and bottom edge, pixels.
    pub(crate) edges: [f32; 4],
    /// Expected absolute error of each edge, in sides of the window's box.
    pub(crate) errors: [f32; 4],
    /// Probability that the box has an IoU of at least 0.5 with the target, 0 to 1.
    pub(crate) probability: f32,
}

impl RefinedBox {
    /// The box between the edges, pixels.
    pub(crate) fn bounds(&self) -> PixelBox {
        let [left, top, right, bottom] = self.edges.map(f64::from);
        PixelBox { u: left, v: top, w: right - left, h: bottom - top }
    }
}

/// Both edges of an axis, moved apart to [`MIN_SIDE_PX`] where they are nearer or crossed.
pub(super) fn apart(first: f32, second: f32) -> (f32, f32) {
    if second - first >= MIN_SIDE_PX {
        return (first, second);
    }
    let middle = 0.5 * (first + second);
    (middle - 0.5 * MIN_SIDE_PX, middle + 0.5 * MIN_SIDE_PX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossed_edges_give_a_box_about_their_middle() {
        assert_eq!(apart(20.0, 10.0), (14.5, 15.5));
        assert_eq!(apart(10.0, 20.0), (10.0, 20.0));
    }
}
