//! Draws one shape into a small tile of the picture: several samples for each pixel, the nearest surface of each kept,
//! every sample painted by its own place on the body.
//!
//! Triangles are straight between their corners, which the lens does not quite allow; shapes are cut finely enough.
//! A triangle with a corner behind the camera is left out.

use super::camera::Camera;
use super::light::Lighting;
use super::mesh::{Mesh, Part, normalised};
use super::object::Instance;
use super::object::paint::paint;
use crate::pose::WorldPoint;

/// Nothing is here.
const NONE: u32 = u32::MAX;
/// All of a triangle's corners look away by more than this: it is the back of something.
const TURNED_AWAY: f32 = -0.15;
/// Samples that a tile may have before it is drawn with fewer for each pixel.
const MAX_TARGET_SAMPLES: usize = 110_000;
/// The same for what is not the target: nothing is measured by it.
const MAX_OTHER_SAMPLES: usize = 30_000;
/// Samples of a pixel that are painted; the others only count.
const MAX_PAINTED_SAMPLES: usize = 4;

/// Which image of a thing is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Image {
    /// The thing.
    Direct,
    /// Its mirror image in the water.
    Reflection,
    /// Its shadow on the water or the floor: opacity alone.
    Shadow,
}

/// The water about a thing as a plane, so that the thing can be cut by it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waterline {
    /// A place of the plane.
    pub(super) position: WorldPoint,
    /// Its slope along the world's x and y.
    pub(super) slope: (f64, f64),
}

impl Waterline {
    /// How far a place is above the water, metres.
    fn above(&self, p: [f32; 3]) -> f32 {
        let (dx, dy) = (p[0] - self.position.x as f32, p[1] - self.position.y as f32);
        p[2] - (self.position.z as f32 + self.slope.0 as f32 * dx + self.slope.1 as f32 * dy)
    }
}

/// Samples and pixels of a part of the picture.
#[derive(Debug, Default)]
pub(super) struct Tile {
    /// Left and top pixel; may lie outside of the picture.
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Red, green and blue times opacity, and opacity, for each pixel.
    pub(super) pixels: Vec<[f32; 4]>,
    /// Samples that show the thing, and those that would if it lay in still water.
    pub(super) shown: usize,
    pub(super) afloat: usize,
    /// Samples for each pixel.
    pub(super) per_pixel: usize,
    nearness: Vec<f32>,
    triangle: Vec<u32>,
    corners: Vec<Corner>,
    lies: Vec<WaterSide>,
}

/// How a triangle lies to the water, as far as its corners say it of all of it.
#[derive(Debug, Clone, Copy)]
struct WaterSide {
    /// Wholly over the water here, or wholly below it.
    dry: bool,
    sunk: bool,
    /// Wholly over the body's own waterline, or wholly below it.
    high: bool,
    low: bool,
}

/// A vertex in the picture and in the world.
#[derive(Debug, Clone, Copy)]
struct Corner {
    u: f32,
    v: f32,
    /// 1 / distance ahead; 0 where it is not seen.
    nearness: f32,
    world: [f32; 3],
    normal: [f32; 3],
    /// Height over the water, metres.
    above: f32,
    /// Cosine between the normal and the way to the camera.
    facing: f32,
}

/// What a shape is drawn with.
pub(super) struct Scene<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Lighting,
    /// Pixels beyond the picture's border that are drawn too.
    pub(super) margin: (i32, i32),
}

impl Tile {
    fn clear(&mut self) {
        (self.width, self.height, self.shown, self.afloat, self.per_pixel) = (0, 0, 0, 0, 1);
        self.pixels.clear();
    }

    /// Leaves the tile empty.
    pub(super) fn skip(&mut self) {
        self.clear();
    }

