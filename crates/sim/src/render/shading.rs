//! The light that comes from water: the sky mirrored by its facets, the sun's glitter, the body of the water below,
//! foam, and the haze in between.
//!
//! Reflection follows Schlick's form of Fresnel's law, weakened by the facets' spread sigma as in `bruneton2010`:
//! `F = 0.02 + 0.98 (1 - cos)^5 / (1 + 22.7 sigma^1.5)`. At grazing angles the facets that are seen are those that
//! lean towards the viewer; their mean is shifted by `sigma^2 vh / (vz + 0.6 sigma vh)`. The glitter is a Gaussian
//! lobe in the space of slopes about the slope that would mirror the sun, as an eighth power.

use barrelman_simd::{Simd, at_level};

use super::chunk::{CHUNK, Chunk};
use super::light::{Colour, Lighting};
use super::texture::Texture;

/// The colour of the water's body and of what floats in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    /// Light from the depth.
    pub(super) deep: Colour,
    /// Light from thin crests that face away from the viewer.
    pub(super) crest: Colour,
    /// Water that is full of air.
    pub(super) aerated: Colour,
}

/// Half of the sun's disc as a spread of slopes, squared, so that calm water does not show a point.
const SUN_VARIANCE: f32 = 2.5e-4;

/// What foam is broken up by.
pub(super) struct FoamLook<'a> {
    pub(super) lace: &'a Texture,
    /// Below the camera, metres modulo the texture's size, along the wind and across it.
    pub(super) origin: (f32, f32),
    /// Cosine and sine of where the wind blows to.
    pub(super) wind: (f32, f32),
}

at_level! { simd;
    /// Breaks the cover of foam up into lace at two scales, streaked along the crests.
    pub(super) fn break_up(simd: Simd, look: &FoamLook<'_>, chunk: &mut Chunk) {
        for i in 0..CHUNK {
            let (x, y) = (chunk.px[i] , chunk.py[i]);
            let along = look.origin.0 + x * look.wind.0 + y * look.wind.1;
            let across = look.origin.1 + y * look.wind.0 - x * look.wind.1;
            // 256 texels along: coarse lace of about 0.6 m, 0.2 m along the wind; fine lace of a third.
            let coarse = look.lace.at(along * 64.0, across * 24.0);
            let fine = look.lace.at(along * 160.0 + 77.0, across * 96.0 + 31.0);
            let patch = look.lace.at(along * 16.0 + 19.0, across * 8.0);
            let near = 1.0 / (1.0 + 6.0 * chunk.footprint[i]);
            let lace = (0.55 * coarse + 0.45 * fine) * (1.0 / 255.0);
            let value = 0.45 + 0.7 * near * (lace - 0.45) + (0.2 + 0.2 * near) * (patch * (1.0 / 255.0) - 0.45);
            let cover = chunk.foam[i];
            let over = (value - (0.86 - 0.72 * cover)) * (2.0 + 4.0 * near);
            let solid = over.max(0.0).min(1.0);
            chunk.foam[i] = if cover > 0.004 { solid * (0.35 + 0.65 * cover.min(1.0)) } else { 0.0 };
        }
    }
}

