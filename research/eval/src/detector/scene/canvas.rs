//! Rasterises meshes over a rendered picture: four samples a pixel, the nearest surface wins, the water cuts.

use barrelman_sim::pose::CameraAxes;
use barrelman_sim::render::ENCODING;
use barrelman_sim::snapshot::Light;
use barrelman_sim::{CameraPose, Optics, WorldPoint};
use barrelman_vocab::{Picture, PixelBox};

use super::mesh::{Colour, Mesh};

/// Samples along each side of a pixel.
const SIDE: usize = 2;
/// Samples of a pixel that an object covers where the pixel belongs to its box.
const LEAST_SAMPLES: usize = 2;
/// No object.
const NOBODY: u16 = u16::MAX;

/// A camera with its lens.
pub(super) struct View {
    optics: Optics,
    position: WorldPoint,
    axes: CameraAxes,
}

/// How an object is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Finish {
    pub(super) object: u16,
    /// Height of the water, metres: what lies below it is hidden.
    pub(super) water_m: f64,
    /// Opacity; below 1 for reflections, which belong to no box.
    pub(super) opacity: f64,
}

/// The samples of the objects.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    nearness: Vec<f64>,
    object: Vec<u16>,
    colour: Vec<[f32; 4]>,
}

impl View {
    pub(super) fn new(optics: Optics, pose: &CameraPose) -> Self {
        Self { optics, position: pose.position, axes: pose.axes() }
    }

    /// Column, row (pixels) and depth (m) of a point; `None` behind the camera.
    pub(super) fn project(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
        let to = self.position.vector_to(WorldPoint { x, y, z });
        let depth = to.dot(self.axes.ahead);
        let at = self.optics.project((to.dot(self.axes.right), to.dot(self.axes.down), depth))?;
        Some([at.u, at.v, depth])
    }

    /// Where the line of sight of a pixel meets the water at rest, nearer than a range (m).
    pub(super) fn on_water(&self, u: f64, v: f64, range_m: f64) -> Option<(f64, f64)> {
        let (right, down) = self.optics.ray_direction(barrelman_vocab::PixelPoint { u, v });
        let axis = |of: fn(WorldPoint) -> f64| {
            of(self.axes.ahead) + right * of(self.axes.right) + down * of(self.axes.down)
        };
        let (x, y, z) = (axis(|at| at.x), axis(|at| at.y), axis(|at| at.z));
        let along = -self.position.z / z;
        let is_ahead = z < 0.0 && along * libm::sqrt(x * x + y * y + z * z) < range_m;
        is_ahead.then_some((self.position.x + along * x, self.position.y + along * y))
    }
}

