//! A shore: a beach with a ragged edge and a line of surf, grass behind it, trees as an upright wall of
//! leaves, and distant hills. The land is flat and lies in the plane of the water, apart from those two
//! walls.

use super::chunk::{CHUNK, Chunk};
use super::light::{Colour, Lighting, mix};
use super::rays::HORIZON;
use super::texture::Texture;
use crate::pose::WorldPoint;
use crate::snapshot::SceneObject;

/// One shore.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shore {
    position: WorldPoint,
    /// Unit vectors along the coast and inland.
    along: (f64, f64),
    inland: (f64, f64),
    seed: f32,
}

/// Trees and hills: distance inland and height, metres.
const WALLS: [Wall; 2] = [
    Wall { inland_m: 62.0, height_m: 7.0, rough_m: 8.0, per_metre: 3.3, haze: 0.10 },
    Wall { inland_m: 420.0, height_m: 26.0, rough_m: 34.0, per_metre: 0.42, haze: 0.38 },
];

/// An upright wall of leaves.
#[derive(Debug, Clone, Copy)]
struct Wall {
    inland_m: f32,
    height_m: f32,
    rough_m: f32,
    /// Texels of noise for a metre.
    per_metre: f32,
    haze: f32,
}

impl Wall {
    /// Colour at a place along the wall and a height, metres, and a share of the wall's height there; a pixel
    /// covers `pixel` thousandths of the distance.
    fn leaves(
        &self,
        light: &Lighting,
        grain: &Texture,
        patches: &Texture,
        (along, height, rise): (f32, f32, f32),
        pixel: f32,
    ) -> Colour {
        let per_metre = self.per_metre;
        let near = 1.0 / (1.0 + pixel * 0.02);
        let leaf = grain.sample(along * per_metre * 6.0, height * per_metre * 7.0) * (1.0 / 255.0) - 0.5;
        let crown = patches.sample(along * per_metre * 2.2, height * per_metre * 2.6) * (1.0 / 255.0);
        let tone = (0.25 + 0.85 * crown + 0.7 * leaf * near) * (0.35 + 0.75 * rise.clamp(0.0, 1.0));
        let leaves: Colour = core::array::from_fn(|c| {
            [0.050, 0.090, 0.026][c] * tone.max(0.05) * (1.3 * light.ambient[c] + 1.1 * light.sun[c])
        });
        mix(leaves, light.haze, self.haze)
    }
}

impl Shore {
    pub(super) fn new(object: &SceneObject) -> Self {
        let (sin, cos) = libm::sincos(object.pose.heading.radians());
        Self {
            position: object.pose.position,
            along: (cos, sin),
            inland: (-sin, cos),
            seed: (object.seed % 199) as f32,
        }
    }

    /// Shades what a chunk shows of the shore over its water and sky. The camera is at `viewpoint`.
    pub(super) fn paint(
        &self,
        viewpoint: WorldPoint,
        light: &Lighting,
        grain: &Texture,
        patches: &Texture,
        chunk: &mut Chunk,
    ) {
        let from = (viewpoint.x - self.position.x, viewpoint.y - self.position.y);
        let along0 = (from.0 * self.along.0 + from.1 * self.along.1) as f32;
        let inland0 = (from.0 * self.inland.0 + from.1 * self.inland.1) as f32;
        let (ax, ay) = (self.along.0 as f32, self.along.1 as f32);
        let (nx, ny) = (self.inland.0 as f32, self.inland.1 as f32);
        for i in 0..CHUNK {
            let (dx, dy, dz) = (chunk.dx[i], chunk.dy[i], chunk.dz[i]);
            let along = along0 + chunk.px[i] * ax + chunk.py[i] * ay;
            let ragged = |along: f32| {
                let coarse = patches.sample(along * 2.3, self.seed) - 128.0;
                let fine = grain.sample(along * 9.0, self.seed + 40.0) - 128.0;
                coarse * 0.045 + fine * 0.004
            };
            let inland = inland0 + chunk.px[i] * nx + chunk.py[i] * ny + ragged(along);
            if -dz > HORIZON && inland > -5.0 {
                let across = inland0 + chunk.px[i] * nx + chunk.py[i] * ny;
                let here = self.ground(light, grain, patches, (along, across, inland), chunk, i);
                for c in 0..3 {
                    chunk.colour[c][i] = here[c];
                }
            }
            for wall in WALLS.iter().rev() {
                let rate = dx * nx + dy * ny;
                if rate < 1e-4 {
                    continue;
                }
                let t = (wall.inland_m - inland0) / rate;
                if t <= 0.0 {
                    continue;
                }
                let (at, z) = (along0 + t * (dx * ax + dy * ay), viewpoint.z as f32 + t * dz);
                let lumps = patches.sample(at * wall.per_metre, self.seed * 3.0)
                    + 0.35 * grain.sample(at * wall.per_metre * 3.1, self.seed * 5.0);
                let top = wall.height_m + wall.rough_m * (lumps * (1.0 / 345.0) - 0.5);
                if z <= -0.5 || z >= top {
                    continue;
                }
                let pixel = t * chunk.footprint[i].min(0.002) / chunk.t[i].max(1.0) * 400.0;
                let seen = wall.leaves(light, grain, patches, (at, z, z / top), pixel);
                for c in 0..3 {
                    chunk.colour[c][i] = seen[c];
                }
            }
        }
    }

    /// Shallow water, surf, sand and grass.
    fn ground(
        &self,
        light: &Lighting,
        grain: &Texture,
        patches: &Texture,
        (along, across, inland): (f32, f32, f32),
        chunk: &Chunk,
        i: usize,
    ) -> Colour {
        let near = 1.0 / (1.0 + 25.0 * chunk.footprint[i]);
        let day: Colour =
            core::array::from_fn(|c| light.ambient[c] + 0.9 * light.sun[c] * light.to_sun[2] * chunk.lit[i]);
        let fine = grain.sample(along * 97.0, across * 97.0) * (1.0 / 255.0) - 0.5;
        let coarse = patches.sample(along * 11.0, across * 13.0) * (1.0 / 255.0) - 0.5;
        let water: Colour = core::array::from_fn(|c| chunk.colour[c][i]);
        let damp = (1.0 - inland * 0.45).clamp(0.0, 1.0);
        let tone = (1.0 + 0.35 * coarse + 0.5 * fine * near) * (1.0 - 0.42 * damp);
        let sand: Colour = core::array::from_fn(|c| [0.50, 0.43, 0.32][c] * tone * day[c]);
        if inland < 0.0 {
            // The bottom shines through; surf runs in lines along the edge.
            let depth = (-inland / 5.0).clamp(0.0, 1.0);
            let shallow = mix(mix(sand, water, 0.35), water, depth.sqrt());
            let wave = grain.sample(along * 15.0, self.seed + inland * 14.0) * (1.0 / 255.0);
            let edge = (1.0 + inland * 0.8).clamp(0.0, 1.0);
            let surf = ((wave + 0.75 * edge - 0.72) * 3.5).clamp(0.0, 1.0) * edge;
            return mix(shallow, day.map(|v| 0.8 * v), 0.85 * surf);
        }
        let green = ((inland - 9.0 + 9.0 * coarse + 5.0 * fine) * 0.4).clamp(0.0, 1.0);
        let blades = (1.0 + 1.1 * fine * near + 0.8 * coarse).max(0.1);
        let grass: Colour = core::array::from_fn(|c| [0.115, 0.15, 0.045][c] * blades * day[c]);
        mix(sand, grass, green)
    }
}
