//! What changes slowly along a row, at every eighth pixel, a *node*: the width of the pixels' footprint, gusts, how
//! widely the facets below a pixel's resolution are spread, and what follows from these for reflections. In between the
//! values lie on straight lines: over eight pixels a line of sight turns by a hundredth of a radian or two.

use super::chunk::{CHUNK, Lane};

/// Pixels from node to node.
pub(super) const STEP: usize = 8;
/// Nodes that a chunk lies between.
const OF_CHUNK: usize = CHUNK / STEP + 1;
/// Nodes are computed so many at a time.
pub(super) const GROUP: usize = 32;

/// One quantity along a row.
#[derive(Debug, Clone)]
pub(super) struct Along(pub(super) Vec<f32>);

/// All quantities of a row.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// The line of sight, of length 1, from the water to the camera.
    pub(super) vx: Along,
    pub(super) vy: Along,
    pub(super) vz: Along,
    /// 1 over the length of the direction.
    pub(super) per_length: Along,
    /// Vertical part of the direction.
    pub(super) dz: Along,
    /// Where it meets the plane, metres from below the camera.
    pub(super) px: Along,
    pub(super) py: Along,
    /// Width of a pixel's footprint, metres, a mean of along and across.
    pub(super) footprint: Along,
    /// How much of what is seen is haze.
    pub(super) haze: Along,
    /// Factor of the short waves' slopes.
    pub(super) gust: Along,
    /// Variance of slope along one axis below the pixels' resolution.
    pub(super) variance: Along,
    /// Its root.
    pub(super) std_dev: Along,
    /// By how much the facets that are seen lean towards the viewer.
    pub(super) lean: Along,
    /// Strength of reflection at grazing angles.
    pub(super) grazing: Along,
    /// The slope that would mirror the sun into the line of sight.
    pub(super) glint_x: Along,
    pub(super) glint_y: Along,
    /// How fast the glitter falls off about it, and how bright it is.
    pub(super) glint_fall: Along,
    pub(super) glint_peak: Along,
}

impl Nodes {
    /// For rows of so many pixels.
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

    /// How many nodes there are.
    pub(super) fn count(&self) -> usize {
        self.vx.0.len()
    }
}

/// Shares of the way to the next node.
const PART: [f32; STEP] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];

impl Along {
    /// The nodes about a chunk that begins with this column.
    #[inline(always)]
    pub(super) fn about(&self, column: usize) -> &[f32] {
        &self.0[column / STEP..][..OF_CHUNK]
    }

    /// The values of a chunk's pixels.
    #[inline(always)]
    pub(super) fn lane(&self, column: usize) -> Lane {
        let mut lane = [0.0; CHUNK];
        self.fill(column, &mut lane);
        lane
    }

    /// Writes down the values of a chunk's pixels.
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

    /// The smallest and the largest value about a chunk.
    pub(super) fn range(&self, column: usize) -> (f32, f32) {
        self.about(column).iter().fold((f32::MAX, f32::MIN), |(low, high), &value| {
            (if value < low { value } else { low }, if value > high { value } else { high })
        })
    }
}
