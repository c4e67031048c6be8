//! Figure of the sensitivities of an arena: a dot for each trial, a row for each set, with the mean, its 95 %
//! interval (Student) and the published value.

use super::canvas::{Anchor, Canvas, distance};
use super::figure::Figure;
use super::scale::Scale;
use super::text::{count_of, number_or_dash};
use super::trial_group::TrialGroup;
use crate::campaign::statistics::mean_interval;
use crate::metrics::Arena;

const WIDTH: f64 = 760.0;
const ENDS: (f64, f64) = (14.0, WIDTH - 14.0);
const TOP: f64 = 30.0;
const ROW: f64 = 84.0;
/// Height of the label at the top of a row.
const LABELS: f64 = 20.0;
const BELOW: f64 = 40.0;
const RADIUS: f64 = 3.8;
/// Largest distance of a dot from the middle of its row.
const MAX_OFFSET: f64 = 22.0;

/// The figure of an arena; `None` where no trial has a sensitivity.
pub(super) fn figure(name: &str, arena: Option<Arena>, groups: &[TrialGroup<'_>]) -> Option<Figure> {
    let published = arena.map(Arena::published_sensitivity);
    let values = groups.iter().flat_map(|group| group.values(|metrics| metrics.sensitivity));
    let largest = values.reduce(f64::max)?;
    let max_sensitivity = 1.06 * published.map_or(largest, |published| largest.max(published)).max(0.1);
    let scale = Scale { values: (0.0, max_sensitivity), paper: ENDS };
    let bottom = TOP + groups.len() as f64 * ROW;
    let mut canvas = Canvas::default();
    for (value, label) in scale.ticks(8).labelled() {
        canvas.line("grid", (scale.at(value), TOP), (scale.at(value), bottom));
        canvas.text("tick", Anchor::Middle, (scale.at(value), bottom + 15.0), &label);
    }
    canvas.line("axis", (ENDS.0, bottom), (ENDS.1, bottom));
    canvas.text("unit", Anchor::End, (ENDS.1, bottom + 31.0), "sensitivity s = mean of h / b, 1/s");
    if let Some(published) = published {
        let x = scale.at(published);
        // Broken where the labels of the rows stand.
        canvas.line("bound", (x, TOP - 8.0), (x, TOP));
        for row in 0..groups.len() {
            let top = TOP + row as f64 * ROW;
            canvas.line("bound", (x, top + LABELS), (x, top + ROW));
        }
        let words = format!("published {published:.4}");
        canvas.text_on_lines("t-region", Anchor::Middle, (x.max(54.0), TOP - 14.0), &words);
    }
    for (row, group) in groups.iter().enumerate() {
        draw_row(&mut canvas, group, &scale, TOP + row as f64 * ROW);
    }
    let place =
        arena.map_or_else(|| "other scenarios".to_owned(), |arena| format!("arena {}", arena.number()));
    let rows = groups.iter().map(|group| {
        let mean = group.summary().pooled.mean_sensitivity;
        format!(
            "{}: {}, mean {}. ",
            group.set.name,
            count_of(group.trials.len(), "trial"),
            number_or_dash(mean, 4)
        )
    });
    let titles = (format!("Sensitivity per trial, {place}"), rows.collect());
    Some(Figure::new(name.to_owned(), titles, (WIDTH, bottom + BELOW), canvas))
}

fn draw_row(canvas: &mut Canvas, group: &TrialGroup<'_>, scale: &Scale, top: f64) {
    let middle = top + 0.5 * ROW + 9.0;
    canvas.line("grid", (ENDS.0, top), (ENDS.1, top));
    let values = group.values(|metrics| metrics.sensitivity);
    let mean = group.summary().pooled.mean_sensitivity;
    if let Some(mean) = mean {
        if let Some(interval) = mean_interval(&values) {
            let (low, high) = (interval.low.max(0.0), interval.high.min(scale.values.1));
            canvas.rect(
                "gap",
                (scale.at(low), middle - 26.0),
                (scale.at(high), middle + 26.0),
                Some("95 % interval of the mean"),
            );
        }
        canvas.line("mean", (scale.at(mean), middle - 26.0), (scale.at(mean), middle + 26.0));
    }
    let with_s = if values.len() < group.trials.len() {
        format!(", {} with a complete excursion", values.len())
    } else {
        String::new()
    };
    let label = format!(
        "{} \u{00b7} {}{with_s} \u{00b7} mean {}",
        group.set.name,
        count_of(group.trials.len(), "trial"),
        number_or_dash(mean, 4)
    );
    canvas.text_on_lines("name", Anchor::Start, (ENDS.0, top + 15.0), &label);
    let mut dots: Vec<(f64, String, bool)> = group
        .trials
        .iter()
        .filter_map(|trial| {
            let metrics = &trial.entry.metrics;
            let sensitivity = metrics.sensitivity?;
            let is_good = metrics.is_success() && !metrics.ends_outside;
            Some((scale.at(sensitivity), format!("{}: {sensitivity:.3}", trial.entry.name), is_good))
        })
        .collect();
    dots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut placed: Vec<(f64, f64)> = Vec::new();
    for (x, tip, is_good) in dots {
        let y = free_y(&placed, x, middle);
        placed.push((x, y));
        canvas.circle(if is_good { "dot" } else { "dot bad" }, (x, y), RADIUS, Some(&tip));
    }
}

/// The y nearest to the middle of the row at which a dot at `x` overlaps no other.
fn free_y(placed: &[(f64, f64)], x: f64, middle: f64) -> f64 {
    let step = 2.0 * RADIUS + 0.6;
    let free = |y: f64| placed.iter().all(|other| distance(*other, (x, y)) >= step);
    let offsets = (0..7).map(|index: i32| {
        let half = f64::from((index + 1) / 2) * 0.9 * step;
        if index % 2 == 0 { half } else { -half }
    });
    offsets
        .filter(|offset| offset.abs() <= MAX_OFFSET)
        .map(|offset| middle + offset)
        .find(|y| free(*y))
        .unwrap_or(middle)
}
