//! The correlation filter, which locates the target's pattern in a patch.
//!
//! Ridge regression over all circular shifts of a training patch (Bolme et al. 2010), with the filter
//! restricted to a mask around the target, so that the surroundings take part in the training but cannot
//! attract the filter (Galoogahi et al. 2017). It is solved by ADMM (alternating direction method of
//! multipliers). With x_d the spectrum of channel d, g the unconstrained filter, h the masked filter, y the
//! desired response (a Gaussian at shift zero) and u the scaled dual, one step is, for each frequency,
//!
//! - g = (x x^H + mu I)^-1 (x conj(y) + mu (h - u)), by the Sherman-Morrison formula,
//! - h = mask . F^-1(g + u) mu / (mu + lambda), in space,
//! - u = u + g - h.
//!
//! x is a running mean of the training patches. Each frame continues from the last solution. The response to
//! a patch z is the inverse transform of sum conj(h_d) z_d.

use crate::fourier::{AREA, Fourier, Map, Spectrum};
use crate::simd::simd_kernel;

/// The filter, with what the next step of the solver continues from.
#[derive(Debug, Clone, Default)]
pub(crate) struct CorrelationFilter {
    /// Running mean of the spectra of the training patches.
    model: Vec<Spectrum>,
    /// The masked filter.
    masked: Vec<Spectrum>,
    /// Scaled dual: the accumulated difference of both filters.
    dual: Vec<Spectrum>,
    /// Energy of the model at each frequency.
    energy: Vec<f32>,
    /// The masked filter in space, channel by channel.
    kernel: Vec<f32>,
}

impl CorrelationFilter {
    pub(crate) fn update_model(&mut self, spectra: &[Spectrum], rate: f32) {
        update_model(self, spectra, rate);
    }

    /// The masked filter in space: [`AREA`] values per channel.
    pub(crate) fn kernel(&self) -> &[f32] {
        &self.kernel
    }

    /// Spectrum of the response to a patch with these spectra.
    pub(crate) fn correlate(&self, spectra: &[Spectrum], out: &mut Spectrum) {
        correlate(&self.masked, spectra, out);
    }
}

/// Solves for filters; keeps its buffers.
#[derive(Debug, Default)]
pub(crate) struct FilterSolver {
    /// The unconstrained filter.
    unconstrained: Vec<Spectrum>,
    sum: Spectrum,
}

impl FilterSolver {
    /// One ADMM step of a filter.
    pub(crate) fn step(
        &mut self,
        filter: &mut CorrelationFilter,
        fourier: &mut Fourier,
        desired: &Spectrum,
        mask: &Map,
    ) {
        self.unconstrained.resize_with(filter.model.len(), Spectrum::default);
        filter.kernel.resize(filter.model.len() * AREA, 0.0);
        solve_step(self, filter, fourier, desired, mask);
    }
}

/// A filter as it was: it responds, and does not learn.
#[derive(Debug)]
pub(crate) struct FixedFilter {
    masked: Vec<Spectrum>,
}

impl FixedFilter {
    /// A filter with this number of channels and without a response.
    pub(crate) fn new(channels: usize) -> Self {
        Self { masked: vec![Spectrum::default(); channels] }
    }

    /// Becomes what another filter is now. Allocates nothing where that has as many channels.
    pub(crate) fn copy_from(&mut self, filter: &CorrelationFilter) {
        self.masked.resize_with(filter.masked.len(), Spectrum::default);
        for (to, from) in self.masked.iter_mut().zip(&filter.masked) {
            to.re.copy_from_slice(&from.re[..]);
            to.im.copy_from_slice(&from.im[..]);
        }
    }

    /// Spectrum of the response to a patch with these spectra.
    pub(crate) fn correlate(&self, spectra: &[Spectrum], out: &mut Spectrum) {
        correlate(&self.masked, spectra, out);
    }

    /// The response at shift zero to a patch with these spectra.
    pub(crate) fn response_in_the_middle(&self, spectra: &[Spectrum]) -> f32 {
        response_in_the_middle(&self.masked, spectra)
    }
}