    /// Opacity at a pixel of the picture.
    pub(super) fn opacity(&self, column: i32, row: i32) -> f32 {
        let (x, y) = (column - self.left, row - self.top);
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return 0.0;
        }
        self.pixels[y as usize * self.width + x as usize][3]
    }

    /// Draws an image of a thing; `cut` is the water about it.
    pub(super) fn draw(
        &mut self,
        scene: &Scene<'_>,
        mesh: &Mesh,
        object: &Instance,
        cut: Option<&Waterline>,
        image: Image,
    ) {
        self.clear();
        if scene.camera.is_outside_view(
            object.pose.position,
            reach_m(scene, mesh, object, image),
            scene.margin,
        ) {
            return;
        }
        self.place_corners(scene, mesh, object, cut, image);
        if !self.frame(scene, image, if object.is_target { MAX_TARGET_SAMPLES } else { MAX_OTHER_SAMPLES }) {
            return;
        }
        for (index, (corners, part)) in mesh.triangles.iter().enumerate() {
            let corners = corners.map(|corner| self.corners[corner as usize]);
            // The far side of a closed shape is never seen.
            let turned_away = corners.iter().all(|corner| corner.facing < TURNED_AWAY);
            if image == Image::Shadow || part.is_seen_from_both_sides() || !turned_away {
                self.scan(corners, index as u32);
            }
        }
        match image {
            Image::Shadow => self.resolve_shadow(),
            _ => {
                self.classify_triangles(mesh, cut);
                self.resolve(scene, mesh, object, cut);
            }
        }
    }

    fn place_corners(
        &mut self,
        scene: &Scene<'_>,
        mesh: &Mesh,
        object: &Instance,
        cut: Option<&Waterline>,
        image: Image,
    ) {
        self.corners.clear();
        let axes = object.axes();
        let sun = scene.light.to_sun;
        let (camera, origin) = (scene.camera, object.pose.position);
        let viewpoint = camera.middle().position;
        let row = camera.row_seeing(origin);
        let single = |p: WorldPoint| [p.x as f32, p.y as f32, p.z as f32];
        let (from_eye, position) = (single(viewpoint.vector_to(origin)), single(origin));
        // A mirror image is what an eye below the water would see of the thing.
        let lower = if image == Image::Reflection { 2.0 * viewpoint.z as f32 } else { 0.0 };
        for (at, vertex) in mesh.vertices.iter().enumerate() {
            let body = object.bent(mesh, at, vertex.position);
            let spread = |p: [f32; 3]| -> [f32; 3] {
                core::array::from_fn(|i| p[0] * axes[0][i] + p[1] * axes[1][i] + p[2] * axes[2][i])
            };
            let turned = spread(body);
            let world: [f32; 3] = core::array::from_fn(|i| position[i] + turned[i]);
            let from: [f32; 3] = core::array::from_fn(|i| from_eye[i] + turned[i]);
            let above = cut.map_or(world[2], |water| water.above(world));
            let shown = match image {
                Image::Direct => from,
                Image::Reflection => [from[0], from[1], from[2] - 2.0 * above],
                Image::Shadow => {
                    let part = above.max(0.0) / sun[2].max(MIN_SUN_SINE);
                    [from[0] - part * sun[0], from[1] - part * sun[1], from[2] - part * sun[2]]
                }
            };
            let (u, v, nearness) = camera.project_vertex(shown, row).unwrap_or_default();
            let normal = spread(vertex.normal);
            let view = [-from[0], -from[1], -from[2] - lower];
            let length = (view[0] * view[0] + view[1] * view[1] + view[2] * view[2]).sqrt().max(1e-9);
            let facing = (normal[0] * view[0] + normal[1] * view[1] + normal[2] * view[2]) / length;
            self.corners.push(Corner { u, v, nearness, world, normal, above, facing });
        }
    }

    /// Fits the tile around the corners; `false` where nothing of it can be seen.
    fn frame(&mut self, scene: &Scene<'_>, image: Image, samples: usize) -> bool {
        let (mut low, mut high) = ((f32::MAX, f32::MAX), (f32::MIN, f32::MIN));
        for corner in self.corners.iter().filter(|corner| corner.nearness > 0.0) {
            low = (low.0.min(corner.u), low.1.min(corner.v));
            high = (high.0.max(corner.u), high.1.max(corner.v));
        }
        let size = scene.camera.optics.picture;
        let (mx, my) = scene.margin;
        let left = (libm::floorf(low.0.clamp(-1e6, 1e6)) as i32).max(-mx);
        let top = (libm::floorf(low.1.clamp(-1e6, 1e6)) as i32).max(-my);
        let right = (libm::ceilf(high.0.clamp(-1e6, 1e6)) as i32).min(size.width as i32 + mx);
        let bottom = (libm::ceilf(high.1.clamp(-1e6, 1e6)) as i32).min(size.height as i32 + my);
        if left >= right || top >= bottom {
            return false;
        }
        (self.left, self.top) = (left, top);
        (self.width, self.height) = ((right - left) as usize, (bottom - top) as usize);
        let area = self.width * self.height;
        let finest = if image == Image::Direct { 4 } else { 1 };
        let few = if area <= 2 * MAX_TARGET_SAMPLES { 2.min(finest) } else { 1 };
        self.per_pixel = (1..=finest).rev().find(|ss| area * ss * ss <= samples).unwrap_or(1).max(few);
        let samples = area * self.per_pixel * self.per_pixel;
        self.nearness.clear();
        self.nearness.resize(samples, 0.0);
        self.triangle.clear();
        self.triangle.resize(samples, NONE);
        self.pixels.resize(area, [0.0; 4]);
        true
    }

    /// Marks the samples that a triangle covers and is nearest in.
    fn scan(&mut self, [a, b, c]: [Corner; 3], index: u32) {
        if a.nearness <= 0.0 || b.nearness <= 0.0 || c.nearness <= 0.0 {
            return;
        }
        let ss = self.per_pixel as f32;
        let local = |corner: &Corner| ((corner.u - self.left as f32) * ss, (corner.v - self.top as f32) * ss);
        let ((ax, ay), (bx, by), (cx, cy)) = (local(&a), local(&b), local(&c));
        let doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if doubled.abs() < 1e-9 {
            return;
        }
        let columns = (self.width * self.per_pixel) as i32;
        let rows = (self.height * self.per_pixel) as i32;
        let first_column = ((ax.min(bx).min(cx) - 0.5) as i32).max(0);
        let last_column = ((ax.max(bx).max(cx) + 0.5) as i32).min(columns - 1);
        let first_row = ((ay.min(by).min(cy) - 0.5) as i32).max(0);
        let last_row = ((ay.max(by).max(cy) + 0.5) as i32).min(rows - 1);
        // Shares of b and c, and the nearness, are linear in x along a row.
        let inverse = 1.0 / doubled;
        let (b_by_x, c_by_x) = ((cy - ay) * inverse, (ay - by) * inverse);
        let near_by_x = b_by_x * (b.nearness - a.nearness) + c_by_x * (c.nearness - a.nearness);
        for row in first_row..=last_row {
            let y = row as f32 + 0.5 - ay;
            let b_start = -y * (cx - ax) * inverse;
            let c_start = (bx - ax) * y * inverse;
            let near_start =
                a.nearness + b_start * (b.nearness - a.nearness) + c_start * (c.nearness - a.nearness);
            let start = row as usize * columns as usize;
            let nearnesses = &mut self.nearness[start..start + columns as usize];
            let triangles = &mut self.triangle[start..start + columns as usize];
            let mut entered = false;
            for column in first_column..=last_column {
                let x = column as f32 + 0.5 - ax;
                let (wb, wc) = (b_start + x * b_by_x, c_start + x * c_by_x);
                let least = if wb < wc { wb } else { wc };
                let least = if 1.0 - wb - wc < least { 1.0 - wb - wc } else { least };
                if least < 0.0 {
                    if entered {
                        break;
                    }
                    continue;
                }
                entered = true;
                let nearness = near_start + x * near_by_x;
                let at = column as usize;
                if nearness > nearnesses[at] {
                    nearnesses[at] = nearness;
                    triangles[at] = index;
                }
            }
        }
    }

    fn resolve_shadow(&mut self) {
        for (pixel, &triangle) in self.pixels.iter_mut().zip(&self.triangle) {
            *pixel = [0.0, 0.0, 0.0, if triangle == NONE { 0.0 } else { 1.0 }];
        }
    }

    fn classify_triangles(&mut self, mesh: &Mesh, cut: Option<&Waterline>) {
        self.lies.clear();
        self.lies.extend(mesh.triangles.iter().map(|(corners, _)| {
            let above = corners.map(|at| self.corners[at as usize].above);
            let level = corners.map(|at| mesh.vertices[at as usize].position[2]);
            WaterSide {
                dry: cut.is_none() || above.iter().all(|&above| above > RAGGED_BELOW_M),
                sunk: cut.is_some() && above.iter().all(|&above| above < -RAGGED_M),
                high: level.iter().all(|&z| z >= 0.0),
                low: level.iter().all(|&z| z < 0.0),
            }
        }));
    }

    fn resolve(&mut self, scene: &Scene<'_>, mesh: &Mesh, object: &Instance, cut: Option<&Waterline>) {
        let ss = self.per_pixel;
        let columns = self.width * ss;
        let share = 1.0 / (ss * ss) as f32;
        let every = (ss * ss).div_ceil(MAX_PAINTED_SAMPLES) | 1;
        for row in 0..self.height {
            for column in 0..self.width {
                let (mut sum, mut covered, mut painted) = ([0.0_f32; 3], 0_usize, 0_usize);
                for sample in 0..ss * ss {
                    let (x, y) = (column * ss + sample % ss, row * ss + sample / ss);
                    let triangle = self.triangle[y * columns + x];
                    if triangle == NONE {
                        continue;
                    }
                    let lies = self.lies[triangle as usize];
                    let is_painted = sample % every == 0 || painted == 0;
                    if (lies.high || lies.low) && (lies.sunk || lies.dry && !is_painted) {
                        self.afloat += usize::from(lies.high);
                        self.shown += usize::from(lies.dry);
                        covered += usize::from(lies.dry);
                        continue;
                    }
                    let (corners, part) = mesh.triangles[triangle as usize];
                    let u = self.left as f32 + (x as f32 + 0.5) / ss as f32;
                    let v = self.top as f32 + (y as f32 + 0.5) / ss as f32;
                    let weights = self.weights(corners, u, v);
                    let body = blend(corners.map(|at| mesh.vertices[at as usize].position), weights);
                    self.afloat += usize::from(body[2] >= 0.0);
                    let height = corners.map(|at| self.corners[at as usize].above);
                    let above = height[0] * weights[0] + height[1] * weights[1] + height[2] * weights[2];
                    let world = blend(corners.map(|at| self.corners[at as usize].world), weights);
                    let above = if cut.is_none() {
                        1.0
                    } else if above > RAGGED_BELOW_M {
                        above
                    } else {
                        above - ragged(world)
                    };
                    if above < 0.0 {
                        continue;
                    }
                    self.shown += 1;
                    covered += 1;
                    if !is_painted {
                        continue;
                    }
                    painted += 1;
                    let normal =
                        normalised(blend(corners.map(|at| self.corners[at as usize].normal), weights));
                    let bent = blend(corners.map(|at| mesh.vertices[at as usize].normal), weights);
                    let scaled: [f32; 3] = core::array::from_fn(|i| body[i] * object.scale[i]);
                    let colour = shade(scene, part, scaled, bent, world, normal, above, object.seed);
                    for c in 0..3 {
                        sum[c] += colour[c];
                    }
                }
                let opacity = covered as f32 * share;
                let each = opacity / painted.max(1) as f32;
                self.pixels[row * self.width + column] =
                    [sum[0] * each, sum[1] * each, sum[2] * each, opacity];
            }
        }
    }

    /// Shares of a triangle's corners at a place of the picture, in space.
    fn weights(&self, corners: [u32; 3], u: f32, v: f32) -> [f32; 3] {
        let [a, b, c] = corners.map(|at| self.corners[at as usize]);
        let doubled = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
        let inverse = 1.0 / doubled;
        let wb = ((u - a.u) * (c.v - a.v) - (v - a.v) * (c.u - a.u)) * inverse;
        let wc = ((b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u)) * inverse;
        let w = [(1.0 - wb - wc) * a.nearness, wb * b.nearness, wc * c.nearness];
        let sum = 1.0 / (w[0] + w[1] + w[2]);
        w.map(|share| share * sum)
    }
}

