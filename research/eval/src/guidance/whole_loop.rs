//! The laws in the whole loop: a swaying kite whose camera follows the boat, the pilot with its marks and its
//! gate, and a simulated operator who marks the people and moves the marks.
//!
//! Localisations are the truth with noise. The camera law is the default. The laboratory's law computes 7.5
//! steps a second, ours one for each video frame.

use std::time::Duration;

use anyhow::{Context, Result};
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_simd::SimdLevel;
use barrelman_trial::campaign::ReportErrors;
use barrelman_trial::campaign::statistics::Interval;
use barrelman_trial::metrics::GuidanceMetrics;
use barrelman_vocab::{Angle, VesselProfile};

use super::summary::{ratio_cell, ratio_of_means};
use crate::output::print_line;
use crate::parallel;
use crate::statistics::mean;

/// What differs from the scenario.
#[derive(Debug, Clone, Copy)]
pub(super) struct Condition {
    name: &'static str,
    scenario: &'static str,
    pictures_per_second: u32,
    /// Along x; `None`: that of the scenario.
    current_m_per_s: Option<f64>,
    /// Of the video; `None`: that of the scenario.
    latency_s: Option<f64>,
    report_errors: ReportErrors,
    /// Least number of arrivals of 60 that is required.
    arrivals_of_60: Option<usize>,
    /// Whether every person's stand-off must be kept.
    keeps_clear: bool,
}

const CALM: Condition = Condition {
    name: "calm",
    scenario: "rescue",
    pictures_per_second: 15,
    current_m_per_s: None,
    latency_s: None,
    report_errors: ReportErrors::NONE,
    arrivals_of_60: Some(60),
    keeps_clear: true,
};
const IN_CURRENT: Condition = Condition {
    name: "current 0.35",
    scenario: "rescue-current",
    current_m_per_s: Some(0.35),
    arrivals_of_60: None,
    ..CALM
};
/// Printed only.
const VARIED: Condition = Condition { keeps_clear: false, ..IN_CURRENT };

const fn off(height_factor: f64, tilt_deg: f64) -> ReportErrors {
    ReportErrors { height_factor, tilt: Angle::from_degrees(tilt_deg), ..ReportErrors::NONE }
}

/// All conditions, in the order of the table.
pub(super) const CONDITIONS: [Condition; 10] = [
    CALM,
    IN_CURRENT,
    Condition { name: "surf", scenario: "rescue-surf", arrivals_of_60: Some(57), ..CALM },
    // The nearest rate to the laboratory's 7.5 that the simulator's ticks allow in whole pictures per second.
    Condition { name: "0.35, 8 frames/s", pictures_per_second: 8, ..VARIED },
    Condition { name: "current 0.7", current_m_per_s: Some(0.7), ..VARIED },
    Condition { name: "0.35, height +20 %", report_errors: off(1.2, 0.0), ..VARIED },
    Condition { name: "0.35, height -20 %", report_errors: off(0.8, 0.0), ..VARIED },
    Condition { name: "0.35, tilt +5", report_errors: off(1.0, 5.0), ..VARIED },
    Condition { name: "0.35, tilt -5", report_errors: off(1.0, -5.0), ..VARIED },
    Condition { name: "0.35, 0.6 s", latency_s: Some(0.6), ..VARIED },
];

impl Condition {
    pub(super) const fn name(&self) -> &'static str {
        self.name
    }

    fn plan(&self, guidance: GuidanceLaw) -> Result<CampaignPlan> {
        let plan = CampaignPlan::new(&CampaignRequest {
            scenario: self.scenario.to_owned(),
            overrides: ScenarioOverrides::default(),
            law: LawChoice::OPTIMAL,
            rate: None,
            guidance: Some(guidance),
            perception: Perception::Truth,
            plant: PlantName::Nominal,
            simd: SimdLevel::Avx512,
        })
        .with_context(|| format!("planning {}", self.name))?;
        Ok(plan
            .with_report_errors(self.report_errors)
            .with_changed_scenario(|world| {
                world.camera.pictures_per_second = self.pictures_per_second;
                if let Some(latency_s) = self.latency_s {
                    world.camera.video.latency_s = latency_s;
                }
                if let (Some(current), Some(water)) = (self.current_m_per_s, &mut world.water) {
                    water.current_m_per_s = (current, 0.0);
                }
            })
            .with_changed_profile(|profile| {
                if let Some(latency_s) = self.latency_s {
                    profile.video_latency = Duration::from_secs_f64(latency_s);
                }
            }))
    }

    fn trials(&self, guidance: GuidanceLaw, seeds: &[u64]) -> Result<Vec<GuidanceMetrics>> {
        let plan = self.plan(guidance)?;
        parallel::map(seeds, |seed| {
            let log = plan.simulate(*seed, &mut ())?;
            plan.entry(*seed, &log).metrics.guidance.context("the trial measured no guidance")
        })
        .into_iter()
        .collect()
    }

    /// What our law misses, in words.
    fn missed(&self, ours: &[GuidanceMetrics]) -> Vec<String> {
        let mut missed = Vec::new();
        if let Some(of_60) = self.arrivals_of_60
            && 60 * arrivals(ours) < of_60 * ours.len()
        {
            missed.push(format!("{of_60} of 60 arrive"));
        }
        if self.keeps_clear && too_close(ours) > 0 {
            missed.push(format!("nobody within {} m", VesselProfile::SIMULATOR.stand_off_m));
        }
        missed
    }
}

