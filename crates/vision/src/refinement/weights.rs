//! The weights of the refinement network, and the sizes of its layers.

use std::sync::{Arc, LazyLock};

use barrelman_simd::{COLUMNS, OUTPUTS};
use thiserror::Error;

use super::convolution::{Convolution, MAX_ROWS};
use super::dense_layer::DenseLayer;
use super::window::{MEASUREMENTS, WINDOW_CHANNELS, WINDOW_SIDE_CELLS};

/// Side of the maps.
pub(super) const SIDE: usize = WINDOW_SIDE_CELLS / 2;
/// Channels after the first convolution and after the others.
pub(super) const FIRST: usize = 32;
pub(super) const SECOND: usize = 48;
/// Channels of the profile of an axis, and values that its edges are computed from.
pub(super) const PROFILE: usize = 24;
pub(super) const EDGE: usize = 48;
/// Answers for an axis: the shifts of both edges, and the logarithms of their errors.
pub(super) const ANSWERS: usize = 4;
/// Values that the probability is computed from, and its inputs.
pub(super) const JUDGE: usize = 32;
pub(super) const JUDGED: usize = 3 * SECOND + 2 * EDGE + MEASUREMENTS;

/// The weights of the network.
#[derive(Debug)]
pub struct RefinementWeights {
    pub(super) first: Convolution,
    pub(super) second: Convolution,
    pub(super) third: Convolution,
    pub(super) fourth: Convolution,
    pub(super) profile: Convolution,
    pub(super) edge: DenseLayer,
    pub(super) answer: DenseLayer,
    pub(super) judge: DenseLayer,
    pub(super) odds: DenseLayer,
}

/// Why weights cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RefinementWeightsError {
    /// The length is wrong.
    #[error("the weights of the refinement network take {expected} bytes, not {found}")]
    Length {
        /// Number of bytes that the network takes.
        expected: usize,
        /// Number of bytes given.
        found: usize,
    },
    /// A weight is not finite.
    #[error("weight {index} of the refinement network is not a finite number")]
    NotFinite {
        /// Index of the weight, from 0.
        index: usize,
    },
}

// What a convolution takes.
const _: () = {
    assert!(SIDE == COLUMNS);
    assert!(
        FIRST.is_multiple_of(OUTPUTS) && SECOND.is_multiple_of(OUTPUTS) && PROFILE.is_multiple_of(OUTPUTS)
    );
    assert!(SIDE <= MAX_ROWS);
};

/// Inputs and outputs of the layers, in the order of the file.
pub(super) const LAYERS: [(usize, usize); 9] = [
    (9 * WINDOW_CHANNELS, FIRST),
    (9 * FIRST, SECOND),
    (9 * SECOND, SECOND),
    (9 * SECOND, SECOND),
    (3 * 2 * SECOND, PROFILE),
    (SIDE * PROFILE, EDGE),
    (EDGE, ANSWERS),
    (JUDGED, JUDGE),
    (JUDGE, 1),
];

static BUILT_IN: LazyLock<Arc<RefinementWeights>> = LazyLock::new(|| {
    #[allow(clippy::expect_used, reason = "a test reads the same bytes")]
    let weights = RefinementWeights::from_bytes(include_bytes!("network.weights"))
        .expect("the built-in weights are valid");
    Arc::new(weights)
});

impl RefinementWeights {
    /// The weights that the program was built with.
    pub fn built_in() -> Arc<Self> {
        Arc::clone(&BUILT_IN)
    }

    /// Reads weights: little-endian numbers of 32 bits, layer by layer the weights, output by output, and the
    /// biases.
    ///
    /// # Errors
    /// If the number of bytes is wrong, or a weight is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RefinementWeightsError> {
        let expected = byte_count();
        if bytes.len() != expected {
            return Err(RefinementWeightsError::Length { expected, found: bytes.len() });
        }
        let values: Vec<f32> =
            bytes.as_chunks::<4>().0.iter().map(|number| f32::from_le_bytes(*number)).collect();
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(RefinementWeightsError::NotFinite { index });
        }
        let mut rest = values.as_slice();
        let mut take = |count: usize| {
            let (taken, after) = rest.split_at(count);
            rest = after;
            taken.to_vec()
        };
        let [first, second, third, fourth, profile, edge, answer, judge, odds] = LAYERS
            .map(|(inputs, outputs)| DenseLayer { weights: take(inputs * outputs), bias: take(outputs) });
        Ok(Self {
            first: convolution(first, 9),
            second: convolution(second, 9),
            third: convolution(third, 9),
            fourth: convolution(fourth, 9),
            profile: convolution(profile, 3),
            edge,
            answer,
            judge,
            odds,
        })
    }
}

/// Number of bytes of all weights and biases.
fn byte_count() -> usize {
    4 * LAYERS.iter().map(|(inputs, outputs)| (inputs + 1) * outputs).sum::<usize>()
}

/// A layer as a convolution with this number of taps.
fn convolution(layer: DenseLayer, taps: usize) -> Convolution {
    Convolution::new(&layer.weights, layer.bias, taps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_weights_are_valid() {
        assert!(RefinementWeights::from_bytes(include_bytes!("network.weights")).is_ok());
    }

    #[test]
    fn other_bytes_are_refused() {
        let bytes = vec![0; byte_count()];
        let found = bytes.len() - 4;
        assert_eq!(
            RefinementWeights::from_bytes(&bytes[..found]).err(),
            Some(RefinementWeightsError::Length { expected: bytes.len(), found })
        );
        let mut bytes = bytes;
        bytes[40..44].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(
            RefinementWeights::from_bytes(&bytes).err(),
            Some(RefinementWeightsError::NotFinite { index: 10 })
        );
    }
}
