//! What is required of the optimal law's modes in each condition.

use super::conditions::Condition;

/// The largest ratio to the motor schema's mean that a metric of a mode may have; `None` where nothing is
/// required.
pub(super) fn max_ratio(condition: &Condition, mode: &str, metric: &str) -> Option<f64> {
    let is_second_arena = condition.scenario.ends_with('2');
    let by_arena = |first: f64, second: f64| Some(if is_second_arena { second } else { first });
    let is_laboratory = condition.is_laboratory();
    let is_field = condition.scenario.starts_with("field");
    match (mode, metric) {
        ("minimum-energy", "time outside") if is_laboratory => by_arena(0.65, 0.15),
        ("minimum-energy", "integral of rate squared") if is_laboratory => by_arena(0.85, 0.75),
        ("minimum-energy", "moves") if is_laboratory => Some(1.0),
        ("minimum-energy", "time out of the picture" | "lost") if is_laboratory => Some(1.0),
        ("minimum-energy", "time outside") if is_field => Some(0.3),
        ("minimum-energy", "integral of rate squared") if is_field => Some(0.75),
        ("minimum-energy", "time outside" | "integral of rate squared") => Some(1.0),
        ("minimum-energy", "moves") if condition.scenario.starts_with("steep") => Some(1.1),
        ("intermittent", "time outside") => Some(if is_laboratory { 0.60 } else { 0.45 }),
        ("intermittent", "integral of rate squared" | "largest P") => Some(0.85),
        ("intermittent", metric) if is_of_motion(metric) => Some(1.0),
        ("intermittent", "time out of the picture" | "lost") => Some(1.0),
        ("eco", "time outside") if is_laboratory => by_arena(0.85, 0.65),
        ("eco", "integral of |rate|" | "integral of rate squared" | "movement time") if is_laboratory => {
            Some(1.0)
        }
        ("eco", "moves") if is_laboratory => Some(1.15),
        _ => None,
    }
}

/// The same for the achieved motion, whose time outside and largest P are those of the commands.
pub(super) fn max_achieved_ratio(mode: &str, metric: &str) -> Option<f64> {
    match (mode, metric) {
        ("intermittent", "integral of rate squared") => Some(0.85),
        ("intermittent", metric) if metric != "jerk" && is_of_motion(metric) => Some(1.0),
        _ => None,
    }
}

/// Whether less of the metric means less or smoother motion.
fn is_of_motion(metric: &str) -> bool {
    matches!(metric, "moves" | "integral of |rate|" | "movement time" | "variation" | "jerk")
}
