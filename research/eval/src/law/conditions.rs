//! The conditions that laws are compared in: scenarios, each with one of its settings.

use anyhow::Result;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_simd::SimdLevel;

/// A scenario with one of its settings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Condition {
    pub(crate) scenario: &'static str,
    pub(crate) setting: &'static str,
}

const fn condition(scenario: &'static str, setting: &'static str) -> Condition {
    Condition { scenario, setting }
}

/// All conditions, in the order of the tables.
pub(crate) const CONDITIONS: [Condition; 14] = [
    condition("lab1", "still"),
    condition("lab1", "indoor"),
    condition("lab1", "windy"),
    condition("lab2", "still"),
    condition("lab2", "indoor"),
    condition("lab2", "windy"),
    condition("field1", "still"),
    condition("field1", "field"),
    condition("field2", "still"),
    condition("field2", "field"),
    condition("steep1", "still"),
    condition("steep1", "field"),
    condition("steep2", "still"),
    condition("steep2", "field"),
];

impl Condition {
    pub(crate) fn name(&self) -> String {
        format!("{}-{}", self.scenario, self.setting)
    }

    /// Whether the scenario is one of the laboratory.
    pub(super) fn is_laboratory(&self) -> bool {
        self.scenario.starts_with("lab")
    }

    /// Trials whose plant is sampled for each trial.
    ///
    /// # Errors
    /// If the scenario cannot be loaded.
    pub(super) fn plan(&self) -> Result<CampaignPlan> {
        self.plan_with(PlantName::Sampled)
    }

    /// Trials with the scenario's nominal plant.
    ///
    /// # Errors
    /// If the scenario cannot be loaded.
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
            guidance: None,
            perception: Perception::Truth,
            plant,
            simd: SimdLevel::Avx512,
        })
    }
}
