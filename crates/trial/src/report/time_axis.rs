//! What figures over time have in common: their width, their axis, and the spans of excursions.

use super::canvas::{Anchor, Canvas};
use super::scale::Scale;
use crate::logs::TrialLog;
use crate::metrics::Excursion;

/// Width of figures over time, units of paper.
pub(super) const WIDTH: f64 = 760.0;
/// Left and right end of the axis.
const ENDS: (f64, f64) = (46.0, WIDTH - 14.0);

/// The axis of time of one trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeAxis {
    scale: Scale,
}

impl TimeAxis {
    pub(super) fn of(log: &TrialLog) -> Self {
        Self { scale: Scale { values: (0.0, log.duration_s()), places: ENDS } }
    }

    pub(super) fn at(&self, time_s: f64) -> f64 {
        self.scale.at(time_s)
    }

    pub(super) const fn left(&self) -> f64 {
        self.scale.places.0
    }

    pub(super) const fn right(&self) -> f64 {
        self.scale.places.1
    }

    /// The axis at `bottom`, with ticks; `top` is where its grid ends.
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

    /// Where the log knows no position, as shaded spans.
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
            let corners = ((self.at(log.rows[from].time_s), top), (self.at(time_of(log, row)), bottom));
            canvas.rect("gap", corners.0, corners.1, Some("track lost"));
        }
    }

    /// The time of an excursion, as a shaded span.
    pub(super) fn draw_span(
        &self,
        canvas: &mut Canvas,
        log: &TrialLog,
        of: &Excursion,
        top: f64,
        bottom: f64,
    ) {
        let (from_s, to_s) = span(log, of);
        canvas.rect("wash", (self.at(from_s), top), (self.at(to_s), bottom), Some(&in_words(log, of)));
    }
}

/// When a row begins; the end of the log for the row after its last.
fn time_of(log: &TrialLog, row: usize) -> f64 {
    log.rows.get(row).map_or_else(|| log.duration_s(), |row| row.time_s)
}

/// When an excursion begins and ends.
pub(super) fn span(log: &TrialLog, of: &Excursion) -> (f64, f64) {
    (time_of(log, of.first), time_of(log, of.end))
}

/// An excursion in words.
pub(super) fn in_words(log: &TrialLog, of: &Excursion) -> String {
    let (from_s, _) = span(log, of);
    let end = if of.complete { "" } else { ", open at the end of the log: not counted in the sensitivity" };
    format!("excursion at {from_s:.1} s: h = {:.2}, b = {:.2} s{end}", of.h, of.b_s)
}