/// A ball of this radius about a thing's origin holds all of its image.
fn reach_m(scene: &Scene<'_>, mesh: &Mesh, object: &Instance, image: Image) -> f64 {
    let stretch = object.scale.into_iter().fold(0.0_f32, f32::max);
    let radius = f64::from(mesh.radius_m * stretch) + f64::from(NOZZLE_M);
    match image {
        Image::Direct => radius,
        // The water that mirrors it may slope, and lie above or below its origin.
        Image::Reflection => 2.5 * radius + 2.0 * object.pose.position.z.abs(),
        Image::Shadow => {
            let low = f64::from(scene.light.to_sun[2].max(MIN_SUN_SINE));
            (radius + object.pose.position.z.abs()) * (2.0 + 1.5 / low)
        }
    }
}

/// By how much a turned nozzle may reach out of its mesh, metres.
const NOZZLE_M: f32 = 0.1;
/// Shadows grow no longer than under a sun that stands so high, as a sine.
const MIN_SUN_SINE: f32 = 0.08;

fn blend(corners: [[f32; 3]; 3], weights: [f32; 3]) -> [f32; 3] {
    core::array::from_fn(|i| {
        corners[0][i] * weights[0] + corners[1][i] * weights[1] + corners[2][i] * weights[2]
    })
}