simd_kernel! {
fn update_model(filter: &mut CorrelationFilter, spectra: &[Spectrum], rate: f32) {
    let first = filter.model.is_empty();
    filter.model.resize_with(spectra.len(), Spectrum::default);
    filter.masked.resize_with(spectra.len(), Spectrum::default);
    filter.dual.resize_with(spectra.len(), Spectrum::default);
    let rate = if first { 1.0 } else { rate };
    let keep = 1.0 - rate;
    filter.energy.clear();
    filter.energy.resize(AREA, 0.0);
    for (m, x) in filter.model.iter_mut().zip(spectra) {
        let (m_re, m_im, x_re, x_im) = (&mut m.re[..], &mut m.im[..], &x.re[..], &x.im[..]);
        let e = &mut filter.energy[..AREA];
        for i in 0..AREA {
            m_re[i] = keep * m_re[i] + rate * x_re[i];
            m_im[i] = keep * m_im[i] + rate * x_im[i];
            e[i] += m_re[i] * m_re[i] + m_im[i] * m_im[i];
        }
    }
}
}

simd_kernel! {
fn solve_step(
    solver: &mut FilterSolver,
    filter: &mut CorrelationFilter,
    fourier: &mut Fourier,
    desired: &Spectrum,
    mask: &Map,
) {
    // A patch without any pattern has no energy, and the following divides by the energy.
    let mean = (filter.energy.iter().sum::<f32>() / AREA as f32).max(MIN_ENERGY);
    let (mu, lambda) = (MU_SHARE * mean, LAMBDA_SHARE * mean);
    solve_unconstrained(solver, filter, desired, mu);
    solve_masked(solver, filter, fourier, mask, mu / (mu + lambda));
}
}

/// q = x conj(y) + mu h - mu u; unconstrained = (q - x (x^H q) / (mu + S)) / mu
#[inline(always)]
fn solve_unconstrained(solver: &mut FilterSolver, filter: &CorrelationFilter, desired: &Spectrum, mu: f32) {
    solver.sum.re.fill(0.0);
    solver.sum.im.fill(0.0);
    let (y_re, y_im) = (&desired.re[..], &desired.im[..]);
    for (((x, g), h), u) in
        filter.model.iter().zip(&mut solver.unconstrained).zip(&filter.masked).zip(&filter.dual)
    {
        let (x_re, x_im, g_re, g_im) = (&x.re[..], &x.im[..], &mut g.re[..], &mut g.im[..]);
        let (h_re, h_im, u_re, u_im) = (&h.re[..], &h.im[..], &u.re[..], &u.im[..]);
        let (s_re, s_im) = (&mut solver.sum.re[..], &mut solver.sum.im[..]);
        for i in 0..AREA {
            let q_re = x_re[i] * y_re[i] + x_im[i] * y_im[i] + mu * (h_re[i] - u_re[i]);
            let q_im = x_im[i] * y_re[i] - x_re[i] * y_im[i] + mu * (h_im[i] - u_im[i]);
            g_re[i] = q_re;
            g_im[i] = q_im;
            s_re[i] += x_re[i] * q_re + x_im[i] * q_im;
            s_im[i] += x_re[i] * q_im - x_im[i] * q_re;
        }
    }
    for ((re, im), &e) in solver.sum.re.iter_mut().zip(solver.sum.im.iter_mut()).zip(&filter.energy) {
        let scale = 1.0 / (mu + e);
        *re *= scale;
        *im *= scale;
    }
    let scale = 1.0 / mu;
    for (x, g) in filter.model.iter().zip(&mut solver.unconstrained) {
        let (x_re, x_im, g_re, g_im) = (&x.re[..], &x.im[..], &mut g.re[..], &mut g.im[..]);
        let (s_re, s_im) = (&solver.sum.re[..], &solver.sum.im[..]);
        for i in 0..AREA {
            let re = x_re[i] * s_re[i] - x_im[i] * s_im[i];
            let im = x_re[i] * s_im[i] + x_im[i] * s_re[i];
            g_re[i] = (g_re[i] - re) * scale;
            g_im[i] = (g_im[i] - im) * scale;
        }
    }
}

