//! The linear light of one row, chunk by chunk: water, sky and land, or the laboratory's floor.

use barrelman_simd::{Simd, multiversion};

use super::chunk::{CHUNK, Chunk};
use super::floor::shade_floor;
use super::light_rows::{BAND_ROWS, LightBand, padded_width};
use super::nodes::Nodes;
use super::rays::{HORIZON, Rays, cast_nodes, cast_pixels};
use super::secondary_image::{SecondaryImage, add_secondary_image, list_secondary_images};
use super::settings::WaterColour;
use super::shading::{FoamTexture, WaterBody, prepare_reflection, shade_sky, shade_water, texture_foam};
use super::surface::{ElevationMap, TileLookup, WaterSurface, fill_node_variance, sample_surface};
use super::view::FrameView;
use super::wake::{WakeLookup, add_wake};
use crate::pose::WorldPoint;
use crate::snapshot::Ground;
use crate::tick::TICKS_PER_SECOND;

/// Sea states from this number on are rendered with relief.
const MIN_RELIEF_STATE: u8 = 2;
/// The foam's textures repeat after 4 m along the wind and 32/3 m across: this length holds whole numbers of
/// both, metres.
const FOAM_PERIOD_M: f64 = 32.0;
/// The same for the floor's textures and slabs, metres.
const FLOOR_PERIOD_M: f64 = 307.2;
/// Speed of gusts over the water, as a share of the wind's speed.
const GUST_SPEED_SHARE: f64 = 0.4;
/// Texels of the gusts' texture for a metre.
const GUST_TEXELS_PER_M: f64 = 2.1;

/// What a row of water is shaded with.
struct WaterRow<'a> {
    surface: WaterSurface<'a>,
    wake: Option<WakeLookup<'a>>,
    foam: FoamTexture<'a>,
    body: WaterBody,
}

/// Shades a row into its place in the band.
pub(super) fn shade_row(view: &FrameView<'_>, row: usize, light: &mut LightBand) {
    let simd = view.settings.simd;
    let optics = &view.settings.optics;
    let width = optics.picture.width as usize;
    let padded = padded_width(width);
    let pose = view.camera.row(row);
    let rays = Rays::new(optics, pose, row);
    let viewpoint = pose.position;
    let water = (view.snapshot.ground == Ground::Water).then(|| water_row(view, viewpoint));
    let LightBand { values, chunk, nodes, images } = light;
    cast_nodes(simd, &rays, nodes);
    if let Some(water) = &water {
        fill_node_variance(simd, &water.surface, nodes);
        prepare_reflection(simd, view.light, nodes);
    }
    list_secondary_images(view, row, images);
    for column in (0..width).step_by(CHUNK) {
        cast_pixels(simd, &rays, nodes, column, chunk);
        match &water {
            Some(water) => shade_sea_chunk(view, water, (nodes, images), (row, column), viewpoint, chunk),
            None => shade_floor_chunk(view, images, (row, column), viewpoint, chunk),
        }
        let start = (row % BAND_ROWS) * 3 * padded + column;
        store_chunk(simd, chunk, padded, &mut values[start..]);
    }
}

/// Water, sky and land.
fn shade_sea_chunk(
    view: &FrameView<'_>,
    water: &WaterRow<'_>,
    (nodes, images): (&Nodes, &[SecondaryImage]),
    (row, column): (usize, usize),
    viewpoint: WorldPoint,
    chunk: &mut Chunk,
) {
    let simd = view.settings.simd;
    let focal_px = view.settings.optics.focal_px;
    let step = (1.0 / focal_px) as f32;
    let clouds = &view.textures.clouds;
    let (low, high) = nodes.dz.range(column);
    let (sky_is_seen, water_is_seen) = (high > -HORIZON - 2.0 * step, low < 2.0 * step - HORIZON);
    if water_is_seen {
        sample_surface(simd, &water.surface, nodes, (row, column), chunk);
        let wake = water.wake.as_ref();
        let wake = wake.filter(|wake| wake.meets(nodes, column, water.surface.max_relief_m()));
        if let Some(wake) = wake {
            add_wake(simd, wake, chunk);
        }
        let mut is_bare = true;
        for image in images {
            is_bare &= !add_secondary_image(view, image, (row, column), chunk);
        }
        let may_foam = wake.is_some() || water.surface.foam.is_some();
        if may_foam && chunk.foam.iter().fold(0, |bits, foam| bits | foam.to_bits()) != 0 {
            texture_foam(simd, &water.foam, chunk);
            is_bare = false;
        }
        is_bare &= wake.is_none();
        shade_water(simd, view.light, &water.body, clouds, nodes, (column, is_bare), chunk);
    } else {
        chunk.colour = [[0.0; CHUNK]; 3];
    }
    if sky_is_seen {
        shade_sky(simd, view.light, clouds, HORIZON, focal_px as f32, chunk);
    }
    for shore in &view.objects.shores {
        shore.paint(viewpoint, view.light, &view.textures.grain, &view.textures.gusts, chunk);
    }
}

