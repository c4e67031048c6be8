//! The commands over time, in the vehicle's own signs: pitch above, yaw below, steps as they were in force.

use barrelman_vocab::{AngularRate, VehicleRates};

use super::canvas::{Anchor, Canvas};
use super::figure::Figure;
use super::scale::Scale;
use super::time_axis::{TimeAxis, WIDTH};
use super::{Course, line};
use crate::metrics::excursions;

const LANE: f64 = 52.0;
const GAP: f64 = 12.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = TOP + 2.0 * LANE + GAP;
const HEIGHT: f64 = BOTTOM + 24.0;
/// The scale goes up to this rate at least, rad/s.
const LEAST_RATE: f64 = 0.1;

/// Which rate of a command.
type Axis = fn(&VehicleRates) -> AngularRate;

/// The figure of a trial; `None` where the log does not say what was commanded.
pub fn figure(name: &str, trial: &str, course: &Course) -> Option<Figure> {
    let log = &course.log;
    let rates: Vec<VehicleRates> = log.rows.iter().filter_map(|row| row.rates).collect();
    if rates.len() != log.rows.len() || rates.is_empty() {
        return None;
    }
    let lanes: [(&str, Axis); 2] = [("pitch", |r| r.pitch), ("yaw", |r| r.yaw)];
    let sizes = rates.iter().flat_map(|r| [r.pitch, r.yaw]).map(|rate| rate.radians_per_second().abs());
    let most = sizes.fold(LEAST_RATE, f64::max);
    let axis = TimeAxis::of(log);
    let mut canvas = Canvas::default();
    axis.draw(&mut canvas, TOP, BOTTOM);
    for excursion in &excursions(log, course.region) {
        axis.draw_span(&mut canvas, log, excursion, TOP, BOTTOM);
    }
    for (lane, (word, of)) in lanes.into_iter().enumerate() {
        let top = TOP + lane as f64 * (LANE + GAP);
        let scale = Scale { values: (-1.12 * most, 1.12 * most), places: (top + LANE, top) };
        for value in [-most, 0.0, most] {
            canvas.line("grid", (axis.left(), scale.at(value)), (axis.right(), scale.at(value)));
            let label = super::text::number(value, if value == 0.0 { 0 } else { 1 });
            canvas.text("tick", Anchor::End, (axis.left() - 7.0, scale.at(value) + 4.0), &label);
        }
        let values: Vec<f64> = rates.iter().map(|rate| of(rate).radians_per_second()).collect();
        let mut steps = vec![(axis.at(0.0), scale.at(0.0))];
        let mut before = 0.0;
        for (row, value) in values.iter().enumerate() {
            if *value != before {
                let x = axis.at(log.rows[row].time_s);
                steps.extend([(x, scale.at(before)), (x, scale.at(*value))]);
                before = *value;
            }
        }
        let end = axis.at(log.duration_s());
        steps.extend([(end, scale.at(before)), (end, scale.at(0.0))]);
        canvas.path(word, &line::area(&steps, scale.at(0.0)));
        canvas.text_on_lines(&format!("name t-{word}"), Anchor::Start, (axis.left() + 5.0, top + 9.0), word);
    }
    canvas.text(
        "unit",
        Anchor::Start,
        (axis.left() - 36.0, TOP - 9.0),
        "rad/s, in the vehicle\u{2019}s own signs",
    );
    let moves = |of: Axis| {
        let zero = |rate: &VehicleRates| of(rate).is_zero();
        usize::from(!zero(&rates[0]))
            + rates.windows(2).filter(|pair| zero(&pair[0]) && !zero(&pair[1])).count()
    };
    let description = format!(
        "The pitch and yaw rates that were commanded over {:.1} s, up to {most:.2} rad/s: {} starts of pitch, {} of yaw.",
        log.duration_s(),
        moves(lanes[0].1),
        moves(lanes[1].1)
    );
    let titles = (format!("{trial}: pitch and yaw commands"), description);
    Some(Figure::new(name.to_owned(), titles, (WIDTH, HEIGHT), canvas))
}
