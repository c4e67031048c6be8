//! Light from water: the sky reflected by facets, the sun's glitter, the body of the water, foam, and haze.
//!
//! Reflection follows Schlick's form of Fresnel's law, reduced by the standard deviation sigma of the facets'
//! slopes as in `bruneton2010`: `F = 0.02 + 0.98 (1 - cos)^5 / (1 + 22.7 sigma^1.5)`. At grazing angles
//! mostly facets that lean towards the viewer are visible; their mean slope is shifted by
//! `sigma^2 vh / (vz + 0.6 sigma vh)`. The glitter is a Gaussian lobe in the space of slopes about the slope
//! that would reflect the sun, as an eighth power.

use barrelman_simd::{Simd, multiversion};

use super::chunk::{CHUNK, Chunk, Lane};
use super::light::{Colour, Lighting};
use super::nodes::Nodes;
use super::texture::Texture;

/// Colours of the water's body.
#[derive(Debug, Clone, Copy)]
pub(super) struct WaterBody {
    /// Light scattered back from the depth.
    pub(super) deep: Colour,
    /// Light through thin crests that face away from the viewer.
    pub(super) crest: Colour,
    /// Water full of air.
    pub(super) aerated: Colour,
}

/// Half of the sun's disc as a standard deviation of slopes, squared, so that calm water shows more than a
/// point.
const SUN_VARIANCE: f32 = 2.5e-4;

/// Texture that breaks foam up.
pub(super) struct FoamTexture<'a> {
    pub(super) lace: &'a Texture,
    /// Position below the camera, metres modulo the texture's period, along and across the wind.
    pub(super) origin: (f32, f32),
    /// Cosine and sine of the direction the wind blows to.
    pub(super) wind: (f32, f32),
}