/// h = mask . (unconstrained + u) mu / (mu + lambda); u += unconstrained - h. `shrink` is mu / (mu + lambda).
#[inline(always)]
fn solve_masked(
    solver: &FilterSolver,
    filter: &mut CorrelationFilter,
    fourier: &mut Fourier,
    mask: &Map,
    shrink: f32,
) {
    for pair in 0..filter.model.len() / 2 {
        for d in [2 * pair, 2 * pair + 1] {
            add(&solver.unconstrained[d], &mut filter.dual[d]);
        }
        let (first, second) = filter.kernel[2 * pair * AREA..(2 * pair + 2) * AREA].split_at_mut(AREA);
        let (Ok(first), Ok(second)) = (<&mut Map>::try_from(first), <&mut Map>::try_from(second)) else {
            return;
        };
        fourier.inverse_pair((&filter.dual[2 * pair], &filter.dual[2 * pair + 1]), (first, second));
        for i in 0..AREA {
            first[i] *= mask[i] * shrink;
            second[i] *= mask[i] * shrink;
        }
        let (a, b) = filter.masked.split_at_mut(2 * pair + 1);
        fourier.forward_pair((first, second), (&mut a[2 * pair], &mut b[0]));
        for d in [2 * pair, 2 * pair + 1] {
            subtract(&filter.masked[d], &mut filter.dual[d]);
        }
    }
}

simd_kernel! {
fn correlate(masked: &[Spectrum], spectra: &[Spectrum], out: &mut Spectrum) {
    out.re.fill(0.0);
    out.im.fill(0.0);
    let (o_re, o_im) = (&mut out.re[..], &mut out.im[..]);
    for (a, z) in masked.iter().zip(spectra) {
        let (a_re, a_im) = (&a.re[..], &a.im[..]);
        let (z_re, z_im) = (&z.re[..], &z.im[..]);
        for i in 0..AREA {
            o_re[i] += a_re[i] * z_re[i] + a_im[i] * z_im[i];
            o_im[i] += a_re[i] * z_im[i] - a_im[i] * z_re[i];
        }
    }
}
}

/// The mean over the frequencies, which is the inverse transform at shift zero.
fn response_in_the_middle(masked: &[Spectrum], spectra: &[Spectrum]) -> f32 {
    let mut sum = 0.0;
    for (a, z) in masked.iter().zip(spectra) {
        for i in 0..AREA {
            sum += a.re[i] * z.re[i] + a.im[i] * z.im[i];
        }
    }
    sum / AREA as f32
}

#[inline(always)]
fn add(from: &Spectrum, to: &mut Spectrum) {
    for (to, from) in to.re.iter_mut().zip(from.re.iter()) {
        *to += from;
    }
    for (to, from) in to.im.iter_mut().zip(from.im.iter()) {
        *to += from;
    }
}
#[inline(always)]
fn subtract(from: &Spectrum, to: &mut Spectrum) {
    for (to, from) in to.re.iter_mut().zip(from.re.iter()) {
        *to -= from;
    }
    for (to, from) in to.im.iter_mut().zip(from.im.iter()) {
        *to -= from;
    }
}

/// ADMM penalty mu, in mean energies of the model.
const MU_SHARE: f32 = 0.1;
/// Regularisation weight lambda, in mean energies of the model.
const LAMBDA_SHARE: f32 = 0.01;

