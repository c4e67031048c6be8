//! How much faster than real time trials run that are perceived by truth, on one thread.

use std::time::Instant;

use anyhow::Result;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_simd::SimdLevel;

use super::Options;
use crate::say;

/// Trials of the scenarios on the water last so long, seconds.
const LASTING_S: f64 = 60.0;

/// Prints the table.
pub(super) fn run(options: &Options) -> Result<()> {
    say(&format!(
        "\n{:10} {:>8} {:>14} {:>10} {:>20}",
        "", "trials", "simulated, s", "took, s", "times real time"
    ));
    for (name, share) in [("lab1", 1), ("sea3", 10)] {
        let plan = CampaignPlan::new(&CampaignRequest {
            scenario: name.to_owned(),
            overrides: ScenarioOverrides::default(),
            law: LawChoice::MOTOR_SCHEMA,
            rate: None,
            perception: Perception::Truth,
            plant: PlantName::Nominal,
            simd: SimdLevel::Avx512,
        })?;
        let plan = if name == "lab1" { plan } else { plan.with_max_duration(LASTING_S) };
        let trials = (options.seeds / share).max(1);
        let mut simulated_s = 0.0;
        let began = Instant::now();
        for seed in options.first_seed..options.first_seed + trials {
            simulated_s += plan.simulate(seed, &mut ())?.duration_s();
        }
        let took_s = began.elapsed().as_secs_f64();
        say(&format!(
            "{name:10} {trials:>8} {simulated_s:>14.0} {took_s:>10.2} {:>20.0}",
            simulated_s / took_s
        ));
    }
    Ok(())
}
