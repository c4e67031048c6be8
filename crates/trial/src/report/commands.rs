//! Figure of the commands over time: tilt above (positive upwards), pan below (positive to the right).

use barrelman_vocab::{AngularRate, CameraCommand};

use super::canvas::{Anchor, Canvas};
use super::figure::Figure;
use super::path_data;
use super::reported_trial::TrialTrace;
use super::scale::Scale;
use super::time_axis::{TimeAxis, WIDTH};
use crate::metrics::find_excursions;

/// Height of the lane of one axis.
const LANE_HEIGHT: f64 = 52.0;
const GAP: f64 = 12.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = TOP + 2.0 * LANE_HEIGHT + GAP;
const HEIGHT: f64 = BOTTOM + 24.0;
/// Smallest range of the scale, rad/s.
const MIN_RATE_RANGE: f64 = 0.1;

/// Selects the rate of one axis.
type AxisRate = fn(&CameraCommand) -> AngularRate;

/// The figure of a trial; `None` where the log has no commands.
pub fn figure(name: &str, trial: &str, trace: &TrialTrace) -> Option<Figure> {
    let log = &trace.log;
    let rates: Vec<CameraCommand> = log.rows.iter().filter_map(|row| row.command).collect();
    if rates.len() != log.rows.len() || rates.is_empty() {
        return None;
    }
    let lanes: [(&str, AxisRate); 2] = [("tilt", |r| r.tilt), ("pan", |r| r.pan)];
    let magnitudes = rates.iter().flat_map(|r| [r.tilt, r.pan]).map(|rate| rate.radians_per_second().abs());
    let max_rate = magnitudes.fold(MIN_RATE_RANGE, f64::max);
    let axis = TimeAxis::new(log);
    let mut canvas = Canvas::default();
    axis.draw(&mut canvas, TOP, BOTTOM);
    for excursion in &find_excursions(log, trace.region) {
        axis.draw_span(&mut canvas, log, excursion, TOP, BOTTOM);
    }
    for (lane, (word, rate_of)) in lanes.into_iter().enumerate() {
        let top = TOP + lane as f64 * (LANE_HEIGHT + GAP);
        let scale = Scale { values: (-1.12 * max_rate, 1.12 * max_rate), paper: (top + LANE_HEIGHT, top) };
        for value in [-max_rate, 0.0, max_rate] {
            canvas.line("grid", (axis.left(), scale.at(value)), (axis.right(), scale.at(value)));
            let label = super::text::format_number(value, if value == 0.0 { 0 } else { 1 });
            canvas.text("tick", Anchor::End, (axis.left() - 7.0, scale.at(value) + 4.0), &label);
        }
        let values: Vec<f64> = rates.iter().map(|rate| rate_of(rate).radians_per_second()).collect();
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
        canvas.path(word, &path_data::area(&steps, scale.at(0.0)));
        canvas.text_on_lines(&format!("name t-{word}"), Anchor::Start, (axis.left() + 5.0, top + 9.0), word);
    }
    canvas.text(
        "unit",
        Anchor::Start,
        (axis.left() - 36.0, TOP - 9.0),
        "rad/s: tilt positive upwards, pan positive to the right",
    );
    let moves = |rate_of: AxisRate| {
        let zero = |rate: &CameraCommand| rate_of(rate).is_zero();
        usize::from(!zero(&rates[0]))
            + rates.windows(2).filter(|pair| zero(&pair[0]) && !zero(&pair[1])).count()
    };
    let description = format!(
        "The tilt and pan rates that were commanded over {:.1} s, up to {max_rate:.2} rad/s: {} starts of tilt, {} of pan.",
        log.duration_s(),
        moves(lanes[0].1),
        moves(lanes[1].1)
    );
    let titles = (format!("{trial}: tilt and pan commands"), description);
    Some(Figure::new(name.to_owned(), titles, (WIDTH, HEIGHT), canvas))
}
