//! The box that is reported of a target with a silhouette: the refinement network's.
//!
//! Length, breadth and axis of such a target follow its silhouette, over several frames, and not at all at the border of
//! the picture. The network reads each frame anew, and its probability, which is the reported confidence, is that of its
//! own box. While the target coasts, the box keeps its place around the target's centre.

use barrelman_vocab::PixelBox;

use super::geometry::TargetGeometry;

/// A box of the refinement network, relative to the target's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SeenBox {
    /// From the target's centre to the box's upper left corner, pixels.
    from_centre: (f32, f32),
    /// Width and height, pixels.
    size: (f32, f32),
}

impl SeenBox {
    /// The box with these edges (left, top, right, bottom; pixels) of a target of this geometry.
    pub(super) fn new([left, top, right, bottom]: [f32; 4], geometry: &TargetGeometry) -> Self {
        let (u, v) = geometry.centre;
        Self { from_centre: (left - u, top - v), size: (right - left, bottom - top) }
    }

    /// The box around the target's present centre, pixels.
    pub(super) fn bounds(&self, geometry: &TargetGeometry) -> PixelBox {
        let (u, v) = geometry.centre;
        PixelBox {
            u: f64::from(u + self.from_centre.0),
            v: f64::from(v + self.from_centre.1),
            w: f64::from(self.size.0),
            h: f64::from(self.size.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PictureSize;

    use super::*;

    #[test]
    fn a_seen_box_moves_with_the_targets_centre() {
        let mut geometry = TargetGeometry::new((60.0, 40.0), (20.0, 10.0), PictureSize::new(320, 240));
        let seen = SeenBox::new([52.0, 36.0, 71.0, 44.0], &geometry);
        assert_eq!(seen.bounds(&geometry), PixelBox { u: 52.0, v: 36.0, w: 19.0, h: 8.0 });
        geometry.centre = (70.0, 42.0);
        assert_eq!(seen.bounds(&geometry), PixelBox { u: 62.0, v: 38.0, w: 19.0, h: 8.0 });
    }
}
