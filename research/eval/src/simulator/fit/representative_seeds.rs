//! A few seeds whose trials represent all.

use barrelman_sim::pursuit::Pursuit;

/// All seeds are below this. The validation begins here.
const SEEDS_END: u64 = 10_000;
/// Multiples of the golden ratio's fractional part are evenly spread modulo 1.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// Seeds below [`SEEDS_END`]: one from each of `count` strata of equal probability by the target's speed,
/// chosen so that the times for which the target stands first are evenly spread, too.
pub(super) fn representative_seeds(count: u64) -> Vec<u64> {
    let mut by_speed: Vec<u64> = (1..SEEDS_END).collect();
    by_speed.sort_by(|a, b| Pursuit::sampled_pace(*a).0.total_cmp(&Pursuit::sampled_pace(*b).0));
    let size = by_speed.len() as f64 / count as f64;
    (0..count)
        .map(|stratum| {
            let first = (stratum as f64 * size) as usize;
            // A quantile that differs between all strata and is not correlated with the speed.
            let quantile = (stratum as f64 * GOLDEN_RATIO).fract();
            let middle = first + (0.5 * size) as usize;
            // The standing time is exponentially distributed.
            let distance = |seed: u64| ((1.0 - (-Pursuit::sampled_pace(seed).1).exp()) - quantile).abs();
            by_speed[first..]
                .iter()
                .take(size as usize)
                .copied()
                .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
                .unwrap_or(by_speed[middle])
        })
        .collect()
}
