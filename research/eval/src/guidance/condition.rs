//! The conditions in which the guidance laws are compared.

use anyhow::{Context, Result};
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_sim::Scenario;

/// One condition: a scenario, and what differs from the nominal case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Condition {
    pub(super) name: &'static str,
    /// The scenario whose water, wind and waves the trials have.
    pub(super) scenario: &'static str,
    /// Current in a direction drawn for each trial, m/s; `None`: that of the scenario.
    pub(super) current_m_per_s: Option<f64>,
    /// Ticks of 1/120 s from one video frame to the next.
    pub(super) ticks_per_frame: u64,
    pub(super) latency_s: f64,
    /// Height that the laws believe, over the true one.
    pub(super) height_factor: f64,
    /// Error of the tilt that the laws believe, degrees.
    pub(super) tilt_error_deg: f64,
    /// The boat's heading at the start lies within this of the direction to the target, degrees.
    pub(super) heading_spread_deg: f64,
    /// Standard deviation of the heading that the tracker gives our law, degrees; 0: it gives none.
    pub(super) heading_noise_deg: f64,
    /// How far people may be from where they are seen, as our law is told, metres: the waves carry them.
    pub(super) uncertainty_m: f64,
    /// Whether the destination is a person who drifts; else a place.
    pub(super) to_person: bool,
    /// Whether another person floats on the way; else two beside it.
    pub(super) person_on_way: bool,
}

/// What the laws know of the camera and see of the boat: the nominal condition.
const NOMINAL: Condition = Condition {
    name: "calm",
    scenario: "rescue",
    current_m_per_s: Some(0.0),
    ticks_per_frame: 8,
    latency_s: 0.25,
    height_factor: 1.0,
    tilt_error_deg: 0.0,
    heading_spread_deg: 30.0,
    heading_noise_deg: 0.0,
    uncertainty_m: 0.0,
    to_person: false,
    person_on_way: false,
};

const IN_CURRENT: Condition = Condition { name: "current 0.35", current_m_per_s: Some(0.35), ..NOMINAL };

/// All conditions, in the order of the table.
pub(super) const CONDITIONS: [Condition; 21] = [
    NOMINAL,
    IN_CURRENT,
    Condition { name: "surf", scenario: "rescue-surf", current_m_per_s: None, uncertainty_m: 0.5, ..NOMINAL },
    Condition { name: "current 0.7", current_m_per_s: Some(0.7), ..NOMINAL },
    Condition { name: "calm, 7.5 Hz", ticks_per_frame: 16, ..NOMINAL },
    Condition { name: "0.35, 7.5 Hz", ticks_per_frame: 16, ..IN_CURRENT },
    Condition { name: "0.35, height +20 %", height_factor: 1.2, ..IN_CURRENT },
    Condition { name: "0.35, height -20 %", height_factor: 0.8, ..IN_CURRENT },
    Condition { name: "0.35, tilt +5", tilt_error_deg: 5.0, ..IN_CURRENT },
    Condition { name: "0.35, tilt -5", tilt_error_deg: -5.0, ..IN_CURRENT },
    Condition { name: "0.35, 0.6 s", latency_s: 0.6, ..IN_CURRENT },
    Condition { name: "0.35, heading 45", heading_spread_deg: 45.0, ..IN_CURRENT },
    Condition { name: "0.35, any heading", heading_spread_deg: 180.0, ..IN_CURRENT },
    Condition { name: "person", to_person: true, ..NOMINAL },
    Condition { name: "person, 0.35", to_person: true, ..IN_CURRENT },
    Condition { name: "on the way", to_person: true, person_on_way: true, ..NOMINAL },
    Condition { name: "on the way, 0.35", to_person: true, person_on_way: true, ..IN_CURRENT },
    Condition {
        name: "on the way, surf",
        scenario: "rescue-surf",
        current_m_per_s: None,
        uncertainty_m: 0.5,
        to_person: true,
        person_on_way: true,
        ..NOMINAL
    },
    Condition {
        name: "on the way, heading",
        to_person: true,
        person_on_way: true,
        heading_noise_deg: 10.0,
        ..NOMINAL
    },
    Condition {
        name: "on the way, 0.35, heading",
        to_person: true,
        person_on_way: true,
        heading_noise_deg: 10.0,
        ..IN_CURRENT
    },
    Condition {
        name: "on the way, surf, heading",
        scenario: "rescue-surf",
        current_m_per_s: None,
        uncertainty_m: 0.5,
        heading_noise_deg: 10.0,
        to_person: true,
        person_on_way: true,
        ..NOMINAL
    },
];

impl Condition {
    /// The condition's name and settings, for a line above its rows.
    pub(super) fn describe(&self) -> String {
        let goal = match (self.to_person, self.person_on_way) {
            (false, _) => "to a place",
            (true, false) => "to a person who drifts",
            (true, true) => "to a person who drifts, another one on the way",
        };
        format!(
            "{}: {goal}, {} frames/s, {} s of latency{}",
            self.name,
            120.0 / self.ticks_per_frame as f64,
            self.latency_s,
            if self.heading_noise_deg > 0.0 { ", with the tracker's heading" } else { "" }
        )
    }

    /// The scenario, whose boat, current and people a trial replaces.
    ///
    /// # Errors
    /// If the scenario cannot be loaded.
    pub(super) fn scenario(&self) -> Result<Scenario> {
        let overrides =
            ScenarioOverrides { setting: Some("still".to_owned()), ..ScenarioOverrides::default() };
        Ok(scenario::load(self.scenario, &overrides).context("loading the scenario")?.scenario)
    }
}
