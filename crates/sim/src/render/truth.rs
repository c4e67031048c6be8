//! The truth about a rendered picture: which pixels show the target, how much of it is visible, where the
//! middle of its waterline is projected to, and its heading in the picture.

use barrelman_vocab::{Angle, PixelBox, PixelPoint};

use super::camera::Camera;
use super::image_tile::ImageTile;
use crate::pose::WorldPoint;
use crate::snapshot::{Snapshot, Target};

/// The truth about one picture.
#[derive(Debug, Clone, Default)]
pub struct RenderedTruth {
    /// Pixels of which the unhidden target covers at least half.
    pub mask: TargetMask,
    /// Smallest upright box around the mask without the rigging: mast and flag, a few pixels wide, would
    /// change the box by up to half with the heading and the wind. `None` where no such pixel is in the mask.
    pub bounds: Option<PixelBox>,
    /// Visible share of the target, 0 to 1: of what would be seen on still water, unhidden and wholly in the
    /// picture.
    pub visible_share: f64,
    /// Projection of the middle of the waterline, inside the picture or not; `None` behind the camera.
    pub waterline: Option<PixelPoint>,
    /// Heading in the picture: 0 along image right, anticlockwise as seen, below 360 degrees. `None` along
    /// the line of sight, or behind the camera.
    pub heading: Option<Angle>,
    /// From the optical centre to the middle of the waterline, metres.
    pub range_m: f64,
}

/// The pixels that show the target, within a part of the picture.
#[derive(Debug, Clone, Default)]
pub struct TargetMask {
    /// First column of the part.
    pub left: usize,
    /// First row of the part.
    pub top: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Row by row, whether each pixel of the part shows the target.
    pub is_target: Vec<bool>,
}

impl TargetMask {
    /// Whether this pixel of the picture shows the target.
    pub fn at(&self, column: usize, row: usize) -> bool {
        let inside = (self.left..self.left + self.width).contains(&column)
            && (self.top..self.top + self.height).contains(&row);
        inside && self.is_target[(row - self.top) * self.width + column - self.left]
    }

    /// Number of pixels that show the target.
    pub fn count(&self) -> usize {
        self.is_target.iter().filter(|is_target| **is_target).count()
    }
}

/// Distance of the point used for the heading ahead of the middle, metres.
const BOW_M: f64 = 0.3;

impl RenderedTruth {
    /// Computes what follows from the geometry.
    pub(super) fn measure(&mut self, camera: &Camera, snapshot: &Snapshot) {
        let position = snapshot.target.position();
        let seen = camera.project(position);
        self.waterline = seen.map(|(point, _)| point);
        let heading = match snapshot.target {
            Target::Boat(boat) => boat.pose.heading,
            Target::FloorTarget(pose) => pose.heading,
        };
        let (sin, cos) = libm::sincos(heading.radians());
        let bow = WorldPoint { x: position.x + BOW_M * cos, y: position.y + BOW_M * sin, z: position.z };
        self.heading = self.waterline.zip(camera.project(bow)).and_then(|(from, (to, _))| {
            let (du, dv) = (to.u - from.u, to.v - from.v);
            (libm::hypot(du, dv) > 1e-6).then(|| {
                let angle = libm::atan2(-dv, du);
                let turn = core::f64::consts::TAU;
                let angle = if angle < 0.0 { angle + turn } else { angle };
                Angle::from_radians(if angle >= turn { 0.0 } else { angle })
            })
        });
        let row = seen.map_or(0, |(point, _)| {
            (point.v.max(0.0) as usize).min(camera.optics.picture.height as usize - 1)
        });
        self.range_m = camera.row(row).position.vector_to(position).norm();
    }

    /// Computes what follows from the rendered tiles: the target's, and those of the objects in front of it.
    pub(super) fn cover<'a>(
        &mut self,
        camera: &Camera,
        target: &ImageTile,
        before: impl Iterator<Item = &'a ImageTile> + Clone,
    ) {
        let size = camera.optics.picture;
        let clip = |at: i32, limit: u32| at.clamp(0, limit as i32) as usize;
        let (left, top) = (clip(target.left, size.width), clip(target.top, size.height));
        let right = clip(target.left + target.width as i32, size.width);
        let bottom = clip(target.top + target.height as i32, size.height);
        let mask = &mut self.mask;
        (mask.left, mask.top, mask.width, mask.height) = (left, top, right - left, bottom - top);
        mask.is_target.clear();
        let mut seen = 0.0;
        let (mut low, mut high) = ((usize::MAX, usize::MAX), (0, 0));
        for row in top..bottom {
            for column in left..right {
                let mut opacity = target.opacity(column as i32, row as i32);
                if opacity > 0.0 {
                    for tile in before.clone() {
                        opacity *= 1.0 - tile.opacity(column as i32, row as i32);
                    }
                }
                seen += f64::from(opacity);
                let is_target = opacity >= 0.499;
                mask.is_target.push(is_target);
                let is_body =
                    target.body.0.contains(&(column as i32)) && target.body.1.contains(&(row as i32));
                if is_target && is_body {
                    low = (low.0.min(column), low.1.min(row));
                    high = (high.0.max(column + 1), high.1.max(row + 1));
                }
            }
        }
        self.bounds = (low.0 < high.0).then(|| PixelBox {
            u: low.0 as f64,
            v: low.1 as f64,
            w: (high.0 - low.0) as f64,
            h: (high.1 - low.1) as f64,
        });
        let whole =
            target.still_water_samples as f64 / (target.samples_per_side * target.samples_per_side) as f64;
        self.visible_share = if whole > 0.0 { (seen / whole).min(1.0) } else { 0.0 };
    }
}
