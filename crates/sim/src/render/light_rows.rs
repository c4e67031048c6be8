//! Linear light of the rows of a picture, in bands that are locked one by one.

use std::sync::{PoisonError, RwLock};

use barrelman_vocab::PictureSize;

use super::chunk::{CHUNK, Chunk};
use super::nodes::Nodes;
use super::secondary_image::SecondaryImage;

/// Rows of a band; even, so that the chroma rows of a band need no other band.
pub(super) const BAND_ROWS: usize = 8;

/// The rows of one picture size.
#[derive(Debug)]
pub(super) struct LightRows {
    size: PictureSize,
    bands: Vec<RwLock<LightBand>>,
}

/// The light of a band, and working memory to shade it.
#[derive(Debug)]
pub(super) struct LightBand {
    /// Red, green and blue of each row, one channel after the other, each padded to whole chunks.
    pub(super) values: Vec<f32>,
    pub(super) chunk: Box<Chunk>,
    pub(super) nodes: Nodes,
    pub(super) images: Vec<SecondaryImage>,
}

/// Values of a channel of a row, with padding.
pub(super) const fn padded_width(width: usize) -> usize {
    width.next_multiple_of(CHUNK)
}

impl LightRows {
    pub(super) fn new(size: PictureSize) -> Self {
        let (width, height) = (size.width as usize, size.height as usize);
        let band = || {
            let values = vec![0.0; BAND_ROWS * 3 * padded_width(width)];
            let (chunk, nodes) = (Box::new(Chunk::new()), Nodes::new(width));
            RwLock::new(LightBand { values, chunk, nodes, images: Vec::new() })
        };
        Self { size, bands: (0..height.div_ceil(BAND_ROWS)).map(|_| band()).collect() }
    }

    /// Number of bands.
    pub(super) fn bands(&self) -> usize {
        self.bands.len()
    }

    /// The rows of a band.
    pub(super) fn rows_of(&self, band: usize) -> std::ops::Range<usize> {
        BAND_ROWS * band..(BAND_ROWS * (band + 1)).min(self.size.height as usize)
    }

    /// Calls `work` for each row of a band, with the band locked for writing.
    pub(super) fn write_rows(&self, band: usize, work: &dyn Fn(usize, &mut LightBand)) {
        let mut light = self.bands[band].write().unwrap_or_else(PoisonError::into_inner);
        self.rows_of(band).for_each(|row| work(row, &mut light));
    }

    /// Calls `read` with one channel of a row. Rows outside the picture repeat its border.
    pub(super) fn read_row(&self, row: i64, channel: usize, read: impl FnOnce(&[f32])) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let row = row.clamp(0, height as i64 - 1) as usize;
        let light = self.bands[row / BAND_ROWS].read().unwrap_or_else(PoisonError::into_inner);
        read(&light.values[((row % BAND_ROWS) * 3 + channel) * padded_width(width)..][..width]);
    }
}