at_level! { simd;
    /// The colour of a chunk of water.
    pub(super) fn light_water(
        simd: Simd,
        light: &Lighting,
        body: &Body,
        clouds: &Texture,
        chunk: &mut Chunk,
    ) {
        let mut reflect = [[0.0_f32; CHUNK]; 3];
        let mut fresnel = [0.0_f32; CHUNK];
        let mut glint = [0.0_f32; CHUNK];
        let mut thin = [0.0_f32; CHUNK];
        for i in 0..CHUNK {
            let (dx, dy, dz) = (chunk.dx[i], chunk.dy[i], chunk.dz[i]);
            let per_length = 1.0 / (dx * dx + dy * dy + dz * dz).sqrt();
            let (vx, vy) = (-dx * per_length, -dy * per_length);
            let vz = (-dz * per_length).max(0.002);
            let variance = chunk.variance[i] + 1e-6;
            let sigma = variance.sqrt();
            let level = (vx * vx + vy * vy).sqrt();
            let lean = variance / (vz + 0.6 * sigma * level);
            let (sx, sy) = (chunk.sx[i] - lean * vx, chunk.sy[i] - lean * vy);
            let steep = 1.0 / (1.0 + sx * sx + sy * sy).sqrt();
            let raw = (vz - sx * vx - sy * vy) * steep;
            let cos = if raw > 0.03 { raw } else { 0.03 };
            let away = 1.0 - cos;
            let away2 = away * away;
            fresnel[i] =
                0.02 + 0.98 * (away2 * away2 * away) / (1.0 + 22.7 * sigma * sigma.sqrt());
            let twice = 2.0 * cos * steep;
            let (rx, ry, rz) = (-twice * sx - vx, -twice * sy - vy, twice - vz);
            let sky = light.sky(clouds, rx, ry, rz, 1.4 * sigma);
            for c in 0..3 {
                reflect[c][i] = sky[c];
            }
            // The slope that would mirror the sun into this line of sight.
            let (hx, hy, hz) = (light.to_sun[0] + vx, light.to_sun[1] + vy, light.to_sun[2] + vz);
            let per_hz = 1.0 / hz;
            let (ex, ey) = (-hx * per_hz - sx, -hy * per_hz - sy);
            let spread = variance + SUN_VARIANCE;
            let off = (ex * ex + ey * ey) / (16.0 * spread);
            let lobe = (1.0 - off).max(0.0);
            let lobe = lobe * lobe;
            let lobe = lobe * lobe;
            let lobe = lobe * lobe;
            glint[i] = (0.010 * lobe / (spread * (vz + 0.15))).min(9.0);
            thin[i] = ((sx * vx + sy * vy) * 1.6 + 0.28).max(0.0).min(1.0);
        }
        for c in 0..3 {
            let (sun, ambient) = (light.sun[c], light.ambient[c]);
            for i in 0..CHUNK {
                let lit = chunk.lit[i];
                let day = ambient * 1.25 + 0.8 * sun * lit;
                let air = chunk.air[i];
                let below = body.deep[c] + thin[i] * body.crest[c];
                let below = day * (below + air * (body.aerated[c] - below));
                let mirrored = reflect[c][i] * chunk.sky_left[i] + chunk.mirror[c][i];
                let f = fresnel[i];
                let water = f * mirrored + (1.0 - f) * below + glint[i] * sun * lit * chunk.sky_left[i];
                let white = 0.86 * (ambient + 0.85 * sun * lit);
                let foam = chunk.foam[i];
                let seen = water + foam * (white - water);
                let length = chunk.t[i];
                let haze = length / (length + 1_800.0);
                chunk.colour[c][i] = seen + haze * haze * (light.haze[c] - seen);
            }
        }
    }
}

at_level! { simd;
    /// The sky, for the pixels of a chunk that look above the horizon.
    pub(super) fn light_sky(
        simd: Simd,
        light: &Lighting,
        clouds: &Texture,
        horizon: f32,
        per_pixel: f32,
        chunk: &mut Chunk,
    ) {
        for i in 0..CHUNK {
            let (dx, dy, dz) = (chunk.dx[i], chunk.dy[i], chunk.dz[i]);
            let per_length = 1.0 / (dx * dx + dy * dy + dz * dz).sqrt();
            let sky = light.sky(clouds, dx * per_length, dy * per_length, dz * per_length, 0.0);
            // The horizon runs through pixels: those it crosses show both.
            let part = (0.5 + (dz + horizon) * per_pixel).max(0.0).min(1.0);
            for c in 0..3 {
                let water = chunk.colour[c][i];
                chunk.colour[c][i] = water + part * (sky[c] - water);
            }
        }
    }
}
