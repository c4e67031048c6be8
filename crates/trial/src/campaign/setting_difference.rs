//! How the settings of two campaigns differ: in the world, or in what the campaigns are there to compare.

use serde::Serialize;

use super::entry::CampaignSettings;

/// A setting that differs between two campaigns.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SettingDifference {
    /// Name of the setting: the option's, where it has one.
    pub setting: &'static str,
    /// Its value in the first campaign, in words.
    pub first: String,
    /// Its value in the second campaign, in words.
    pub second: String,
}

/// A setting: its name, and its value in words.
type Setting = (&'static str, fn(&CampaignSettings) -> String);

/// Settings of the world and of the figures. Trials of the same seed are a pair only where these are equal.
const WORLD: [Setting; 11] = [
    ("scenario", |settings| settings.scenario.clone()),
    ("scenario file (hash)", |settings| settings.scenario_hash.clone()),
    ("perception", |settings| settings.perception.clone()),
    ("setting", |settings| settings.setting.clone()),
    ("plant", |settings| settings.plant.clone()),
    ("sea state", |settings| or_the_scenarios(settings.sea_state.map(|state| state.to_string()))),
    ("wind", |settings| or_the_scenarios(settings.wind_m_per_s.map(|wind| format!("{wind} m/s")))),
    ("boat speed", |settings| {
        or_the_scenarios(settings.boat_speed_m_per_s.map(|speed| format!("{speed} m/s")))
    }),
    ("current", |settings| {
        or_the_scenarios(settings.current_m_per_s.map(|current| format!("{current} m/s")))
    }),
    ("size", |settings| or_the_scenarios(settings.size.clone())),
    ("drive", |settings| settings.drive.clone().unwrap_or_else(|| "none".to_owned())),
];

/// Settings that a comparison may be about.
const CHOICES: [Setting; 8] = [
    ("law", |settings| settings.law.clone()),
    ("mode", |settings| settings.mode.clone().unwrap_or_else(|| "none".to_owned())),
    ("horizon", |settings| {
        settings.horizon_s.map_or_else(|| "default".to_owned(), |horizon| format!("{horizon} s"))
    }),
    ("frame", |settings| settings.frame.clone().unwrap_or_else(|| "boat".to_owned())),
    ("guidance", |settings| settings.guidance.clone().unwrap_or_else(|| "none".to_owned())),
    ("rate", |settings| {
        settings.rate_rad_per_s.map_or_else(|| "the vehicle's".to_owned(), |rate| format!("{rate} rad/s"))
    }),
    ("tracker", |settings| settings.tracker.clone().unwrap_or_else(|| "none".to_owned())),
    ("program", |settings| settings.program.clone()),
];

fn or_the_scenarios(value: Option<String>) -> String {
    value.unwrap_or_else(|| "the scenario's".to_owned())
}

impl CampaignSettings {
    /// How the world, or the kind of figures, differs from that of `other`: where it does, a difference
    /// between their trials tells nothing about laws or trackers.
    pub fn world_differences(&self, other: &Self) -> Vec<SettingDifference> {
        differences(&WORLD, self, other)
    }

    /// How the choices differ that a comparison may be about: law, tracker, program.
    pub fn choice_differences(&self, other: &Self) -> Vec<SettingDifference> {
        differences(&CHOICES, self, other)
    }
}

fn differences(
    settings: &[Setting],
    first: &CampaignSettings,
    second: &CampaignSettings,
) -> Vec<SettingDifference> {
    let values = settings.iter().map(|(setting, value)| (*setting, value(first), value(second)));
    values
        .filter(|(_, first, second)| first != second)
        .map(|(setting, first, second)| SettingDifference { setting, first, second })
        .collect()
}
