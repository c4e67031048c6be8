//! The table of laws and conditions, with what is required.

use anyhow::Result;
use barrelman_control::optimal::Tuning;
use barrelman_trial::campaign::compare::{CampaignComparison, PairedMetric};
use barrelman_trial::campaign::statistics::{Bootstrap, Interval};

use super::Options;
use super::conditions::{Condition, Subject, trials};
use crate::say;

/// What is printed: name, figure of a comparison.
const COLUMNS: [(&str, &str); 11] = [
    ("outside", "time outside"),
    ("rate2", "integral of rate squared"),
    ("moves", "moves"),
    ("|rate|", "integral of |rate|"),
    ("moving", "movement time"),
    ("variat.", "variation"),
    ("jerk", "jerk"),
    ("s", "sensitivity"),
    ("max P", "largest P"),
    ("out pic", "time out of the picture"),
    ("lost", "lost"),
];

/// Trials of each condition of a law that solves at each picture.
const SEEDS_OF_SLOW: u64 = 48;

/// Prints it; whether every requirement holds.
pub(super) fn print(conditions: &[&Condition], options: &Options, minimum_energy: &Tuning) -> Result<bool> {
    let Options { first_seed, seeds, .. } = *options;
    let wanted = |name: &str| options.law.is_empty() || options.law.iter().any(|law| name.starts_with(law));
    let mut holds = true;
    for condition in conditions {
        let plan = condition.plan()?;
        let base = trials(&plan, &Subject::Schema, first_seed, seeds)?;
        say(&format!(
            "\n{}: {seeds} trials, seeds from {first_seed} on; ratios to the schema's means, 95 %",
            condition.name()
        ));
        for (name, subject) in [
            ("minimum-energy", Subject::Optimal(*minimum_energy)),
            ("time-fuel", Subject::Optimal(Tuning::TIME_FUEL)),
            ("eco", Subject::Optimal(Tuning::ECO)),
            ("centre", Subject::Centre),
            ("LQG, weight 1", Subject::Lqg(1.0)),
            ("LQG, weight 10", Subject::Lqg(10.0)),
            ("MPC", Subject::Mpc),
        ] {
            if !wanted(name) {
                continue;
            }
            // A solver at each picture takes its time.
            let count = if subject.is_slow() { seeds.min(SEEDS_OF_SLOW) } else { seeds };
            let other = trials(&plan, &subject, first_seed, count)?;
            let comparison = CampaignComparison::new(&base, &other, &Bootstrap::DEFAULT);
            for (short, figure) in COLUMNS {
                let Some(paired) = comparison.metrics.iter().find(|paired| paired.metric == figure) else {
                    continue;
                };
                let limit = limit(condition, name, figure);
                let missed = limit.is_some_and(|limit| !meets(paired, limit));
                holds &= !missed;
                say(&format!(
                    "  {name:15} {short:8} {:>9.3} {:>9.3}  {}  {}",
                    paired.first,
                    paired.second,
                    ratio(paired.ratio),
                    match (limit, missed) {
                        (None, _) => String::new(),
                        (Some(limit), false) => format!("<= {limit}"),
                        (Some(limit), true) => format!("<= {limit} MISSED"),
                    }
                ));
            }
        }
    }
    Ok(holds)
}

pub(super) fn ratio(ratio: Option<Interval>) -> String {
    ratio.map_or_else(String::new, |r| format!("{:.3} [{:.3}, {:.3}]", r.value, r.low, r.high))
}

/// Whether the upper end of a ratio's interval meets a limit; where the schema has nothing of it, the law has none.
fn meets(paired: &PairedMetric, limit: f64) -> bool {
    match paired.ratio {
        Some(ratio) => ratio.high <= limit,
        None => paired.second <= 0.0,
    }
}

/// What is required of a mode in a condition.
pub(super) fn limit(condition: &Condition, mode: &str, figure: &str) -> Option<f64> {
    let second = condition.scenario.ends_with('2');
    let by_arena = |first: f64, other: f64| Some(if second { other } else { first });
    let laboratory = condition.scenario.starts_with("lab");
    match (mode, figure) {
        ("minimum-energy", "time outside") if laboratory => by_arena(0.65, 0.15),
        ("minimum-energy", "integral of rate squared") if laboratory => by_arena(0.85, 0.75),
        ("minimum-energy", "moves") if laboratory => Some(1.0),
        ("minimum-energy", "time out of the picture" | "lost") if laboratory => Some(1.0),
        ("minimum-energy", "time outside") if condition.scenario.starts_with("field") => Some(0.3),
        ("minimum-energy", "integral of rate squared") if condition.scenario.starts_with("field") => {
            Some(0.75)
        }
        ("minimum-energy", "time outside" | "integral of rate squared") => Some(1.0),
        ("minimum-energy", "moves") if condition.scenario.starts_with("steep") => Some(1.1),
        ("eco", "time outside") if laboratory => by_arena(0.85, 0.65),
        ("eco", "integral of |rate|" | "integral of rate squared" | "movement time") if laboratory => {
            Some(1.0)
        }
        ("eco", "moves") if laboratory => Some(1.15),
        _ => None,
    }
}
