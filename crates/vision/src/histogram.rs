//! Hue histogram of the selection.

use thiserror::Error;

use crate::hue::HUE_CODES;

/// A histogram over the hue circle, scaled as in the laboratory's program: the fullest bin weighs 255 and the
/// emptiest 0; if all are equally full, all weigh 255.
///
/// Hue is counted in steps of two degrees, h = 0 to 179, and bin = floor(h * bins / 180). The circle is cut
/// at red: a red boat fills the first and the last bin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HueHistogram {
    /// Weight of each bin.
    weights: Vec<u8>,
    /// Weight of each hue code; 0 for codes that are no hue.
    weight_by_hue: [u8; 256],
}

/// There was no hue to count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("no pixel with a hue was counted")]
pub struct EmptyHistogram;

impl HueHistogram {
    /// Builds the histogram from the number of pixels of each hue code.
    ///
    /// # Errors
    /// If all counts are zero.
    pub fn new(counts: &[u32; HUE_CODES as usize], bins: usize) -> Result<Self, EmptyHistogram> {
        let bins = bins.clamp(1, counts.len());
        let mut filled = vec![0u64; bins];
        for (hue, &count) in counts.iter().enumerate() {
            filled[bin_of(hue, bins)] += u64::from(count);
        }
        let fullest = filled.iter().copied().max().unwrap_or(0);
        let emptiest = filled.iter().copied().min().unwrap_or(0);
        if fullest == 0 {
            return Err(EmptyHistogram);
        }
        let range = fullest - emptiest;
        let weight = |count: u64| match range {
            0 => 255,
            // Rounded to the nearest; at most 255, so the cast is lossless.
            range => (((count - emptiest) * 255 * 2 + range) / (range * 2)) as u8,
        };
        let weights: Vec<u8> = filled.into_iter().map(weight).collect();
        let mut weight_by_hue = [0; 256];
        for (hue, slot) in weight_by_hue.iter_mut().take(counts.len()).enumerate() {
            *slot = weights[bin_of(hue, bins)];
        }
        Ok(Self { weights, weight_by_hue })
    }

    /// Weight of each bin, 0 to 255.
    pub fn weights(&self) -> &[u8] {
        &self.weights
    }

    /// Weight of each hue code, 0 to 255; 0 for the codes from 180 on, which are no hue.
    pub(crate) const fn weight_by_hue(&self) -> &[u8; 256] {
        &self.weight_by_hue
    }
}

const fn bin_of(hue: usize, bins: usize) -> usize {
    hue * bins / HUE_CODES as usize
}