fn shade_floor_chunk(
    view: &FrameView<'_>,
    images: &[SecondaryImage],
    (row, column): (usize, usize),
    viewpoint: WorldPoint,
    chunk: &mut Chunk,
) {
    chunk.lit = [1.0; CHUNK];
    for image in images {
        add_secondary_image(view, image, (row, column), chunk);
    }
    let origin = (remainder(viewpoint.x, FLOOR_PERIOD_M), remainder(viewpoint.y, FLOOR_PERIOD_M));
    let simd = view.settings.simd;
    shade_floor(simd, view.light, &view.textures.grain, &view.textures.gusts, origin, chunk);
}

multiversion! { simd;
    /// Copies a chunk's colours to the front of each channel's row.
    fn store_chunk(simd: Simd, chunk: &Chunk, padded: usize, values: &mut [f32]) {
        for (channel, colour) in chunk.colour.iter().enumerate() {
            values[channel * padded..][..CHUNK].copy_from_slice(colour);
        }
    }
}

/// The remainder of a length modulo a period, both in metres.
fn remainder(v: f64, period: f64) -> f32 {
    (v - libm::floor(v / period) * period) as f32
}

fn water_row<'a>(view: &FrameView<'a>, viewpoint: WorldPoint) -> WaterRow<'a> {
    let WorldPoint { x, y, .. } = viewpoint;
    let (ws, wc) = libm::sincos(view.sea.wind().towards.radians());
    WaterRow {
        surface: water_surface(view, x, y),
        wake: view.wake.and_then(|wake| wake.lookup(x, y)),
        foam: FoamTexture {
            lace: &view.textures.lace,
            origin: (remainder(x * wc + y * ws, FOAM_PERIOD_M), remainder(y * wc - x * ws, FOAM_PERIOD_M)),
            wind: (wc as f32, ws as f32),
        },
        body: water_body(view.settings.water),
    }
}

fn water_surface<'a>(view: &FrameView<'a>, x: f64, y: f64) -> WaterSurface<'a> {
    let swell = view.tiles[0].swell();
    let has_relief = view.sea.state().number() >= MIN_RELIEF_STATE;
    // Gusts drift with the wind.
    let time_s = view.snapshot.tick as f64 / f64::from(TICKS_PER_SECOND);
    let wind = view.sea.wind();
    let (ws, wc) = libm::sincos(wind.towards.radians());
    let travel = GUST_SPEED_SHARE * wind.speed_mps * time_s;
    let texels = |v: f64| (GUST_TEXELS_PER_M * v - libm::floor(GUST_TEXELS_PER_M * v / 256.0) * 256.0) as f32;
    WaterSurface {
        tiles: view.tiles.map(|tile| TileLookup::new(tile, x, y)),
        elevation: swell
            .filter(|_| has_relief)
            .map(|swell| ElevationMap { quads: &swell.elevation.quads, step: swell.step_m }),
        foam: swell.and_then(|swell| swell.foam.as_ref()),
        gusts: &view.textures.gusts,
        gust_origin: (texels(x - travel * wc), texels(y - travel * ws)),
        unresolved_variance: view.unresolved_variance,
    }
}

fn water_body(water: WaterColour) -> WaterBody {
    let (deep, crest) = match water {
        WaterColour::Lake => ([0.008, 0.058, 0.078], [0.008, 0.050, 0.052]),
        WaterColour::Sea => ([0.005, 0.042, 0.100], [0.006, 0.055, 0.075]),
        WaterColour::Green => ([0.030, 0.068, 0.052], [0.016, 0.036, 0.024]),
    };
    WaterBody { deep, crest, aerated: [0.16, 0.40, 0.38] }
}
