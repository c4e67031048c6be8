//! The conditions that laws are compared in, and trials of a law in them.

use anyhow::Result;
use barrelman_control::optimal::{OptimalLaw, Tuning};
use barrelman_control::{CentringGains, Law, MotorSchema};
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_simd::SimdLevel;
use barrelman_trial::metrics::TrialEntry;
use barrelman_vocab::VehicleProfile;

use super::lqg::Lqg;
use super::mpc::Mpc;
use crate::tracker::parallel;

/// A scenario with one of its settings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condition {
    pub(super) scenario: &'static str,
    pub(super) setting: &'static str,
}

const fn condition(scenario: &'static str, setting: &'static str) -> Condition {
    Condition { scenario, setting }
}

/// All of them.
pub(super) const CONDITIONS: [Condition; 10] = [
    condition("lab1", "still"),
    condition("lab1", "indoor"),
    condition("lab1", "windy"),
    condition("lab2", "still"),
    condition("lab2", "indoor"),
    condition("lab2", "windy"),
    condition("field1", "field"),
    condition("field2", "field"),
    condition("steep1", "field"),
    condition("steep2", "field"),
];

impl Condition {
    pub(super) fn name(&self) -> String {
        format!("{}-{}", self.scenario, self.setting)
    }

    /// Trials of it with a plant that is drawn for each.
    pub(super) fn plan(&self) -> Result<CampaignPlan> {
        self.plan_with(PlantName::Sampled)
    }

    /// The same with the scenario's plant.
    pub(super) fn nominal_plan(&self) -> Result<CampaignPlan> {
        self.plan_with(PlantName::Nominal)
    }

    fn plan_with(&self, plant: PlantName) -> Result<CampaignPlan> {
        let changes =
            ScenarioOverrides { setting: Some(self.setting.to_owned()), ..ScenarioOverrides::default() };
        CampaignPlan::new(&CampaignRequest {
            scenario: self.scenario.to_owned(),
            overrides: changes,
            law: LawChoice::MOTOR_SCHEMA,
            rate: None,
            perception: Perception::Truth,
            plant,
            simd: SimdLevel::Avx512,
        })
    }
}

/// A law under test.
#[derive(Debug, Clone, Copy)]
pub(super) enum Subject {
    Schema,
    Centre,
    Optimal(Tuning),
    /// Centring by a linear-quadratic regulator that weighs the squared rate with so much, s².
    Lqg(f64),
    /// Model predictive control with a soft ellipse.
    Mpc,
}

impl Subject {
    /// Whether its trials take many times as long as the others'.
    pub(super) const fn is_slow(&self) -> bool {
        matches!(self, Self::Mpc)
    }

    fn law(&self, profile: &VehicleProfile) -> Box<dyn Law> {
        match self {
            Self::Schema => Box::new(MotorSchema::new(profile.motor_schema_rates)),
            Self::Centre => Box::new(barrelman_control::centring::Centring::new(
                CentringGains::HAND_TUNED,
                profile.limits,
            )),
            Self::Optimal(tuning) => Box::new(OptimalLaw::with_tuning(*tuning, profile)),
            Self::Lqg(weight) => Box::new(Lqg::new(*weight, profile)),
            Self::Mpc => Box::new(Mpc::new(profile)),
        }
    }
}

/// Trials of a law, with these seeds.
pub(super) fn trials(
    plan: &CampaignPlan,
    subject: &Subject,
    first_seed: u64,
    seeds: u64,
) -> Result<Vec<TrialEntry>> {
    let jobs: Vec<u64> = (first_seed..first_seed + seeds).collect();
    parallel::map(&jobs, |seed| {
        let log = plan.simulate_with_law(Some(subject.law(plan.profile())), *seed, &mut ())?;
        Ok(plan.entry(*seed, &log))
    })
    .into_iter()
    .collect()
}
