//! The stored result of a simulated trial: one line of a campaign's file.

use serde::{Deserialize, Serialize};

use crate::metrics::TrialEntry;

/// The settings of a campaign. Two trials with equal settings and equal seeds have equal results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CampaignSettings {
    /// Name of the scenario.
    pub scenario: String,
    /// XXH3-64 of the scenario's file, in hexadecimal digits.
    pub scenario_hash: String,
    /// Name of the camera law.
    pub law: String,
    /// Mode of the optimal law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
    /// Horizon of the optimal law, s; `None`: the mode's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
    /// What the optimal law shows, where it is not the boat alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Camera rate of the motor schema, rad/s; `None`: the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_rad_per_s: Option<f64>,
    /// `truth` (simulated localisations) or `pixels` (rendered video frames).
    pub perception: String,
    /// Name of the kite's motion: `still` or another setting of the scenario.
    pub setting: String,
    /// Camera plant: `nominal`, or `drawn` (sampled for each seed).
    pub plant: String,
    /// Sea state; `None`: the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sea_state: Option<u8>,
    /// Mean wind, m/s; `None`: the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind_m_per_s: Option<f64>,
    /// Speed of the boat, m/s; `None`: the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boat_speed_m_per_s: Option<f64>,
    /// Size of the picture, `WIDTHxHEIGHT`; `None`: the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<String>,
    /// Name of the tracker, where the perception is `pixels`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<String>,
    /// The law that guides the boat to a person: `los` or `lab`; `None`: the scenario's helmsman steers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guidance: Option<String>,
    /// Water current, m/s; `None`: the scenario's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_m_per_s: Option<f64>,
    /// XXH3-64 of the requests of the stored drive that steered the boat, in hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<String>,
    /// Version of the program and hash of its executable.
    pub program: String,
}

/// One trial of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CampaignEntry {
    /// Seed of the trial.
    pub seed: u64,
    /// Name and metrics of the trial.
    #[serde(flatten)]
    pub trial: TrialEntry,
    /// Settings of the campaign.
    pub campaign: CampaignSettings,
}
