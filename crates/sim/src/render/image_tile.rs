//! A part of the picture into which one shape is rendered: its samples while it is rasterised, its pixels
//! afterwards.

use std::ops::Range;

use super::camera::Camera;
use super::light::Lighting;
use super::mesh::Mesh;
use super::object::Instance;
use super::waterline::Waterline;

/// No triangle covers the sample.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

/// Which image of an object is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ImageKind {
    /// The object itself.
    Direct,
    /// Its reflection in the water.
    Reflection,
    /// Its shadow on the water or the floor: opacity only.
    Shadow,
}

/// What shapes are rendered with.
pub(super) struct Scene<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Lighting,
    /// Pixels beyond the picture's border that are rendered too, horizontally and vertically.
    pub(super) margin: (i32, i32),
}

/// What a tile shows.
pub(super) struct Source<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) mesh: &'a Mesh,
    pub(super) object: &'a Instance,
    /// The water around the object, if the object floats.
    pub(super) waterline: Option<&'a Waterline>,
}

/// Samples and pixels of a part of the picture.
#[derive(Debug, Default)]
pub(super) struct ImageTile {
    /// First column and row; may lie outside the picture.
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Columns and rows of the body: of all parts but the rigging. Empty unless the tile shows the target
    /// itself.
    pub(super) body: (Range<i32>, Range<i32>),
    /// Red, green and blue times opacity, and opacity, of each pixel.
    pub(super) pixels: Vec<[f32; 4]>,
    /// Samples that would show the object if it lay in still water.
    pub(super) still_water_samples: usize,
    /// Samples along each side of a pixel.
    pub(super) samples_per_side: usize,
    /// For each sample, 1 / depth of the nearest triangle, and the triangle's index or [`NO_TRIANGLE`].
    pub(super) nearness: Vec<f32>,
    pub(super) triangle: Vec<u32>,
    pub(super) vertices: Vec<ProjectedVertex>,
    /// Of each triangle.
    pub(super) water_sides: Vec<WaterSide>,
}

/// On which side of the water a triangle lies, as far as its vertices decide that.
#[derive(Debug, Clone, Copy)]
pub(super) struct WaterSide {
    /// Wholly above, or wholly below, the water around the object.
    pub(super) is_dry: bool,
    pub(super) is_submerged: bool,
    /// Wholly above, or wholly below, the body's own waterline.
    pub(super) is_high: bool,
    pub(super) is_low: bool,
}

/// A vertex in the picture and in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProjectedVertex {
    /// Pixels.
    pub(super) u: f32,
    pub(super) v: f32,
    /// 1 / depth; 0 behind the camera.
    pub(super) nearness: f32,
    pub(super) world: [f32; 3],
    pub(super) normal: [f32; 3],
    /// Height above the water, metres.
    pub(super) above: f32,
    /// Cosine between the normal and the direction to the camera.
    pub(super) facing: f32,
}

impl ImageTile {
    /// Makes the tile empty; its memory stays.
    pub(super) fn clear(&mut self) {
        (self.width, self.height, self.still_water_samples, self.samples_per_side) = (0, 0, 0, 1);
        self.body = (0..0, 0..0);
        self.pixels.clear();
    }

    /// Opacity at a pixel of the picture, 0 to 1.
    pub(super) fn opacity(&self, column: i32, row: i32) -> f32 {
        let (x, y) = (column - self.left, row - self.top);
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return 0.0;
        }
        self.pixels[y as usize * self.width + x as usize][3]
    }

    /// Composites the tile over a row of light: three channels of `padded` values each, `width` of them in
    /// the picture.
    pub(super) fn composite_row(&self, row: usize, width: usize, padded: usize, values: &mut [f32]) {
        let y = row as i32 - self.top;
        if y < 0 || y as usize >= self.height {
            return;
        }
        let first = self.left.max(0);
        let last = (self.left + self.width as i32).min(width as i32);
        for column in first..last {
            let pixel = self.pixels[y as usize * self.width + (column - self.left) as usize];
            if pixel[3] > 0.0 {
                for c in 0..3 {
                    let slot = &mut values[c * padded + column as usize];
                    *slot = *slot * (1.0 - pixel[3]) + pixel[c];
                }
            }
        }
    }
}
