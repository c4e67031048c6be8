//! Lines of sight of a row's pixels, through the lens, and where they meet the plane of the water or the floor.

use barrelman_simd::{Simd, at_level};

use super::camera::RowPose;
use super::chunk::{CHUNK, Chunk};
use crate::optics::Optics;

/// A line of sight that sinks less than this for one unit ahead looks at the sky.
pub(super) const HORIZON: f32 = 2e-4;
/// The length of a line of sight at most, metres.
const FARTHEST_M: f32 = 6_000.0;

/// One row's rays in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rays {
    right: [f32; 3],
    down: [f32; 3],
    ahead: [f32; 3],
    /// Of the camera over the plane, metres.
    height: f32,
    /// Right and down of the row's first pixel in focal lengths, and a pixel's step.
    x0: f32,
    y: f32,
    step: f32,
    barrel: f32,
}

impl Rays {
    pub(super) fn new(optics: &Optics, pose: &RowPose, row: usize) -> Self {
        let single = |p: crate::pose::WorldPoint| [p.x as f32, p.y as f32, p.z as f32];
        Self {
            right: single(pose.axes.right),
            down: single(pose.axes.down),
            ahead: single(pose.axes.ahead),
            height: pose.place.z as f32,
            x0: ((0.5 - 0.5 * f64::from(optics.picture.width)) / optics.focal_px) as f32,
            y: ((row as f64 + 0.5 - 0.5 * f64::from(optics.picture.height)) / optics.focal_px) as f32,
            step: (1.0 / optics.focal_px) as f32,
            barrel: optics.barrel as f32,
        }
    }
}

at_level! { simd;
    /// Fills directions, lengths, places and footprints of the pixels from `column` on.
    pub(super) fn cast(simd: Simd, rays: &Rays, column: usize, chunk: &mut Chunk) {
        for i in 0..CHUNK {
            let x = rays.x0 + (column + i) as i32 as f32 * rays.step;
            let y = rays.y;
            let stretch = 1.0 + rays.barrel * (x * x + y * y);
            let (right, down) = (x * stretch, y * stretch);
            let dx = rays.ahead[0] + right * rays.right[0] + down * rays.down[0];
            let dy = rays.ahead[1] + right * rays.right[1] + down * rays.down[1];
            let dz = rays.ahead[2] + right * rays.right[2] + down * rays.down[2];
            let sink = if -dz > HORIZON { -dz } else { HORIZON };
            let t = rays.height / sink;
            let t = if t < FARTHEST_M { t } else { FARTHEST_M };
            let length = (dx * dx + dy * dy + dz * dz).sqrt();
            // Across the line of sight a pixel is t * length * step wide, along the water 1/sin(grazing) of that.
            let grazing = (sink / length).sqrt();
            chunk.dx[i] = dx;
            chunk.dy[i] = dy;
            chunk.dz[i] = dz;
            chunk.t[i] = t;
            chunk.px[i] = t * dx;
            chunk.py[i] = t * dy;
            chunk.footprint[i] = t * length * rays.step / (grazing * grazing.sqrt());
        }
    }
}