/// Prints the rows of a condition. Returns whether our law meets what is required.
///
/// # Errors
/// If a trial cannot be simulated.
pub(super) fn compare(condition: &Condition, seeds: &[u64]) -> Result<bool> {
    let lab = condition.trials(GuidanceLaw::Laboratory, seeds)?;
    let ours = condition.trials(GuidanceLaw::LineOfSight, seeds)?;
    print_line(&row("lab", &lab));
    let missed = condition.missed(&ours);
    print_line(&format!(
        "{}   time {}  off line {}  rudder {}{}",
        row("ours", &ours),
        ratio_cell(ratio(&lab, &ours, |trial| trial.time_to_circle_s)),
        ratio_cell(ratio(&lab, &ours, |trial| trial.cross_track_m)),
        ratio_cell(ratio(&lab, &ours, |trial| trial.rudder_travel)),
        missed.iter().map(|what| format!("  MISSED: {what}")).collect::<String>(),
    ));
    Ok(missed.is_empty())
}

fn row(law: &str, trials: &[GuidanceMetrics]) -> String {
    let mean_of = |value: fn(&GuidanceMetrics) -> Option<f64>| {
        mean(&trials.iter().filter_map(value).collect::<Vec<f64>>())
    };
    format!(
        "{law:5} {:>7}  {:>6.1}  {:>10.2}  {:>6.1}  {:>8.2}  {:>5}  {:>7.0} %",
        format!("{}/{}", arrivals(trials), trials.len()),
        mean_of(|trial| trial.time_to_circle_s),
        mean_of(|trial| trial.cross_track_m),
        mean_of(|trial| trial.rudder_travel),
        trials.iter().filter_map(|trial| trial.closest_person_m).fold(f64::INFINITY, f64::min),
        too_close(trials),
        100.0 * mean_of(|trial| trial.both_in_view),
    )
}

/// The line above the rows.
pub(super) const HEADER: &str = "law   arrived  time s  off line m  rudder  least m  < 2 m  in view   ratios to the \
                                 lab's law, 95 %";

fn arrivals(trials: &[GuidanceMetrics]) -> usize {
    trials.iter().filter(|trial| trial.arrived).count()
}

/// Trials in which the boat came closer to a person than the stand-off.
fn too_close(trials: &[GuidanceMetrics]) -> usize {
    let stand_off_m = VesselProfile::SIMULATOR.stand_off_m;
    trials.iter().filter_map(|trial| trial.closest_person_m).filter(|closest| *closest < stand_off_m).count()
}

/// The ratio of the means of a value over the trials that have it under both laws.
fn ratio(
    lab: &[GuidanceMetrics],
    ours: &[GuidanceMetrics],
    value: fn(&GuidanceMetrics) -> Option<f64>,
) -> Option<Interval> {
    let pairs: Vec<(f64, f64)> =
        lab.iter().zip(ours).filter_map(|(lab, ours)| value(lab).zip(value(ours))).collect();
    ratio_of_means(&pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_condition_changes_what_its_name_says() {
        let plan = |condition: &Condition| condition.plan(GuidanceLaw::LineOfSight).unwrap();
        let (calm, late) = (plan(&CONDITIONS[0]), plan(&CONDITIONS[9]));
        assert_eq!(calm.scenario().camera.pictures_per_second, 15);
        assert_eq!(late.scenario().camera.video.latency_s, 0.6);
        assert_eq!(late.profile().video_latency, Duration::from_millis(600));
        let strong = plan(&CONDITIONS[4]);
        assert_eq!(strong.scenario().water.as_ref().unwrap().current_m_per_s, (0.7, 0.0));
    }

    #[test]
    fn what_is_missed_is_told() {
        let trial = GuidanceMetrics {
            arrived: true,
            closest_person_m: Some(2.5),
            time_to_circle_s: Some(10.0),
            ..GuidanceMetrics::default()
        };
        let too_close = GuidanceMetrics { closest_person_m: Some(1.9), ..trial };
        let never = GuidanceMetrics { arrived: false, time_to_circle_s: None, ..trial };
        assert!(CALM.missed(&[trial, trial]).is_empty());
        assert_eq!(CALM.missed(&[trial, too_close]), ["nobody within 2 m"]);
        assert_eq!(CALM.missed(&[trial, never]), ["60 of 60 arrive"]);
        assert!(VARIED.missed(&[too_close, never]).is_empty());
        let half = GuidanceMetrics { time_to_circle_s: Some(5.0), ..trial };
        let found =
            ratio(&[trial, trial, never], &[half, half, half], |trial| trial.time_to_circle_s).unwrap();
        assert_eq!((found.value, found.low, found.high), (0.5, 0.5, 0.5));
    }
}
