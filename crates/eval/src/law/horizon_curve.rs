//! The curve of the horizon: time outside against movement, one panel for each scenario, with the other laws as points.
//!
//! All are ratios to the motor schema's means on the same seeds, so that the schema is the point (1, 1). A law *dominates* a
//! point of the curve if it has less of both. Two drawings: over the integral of |rate|, and over that of rate².

use anyhow::{Result, bail};
use barrelman_control::optimal::ModeTuning;
use barrelman_experiments::law_choice::ModeName;
use barrelman_trial::metrics::{TrialEntry, TrialMetrics};

use super::conditions::Condition;
use super::law_under_test::LawUnderTest;
use super::options::Options;
use crate::output::print_line;
use crate::statistics::mean;
use crate::svg::{self, Svg};

/// The horizons of the curve, seconds.
const HORIZONS_S: [f64; 7] = [0.7, 0.9, 1.2, 1.6, 2.0, 2.6, 3.5];
/// Most trials of each condition for a law that solves an optimisation problem for each picture.
const MAX_SEEDS_OF_SLOW_LAW: u64 = 16;

const PANEL: [f64; 2] = [330.0, 250.0];
const MARGIN: [f64; 2] = [48.0, 40.0];
/// The ratios of movement that are drawn, on a logarithmic scale, and those of the time outside.
const MOVEMENT: [f64; 2] = [0.25, 8.0];
const OUTSIDE: [f64; 2] = [0.0, 1.2];
/// Ticks of the scale of movement.
const MOVEMENT_TICKS: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// A law's ratios to the schema.
#[derive(Debug, Clone, Copy)]
struct Ratios {
    outside: f64,
    travel: f64,
    energy: f64,
}