/// Below this height over the water a thing is cut by small waves, metres.
const RAGGED_BELOW_M: f32 = 0.03;
/// Their height is less than this, metres.
const RAGGED_M: f32 = 0.01;

/// Small waves along a waterline, metres: no hull is cut straight.
fn ragged(world: [f32; 3]) -> f32 {
    let wave = |x: f32| {
        let x = x - libm::floorf(x);
        (x - x * x) * 4.0
    };
    0.008 * (wave(world[0] * 3.1 + world[1] * 1.3) + wave(world[1] * 4.3 - world[0] * 1.7) - 1.2)
}

/// Wet from below this height over the water, metres.
const WET_M: f32 = 0.05;

#[allow(clippy::too_many_arguments)]
fn shade(
    scene: &Scene<'_>,
    part: Part,
    body: [f32; 3],
    body_normal: [f32; 3],
    world: [f32; 3],
    normal: [f32; 3],
    above: f32,
    seed: u64,
) -> [f32; 3] {
    let light = scene.light;
    let paint = paint(part, body, body_normal, seed);
    let viewpoint = scene.camera.middle().position;
    let view = normalised([
        viewpoint.x as f32 - world[0],
        viewpoint.y as f32 - world[1],
        viewpoint.z as f32 - world[2],
    ]);
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // Both sides of a sheet are seen: the normal is turned to the viewer.
    let facing = dot(normal, view);
    let normal = if facing < 0.0 { normal.map(|v| -v) } else { normal };
    let wet = (1.0 - above / WET_M).clamp(0.0, 1.0);
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
