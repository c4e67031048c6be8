//! Rays of a row's pixels through the lens, and where they meet the plane of the water or the floor.

use barrelman_simd::{Simd, multiversion};

use super::camera::RowPose;
use super::chunk::{CHUNK, Chunk};
use super::nodes::{Nodes, STEP};
use crate::optics::Optics;

/// A ray that sinks less than this for one unit ahead looks at the sky.
pub(super) const HORIZON: f32 = 2e-4;
/// Upper bound of a ray's length, metres.
const MAX_RAY_M: f32 = 6_000.0;

/// One row's rays in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rays {
    right: [f32; 3],
    down: [f32; 3],
    ahead: [f32; 3],
    /// Height of the camera above the plane, metres.
    height: f32,
    /// Right and down of the row's first pixel in focal lengths, and the step from pixel to pixel.
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
            height: pose.position.z as f32,
            x0: ((0.5 - 0.5 * f64::from(optics.picture.width)) / optics.focal_px) as f32,
            y: ((row as f64 + 0.5 - 0.5 * f64::from(optics.picture.height)) / optics.focal_px) as f32,
            step: (1.0 / optics.focal_px) as f32,
            barrel: optics.barrel as f32,
        }
    }
}

/// A direction with length 1 along the optical axis, and how many times its length it is down to the plane.
struct Ray {
    dx: f32,
    dy: f32,
    dz: f32,
    sink: f32,
    t: f32,
}

impl Rays {
    #[inline(always)]
    fn ray_at(&self, column: usize) -> Ray {
        let x = self.x0 + column as i32 as f32 * self.step;
        let y = self.y;
        let stretch = 1.0 + self.barrel * (x * x + y * y);
        let (right, down) = (x * stretch, y * stretch);
        let dx = self.ahead[0] + right * self.right[0] + down * self.down[0];
        let dy = self.ahead[1] + right * self.right[1] + down * self.down[1];
        let dz = self.ahead[2] + right * self.right[2] + down * self.down[2];
        let sink = if -dz > HORIZON { -dz } else { HORIZON };
        let t = self.height / sink;
        Ray { dx, dy, dz, sink, t: if t < MAX_RAY_M { t } else { MAX_RAY_M } }
    }
}

multiversion! { simd;
    /// Fills the nodes' geometry of a row.
    pub(super) fn cast_nodes(simd: Simd, rays: &Rays, nodes: &mut Nodes) {
        let count = nodes.count();
        let (vx, vy, vz) = (&mut nodes.vx.0[..count], &mut nodes.vy.0[..count], &mut nodes.vz.0[..count]);
        let (px, py) = (&mut nodes.px.0[..count], &mut nodes.py.0[..count]);
        let dzs = &mut nodes.dz.0[..count];
        let (per_length, haze) = (&mut nodes.per_length.0[..count], &mut nodes.haze.0[..count]);
        let footprint = &mut nodes.footprint.0[..count];
        for i in 0..count {
            let ray = rays.ray_at(STEP * i);
            let (dx, dy, dz) = (ray.dx, ray.dy, ray.dz);
            let length = (dx * dx + dy * dy + dz * dz).sqrt();
            let shorten = 1.0 / length;
            per_length[i] = shorten;
            vx[i] = -dx * shorten;
            vy[i] = -dy * shorten;
            vz[i] = (-dz * shorten).max(0.002);
            dzs[i] = dz;
            px[i] = ray.t * dx;
            py[i] = ray.t * dy;
            // Across the line of sight a pixel is t * length * step wide, along the water 1/sin(grazing) of
            // that.
            let grazing = (ray.sink * shorten).sqrt();
            footprint[i] = ray.t * length * rays.step / (grazing * grazing.sqrt());
            let share = ray.t / (ray.t + 1_800.0);
            haze[i] = share * share;
        }
    }
}

multiversion! { simd;
    /// Fills directions, lengths, positions and footprints of a chunk's pixels from `column` on.
    pub(super) fn cast_pixels(simd: Simd, rays: &Rays, nodes: &Nodes, column: usize, chunk: &mut Chunk) {
        for i in 0..CHUNK {
            let ray = rays.ray_at(column + i);
            chunk.dx[i] = ray.dx;
            chunk.dy[i] = ray.dy;
            chunk.dz[i] = ray.dz;
            chunk.t[i] = ray.t;
            chunk.px[i] = ray.t * ray.dx;
            chunk.py[i] = ray.t * ray.dy;
        }
        nodes.footprint.fill(column, &mut chunk.footprint);
    }
}
