//! A dense layer: each output depends on each input.

use crate::simd::simd_kernel;

/// Weights of a dense layer.
#[derive(Debug)]
pub(super) struct DenseLayer {
    /// For each output the weights of all inputs.
    pub(super) weights: Vec<f32>,
    /// One for each output.
    pub(super) bias: Vec<f32>,
}

impl DenseLayer {
    /// Computes the outputs.
    pub(super) fn apply(&self, inputs: &[f32], outputs: &mut [f32]) {
        dense(self, inputs, outputs);
    }

    /// The same, with 0 in place of negative outputs.
    pub(super) fn apply_and_clear_negative(&self, inputs: &[f32], outputs: &mut [f32]) {
        dense(self, inputs, outputs);
        outputs.iter_mut().for_each(|value| *value = value.max(0.0));
    }
}

simd_kernel! {
fn dense(layer: &DenseLayer, inputs: &[f32], outputs: &mut [f32]) {
    /// Partial sums, for vector instructions.
    const PARTS: usize = 8;
    for ((weights, bias), out) in
        layer.weights.chunks_exact(inputs.len()).zip(&layer.bias).zip(outputs.iter_mut())
    {
        let mut sums = [0.0_f32; PARTS];
        let ((w, w_rest), (x, x_rest)) = (weights.as_chunks::<PARTS>(), inputs.as_chunks::<PARTS>());
        for (w, x) in w.iter().zip(x) {
            for k in 0..PARTS {
                sums[k] += w[k] * x[k];
            }
        }
        let rest: f32 = w_rest.iter().zip(x_rest).map(|(w, x)| w * x).sum();
        *out = bias + sums.iter().sum::<f32>() + rest;
    }
}
}
