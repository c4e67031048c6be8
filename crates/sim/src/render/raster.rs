//! Rasterises one shape into an [`ImageTile`]: several samples for each pixel, each with its nearest
//! triangle.
//!
//! Edges of triangles are straight in the picture. The lens bends them slightly; shapes are divided finely
//! enough that the difference does not show. A triangle with a vertex behind the camera is left out.

use super::image_tile::{ImageKind, ImageTile, NO_TRIANGLE, ProjectedVertex, Scene, Source};
use super::mesh::Mesh;
use super::resolve::{resolve_image, resolve_shadow};
use crate::pose::WorldPoint;

/// A triangle faces away, and is the back of a closed shape, where the facing of all its vertices is less
/// than this.
const MAX_BACK_FACING: f32 = -0.15;
/// Samples of the target's tile; a larger tile gets fewer samples for each pixel.
const MAX_TARGET_SAMPLES: usize = 110_000;
/// The same for other objects, of which nothing is measured.
const MAX_OTHER_SAMPLES: usize = 30_000;
/// A turned nozzle reaches at most this far out of its mesh, metres.
const MAX_NOZZLE_M: f32 = 0.1;
/// Lower bound of the sine of the sun's elevation for the length of shadows.
const MIN_SUN_SINE: f32 = 0.08;

impl ImageTile {
    /// Renders an image of an object.
    pub(super) fn render(&mut self, source: &Source<'_>, kind: ImageKind) {
        let &Source { scene, mesh, object, .. } = source;
        self.clear();
        let radius_m = image_radius_m(source, kind);
        if scene.camera.is_outside_view(object.pose.position, radius_m, scene.margin) {
            return;
        }
        self.project_vertices(source, kind);
        let max_samples = if object.is_target { MAX_TARGET_SAMPLES } else { MAX_OTHER_SAMPLES };
        if !self.fit_to_vertices(scene, kind, max_samples) {
            return;
        }
        if kind == ImageKind::Direct && object.is_target {
            self.measure_body(mesh);
        }
        for (index, (corners, part)) in mesh.triangles.iter().enumerate() {
            let vertices = corners.map(|corner| self.vertices[corner as usize]);
            let is_back = vertices.iter().all(|vertex| vertex.facing < MAX_BACK_FACING);
            if kind == ImageKind::Shadow || part.is_seen_from_both_sides() || !is_back {
                self.scan_triangle(vertices, index as u32);
            }
        }
        match kind {
            ImageKind::Shadow => resolve_shadow(self),
            ImageKind::Direct | ImageKind::Reflection => resolve_image(self, source),
        }
    }

    fn project_vertices(&mut self, source: &Source<'_>, kind: ImageKind) {
        let &Source { scene, mesh, object, waterline } = source;
        self.vertices.clear();
        let axes = object.axes();
        let sun = scene.light.to_sun;
        let (camera, origin) = (scene.camera, object.pose.position);
        let viewpoint = camera.middle().position;
        let row = camera.row_seeing(origin);
        let single = |p: WorldPoint| [p.x as f32, p.y as f32, p.z as f32];
        let (from_viewpoint, position) = (single(viewpoint.vector_to(origin)), single(origin));
        // A reflection is the object as seen from the camera mirrored below the water.
        let lower = if kind == ImageKind::Reflection { 2.0 * viewpoint.z as f32 } else { 0.0 };
        for (at, vertex) in mesh.vertices.iter().enumerate() {
            let body = object.deformed(mesh, at, vertex.position);
            let to_world_axes = |p: [f32; 3]| -> [f32; 3] {
                core::array::from_fn(|i| p[0] * axes[0][i] + p[1] * axes[1][i] + p[2] * axes[2][i])
            };
            let turned = to_world_axes(body);
            let world: [f32; 3] = core::array::from_fn(|i| position[i] + turned[i]);
            let from: [f32; 3] = core::array::from_fn(|i| from_viewpoint[i] + turned[i]);
            let above = waterline.map_or(world[2], |water| water.height_above(world));
            let shown = match kind {
                ImageKind::Direct => from,
                ImageKind::Reflection => [from[0], from[1], from[2] - 2.0 * above],
                ImageKind::Shadow => {
                    let part = above.max(0.0) / sun[2].max(MIN_SUN_SINE);
                    [from[0] - part * sun[0], from[1] - part * sun[1], from[2] - part * sun[2]]
                }
            };
            let (u, v, nearness) = camera.project_vertex(shown, row).unwrap_or_default();
            let normal = to_world_axes(vertex.normal);
            let view = [-from[0], -from[1], -from[2] - lower];
            let length = (view[0] * view[0] + view[1] * view[1] + view[2] * view[2]).sqrt().max(1e-9);
            let facing = (normal[0] * view[0] + normal[1] * view[1] + normal[2] * view[2]) / length;
            self.vertices.push(ProjectedVertex { u, v, nearness, world, normal, above, facing });
        }
    }