multiversion! { simd;
    /// Breaks the foam's cover up into lace at two scales, streaked along the crests.
    pub(super) fn texture_foam(simd: Simd, lookup: &FoamTexture<'_>, chunk: &mut Chunk) {
        for i in 0..CHUNK {
            let (x, y) = (chunk.px[i] , chunk.py[i]);
            let along = lookup.origin.0 + x * lookup.wind.0 + y * lookup.wind.1;
            let across = lookup.origin.1 + y * lookup.wind.0 - x * lookup.wind.1;
            // 256 texels along: coarse lace of about 0.6 m, 0.2 m along the wind; fine lace of a third.
            let coarse = lookup.lace.sample(along * 64.0, across * 24.0);
            let fine = lookup.lace.sample(along * 160.0 + 77.0, across * 96.0 + 31.0);
            let patch = lookup.lace.sample(along * 16.0 + 19.0, across * 8.0);
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

multiversion! { simd;
    /// Computes what the variance of slopes means for reflections, at the nodes of a row.
    pub(super) fn prepare_reflection(simd: Simd, light: &Lighting, nodes: &mut Nodes) {
        let count = nodes.count();
        let (vx, vy, vz) = (&nodes.vx.0[..count], &nodes.vy.0[..count], &nodes.vz.0[..count]);
        let variance = &nodes.variance.0[..count];
        let (std_dev, lean) = (&mut nodes.std_dev.0[..count], &mut nodes.lean.0[..count]);
        let grazing = &mut nodes.grazing.0[..count];
        let (glint_x, glint_y) = (&mut nodes.glint_x.0[..count], &mut nodes.glint_y.0[..count]);
        let (fall, peak) = (&mut nodes.glint_fall.0[..count], &mut nodes.glint_peak.0[..count]);
        for i in 0..count {
            let variance = variance[i] + 1e-6;
            let sigma = variance.sqrt();
            let level = (vx[i] * vx[i] + vy[i] * vy[i]).sqrt();
            std_dev[i] = sigma;
            lean[i] = variance / (vz[i] + 0.6 * sigma * level);
            grazing[i] = 0.98 / (1.0 + 22.7 * sigma * sigma.sqrt());
            // The slope that would reflect the sun into this line of sight.
            let (hx, hy, hz) = (light.to_sun[0] + vx[i], light.to_sun[1] + vy[i], light.to_sun[2] + vz[i]);
            let per_hz = -1.0 / hz;
            glint_x[i] = hx * per_hz;
            glint_y[i] = hy * per_hz;
            let spread = variance + SUN_VARIANCE;
            fall[i] = 1.0 / (16.0 * spread);
            peak[i] = 0.010 / (spread * (vz[i] + 0.15));
        }
    }
}

/// 1 / sqrt(1 + q), to a thousandth below q = 1: a cubic, and one Newton step.
#[inline(always)]
fn per_root(q: f32) -> f32 {
    let p = if q < 1.5 { q } else { 1.5 };
    let first = 1.0 - p * (0.5 - p * (0.375 - 0.18 * p));
    first * (1.5 - 0.5 * (1.0 + q) * first * first)
}

/// What the facets of a chunk's water do to light.
struct Facets {
    /// The sky in them.
    reflect: [Lane; 3],
    /// Share of light that they reflect.
    fresnel: Lane,
    /// The sun's glitter.
    glint: Lane,
    /// Share of light that comes through crests.
    thin: Lane,
}

impl Facets {
    /// Composes the colours of a chunk. The pair is the share of haze at each pixel, and whether the water is
    /// bare.
    #[inline(always)]
    fn compose(&self, light: &Lighting, body: &WaterBody, (haze, is_bare): (&Lane, bool), chunk: &mut Chunk) {
        let Self { reflect, fresnel, glint, thin } = self;
        for c in 0..3 {
            let (sun, ambient) = (light.sun[c], light.ambient[c]);
            let far = light.haze[c];
            if is_bare {
                let day = ambient * 1.25 + 0.8 * sun;
                let (deep, crest) = (day * body.deep[c], day * body.crest[c]);
                for i in 0..CHUNK {
                    let below = deep + thin[i] * crest;
                    let water = below + fresnel[i] * (reflect[c][i] - below) + glint[i] * sun;
                    chunk.colour[c][i] = water + haze[i] * (far - water);
                }
                continue;
            }
            for i in 0..CHUNK {
                let shone = sun * chunk.lit[i];
                let day = ambient * 1.25 + 0.8 * shone;
                let air = chunk.air[i];
                let below = body.deep[c] + thin[i] * body.crest[c];
                let below = day * (below + air * (body.aerated[c] - below));
                let mirrored = reflect[c][i] * chunk.sky_left[i] + chunk.reflection[c][i];
                let water = below + fresnel[i] * (mirrored - below) + glint[i] * shone * chunk.sky_left[i];
                let white = 0.86 * ambient + 0.731 * shone;
                let seen = water + chunk.foam[i] * (white - water);
                chunk.colour[c][i] = seen + haze[i] * (far - seen);
            }
        }
    }
}

multiversion! { simd;
    /// Shades a chunk of water. `start` is its first column, and whether the water is bare: in full light,
    /// without foam, wake and images of objects.
    pub(super) fn shade_water(
        simd: Simd,
        light: &Lighting,
        body: &WaterBody,
        clouds: &Texture,
        nodes: &Nodes,
        start: (usize, bool),
        chunk: &mut Chunk,
    ) {
        let (column, is_bare) = start;
        let mut facets = Facets {
            reflect: [[0.0; CHUNK]; 3],
            fresnel: [0.0; CHUNK],
            glint: [0.0; CHUNK],
            thin: [0.0; CHUNK],
        };
        let per_length = nodes.per_length.lane(column);
        let (std_dev, lean) = (nodes.std_dev.lane(column), nodes.lean.lane(column));
        let grazing = nodes.grazing.lane(column);
        let (glint_x, glint_y) = (nodes.glint_x.lane(column), nodes.glint_y.lane(column));
        let (fall, peak) = (nodes.glint_fall.lane(column), nodes.glint_peak.lane(column));
        for i in 0..CHUNK {
            let (vx, vy) = (-chunk.dx[i] * per_length[i], -chunk.dy[i] * per_length[i]);
            let vz = (-chunk.dz[i] * per_length[i]).max(0.002);
            let (sx, sy) = (chunk.sx[i] - lean[i] * vx, chunk.sy[i] - lean[i] * vy);
            let steep = per_root(sx * sx + sy * sy);
            let uphill = sx * vx + sy * vy;
            let raw = (vz - uphill) * steep;
            let cos = if raw > 0.03 { raw } else { 0.03 };
            let away = 1.0 - cos;
            let away2 = away * away;
            facets.fresnel[i] = 0.02 + grazing[i] * (away2 * away2 * away);
            let twice = 2.0 * cos * steep;
            let (rx, ry, rz) = (-twice * sx - vx, -twice * sy - vy, twice - vz);
            let sky = light.sky(clouds, rx, ry, rz, 1.4 * std_dev[i]);
            for c in 0..3 {
                facets.reflect[c][i] = sky[c];
            }
            let (ex, ey) = (glint_x[i] - sx, glint_y[i] - sy);
            let lobe = (1.0 - (ex * ex + ey * ey) * fall[i]).max(0.0);
            let lobe = lobe * lobe;
            let lobe = lobe * lobe;
            let lobe = lobe * lobe;
            facets.glint[i] = (peak[i] * lobe).min(9.0);
            facets.thin[i] = (uphill * 1.6 + 0.28).max(0.0).min(1.0);
        }
        facets.compose(light, body, (&nodes.haze.lane(column), is_bare), chunk);
    }
}

multiversion! { simd;
    /// Shades the pixels of a chunk above the horizon.
    pub(super) fn shade_sky(
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
            // Pixels that the horizon crosses show both.
            let part = (0.5 + (dz + horizon) * per_pixel).max(0.0).min(1.0);
            for c in 0..3 {
                let water = chunk.colour[c][i];
                chunk.colour[c][i] = water + part * (sky[c] - water);
            }
        }
    }
}
