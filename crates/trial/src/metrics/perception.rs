//! What the tracker said in a trial in pixels, beside the truth.

use serde::{Deserialize, Serialize};

use super::mean::mean;
use crate::logs::TrialLog;
use crate::target_in_picture::JudgedTrack;

/// The target counts as visible from this share on.
pub const MIN_VISIBLE_SHARE: f64 = 0.5;
/// The target counts as tracked from this IoU on.
pub const MIN_TRACKED_IOU: f64 = 0.3;
/// A confidence from here on counts as sure,
pub const SURE: f64 = 0.8;
/// and an IoU below this as wrong.
pub const MAX_WRONG_IOU: f64 = 0.1;
/// A target that comes back had been invisible for at least this long, s.
pub const MIN_ABSENCE_S: f64 = 1.0;

/// Figures of the tracker in a trial in pixels. Fields are `null` where they are not defined, all of them
/// where the trial is not in pixels.
///
/// The target is *visible* where at least half of it can be seen in the picture, and *tracked* where the
/// state is `tracking` and the box overlaps the visible part by IoU 0.3 or more.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PerceptionMetrics {
    /// Share of the time with a visible target in which it is tracked, 0 to 1.
    pub tracked: Option<f64>,
    /// Longest time with a visible target that is not tracked, s. Time in which the target is not visible
    /// does not count, and does not end the interval.
    pub blind_s: Option<f64>,
    /// Share of the time with a confidence of 0.8 or more, tracking or coasting, and an IoU below 0.1, 0
    /// to 1.
    pub sure_wrong: Option<f64>,
    /// From the first picture to the first time that the target is tracked, s.
    pub first_track_s: Option<f64>,
    /// Mean time from the moment at which the target is visible again, after at least 1 s without, until it
    /// is tracked, s.
    pub reacquire_s: Option<f64>,
    /// Number of selections.
    pub selections: Option<usize>,
}

impl PerceptionMetrics {
    /// The figures of a log.
    pub(super) fn from_log(log: &TrialLog) -> Self {
        let (Some(selections), Some(truth)) = (log.selections, &log.truth) else { return Self::default() };
        let mut totals = Totals::default();
        for (index, row) in truth.iter().enumerate() {
            if let Some(track) = &row.track {
                totals.add(track, log.row_duration_s(index));
            }
        }
        let share = |part: f64, whole: f64| (whole > 0.0).then(|| part / whole);
        Self {
            tracked: share(totals.tracked_s, totals.visible_s),
            blind_s: Some(totals.longest_blind_s),
            sure_wrong: share(totals.sure_wrong_s, totals.judged_s),
            first_track_s: totals.first_track_s,
            reacquire_s: totals.mean_return_s(),
            selections: Some(selections),
        }
    }
}

/// Sums over the rows of a trial, s.
#[derive(Debug, Default)]
struct Totals {
    judged_s: f64,
    visible_s: f64,
    tracked_s: f64,
    sure_wrong_s: f64,
    first_track_s: Option<f64>,
    blind_s: f64,
    longest_blind_s: f64,
    /// For how long the target has been invisible.
    absent_s: f64,
    /// For how long a target that came back has not been tracked.
    return_s: Option<f64>,
    returns: Vec<f64>,
}

impl Totals {
    fn add(&mut self, track: &JudgedTrack, step_s: f64) {
        let is_visible = track.visible_share >= MIN_VISIBLE_SHARE;
        let is_tracked = track.is_tracking && track.iou.is_some_and(|iou| iou >= MIN_TRACKED_IOU);
        if track.confidence >= SURE && track.iou.is_some_and(|iou| iou < MAX_WRONG_IOU) {
            self.sure_wrong_s += step_s;
        }
        if is_tracked {
            self.first_track_s.get_or_insert(self.judged_s);
            self.blind_s = 0.0;
            self.returns.extend(self.return_s.take());
        }
        if is_visible {
            if self.absent_s >= MIN_ABSENCE_S && self.first_track_s.is_some() && !is_tracked {
                self.return_s.get_or_insert(0.0);
            } else if self.absent_s >= MIN_ABSENCE_S && is_tracked {
                self.returns.push(0.0);
            }
            self.absent_s = 0.0;
            self.visible_s += step_s;
            if is_tracked {
                self.tracked_s += step_s;
            } else {
                self.blind_s += step_s;
                self.longest_blind_s = self.longest_blind_s.max(self.blind_s);
                self.return_s = self.return_s.map(|waited| waited + step_s);
            }
        } else {
            // A target that hides again before it is tracked ends its return.
            self.absent_s += step_s;
            if self.absent_s >= MIN_ABSENCE_S {
                self.returns.extend(self.return_s.take());
            }
        }
        self.judged_s += step_s;
    }

    fn mean_return_s(mut self) -> Option<f64> {
        self.returns.extend(self.return_s.take());
        mean(self.returns.into_iter())
    }
}
