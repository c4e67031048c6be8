//! From the samples of an [`ImageTile`] to its pixels: which samples show the object above the water, and the
//! colour of each pixel.

use super::image_tile::{ImageTile, NO_TRIANGLE, Source, WaterSide};
use super::light::Colour;
use super::mesh::{Part, normalised};
use super::object::paint::paint;
use super::waterline::{MAX_RIPPLE_M, MAX_RIPPLED_M, ripple_elevation};

/// Samples of a pixel whose colour is computed; the others only count for the opacity.
const MAX_PAINTED_SAMPLES: usize = 4;
/// Surfaces below this height above the water are wet, metres.
const WET_M: f32 = 0.05;

/// Makes the covered pixels opaque.
pub(super) fn resolve_shadow(tile: &mut ImageTile) {
    for (pixel, &triangle) in tile.pixels.iter_mut().zip(&tile.triangle) {
        *pixel = [0.0, 0.0, 0.0, if triangle == NO_TRIANGLE { 0.0 } else { 1.0 }];
    }
}

/// Computes the colour and the opacity of all pixels, and how many samples would show the object in still
/// water.
pub(super) fn resolve_image(tile: &mut ImageTile, source: &Source<'_>) {
    classify_triangles(tile, source);
    for row in 0..tile.height {
        for column in 0..tile.width {
            tile.pixels[row * tile.width + column] = resolve_pixel(tile, source, column, row);
        }
    }
}

/// Where a sample meets the surface of an object.
struct SurfacePoint {
    corners: [u32; 3],
    part: Part,
    /// Weights of the triangle's corners.
    weights: [f32; 3],
    /// In the body's frame of reference, before the object's stretching.
    body: [f32; 3],
    world: [f32; 3],
    /// Height above the water, metres.
    above: f32,
}

fn classify_triangles(tile: &mut ImageTile, &Source { mesh, waterline, .. }: &Source<'_>) {
    let vertices = &tile.vertices;
    tile.water_sides.clear();
    tile.water_sides.extend(mesh.triangles.iter().map(|(corners, _)| {
        let above = corners.map(|at| vertices[at as usize].above);
        let level = corners.map(|at| mesh.vertices[at as usize].position[2]);
        WaterSide {
            is_dry: waterline.is_none() || above.iter().all(|&above| above > MAX_RIPPLED_M),
            is_submerged: waterline.is_some() && above.iter().all(|&above| above < -MAX_RIPPLE_M),
            is_high: level.iter().all(|&z| z >= 0.0),
            is_low: level.iter().all(|&z| z < 0.0),
        }
    }));
}

fn resolve_pixel(tile: &mut ImageTile, source: &Source<'_>, column: usize, row: usize) -> [f32; 4] {
    let ss = tile.samples_per_side;
    let columns = tile.width * ss;
    let painted_step = (ss * ss).div_ceil(MAX_PAINTED_SAMPLES) | 1;
    let (mut sum, mut covered, mut painted) = ([0.0_f32; 3], 0_usize, 0_usize);
    for sample in 0..ss * ss {
        let (x, y) = (column * ss + sample % ss, row * ss + sample / ss);
        let triangle = tile.triangle[y * columns + x];
        if triangle == NO_TRIANGLE {
            continue;
        }
        let side = tile.water_sides[triangle as usize];
        let is_painted = sample % painted_step == 0 || painted == 0;
        if (side.is_high || side.is_low) && (side.is_submerged || side.is_dry && !is_painted) {
            tile.still_water_samples += usize::from(side.is_high);
            covered += usize::from(side.is_dry);
            continue;
        }
        let (point, is_above_own_waterline) = surface_point(tile, source, triangle, (x, y));
        tile.still_water_samples += usize::from(is_above_own_waterline);
        let Some(point) = point else { continue };
        covered += 1;
        if !is_painted {
            continue;
        }
        painted += 1;
        let colour = shade(tile, source, &point);
        for c in 0..3 {
            sum[c] += colour[c];
        }
    }
    let share = 1.0 / (ss * ss) as f32;
    let opacity = covered as f32 * share;
    let each = opacity / painted.max(1) as f32;
    [sum[0] * each, sum[1] * each, sum[2] * each, opacity]
}