    /// Measures the columns and rows of the body.
    fn measure_body(&mut self, mesh: &Mesh) {
        let (mut low, mut high) = ((f32::MAX, f32::MAX), (f32::MIN, f32::MIN));
        for (vertex, shape) in self.vertices.iter().zip(&mesh.vertices) {
            if vertex.nearness > 0.0 && !shape.part.is_rigging() {
                low = (low.0.min(vertex.u), low.1.min(vertex.v));
                high = (high.0.max(vertex.u), high.1.max(vertex.v));
            }
        }
        let pixels = |low: f32, high: f32| {
            libm::floorf(low.clamp(-1e6, 1e6)) as i32..libm::ceilf(high.clamp(-1e6, 1e6)) as i32
        };
        self.body = (pixels(low.0, high.0), pixels(low.1, high.1));
    }

    /// Fits the tile around the projected vertices and chooses the samples for each pixel. Returns `false`
    /// where nothing of the shape lies in the picture or its margin.
    fn fit_to_vertices(&mut self, scene: &Scene<'_>, kind: ImageKind, max_samples: usize) -> bool {
        let (mut low, mut high) = ((f32::MAX, f32::MAX), (f32::MIN, f32::MIN));
        for vertex in self.vertices.iter().filter(|vertex| vertex.nearness > 0.0) {
            low = (low.0.min(vertex.u), low.1.min(vertex.v));
            high = (high.0.max(vertex.u), high.1.max(vertex.v));
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
        let max_side = if kind == ImageKind::Direct { 4 } else { 1 };
        let min_side = if area <= 2 * MAX_TARGET_SAMPLES { 2.min(max_side) } else { 1 };
        self.samples_per_side =
            (1..=max_side).rev().find(|ss| area * ss * ss <= max_samples).unwrap_or(1).max(min_side);
        let samples = area * self.samples_per_side * self.samples_per_side;
        self.nearness.clear();
        self.nearness.resize(samples, 0.0);
        self.triangle.clear();
        self.triangle.resize(samples, NO_TRIANGLE);
        self.pixels.resize(area, [0.0; 4]);
        true
    }

    /// Writes a triangle into the samples that it covers and where it is the nearest so far.
    fn scan_triangle(&mut self, [a, b, c]: [ProjectedVertex; 3], index: u32) {
        if a.nearness <= 0.0 || b.nearness <= 0.0 || c.nearness <= 0.0 {
            return;
        }
        let ss = self.samples_per_side as f32;
        let local = |vertex: &ProjectedVertex| {
            ((vertex.u - self.left as f32) * ss, (vertex.v - self.top as f32) * ss)
        };
        let ((ax, ay), (bx, by), (cx, cy)) = (local(&a), local(&b), local(&c));
        let doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if doubled.abs() < 1e-9 {
            return;
        }
        let columns = (self.width * self.samples_per_side) as i32;
        let rows = (self.height * self.samples_per_side) as i32;
        let first_column = ((ax.min(bx).min(cx) - 0.5) as i32).max(0);
        let last_column = ((ax.max(bx).max(cx) + 0.5) as i32).min(columns - 1);
        let first_row = ((ay.min(by).min(cy) - 0.5) as i32).max(0);
        let last_row = ((ay.max(by).max(cy) + 0.5) as i32).min(rows - 1);
        // The weights of b and c, and the nearness, are linear in x along a row.
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
            let mut has_entered = false;
            for column in first_column..=last_column {
                let x = column as f32 + 0.5 - ax;
                let (wb, wc) = (b_start + x * b_by_x, c_start + x * c_by_x);
                let min_weight = if wb < wc { wb } else { wc };
                let min_weight = if 1.0 - wb - wc < min_weight { 1.0 - wb - wc } else { min_weight };
                if min_weight < 0.0 {
                    if has_entered {
                        break;
                    }
                    continue;
                }
                has_entered = true;
                let nearness = near_start + x * near_by_x;
                let at = column as usize;
                if nearness > nearnesses[at] {
                    nearnesses[at] = nearness;
                    triangles[at] = index;
                }
            }
        }
    }
}

/// Radius of a ball around the object's origin that contains the whole image, metres.
fn image_radius_m(&Source { scene, mesh, object, .. }: &Source<'_>, kind: ImageKind) -> f64 {
    let stretch = object.scale.into_iter().fold(0.0_f32, f32::max);
    let radius = f64::from(mesh.radius_m * stretch) + f64::from(MAX_NOZZLE_M);
    match kind {
        ImageKind::Direct => radius,
        // The reflecting water may slope, and lie above or below the origin.
        ImageKind::Reflection => 2.5 * radius + 2.0 * object.pose.position.z.abs(),
        ImageKind::Shadow => {
            let low = f64::from(scene.light.to_sun[2].max(MIN_SUN_SINE));
            (radius + object.pose.position.z.abs()) * (2.0 + 1.5 / low)
        }
    }
}
