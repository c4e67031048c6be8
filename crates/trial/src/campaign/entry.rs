//! What is kept of a simulated trial: one line of a campaign's file.

use serde::{Deserialize, Serialize};

use crate::behaviour::{BehaviourVersions, FIRST, VersionDifference};
use crate::metrics::TrialEntry;

/// The settings of a campaign: two trials with the same ones and the same seed are the same trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CampaignSettings {
    /// Name of the scenario.
    pub scenario: String,
    /// XXH3-64 of the scenario's file, in hexadecimal digits.
    pub scenario_hash: String,
    /// The law.
    pub law: String,
    /// Behaviour version of the law.
    #[serde(default = "first_version")]
    pub law_behaviour: u32,
    /// What the optimal law spares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
    /// The optimal law's horizon, seconds, where it was not the mode's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
    /// Rate of the schema, rad/s, where it was not the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_rad_per_s: Option<f64>,
    /// `truth` or `pixels`.
    pub perception: String,
    /// How the kite moves by itself.
    pub setting: String,
    /// `nominal` or `drawn`.
    pub plant: String,
    /// Sea state, where it was not the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sea_state: Option<u8>,
    /// Mean wind, m/s, where it was not the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind_m_per_s: Option<f64>,
    /// The boat's speed, m/s, where it was not the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boat_speed_m_per_s: Option<f64>,
    /// Size of the picture, where it was not the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
    /// The tracker, in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<String>,
    /// Behaviour version of the tracker, in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker_behaviour: Option<u32>,
    /// XXH3-64 of the inputs of the stored drive that the boat was steered by, in hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<String>,
    /// Version of the program.
    pub program: String,
}

const fn first_version() -> u32 {
    FIRST
}

impl CampaignSettings {
    /// The settings with what files of earlier programs leave out: the mode of the optimal law and the behaviour
    /// version of the tracker.
    #[must_use]
    pub fn completed(mut self) -> Self {
        if self.law == "optimal" {
            self.mode.get_or_insert_with(|| "minimum-energy".to_owned());
        }
        if self.tracker.is_some() {
            self.tracker_behaviour.get_or_insert(FIRST);
        }
        self
    }

    /// The behaviour versions of tracker and law.
    pub fn behaviour(&self) -> BehaviourVersions {
        BehaviourVersions { tracker: self.tracker_behaviour.unwrap_or(FIRST), law: self.law_behaviour }
    }

    /// How the behaviour versions differ from those of `other`, where both have the same tracker and the same law.
    pub fn version_difference(&self, other: &Self) -> Option<VersionDifference> {
        if (&self.tracker, &self.law) != (&other.tracker, &other.law) {
            return None;
        }
        let tracker = self.tracker.as_deref().unwrap_or_default();
        self.behaviour().difference(other.behaviour(), tracker, &self.law)
    }
}

/// One trial of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CampaignEntry {
    /// Its seed.
    pub seed: u64,
    /// Its name and metrics.
    #[serde(flatten)]
    pub trial: TrialEntry,
    /// What it was a trial of.
    pub campaign: CampaignSettings,
}