/// The curve and the other laws in one condition.
struct Panel {
    title: String,
    curve: Vec<Ratios>,
    others: Vec<(&'static str, Ratios)>,
}

/// Prints the curve of each condition, and draws both figures. Returns whether no other law dominates a point of a curve.
pub(super) fn print(
    conditions: &[&Condition],
    options: &Options,
    laws: &[(&'static str, LawUnderTest)],
) -> Result<bool> {
    let mut panels = Vec::new();
    let mut is_undominated = true;
    for condition in conditions {
        let panel = Panel::measure(condition, options, laws)?;
        print_line(&format!("\n{}: horizon, time outside, |rate|, rate²; ratios to the schema", panel.title));
        for (horizon_s, ratios) in HORIZONS_S.iter().zip(&panel.curve) {
            print_line(&format!("  {horizon_s:17.1} s  {}", ratios.cells()));
        }
        for (name, ratios) in &panel.others {
            let dominated = panel.dominated_by(ratios);
            is_undominated &= dominated.is_empty();
            print_line(&format!("  {name:18}  {}  {dominated}", ratios.cells()));
        }
        panels.push(panel);
    }
    svg::save_plot("law-travel.svg", &drawing(&panels, "integral of |rate|", |ratios| ratios.travel))?;
    svg::save_plot("law-energy.svg", &drawing(&panels, "integral of rate²", |ratios| ratios.energy))?;
    Ok(is_undominated)
}

impl Ratios {
    fn new(trials: &[TrialEntry], schema: &[TrialEntry]) -> Self {
        let ratio = |value: fn(&TrialMetrics) -> f64| {
            let mean_of = |trials: &[TrialEntry]| {
                mean(&trials.iter().map(|trial| value(&trial.metrics)).collect::<Vec<f64>>())
            };
            mean_of(trials) / mean_of(&schema[..trials.len()])
        };
        Self {
            outside: ratio(|metrics| metrics.time_outside_s),
            travel: ratio(|metrics| metrics.travel_rad.unwrap_or(0.0)),
            energy: ratio(|metrics| metrics.effort_rad2_per_s.unwrap_or(0.0)),
        }
    }

    fn cells(&self) -> String {
        format!("{:6.3} {:6.3} {:6.3}", self.outside, self.travel, self.energy)
    }
}

impl Panel {
    fn measure(
        condition: &Condition,
        options: &Options,
        laws: &[(&'static str, LawUnderTest)],
    ) -> Result<Self> {
        let seeds = options.first_seed..options.first_seed + options.seeds;
        let plan = condition.plan()?.with_recorded_motion(seeds.clone())?;
        let schema = LawUnderTest::MotorSchema.simulate(&plan, seeds.clone())?;
        let (_, tuning) = options.tuning_of(ModeName::Intermittent)?;
        let ModeTuning::Intermittent(tuning) = tuning else {
            bail!("the intermittent mode has the tuning of another mode");
        };
        let curve = HORIZONS_S
            .iter()
            .map(|horizon_s| {
                let law = LawUnderTest::Optimal(tuning.with_horizon(*horizon_s).into());
                Ok(Ratios::new(&law.simulate(&plan, seeds.clone())?, &schema))
            })
            .collect::<Result<_>>()?;
        let others = laws
            .iter()
            .filter(|(name, _)| *name != "intermittent" && options.includes_law(name))
            .map(|(name, law)| {
                let count =
                    if law.is_slow() { options.seeds.min(MAX_SEEDS_OF_SLOW_LAW) } else { options.seeds };
                let trials = law.simulate(&plan, seeds.start..seeds.start + count)?;
                Ok((*name, Ratios::new(&trials, &schema)))
            })
            .collect::<Result<_>>()?;
        Ok(Self { title: condition.name(), curve, others })
    }

    /// What a law dominates, in words; empty: nothing.
    fn dominated_by(&self, law: &Ratios) -> String {
        let dominates = |movement: fn(&Ratios) -> f64| {
            self.curve.iter().any(|point| law.outside <= point.outside && movement(law) <= movement(point))
        };
        match (dominates(|ratios| ratios.travel), dominates(|ratios| ratios.energy)) {
            (false, false) => String::new(),
            (true, false) => "dominates a point over |rate|".to_owned(),
            (false, true) => "dominates a point over rate²".to_owned(),
            (true, true) => "dominates a point over both".to_owned(),
        }
    }
}

fn drawing(panels: &[Panel], movement: &str, value: fn(&Ratios) -> f64) -> String {
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns);
    let mut svg = Svg::new(columns as f64 * PANEL[0], rows as f64 * PANEL[1] + 64.0);
    for (index, panel) in panels.iter().enumerate() {
        let origin = [(index % columns) as f64 * PANEL[0], (index / columns) as f64 * PANEL[1]];
        draw_panel(&mut svg, panel, origin, value);
    }
    let first = panels.first().map_or(&[][..], |panel| &panel.others);
    let legend: Vec<String> = first.iter().map(|(name, _)| format!("{} {name}", mark_of(name))).collect();
    let curve = format!("horizons {} to {} s", HORIZONS_S[0], HORIZONS_S[HORIZONS_S.len() - 1]);
    let lines = [
        format!("across: {movement}, up: time outside; ratios to the schema (S); {curve}"),
        legend.join(", "),
    ];
    for (line, text) in (1_u8..).zip(lines) {
        svg.text("", [12.0, rows as f64 * PANEL[1] + 20.0 * f64::from(line)], &text);
    }
    svg.finish()
}

fn draw_panel(svg: &mut Svg, panel: &Panel, [left, top]: [f64; 2], value: fn(&Ratios) -> f64) {
    let (width, height) = (PANEL[0] - MARGIN[0] - 12.0, PANEL[1] - 2.0 * MARGIN[1]);
    let at = |movement: f64, outside: f64| {
        let across = (movement / MOVEMENT[0]).ln() / (MOVEMENT[1] / MOVEMENT[0]).ln();
        let up = (outside - OUTSIDE[0]) / (OUTSIDE[1] - OUTSIDE[0]);
        [
            left + MARGIN[0] + width * across.clamp(0.0, 1.0),
            top + MARGIN[1] + height * (1.0 - up.clamp(0.0, 1.0)),
        ]
    };
    svg.text("", [left + MARGIN[0], top + MARGIN[1] - 14.0], &panel.title);
    for movement in MOVEMENT_TICKS {
        let ([x, low], [_, high]) = (at(movement, OUTSIDE[0]), at(movement, OUTSIDE[1]));
        svg.line("grid", [x, low, x, high]);
        svg.text("middle", [x, low + 16.0], &movement.to_string());
    }
    for tenths in [0_u8, 4, 8, 12] {
        let outside = f64::from(tenths) / 10.0;
        let ([low, y], [high, _]) = (at(MOVEMENT[0], outside), at(MOVEMENT[1], outside));
        svg.line("grid", [low, y, high, y]);
        svg.text("end", [low - 6.0, y + 4.0], &outside.to_string());
    }
    let curve: Vec<[f64; 2]> = panel.curve.iter().map(|ratios| at(value(ratios), ratios.outside)).collect();
    svg.polyline("curve", &curve);
    for point in &curve {
        svg.circle("mark", *point);
    }
    let schema = [("S", [1.0, 1.0])];
    let others = panel.others.iter().map(|(name, ratios)| (*name, [value(ratios), ratios.outside]));
    for (name, [movement, outside]) in schema.into_iter().chain(others) {
        let [x, y] = at(movement, outside);
        svg.circle("other-mark", [x, y]);
        svg.text("", [x + 6.0, y - 5.0], mark_of(name));
    }
}

/// What stands beside a law's point.
fn mark_of(name: &str) -> &str {
    match name {
        "minimum-energy" => "M",
        "time-fuel" => "T",
        "eco" => "E",
        "centre" => "C",
        "LQG, weight 1" => "L1",
        "LQG, weight 10" => "L10",
        "MPC" => "P",
        other => other,
    }
}
