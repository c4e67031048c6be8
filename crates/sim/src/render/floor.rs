//! The laboratory's floor: slightly worn, with joints between slabs, and a hall beyond it.

use barrelman_simd::{Simd, multiversion};

use super::chunk::{CHUNK, Chunk};
use super::light::Lighting;
use super::rays::HORIZON;
use super::texture::Texture;

/// Side of a slab and width of a joint, metres.
const SLAB_M: f32 = 1.2;
const JOINT_M: f32 = 0.008;

multiversion! { simd;
    /// Shades a chunk of floor. `origin` is the floor's point below the camera, metres modulo the textures'
    /// period.
    pub(super) fn shade_floor(
        simd: Simd,
        light: &Lighting,
        grain: &Texture,
        patches: &Texture,
        origin: (f32, f32),
        chunk: &mut Chunk,
    ) {
        for i in 0..CHUNK {
            let (x, y) = (origin.0 + chunk.px[i], origin.1 + chunk.py[i]);
            let near = 1.0 / (1.0 + 60.0 * chunk.footprint[i]);
            let fine = grain.sample(x * 210.0, y * 210.0) * (1.0 / 255.0) - 0.5;
            let rough = grain.sample(x * 31.0 + 90.0, y * 37.0) * (1.0 / 255.0) - 0.5;
            let worn = patches.sample(x * 9.0, y * 7.0) * (1.0 / 255.0) - 0.5;
            // Distance to the next joint, along both axes.
            let to_joint = |v: f32| {
                let slabs = v * (1.0 / SLAB_M) + 0.013 * rough * 0.1;
                (slabs - ((slabs + super::texture::ROUNDING) - super::texture::ROUNDING)).abs() * SLAB_M
            };
            let (jx, jy) = (to_joint(x), to_joint(y));
            let nearest = if jx < jy { jx } else { jy };
            let breadth = JOINT_M + 0.6 * chunk.footprint[i];
            let joint = (1.0 - nearest / breadth).max(0.0) * (JOINT_M / breadth + 0.25).min(1.0);
            let tone = (1.0 + 0.16 * worn + 0.20 * rough * (0.3 + 0.7 * near) + 0.22 * fine * near)
                * (1.0 - 0.55 * joint);
            // Polished concrete reflects the bright ceiling at grazing angles.
            let (dx, dy, dz) = (chunk.dx[i], chunk.dy[i], chunk.dz[i]);
            let grazing = -dz / (dx * dx + dy * dy + dz * dz).sqrt();
            let away = (1.0 - grazing).max(0.0);
            let sheen = 0.22 * away * away * away * away;
            let sun = light.to_sun[2] * chunk.lit[i];
            let base = [0.335, 0.325, 0.305];
            let floor = -dz > HORIZON;
            for c in 0..3 {
                let lit = light.ambient[c] * (0.55 + 0.45 * chunk.lit[i]) + light.sun[c] * sun;
                let ground = base[c] * tone * lit * 1.15 + sheen * light.ambient[c];
                let hall = light.ambient[c] * (0.75 + 0.6 * dz);
                chunk.colour[c][i] = if floor { ground } else { hall };
            }
        }
    }
}
