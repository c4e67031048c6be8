//! The table `speed`: up to what speed of the boat the laws hold the target, measured by the share of trials
//! in which the target is never lost. Trials are perceived by truth, with the boat's full throttle. Nothing
//! is judged.

use anyhow::{Result, bail};
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_sim::scenario::TargetScript;
use barrelman_simd::SimdLevel;
use barrelman_trial::metrics::TrialMetrics;
use barrelman_vocab::LawId;

use super::options::Options;
use crate::output::print_line;
use crate::svg::{self, Svg};

/// Speeds that the helmsman is asked to hold, m/s. In turns the helmsman goes slower.
const SPEEDS: [f64; 8] = [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];
const LAWS: [(LawChoice, &str); 2] =
    [(LawChoice::MOTOR_SCHEMA, "schema"), (LawChoice::of(LawId::MinimumEnergy), "minimum-energy")];
const ARENAS: [&str; 2] = ["arena1", "arena2"];

/// A point of a curve: the boat's speed, m/s, and the share of trials in which the boat is never lost.
type CurvePoint = (f64, f64);

/// Prints the table, and plots the curves to `target/acceptance/speed.svg` in the workspace.
pub(super) fn run(options: &Options) -> Result<()> {
    let mut curves = Vec::new();
    for arena in ARENAS {
        for (law, name) in LAWS {
            print_line(&format!(
                "\n{arena}, {name}, all of the boat's throttle: {} trials by truth, seeds from {} on",
                options.seeds, options.first_seed
            ));
            print_line(&format!(
                "{:>12} {:>14} {:>16} {:>12} {:>10}",
                "speed, m/s", "not lost, %", "outside, s", "trial, s", "max P"
            ));
            let curve: Vec<CurvePoint> = SPEEDS
                .into_iter()
                .map(|speed| print_row(&plan(arena, law, speed)?, speed, options))
                .collect::<Result<_>>()?;
            curves.push(curve);
        }
    }
    svg::save_plot("speed.svg", &plot(&curves))
}

/// Simulates the trials of a plan, prints the row and returns the point of the curve.
fn print_row(plan: &CampaignPlan, speed: f64, options: &Options) -> Result<CurvePoint> {
    let metrics: Vec<TrialMetrics> = options
        .seed_range()
        .map(|seed| Ok(plan.entry(seed, &plan.simulate(seed, &mut ())?).metrics))
        .collect::<Result<_>>()?;
    let mean =
        |value: fn(&TrialMetrics) -> f64| metrics.iter().map(value).sum::<f64>() / metrics.len() as f64;
    let share_not_lost = mean(|m| f64::from(u8::from(m.lost == Some(false))));
    print_line(&format!(
        "{speed:>12.1} {:>14.1} {:>16.2} {:>12.1} {:>10.2}",
        100.0 * share_not_lost,
        mean(|m| m.time_outside_s),
        mean(|m| m.duration_s),
        mean(|m| m.max_p.unwrap_or(0.0)),
    ));
    Ok((speed, share_not_lost))
}

/// Trials in an arena whose boat is asked to hold a speed, m/s, with full throttle.
fn plan(arena: &str, law: LawChoice, speed: f64) -> Result<CampaignPlan> {
    let plan = CampaignPlan::new(&CampaignRequest {
        scenario: arena.to_owned(),
        overrides: ScenarioOverrides { boat_speed_m_per_s: Some(speed), ..ScenarioOverrides::default() },
        law,
        rate: None,
        guidance: None,
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

/// Size of the plot and edges of the two panels, pixels.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 330.0;
const TOP: f64 = 50.0;
const BOTTOM: f64 = 270.0;
const PANEL_WIDTH: f64 = 250.0;
const LEFTS: [f64; 2] = [60.0, 370.0];

/// The plot of both arenas side by side, each with the curves of both laws.
fn plot(curves: &[Vec<CurvePoint>]) -> String {
    let max_speed = SPEEDS.into_iter().fold(0.0, f64::max);
    let mut out = Svg::new(WIDTH, HEIGHT);
    for ((left, arena), curves) in LEFTS.into_iter().zip(ARENAS).zip(curves.chunks(LAWS.len())) {
        let to_pixels = |(speed, share_not_lost): CurvePoint| {
            [left + PANEL_WIDTH * speed / max_speed, BOTTOM - (BOTTOM - TOP) * share_not_lost]
        };
        for step in 0..=4_u8 {
            let (share, speed) = (f64::from(step) / 4.0, 2.0 * f64::from(step));
            let ([x, _], [_, y]) = (to_pixels((speed, 0.0)), to_pixels((0.0, share)));
            out.line("grid", [left, y, left + PANEL_WIDTH, y]);
            out.line("grid", [x, TOP, x, BOTTOM]);
            out.text("end", [left - 6.0, y + 4.0], &format!("{:.0} %", 100.0 * share));
            out.text("middle", [x, BOTTOM + 18.0], &format!("{speed:.0}"));
        }
        let classes = [("curve", "mark"), ("other", "other-mark")];
        for (curve, (line, mark)) in curves.iter().zip(classes) {
            let points: Vec<[f64; 2]> = curve.iter().map(|point| to_pixels(*point)).collect();
            out.polyline(line, &points);
            points.into_iter().for_each(|point| out.circle(mark, point));
        }
        out.rectangle("axis", [left, TOP, PANEL_WIDTH, BOTTOM - TOP]);
        out.text("middle", [left + PANEL_WIDTH / 2.0, TOP - 10.0], arena);
        out.text("middle", [left + PANEL_WIDTH / 2.0, BOTTOM + 40.0], "speed of the boat, m/s");
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
        let curve: Vec<CurvePoint> = SPEEDS.iter().map(|speed| (*speed, 1.0)).collect();
        let svg = plot(&vec![curve; ARENAS.len() * LAWS.len()]);
        assert_eq!(svg.matches("<polyline").count(), 4);
        assert_eq!(svg.matches("<circle").count(), 4 * SPEEDS.len());
        assert!(svg.trim_end().ends_with("</svg>"));
    }
}
