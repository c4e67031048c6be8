//! The laws that are compared, and their trials.

use std::ops::Range;

use anyhow::Result;
use barrelman_control::optimal::{OptimalLaw, OptimalSettings};
use barrelman_control::{CentringGains, Law, MotorSchema};
use barrelman_experiments::campaign::plan::CampaignPlan;
use barrelman_trial::metrics::TrialEntry;
use barrelman_vocab::OptimalMode;
use barrelman_vocab::VehicleProfile;

use super::achieved_motion;
use super::assumed_latency::AssumedLatency;
use super::lqg::Lqg;
use super::mpc::Mpc;
use crate::parallel;

/// A law under test.
#[derive(Debug, Clone, Copy)]
pub(super) enum LawUnderTest {
    MotorSchema,
    Centring,
    Optimal(OptimalMode),
    /// The same, with pictures that are taken to arrive this long after their capture, seconds, whatever the
    /// truth is.
    OptimalWithAssumedLatency(OptimalMode, f64),
    /// A linear-quadratic regulator with this weight of the squared rate, s².
    Lqg(f64),
    /// Model predictive control with a soft ellipse.
    Mpc,
}

impl LawUnderTest {
    /// Whether its trials take many times as long as those of the other laws.
    pub(super) const fn is_slow(&self) -> bool {
        matches!(self, Self::Mpc)
    }

    /// The law for a vehicle.
    pub(super) fn build(&self, profile: &VehicleProfile) -> Box<dyn Law> {
        match self {
            Self::MotorSchema => Box::new(MotorSchema::new(profile.motor_schema_rates)),
            Self::Centring => Box::new(barrelman_control::centring::Centring::new(
                CentringGains::HAND_TUNED,
                profile.limits,
            )),
            Self::Optimal(mode) => Box::new(optimal(*mode, profile)),
            Self::OptimalWithAssumedLatency(mode, latency_s) => {
                Box::new(AssumedLatency::new(optimal(*mode, profile), *latency_s))
            }
            Self::Lqg(weight) => Box::new(Lqg::new(*weight, profile)),
            Self::Mpc => Box::new(Mpc::new(profile)),
        }
    }

    /// Simulates a trial for each seed.
    ///
    /// # Errors
    /// If a trial cannot be simulated.
    pub(super) fn simulate(&self, plan: &CampaignPlan, seeds: Range<u64>) -> Result<Vec<TrialEntry>> {
        Ok(self.simulate_with_motion(plan, seeds)?.0)
    }

    /// Simulates a trial for each seed. The second list has the same trials, with the achieved rates in the
    /// place of the commands.
    ///
    /// # Errors
    /// If a trial cannot be simulated.
    pub(super) fn simulate_with_motion(
        &self,
        plan: &CampaignPlan,
        seeds: Range<u64>,
    ) -> Result<(Vec<TrialEntry>, Vec<TrialEntry>)> {
        let seeds: Vec<u64> = seeds.collect();
        parallel::map(&seeds, |seed| {
            let log = plan.simulate_with_law(Some(self.build(plan.profile())), *seed, &mut ())?;
            Ok((plan.entry(*seed, &log), plan.entry(*seed, &achieved_motion::as_commands(&log))))
        })
        .into_iter()
        .collect::<Result<Vec<_>>>()
        .map(|pairs| pairs.into_iter().unzip())
    }
}

fn optimal(mode: OptimalMode, profile: &VehicleProfile) -> OptimalLaw {
    OptimalLaw::new(&OptimalSettings::new(mode), profile)
}