impl Canvas {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize * SIDE, height as usize * SIDE);
        let samples = width * height;
        Self {
            width,
            height,
            nearness: vec![0.0; samples],
            object: vec![NOBODY; samples],
            colour: vec![[0.0; 4]; samples],
        }
    }

    /// Draws a mesh that is placed in the world.
    pub(super) fn draw(&mut self, view: &View, light: &Light, mesh: &Mesh, finish: Finish) {
        for (corners, colour) in &mesh.triangles {
            if corners.iter().all(|corner| corner[2] < finish.water_m) && finish.opacity >= 1.0 {
                continue;
            }
            let shade = shaded(view, light, corners, *colour);
            let projected = corners.map(|corner| view.project(corner));
            if let [Some(a), Some(b), Some(c)] = projected {
                let heights = corners.map(|corner| corner[2]);
                self.fill([a, b, c], heights, shade, finish);
            }
        }
    }

    fn fill(&mut self, points: [[f64; 3]; 3], heights: [f64; 3], shade: Colour, finish: Finish) {
        let scale = SIDE as f64;
        let [a, b, c] = points.map(|[u, v, _]| [u * scale, v * scale]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-9 {
            return;
        }
        let range = |axis: usize, limit: usize| {
            let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
            let first = low.max(0.0) as usize;
            first..(high.max(0.0) as usize + 1).min(limit)
        };
        for row in range(1, self.height) {
            for column in range(0, self.width) {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
                let third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
                let weights = [1.0 - second - third, second, third];
                if weights.iter().any(|weight| *weight < 0.0) {
                    continue;
                }
                let nearness: f64 = weights.iter().zip(points).map(|(w, [.., depth])| w / depth).sum();
                let height: f64 = weights
                    .iter()
                    .zip(points)
                    .zip(heights)
                    .map(|((w, [.., depth]), z)| w / depth * z)
                    .sum::<f64>()
                    / nearness;
                let is_above = (height > finish.water_m) == (finish.opacity >= 1.0);
                let index = row * self.width + column;
                if is_above && nearness > self.nearness[index] {
                    self.nearness[index] = nearness;
                    self.object[index] = if finish.opacity < 1.0 { NOBODY } else { finish.object };
                    let [red, green, blue] = shade.map(|channel| channel as f32);
                    self.colour[index] = [red, green, blue, finish.opacity as f32];
                }
            }
        }
    }

    /// Forgets depths: what is drawn next covers all that is drawn.
    pub(super) fn next_layer(&mut self) {
        self.nearness.fill(0.0);
    }

    /// The boxes around the visible pixels of so many objects.
    pub(super) fn bounds(&self, objects: usize) -> Vec<Option<PixelBox>> {
        // Of each object: first column and row, and those after the last.
        let mut reaches = vec![[usize::MAX, usize::MAX, 0, 0]; objects];
        for row in 0..self.height / SIDE {
            for column in 0..self.width / SIDE {
                for at in self.samples(column, row) {
                    let object = self.object[at];
                    let Some(reach) = reaches.get_mut(usize::from(object)) else { continue };
                    let covered = self.samples(column, row).filter(|at| self.object[*at] == object).count();
                    if covered >= LEAST_SAMPLES {
                        let [left, top, right, bottom] = *reach;
                        *reach = [left.min(column), top.min(row), right.max(column + 1), bottom.max(row + 1)];
                    }
                }
            }
        }
        let bounds = |[left, top, right, bottom]: [usize; 4]| {
            let (w, h) = (right.checked_sub(left)?, bottom.checked_sub(top)?);
            Some(PixelBox { u: left as f64, v: top as f64, w: w as f64, h: h as f64 })
        };
        reaches.into_iter().map(bounds).collect()
    }

    fn samples(&self, column: usize, row: usize) -> impl Iterator<Item = usize> {
        let first = row * SIDE * self.width + column * SIDE;
        let width = self.width;
        (0..SIDE * SIDE).map(move |sample| first + sample / SIDE * width + sample % SIDE)
    }

    /// Blends the samples into a picture in [`ENCODING`].
    pub(super) fn composite(&self, picture: &mut Picture, gain: f64) {
        let weights = ENCODING.matrix.luma_weights();
        let scale = ENCODING.range.full_scale();
        let (columns, rows) = (self.width / SIDE, self.height / SIDE);
        let [luma, blue, red] = picture.planes_mut();
        let mut chroma = vec![[0.0_f64; 3]; (columns / 2) * (rows / 2)];
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut opacity) = ([0.0_f64; 3], 0.0_f64);
                for at in self.samples(column, row) {
                    let [r, g, b, part] = self.colour[at].map(f64::from);
                    for (total, channel) in sum.iter_mut().zip([r, g, b]) {
                        *total += part * channel;
                    }
                    opacity += part;
                }
                if opacity <= 0.0 {
                    continue;
                }
                let [r, g, b] = sum.map(|channel| tone(gain * channel / opacity));
                let share = opacity / (SIDE * SIDE) as f64;
                let y = weights.red * r + weights.green * g + weights.blue * b;
                let sample = &mut luma[row * columns + column];
                let value = scale.black + 255.0 * y / scale.luma;
                *sample = (f64::from(*sample) * (1.0 - share) + value * share).round() as u8;
                let cell = &mut chroma[row / 2 * (columns / 2) + column / 2];
                cell[0] += share * (b - y) / weights.cb_divisor();
                cell[1] += share * (r - y) / weights.cr_divisor();
                cell[2] += share;
            }
        }
        for (plane, which) in [(blue, 0), (red, 1)] {
            for (sample, cell) in plane.iter_mut().zip(&chroma) {
                let value = 128.0 * cell[2] + 255.0 * cell[which] / scale.chroma;
                *sample = (f64::from(*sample) * (1.0 - cell[2] / 4.0) + value / 4.0).round() as u8;
            }
        }
    }
}

