//! What speed of the boat the laws can hold: the share of trials in which it is never lost, over its speed.

use anyhow::{Result, bail};
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::{LawChoice, LawName};
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_sim::scenario::TargetScript;
use barrelman_simd::SimdLevel;
use barrelman_trial::metrics::TrialMetrics;

use super::Options;
use crate::say;
use crate::svg::{self, Svg};

/// Speeds that the helmsman is asked for, m/s. In turns he is slower.
const SPEEDS: [f64; 8] = [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
const LAWS: [(LawName, &str); 2] = [(LawName::MotorSchema, "schema"), (LawName::Optimal, "minimum-energy")];
const ARENAS: [&str; 2] = ["arena1", "arena2"];

/// Prints the table, and draws the curves to `target/acceptance/speed.svg` in the workspace.
pub(super) fn run(options: &Options) -> Result<()> {
    let mut curves = Vec::new();
    for arena in ARENAS {
        for (law, name) in LAWS {
            say(&format!(
                "\n{arena}, {name}, all of the boat's throttle: {} trials by truth, seeds from {} on",
                options.seeds, options.first_seed
            ));
            say(&format!(
                "{:>12} {:>14} {:>16} {:>12} {:>10}",
                "speed, m/s", "not lost, %", "outside, s", "trial, s", "max P"
            ));
            let mut curve = Vec::new();
            for speed in SPEEDS {
                let plan = plan(arena, law, speed)?;
                let metrics: Vec<TrialMetrics> = (options.first_seed..options.first_seed + options.seeds)
                    .map(|seed| Ok(plan.entry(seed, &plan.simulate(seed, &mut ())?).metrics))
                    .collect::<Result<_>>()?;
                let mean =
                    |of: fn(&TrialMetrics) -> f64| metrics.iter().map(of).sum::<f64>() / metrics.len() as f64;
                let held = mean(|m| f64::from(u8::from(m.lost == Some(false))));
                curve.push((speed, held));
                say(&format!(
                    "{speed:>12.1} {:>14.1} {:>16.2} {:>12.1} {:>10.2}",
                    100.0 * held,
                    mean(|m| m.time_outside_s),
                    mean(|m| m.duration_s),
                    mean(|m| m.max_p.unwrap_or(0.0)),
                ));
            }
            curves.push(curve);
        }
    }
    svg::keep("speed.svg", &drawn(&curves))
}

fn plan(arena: &str, law: LawName, speed: f64) -> Result<CampaignPlan> {
    let plan = CampaignPlan::new(&CampaignRequest {
        scenario: arena.to_owned(),
        overrides: ScenarioOverrides { boat_speed_m_per_s: Some(speed), ..ScenarioOverrides::default() },
        law: LawChoice::new(law),
        rate: None,
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    })?;
    let TargetScript::Boat(_) = plan.scenario().target else { bail!("{arena} has no boat") };
    Ok(plan.with_changed_scenario(|world| {
        if let TargetScript::Boat(script) = &mut world.target {
            script.max_throttle = 1.0;
        }
    }))
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 330.0;
const TOP: f64 = 50.0;
const BOTTOM: f64 = 270.0;
const SIDE: f64 = 250.0;
const LEFTS: [f64; 2] = [60.0, 370.0];

/// Both arenas beside each other; in each the curves of both laws.
fn drawn(curves: &[Vec<(f64, f64)>]) -> String {
    let most = SPEEDS.into_iter().fold(0.0, f64::max);
    let mut out = Svg::of(WIDTH, HEIGHT);
    for ((left, arena), curves) in LEFTS.into_iter().zip(ARENAS).zip(curves.chunks(LAWS.len())) {
        let at = |(speed, held): (f64, f64)| [left + SIDE * speed / most, BOTTOM - (BOTTOM - TOP) * held];
        for step in 0..=4_u8 {
            let (share, speed) = (f64::from(step) / 4.0, 2.0 * f64::from(step));
            let ([x, _], [_, y]) = (at((speed, 0.0)), at((0.0, share)));
            out.line("grid", [left, y, left + SIDE, y]);
            out.line("grid", [x, TOP, x, BOTTOM]);
            out.text("end", [left - 6.0, y + 4.0], &format!("{:.0} %", 100.0 * share));
            out.text("middle", [x, BOTTOM + 18.0], &format!("{speed:.0}"));
        }
        let classes = [("curve", "mark"), ("other", "other-mark")];
        for (curve, (line, mark)) in curves.iter().zip(classes) {
            let points: Vec<[f64; 2]> = curve.iter().map(|point| at(*point)).collect();
            out.polyline(line, &points);
            points.into_iter().for_each(|point| out.circle(mark, point));
        }
        out.rectangle("axis", [left, TOP, SIDE, BOTTOM - TOP]);
        out.text("middle", [left + SIDE / 2.0, TOP - 10.0], arena);
        out.text("middle", [left + SIDE / 2.0, BOTTOM + 40.0], "speed of the boat, m/s");
    }
    out.text(
        "middle",
        [WIDTH / 2.0, 20.0],
        "Trials in which the boat is not lost: schema (blue), minimum-energy (brown)",
    );
    out.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_arena_has_the_curve_of_every_law() {
        let curve: Vec<(f64, f64)> = SPEEDS.iter().map(|speed| (*speed, 1.0)).collect();
        let svg = drawn(&vec![curve; ARENAS.len() * LAWS.len()]);
        assert_eq!(svg.matches("<polyline").count(), 4);
        assert_eq!(svg.matches("<circle").count(), 4 * SPEEDS.len());
        assert!(svg.trim_end().ends_with("</svg>"));
    }
}