/// Lower bound of the model's mean energy.
const MIN_ENERGY: f32 = 1.0e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fourier::SIDE;
    use crate::peak::{Peak, desired_response_spectrum};

    /// Smoothed noise, circularly shifted by cells right and down.
    fn patch(seed: u32, (right, down): (usize, usize)) -> Box<Map> {
        let mut state = seed;
        let raw: Vec<f32> = (0..AREA)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / 16_777_216.0 - 0.5
            })
            .collect();
        let mut map: Box<Map> = Box::new([0.0; AREA]);
        for (index, value) in map.iter_mut().enumerate() {
            let (row, column) = (index / SIDE + SIDE - down, index % SIDE + SIDE - right);
            for (r, c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                *value += raw[(row + r) % SIDE * SIDE + (column + c) % SIDE];
            }
        }
        map
    }

    fn spectra(fourier: &mut Fourier, shift: (usize, usize)) -> [Spectrum; 2] {
        let [mut first, mut second] = [Spectrum::default(), Spectrum::default()];
        fourier.forward_pair((&patch(1, shift), &patch(2, shift)), (&mut first, &mut second));
        [first, second]
    }

    /// 1 within `half` cells of the centre, else 0.
    fn mask(half: usize) -> Box<Map> {
        let mut mask: Box<Map> = Box::new([0.0; AREA]);
        let within = |k: usize| (SIDE / 2 - half..SIDE / 2 + half).contains(&k);
        for (index, value) in mask.iter_mut().enumerate() {
            *value = f32::from(u8::from(within(index / SIDE) && within(index % SIDE)));
        }
        mask
    }

    fn trained(fourier: &mut Fourier, half: usize) -> CorrelationFilter {
        let (mut filter, mut solver) = (CorrelationFilter::default(), FilterSolver::default());
        let desired = desired_response_spectrum(fourier, 1.0);
        let learned = spectra(fourier, (0, 0));
        filter.update_model(&learned, 1.0);
        for _ in 0..6 {
            solver.step(&mut filter, fourier, &desired, &mask(half));
        }
        filter
    }

    fn peak(fourier: &mut Fourier, filter: &CorrelationFilter, shift: (usize, usize)) -> Peak {
        let (mut response, mut map) = (Spectrum::default(), Box::new([0.0; AREA]));
        let moved = spectra(fourier, shift);
        filter.correlate(&moved, &mut response);
        fourier.inverse(&response, &mut map);
        Peak::find(&map)
    }

    #[test]
    fn a_learned_patch_responds_at_the_shift_by_which_it_was_moved() {
        let mut fourier = Fourier::new();
        let filter = trained(&mut fourier, 6);
        let unmoved = peak(&mut fourier, &filter, (0, 0));
        for (shift, expected) in [
            ((0, 0), (0.0, 0.0)),
            ((3, 0), (3.0, 0.0)),
            ((0, 5), (0.0, 5.0)),
            ((SIDE - 4, SIDE - 7), (-4.0, -7.0)),
            ((9, SIDE - 2), (9.0, -2.0)),
        ] {
            let peak = peak(&mut fourier, &filter, shift);
            // The parabola is biased by the noise around the peak; the cell must be right.
            assert!(
                (peak.right - expected.0).abs() < 0.25 && (peak.down - expected.1).abs() < 0.25,
                "{peak:?}"
            );
            // Measured 9.3 for this noise and mask; another patch gives 3.3.
            assert!(peak.peak_to_sidelobe_ratio > 8.0, "{peak:?}");
            // All shifts are circular, so that only the position differs.
            assert!((peak.height - unmoved.height).abs() < 1e-4, "{peak:?} and {unmoved:?}");
        }
    }

    #[test]
    fn another_patch_does_not_respond() {
        let mut fourier = Fourier::new();
        let filter = trained(&mut fourier, 6);
        let [mut first, mut second] = [Spectrum::default(), Spectrum::default()];
        fourier.forward_pair((&patch(8, (0, 0)), &patch(9, (0, 0))), (&mut first, &mut second));
        let (mut response, mut map) = (Spectrum::default(), Box::new([0.0; AREA]));
        filter.correlate(&[first, second], &mut response);
        fourier.inverse(&response, &mut map);
        let peak = Peak::find(&map);
        assert!(peak.peak_to_sidelobe_ratio < 6.0 && peak.height < 0.2, "{peak:?}");
    }

    #[test]
    fn the_kernel_is_confined_to_the_mask() {
        let mut fourier = Fourier::new();
        for half in [3, 8] {
            let filter = trained(&mut fourier, half);
            assert_eq!(filter.kernel().len(), 2 * AREA);
            for channel in filter.kernel().chunks_exact(AREA) {
                let mask = mask(half);
                let outside = channel.iter().zip(mask.iter()).filter(|(_, mask)| **mask == 0.0);
                assert!(outside.clone().count() > 0);
                assert!(outside.into_iter().all(|(value, _)| *value == 0.0));
                assert!(channel.iter().any(|&value| value != 0.0));
            }
        }
    }

    #[test]
    fn a_filter_forgets_at_its_rate() {
        let mut fourier = Fourier::new();
        let mut filter = trained(&mut fourier, 6);
        let before = filter.model[0].re[5];
        let [first, _] = spectra(&mut fourier, (7, 3));
        let new = first.re[5];
        filter.update_model(&[first.clone(), first], 0.25);
        assert!((filter.model[0].re[5] - (0.75 * before + 0.25 * new)).abs() < 1e-5);
    }
}
