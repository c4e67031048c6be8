//! What is required of our guidance law in each condition.

use super::condition::Condition;
use super::summary::{Ratios, arrivals, least_clearance, mean_of};
use super::trial::Outcome;

/// The requirements of a condition; `None`: the value is printed only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Requirements {
    /// Largest ratios of the means: cross-track error, time, rudder travel.
    ratios: Option<(f64, f64, f64)>,
    /// Largest mean cross-track error, metres.
    cross_track_m: Option<f64>,
    /// Least share of the trials that arrive.
    arrived: Option<f64>,
    /// Whether the distance to each person must stay above stand-off or keep-out.
    keeps_clear: bool,
}

impl Requirements {
    pub(super) fn of(condition: &Condition) -> Self {
        let is_compared = matches!(condition.name, "calm" | "current 0.35");
        let is_known = condition.height_factor == 1.0 && condition.tilt_error_deg == 0.0;
        Self {
            ratios: is_compared.then_some((0.5, 1.0, 0.6)),
            cross_track_m: is_compared.then_some(0.3),
            arrived: match condition.name {
                "surf" => Some(0.95),
                "calm" | "current 0.35" | "person" | "on the way" => Some(1.0),
                _ => None,
            },
            // With a wrong height or tilt, distances are wrong, too.
            keeps_clear: is_known,
        }
    }

    /// What is missed, in words.
    pub(super) fn missed(&self, ours: &[Outcome], ratios: &Ratios) -> Vec<String> {
        let mut missed = Vec::new();
        if let Some((cross_track, time, rudder)) = self.ratios {
            for (what, found, limit) in [
                ("cross-track ratio", ratios.cross_track, cross_track),
                ("time ratio", ratios.time, time),
                ("rudder ratio", ratios.rudder, rudder),
            ] {
                if found.is_none_or(|found| found.value > limit) {
                    missed.push(format!("{what} <= {limit}"));
                }
            }
        }
        if let Some(limit) = self.cross_track_m
            && mean_of(ours, |outcome| outcome.cross_track_m) > limit
        {
            missed.push(format!("cross-track error <= {limit} m"));
        }
        if let Some(share) = self.arrived
            && (arrivals(ours) as f64) < share * ours.len() as f64
        {
            missed.push(format!("arrival of {:.0} %", 100.0 * share));
        }
        if self.keeps_clear && least_clearance(ours) < 0.0 {
            missed.push("clearance >= 0 m".to_owned());
        }
        missed
    }
}
