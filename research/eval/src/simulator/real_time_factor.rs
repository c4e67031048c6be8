//! The table `pace`: how much faster than real time trials run on one thread, perceived by truth.

use std::time::Instant;

use anyhow::Result;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_simd::SimdLevel;

use super::options::Options;
use crate::output::print_line;

/// Duration of the trials on the water, seconds.
const WATER_TRIAL_S: f64 = 60.0;

/// Prints the table.
pub(super) fn run(options: &Options) -> Result<()> {
    print_line(&format!(
        "\n{:10} {:>8} {:>14} {:>10} {:>20}",
        "", "trials", "simulated, s", "took, s", "times real time"
    ));
    // A trial on the water takes longer to simulate: a tenth of the seeds is enough.
    for (name, divisor) in [("lab1", 1), ("sea3", 10)] {
        let plan = CampaignPlan::new(&CampaignRequest {
            scenario: name.to_owned(),
            overrides: ScenarioOverrides::default(),
            law: LawChoice::MOTOR_SCHEMA,
            rate: None,
            guidance: None,
            perception: Perception::Truth,
            plant: PlantName::Nominal,
            simd: SimdLevel::Avx512,
        })?;
        let plan = if name == "lab1" { plan } else { plan.with_max_duration(WATER_TRIAL_S) };
        let trials = (options.seeds / divisor).max(1);
        let mut simulated_s = 0.0;
        let started = Instant::now();
        for seed in options.first_seed..options.first_seed + trials {
            simulated_s += plan.simulate(seed, &mut ())?.duration_s();
        }
        let elapsed_s = started.elapsed().as_secs_f64();
        print_line(&format!(
            "{name:10} {trials:>8} {simulated_s:>14.0} {elapsed_s:>10.2} {:>20.0}",
            simulated_s / elapsed_s
        ));
    }
    Ok(())
}
