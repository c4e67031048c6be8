//! The optimiser: the evolution strategy sep-CMA-ES, which adapts a variance for each parameter and a common
//! step size (Ros and Hansen, A simple modification in CMA-ES achieving linear time and space
//! complexity, 2008).

use barrelman_sim::noise;

use super::parameters::{PARAMETERS, UnitPoint};

/// Parameters.
const DIMENSIONS: usize = PARAMETERS.len();
/// Candidates of a generation, and how many of them are the parents of the next one.
pub(super) const CANDIDATES: usize = 16;
const PARENTS: usize = CANDIDATES / 2;
/// Seed of the random numbers.
const SEED: u64 = 7;
/// Random numbers reserved for a candidate.
const NUMBERS_OF_CANDIDATE: u64 = 64;

/// The state of a search.
pub(super) struct EvolutionStrategy {
    mean: UnitPoint,
    /// The common step size.
    step_size: f64,
    /// The standard deviation of each parameter, in steps.
    std_devs: UnitPoint,
    /// The evolution paths of the step size and of the variances.
    step_path: UnitPoint,
    variance_path: UnitPoint,
    /// Which random numbers the search uses.
    stream: u64,
    generation: u64,
}

impl EvolutionStrategy {
    /// Begins a search around a point. Each stream has random numbers of its own.
    pub(super) fn new(mean: UnitPoint, step_size: f64, stream: u64) -> Self {
        let zeros = [0.0; DIMENSIONS];
        Self {
            mean,
            step_size,
            std_devs: [1.0; DIMENSIONS],
            step_path: zeros,
            variance_path: zeros,
            stream,
            generation: 0,
        }
    }

    pub(super) const fn step_size(&self) -> f64 {
        self.step_size
    }

    /// The candidates of the current generation.
    pub(super) fn candidates(&self) -> Vec<UnitPoint> {
        (0..CANDIDATES as u64)
            .map(|candidate| {
                std::array::from_fn(|index| {
                    let number = (self.generation * CANDIDATES as u64 + candidate) * NUMBERS_OF_CANDIDATE
                        + index as u64;
                    let offset =
                        self.step_size * self.std_devs[index] * noise::normal(SEED, self.stream, number);
                    (self.mean[index] + offset).clamp(0.0, 1.0)
                })
            })
            .collect()
    }

    /// Advances to the next generation, from all candidates in the order of their misfits, the best first.
    pub(super) fn update(&mut self, best_first: &[UnitPoint]) {
        let n = DIMENSIONS as f64;
        let raw: [f64; PARENTS] =
            std::array::from_fn(|rank| (PARENTS as f64 + 0.5).ln() - (rank as f64 + 1.0).ln());
        let sum: f64 = raw.iter().sum();
        let weights = raw.map(|weight| weight / sum);
        let effective_parents = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        let step_rate = (effective_parents + 2.0) / (n + effective_parents + 3.0);
        let damping = 1.0 + 2.0 * ((effective_parents - 1.0) / (n + 1.0)).sqrt().max(1.0) - 2.0 + step_rate;
        let path_rate = 4.0 / (n + 4.0);
        // A diagonal has fewer values than a full covariance matrix: its learning rates are larger by this
        // factor.
        let separable = (n + 1.5) / 3.0;
        let rank_one_rate = (separable * 2.0 / ((n + 1.3).powi(2) + effective_parents)).min(0.5);
        let rank_mu_rate = (separable * 2.0 * (effective_parents - 2.0 + 1.0 / effective_parents)
            / ((n + 2.0).powi(2) + effective_parents))
            .min(0.4);
        let before = self.mean;
        for index in 0..DIMENSIONS {
            self.mean[index] =
                weights.iter().zip(best_first).map(|(weight, point)| weight * point[index]).sum();
            let moved = (self.mean[index] - before[index]) / (self.step_size * self.std_devs[index]);
            self.step_path[index] = (1.0 - step_rate) * self.step_path[index]
                + (step_rate * (2.0 - step_rate) * effective_parents).sqrt() * moved;
            let moved = moved * self.std_devs[index];
            self.variance_path[index] = (1.0 - path_rate) * self.variance_path[index]
                + (path_rate * (2.0 - path_rate) * effective_parents).sqrt() * moved;
            let spread: f64 = weights
                .iter()
                .zip(best_first)
                .map(|(weight, point)| weight * ((point[index] - before[index]) / self.step_size).powi(2))
                .sum();
            let variance = (1.0 - rank_one_rate - rank_mu_rate) * self.std_devs[index].powi(2)
                + rank_one_rate * self.variance_path[index].powi(2)
                + rank_mu_rate * spread;
            self.std_devs[index] = variance.max(1.0e-6).sqrt();
        }
        let length: f64 = self.step_path.iter().map(|value| value * value).sum::<f64>().sqrt();
        let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        self.step_size *= (step_rate / damping * (length / expected - 1.0)).exp();
        self.step_size = self.step_size.clamp(1.0e-3, 0.5);
        self.generation += 1;
    }
}
