//! Quantities that change slowly along a row, at every eighth pixel (a *node*): the footprint of the pixels,
//! gusts, the variance of slopes below the pixels' resolution, and what follows from these for reflections.
//! Between nodes they are interpolated linearly: over eight pixels a line of sight turns by one or two
//! hundredths of a radian.

use super::chunk::{CHUNK, Lane};

/// Pixels from node to node.
pub(super) const STEP: usize = 8;
/// Nodes of a chunk, both ends included.
const CHUNK_NODES: usize = CHUNK / STEP + 1;
/// Nodes computed at a time.
pub(super) const GROUP: usize = 32;

/// One quantity along a row.
#[derive(Debug, Clone)]
pub(super) struct Along(pub(super) Vec<f32>);

/// All quantities of a row.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// Unit vector from the water to the camera.
    pub(super) vx: Along,
    pub(super) vy: Along,
    pub(super) vz: Along,
    /// 1 / length of the direction.
    pub(super) per_length: Along,
    /// Vertical part of the direction.
    pub(super) dz: Along,
    /// Where the direction meets the plane, from below the camera, metres.
    pub(super) px: Along,
    pub(super) py: Along,
    /// Width of a pixel's footprint, metres: geometric mean of along and across.
    pub(super) footprint: Along,
    /// Share of haze in what is seen.
    pub(super) haze: Along,
    /// Factor of the slopes of the short waves.
    pub(super) gust: Along,
    /// Variance of slope along one axis below the pixels' resolution.
    pub(super) variance: Along,
    /// Square root of the variance.
    pub(super) std_dev: Along,
    /// Mean slope of the visible facets towards the viewer.
    pub(super) lean: Along,
    /// Strength of reflection at grazing angles.
    pub(super) grazing: Along,
    /// The slope that would reflect the sun into the line of sight.
    pub(super) glint_x: Along,
    pub(super) glint_y: Along,
    /// Decay of the glitter around that slope, and its peak.
    pub(super) glint_fall: Along,
    pub(super) glint_peak: Along,
}

impl Nodes {
    /// Nodes for rows of `width` pixels.
    pub(super) fn new(width: usize) -> Self {
        let nodes = width.next_multiple_of(CHUNK) / STEP + 1;
        let along = || Along(vec![0.0; nodes.next_multiple_of(GROUP)]);
        Self {
            vx: along(),
            vy: along(),
            vz: along(),
            per_length: along(),
            dz: along(),
            px: along(),
            py: along(),
            footprint: along(),
            haze: along(),
            gust: along(),
            variance: along(),
            std_dev: along(),
            lean: along(),
            grazing: along(),
            glint_x: along(),
            glint_y: along(),
            glint_fall: along(),
            glint_peak: along(),
        }
    }

    /// Number of nodes.
    pub(super) fn count(&self) -> usize {
        self.vx.0.len()
    }
}

/// Interpolation weights of the next node.
const PART: [f32; STEP] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];

impl Along {
    /// The nodes of a chunk that begins at a column.
    #[inline(always)]
    pub(super) fn about(&self, column: usize) -> &[f32] {
        &self.0[column / STEP..][..CHUNK_NODES]
    }

    /// The values of a chunk's pixels.
    #[inline(always)]
    pub(super) fn lane(&self, column: usize) -> Lane {
        let mut lane = [0.0; CHUNK];
        self.fill(column, &mut lane);
        lane
    }

    /// Writes the values of a chunk's pixels.
    #[inline(always)]
    pub(super) fn fill(&self, column: usize, lane: &mut Lane) {
        let nodes = self.about(column);
        for k in 0..CHUNK / STEP {
            let (from, by) = (nodes[k], nodes[k + 1] - nodes[k]);
            for j in 0..STEP {
                lane[STEP * k + j] = from + PART[j] * by;
            }
        }
    }

    /// Smallest and largest value at the nodes of a chunk.
    pub(super) fn range(&self, column: usize) -> (f32, f32) {
        self.about(column).iter().fold((f32::MAX, f32::MIN), |(low, high), &value| {
            (if value < low { value } else { low }, if value > high { value } else { high })
        })
    }
}