/// The surface point of a sample, `None` where it is below the water; and whether it would be seen in still
/// water.
fn surface_point(
    tile: &ImageTile,
    source: &Source<'_>,
    triangle: u32,
    (x, y): (usize, usize),
) -> (Option<SurfacePoint>, bool) {
    let ss = tile.samples_per_side as f32;
    let (corners, part) = source.mesh.triangles[triangle as usize];
    let u = tile.left as f32 + (x as f32 + 0.5) / ss;
    let v = tile.top as f32 + (y as f32 + 0.5) / ss;
    let weights = weights(tile, corners, u, v);
    let body = blend(corners.map(|at| source.mesh.vertices[at as usize].position), weights);
    let height = corners.map(|at| tile.vertices[at as usize].above);
    let above = height[0] * weights[0] + height[1] * weights[1] + height[2] * weights[2];
    let world = blend(corners.map(|at| tile.vertices[at as usize].world), weights);
    let above = if source.waterline.is_none() {
        1.0
    } else if above > MAX_RIPPLED_M {
        above
    } else {
        above - ripple_elevation(world)
    };
    let point = SurfacePoint { corners, part, weights, body, world, above };
    ((above >= 0.0).then_some(point), body[2] >= 0.0)
}

/// Perspective-correct weights of a triangle's vertices at a point of the picture.
fn weights(tile: &ImageTile, corners: [u32; 3], u: f32, v: f32) -> [f32; 3] {
    let [a, b, c] = corners.map(|at| tile.vertices[at as usize]);
    let doubled = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
    let inverse = 1.0 / doubled;
    let wb = ((u - a.u) * (c.v - a.v) - (v - a.v) * (c.u - a.u)) * inverse;
    let wc = ((b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u)) * inverse;
    let w = [(1.0 - wb - wc) * a.nearness, wb * b.nearness, wc * c.nearness];
    let sum = 1.0 / (w[0] + w[1] + w[2]);
    w.map(|share| share * sum)
}

fn blend(corners: [[f32; 3]; 3], weights: [f32; 3]) -> [f32; 3] {
    core::array::from_fn(|i| {
        corners[0][i] * weights[0] + corners[1][i] * weights[1] + corners[2][i] * weights[2]
    })
}

/// Diffuse light from sun and sky, a sheen at grazing angles, and the sun's highlight.
fn shade(tile: &ImageTile, source: &Source<'_>, point: &SurfacePoint) -> Colour {
    let Source { scene, mesh, object, .. } = source;
    let SurfacePoint { corners, weights, world, .. } = *point;
    let light = scene.light;
    let normal = normalised(blend(corners.map(|at| tile.vertices[at as usize].normal), weights));
    let body_normal = blend(corners.map(|at| mesh.vertices[at as usize].normal), weights);
    let stretched: [f32; 3] = core::array::from_fn(|i| point.body[i] * object.scale[i]);
    let paint = paint(point.part, stretched, body_normal, object.seed);
    let viewpoint = scene.camera.middle().position;
    let view = normalised([
        viewpoint.x as f32 - world[0],
        viewpoint.y as f32 - world[1],
        viewpoint.z as f32 - world[2],
    ]);
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // Sheets are seen from both sides: the normal is turned towards the viewer.
    let facing = dot(normal, view);
    let normal = if facing < 0.0 { normal.map(|v| -v) } else { normal };
    let wet = (1.0 - point.above / WET_M).clamp(0.0, 1.0);
    let gloss = paint.gloss + wet * (0.7 - paint.gloss).max(0.0);
    let sun = dot(normal, light.to_sun).max(0.0);
    let half = normalised(core::array::from_fn(|i| view[i] + light.to_sun[i]));
    let shine = dot(normal, half).max(0.0);
    let shine = shine * shine;
    let shine = shine * shine;
    let shine = shine * shine;
    let shine = shine * shine;
    let shine = shine * shine;
    let away = 1.0 - facing.abs();
    let away = away * away * away;
    let up = 0.55 + 0.45 * normal[2];
    core::array::from_fn(|c| {
        let albedo = paint.albedo[c] * (1.0 - 0.45 * wet);
        let diffuse = albedo * (light.sun[c] * sun + light.ambient[c] * up);
        let sheen = (0.03 + 0.30 * away) * gloss * light.horizon[c] * (0.3 + 0.7 * up);
        diffuse + sheen + 0.9 * gloss * shine * light.sun[c]
    })
}
