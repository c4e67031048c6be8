//! The time axis of figures over time, and the time spans of excursions.

use super::canvas::{Anchor, Canvas};
use super::scale::Scale;
use crate::logs::TrialLog;
use crate::metrics::Excursion;

/// Width of figures over time, units of paper.
pub(super) const WIDTH: f64 = 760.0;
/// Coordinates of the left and right end of the axis.
const ENDS: (f64, f64) = (46.0, WIDTH - 14.0);

/// The time axis of one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeAxis {
    scale: Scale,
}

impl TimeAxis {
    pub(super) fn new(log: &TrialLog) -> Self {
        Self { scale: Scale { values: (0.0, log.duration_s()), paper: ENDS } }
    }

    pub(super) fn at(&self, time_s: f64) -> f64 {
        self.scale.at(time_s)
    }

    pub(super) const fn left(&self) -> f64 {
        self.scale.paper.0
    }

    pub(super) const fn right(&self) -> f64 {
        self.scale.paper.1
    }

    /// Draws the axis at `bottom`, with ticks and grid lines up to `top`.
    pub(super) fn draw(&self, canvas: &mut Canvas, top: f64, bottom: f64) {
        let ticks = self.scale.ticks(10);
        let last = ticks.values.len().saturating_sub(1);
        for (index, (value, label)) in ticks.labelled().enumerate() {
            let x = self.at(value);
            canvas.line("grid", (x, top), (x, bottom));
            let label = if index == last { format!("{label} s") } else { label };
            canvas.text("tick", Anchor::Middle, (x, bottom + 15.0), &label);
        }
        canvas.line("axis", (self.left(), bottom), (self.right(), bottom));
    }

    /// Shades the time spans without a position.
    pub(super) fn draw_gaps(&self, canvas: &mut Canvas, log: &TrialLog, top: f64, bottom: f64) {
        let mut row = 0;
        while row < log.rows.len() {
            if log.rows[row].position.is_some() {
                row += 1;
                continue;
            }
            let from = row;
            while row < log.rows.len() && log.rows[row].position.is_none() {
                row += 1;
            }
            let corners = ((self.at(log.rows[from].time_s), top), (self.at(row_start_s(log, row)), bottom));
            canvas.rect("gap", corners.0, corners.1, Some("track lost"));
        }
    }

    /// Shades the time span of an excursion.
    pub(super) fn draw_span(
        &self,
        canvas: &mut Canvas,
        log: &TrialLog,
        excursion: &Excursion,
        top: f64,
        bottom: f64,
    ) {
        let (from_s, to_s) = time_span(log, excursion);
        canvas.rect("wash", (self.at(from_s), top), (self.at(to_s), bottom), Some(&describe(log, excursion)));
    }
}

/// Start of a row, s; the end of the log for the row after the last.
fn row_start_s(log: &TrialLog, row: usize) -> f64 {
    log.rows.get(row).map_or_else(|| log.duration_s(), |row| row.time_s)
}

/// Start and end of an excursion, s.
pub(super) fn time_span(log: &TrialLog, excursion: &Excursion) -> (f64, f64) {
    (row_start_s(log, excursion.first), row_start_s(log, excursion.end))
}

/// A description of an excursion.
pub(super) fn describe(log: &TrialLog, excursion: &Excursion) -> String {
    let (from_s, _) = time_span(log, excursion);
    let end = if excursion.is_complete {
        ""
    } else {
        ", open at the end of the log: not counted in the sensitivity"
    };
    format!("excursion at {from_s:.1} s: h = {:.2}, b = {:.2} s{end}", excursion.h, excursion.b_s)
}