/// From linear light to a sample, 0 to 1.
fn tone(light: f64) -> f64 {
    libm::pow(light.clamp(0.0, 1.0), 1.0 / 2.2)
}

/// The colour of a triangle, seen from either side, in the light of sun and sky.
fn shaded(view: &View, light: &Light, corners: &[[f64; 3]; 3], colour: Colour) -> Colour {
    let point = |[x, y, z]: [f64; 3]| WorldPoint { x, y, z };
    let [a, b, c] = corners.map(point);
    let (one, other) = (a.vector_to(b), a.vector_to(c));
    let normal = WorldPoint {
        x: one.y * other.z - one.z * other.y,
        y: one.z * other.x - one.x * other.z,
        z: one.x * other.y - one.y * other.x,
    };
    let facing = if normal.dot(a.vector_to(view.position)) < 0.0 { -1.0 } else { 1.0 };
    let length = facing * normal.norm().max(1e-12);
    let (sin_b, cos_b) = libm::sincos(light.sun_bearing.radians());
    let (sin_e, cos_e) = libm::sincos(light.sun_elevation.radians());
    let sun = WorldPoint { x: sin_b * cos_e, y: cos_b * cos_e, z: sin_e };
    let direct = 0.8 * (1.0 - light.overcast) * (normal.dot(sun) / length).max(0.0);
    let sky = (0.24 + 0.34 * light.overcast) * (0.65 + 0.35 * normal.z / length);
    colour.map(|channel| channel * (direct + sky))
}

#[cfg(test)]
mod tests {
    use barrelman_sim::BodyPose;
    use barrelman_vocab::{Angle, PictureSize};

    use super::*;

    const SIZE: PictureSize = PictureSize::new(160, 90);

    /// Draws cubes of 1 m, their middles at these places, before a level camera 1 m above the water, and
    /// returns the boxes: 100 pixels a metre at a distance of 1 m.
    fn boxes_of_cubes(places: &[[f64; 3]]) -> Vec<Option<PixelBox>> {
        let pose = CameraPose {
            position: WorldPoint { x: 0.0, y: 0.0, z: 1.0 },
            pan: Angle::ZERO,
            tilt: Angle::ZERO,
            roll: Angle::ZERO,
        };
        let view = View::new(Optics { picture: SIZE, focal_px: 100.0, barrel: 0.0 }, &pose);
        let light = Light { sun_bearing: Angle::ZERO, sun_elevation: Angle::ZERO, overcast: 1.0 };
        let mut canvas = Canvas::new(SIZE.width, SIZE.height);
        for (&[x, y, z], object) in places.iter().zip(0..) {
            let mut mesh = Mesh::default();
            mesh.cuboid([0.5; 3], [0.5; 3], [-0.5; 3], [0.5; 3]);
            let heading = Angle::ZERO;
            let pose =
                BodyPose { position: WorldPoint { x, y, z }, heading, pitch: Angle::ZERO, roll: Angle::ZERO };
            canvas.draw(&view, &light, &mesh.placed(&pose), Finish { object, water_m: 0.0, opacity: 1.0 });
        }
        canvas.bounds(places.len())
    }

    #[test]
    fn the_box_is_that_of_the_projected_shape() {
        // The front is 4 m away: 25 pixels a metre.
        let expected = PixelBox { u: 67.0, v: 32.0, w: 26.0, h: 26.0 };
        let found = boxes_of_cubes(&[[0.0, 4.5, 1.0]])[0].unwrap();
        assert!(found.iou(expected) > 0.9, "{found}");
    }

    #[test]
    fn the_water_cuts_a_shape() {
        let found = boxes_of_cubes(&[[0.0, 4.5, 0.0]])[0].unwrap();
        // From 0.5 m below the camera at the back, 5 m away, down to the water at the front.
        assert!((found.v - 55.0).abs() <= 1.0 && (found.v + found.h - 70.0).abs() <= 1.0, "{found}");
    }

    #[test]
    fn the_nearer_shape_hides_the_farther() {
        let boxes = boxes_of_cubes(&[[0.0, 9.5, 1.0], [0.0, 4.5, 1.0], [40.0, 4.5, 1.0]]);
        assert_eq!((boxes[0], boxes[2]), (None, None));
        assert!(boxes[1].is_some());
    }
}
