//! The metrics of one trial.

use barrelman_control::Region;
use barrelman_vocab::{CameraCommand, ImagePoint, PictureSize};
use serde::{Deserialize, Serialize};

use super::excursion::{Excursion, find_excursions};
use super::guidance::GuidanceMetrics;
use super::mean::mean;
use super::perception::PerceptionMetrics;
use crate::logs::{RowTruth, TrialLog};

/// A target closer to the picture's border than this share of half its width or height counts as at the
/// border.
pub const BORDER_SHARE: f64 = 0.05;
/// Longest uninterrupted loss of the target that does not make the trial a lost one, s.
pub const MAX_LOST_S: f64 = 2.0;

/// The metrics of one trial. Fields are `null` where the log cannot tell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialMetrics {
    /// Number of rows.
    pub samples: usize,
    /// From the first row to the end of the last, s.
    pub duration_s: f64,
    /// Number of excursions: maximal runs of rows with P > 1.
    pub excursions: usize,
    /// Number of excursions after which the log continues.
    pub complete_excursions: usize,
    /// Time with P > 1, s.
    pub time_outside_s: f64,
    /// Largest P.
    pub max_p: Option<f64>,
    /// Mean height h (largest P minus 1) of the complete excursions.
    pub mean_h: Option<f64>,
    /// Mean duration b of the complete excursions, s.
    pub mean_b_s: Option<f64>,
    /// Share of time with a command other than rest in force, 0 to 1.
    pub duty: Option<f64>,
    /// Integral of |rate| over both axes, rad.
    pub travel_rad: Option<f64>,
    /// Integral of the squared rate over both axes, rad²/s.
    pub effort_rad2_per_s: Option<f64>,
    /// Number of commands that start from rest.
    pub moves: Option<usize>,
    /// Number of changes from one command to another without rest between them.
    pub switches: Option<usize>,
    /// Share of the moving time in which both axes move, 0 to 1.
    pub both_axes: Option<f64>,
    /// Time with a command other than rest in force, s.
    pub movement_s: Option<f64>,
    /// Sum of |change| of the command over both axes, rad/s.
    pub variation_rad_per_s: Option<f64>,
    /// RMS of the second derivative of the achieved rates, rad/s³; simulated trials only.
    pub jerk_rad_per_s3: Option<f64>,
    /// Time with the target at the picture's border, s.
    pub border_s: f64,
    /// Time with the target out of the picture (recordings: track lost), s.
    pub out_of_picture_s: Option<f64>,
    /// Whether the last known position is outside the region.
    pub ends_outside: bool,
    /// Whether the target was out of the picture for over 2 s without interruption, or at the end.
    pub lost: Option<bool>,
    /// Sensitivity: mean of h/b over the complete excursions, 1/s.
    pub sensitivity: Option<f64>,
    /// The tracker beside the truth, in a trial in pixels.
    #[serde(flatten)]
    pub perception: PerceptionMetrics,
    /// How the boat went to a person, in a trial with guidance; no fields otherwise.
    #[serde(flatten)]
    pub guidance: Option<GuidanceMetrics>,
}

/// Longest time with a visible target that is not tracked, in a successful trial in pixels, s.
pub const MAX_BLIND_S: f64 = 5.0;
/// Least share of the time with a visible target in which it is tracked, in a successful trial in pixels.
pub const MIN_TRACKED: f64 = 0.95;

impl TrialMetrics {
    /// Whether the trial is a simulated one in pixels: its figures are taken from the truth, and its tracker
    /// is judged.
    pub const fn is_in_pixels(&self) -> bool {
        self.perception.selections.is_some()
    }

    /// Whether the trial succeeded: the target was not lost, or, where the log does not record losses, the
    /// trial does not end outside the region. In pixels the target was also tracked: for 95 % of the time in
    /// which it was visible, and never for more than 5 s not.
    pub fn is_success(&self) -> bool {
        let PerceptionMetrics { tracked, blind_s, .. } = self.perception;
        let is_tracked = !self.is_in_pixels()
            || (blind_s.is_some_and(|blind_s| blind_s <= MAX_BLIND_S)
                && tracked.is_some_and(|tracked| tracked >= MIN_TRACKED));
        is_tracked && !self.lost.unwrap_or(self.ends_outside)
    }
}

/// Computes the metrics of a trial for a region and a size of the picture.
pub fn measure(log: &TrialLog, region: Region, picture: PictureSize) -> TrialMetrics {
    let all = find_excursions(log, region);
    let complete: Vec<&Excursion> = all.iter().filter(|excursion| excursion.is_complete).collect();
    let ps = || log.rows.iter().filter_map(|row| row.position).map(|position| region.p(position));
    let time_where = |condition: &dyn Fn(ImagePoint) -> bool| -> f64 {
        let rows = log.rows.iter().enumerate();
        rows.filter(|(_, row)| row.position.is_some_and(condition))
            .fold(0.0, |sum, (index, _)| sum + log.row_duration_s(index))
    };
    let commands = CommandTotals::from_log(log);
    let lost = match &log.truth {
        Some(truth) => Some(LostTime::from_log(log, |index| truth[index].out_of_picture)),
        None => log
            .records_track_loss
            .then(|| LostTime::from_log(log, |index| log.rows[index].position.is_none())),
    };
    let duration_s = log.duration_s();
    TrialMetrics {
        samples: log.rows.len(),
        duration_s,
        excursions: all.len(),
        complete_excursions: complete.len(),
        // `sum` of an empty sequence is -0.0, which would be printed.
        time_outside_s: all.iter().fold(0.0, |sum, excursion| sum + excursion.b_s),
        max_p: ps().reduce(f64::max),
        mean_h: mean(complete.iter().map(|excursion| excursion.h)),
        mean_b_s: mean(complete.iter().map(|excursion| excursion.b_s)),
        duty: commands.as_ref().and_then(|totals| (duration_s > 0.0).then(|| totals.movement_s / duration_s)),
        travel_rad: commands.as_ref().map(|totals| totals.travel_rad),
        effort_rad2_per_s: commands.as_ref().map(|totals| totals.effort_rad2_per_s),
        moves: commands.as_ref().map(|totals| totals.moves),
        switches: commands.as_ref().map(|totals| totals.switches),
        both_axes: commands
            .as_ref()
            .and_then(|totals| (totals.movement_s > 0.0).then(|| totals.both_axes_s / totals.movement_s)),
        movement_s: commands.as_ref().map(|totals| totals.movement_s),
        variation_rad_per_s: commands.as_ref().map(|totals| totals.variation_rad_per_s),
        jerk_rad_per_s3: log.truth.as_ref().and_then(|truth| jerk(log, truth)),
        border_s: time_where(&|position| is_at_border(position, picture)),
        out_of_picture_s: lost.as_ref().map(|lost| lost.total_s),
        ends_outside: ps().next_back().is_some_and(|p| p > 1.0),
        lost: lost.map(|lost| lost.longest_s > MAX_LOST_S || lost.at_end),
        sensitivity: mean(complete.iter().filter_map(|excursion| excursion.sensitivity())),
        perception: PerceptionMetrics::from_log(log),
        guidance: log.guidance,
    }
}

fn is_at_border(position: ImagePoint, picture: PictureSize) -> bool {
    let inner = 1.0 - BORDER_SHARE;
    position.x.abs() >= inner * f64::from(picture.width) / 2.0
        || position.y.abs() >= inner * f64::from(picture.height) / 2.0
}

/// Sums over the commands of a trial; units as in [`TrialMetrics`].
#[derive(Debug, Default)]
struct CommandTotals {
    travel_rad: f64,
    effort_rad2_per_s: f64,
    moves: usize,
    switches: usize,
    both_axes_s: f64,
    movement_s: f64,
    variation_rad_per_s: f64,
}

impl CommandTotals {
    /// `None` where a row has no command.
    fn from_log(log: &TrialLog) -> Option<Self> {
        let mut totals = Self::default();
        let mut before = CameraCommand::REST;
        for (index, row) in log.rows.iter().enumerate() {
            let command = row.command?;
            let step_s = log.row_duration_s(index);
            let (pan, tilt) = (command.pan.radians_per_second(), command.tilt.radians_per_second());
            totals.travel_rad += (pan.abs() + tilt.abs()) * step_s;
            totals.effort_rad2_per_s += (pan * pan + tilt * tilt) * step_s;
            totals.variation_rad_per_s += (pan - before.pan.radians_per_second()).abs()
                + (tilt - before.tilt.radians_per_second()).abs();
            if !command.is_rest() {
                totals.movement_s += step_s;
                totals.moves += usize::from(before.is_rest());
                totals.switches += usize::from(!before.is_rest() && command != before);
                if !command.pan.is_zero() && !command.tilt.is_zero() {
                    totals.both_axes_s += step_s;
                }
            }
            before = command;
        }
        Some(totals)
    }
}

/// RMS of the second derivative of the achieved rates, both axes together, rad/s³; `None` for fewer than
/// three rows.
fn jerk(log: &TrialLog, truth: &[RowTruth]) -> Option<f64> {
    let squares = (1..truth.len().saturating_sub(1)).map(|index| {
        let (before_s, after_s) = (log.row_duration_s(index - 1), log.row_duration_s(index));
        let (before, now, after) = (
            truth[index - 1].achieved_rates?,
            truth[index].achieved_rates?,
            truth[index + 1].achieved_rates?,
        );
        let second = |before: f64, now: f64, after: f64| {
            ((after - now) / after_s - (now - before) / before_s) / (0.5 * (before_s + after_s))
        };
        let (pan, tilt) = (second(before.0, now.0, after.0), second(before.1, now.1, after.1));
        Some(pan * pan + tilt * tilt)
    });
    mean(squares.flatten().filter(|square| square.is_finite())).map(f64::sqrt)
}

/// Time without the target, s.
struct LostTime {
    total_s: f64,
    longest_s: f64,
    at_end: bool,
}

impl LostTime {
    fn from_log(log: &TrialLog, is_lost: impl Fn(usize) -> bool) -> Self {
        let mut lost = Self { total_s: 0.0, longest_s: 0.0, at_end: false };
        let mut current_s = 0.0;
        for index in 0..log.rows.len() {
            lost.at_end = is_lost(index);
            if lost.at_end {
                let step_s = log.row_duration_s(index);
                current_s += step_s;
                lost.total_s += step_s;
                lost.longest_s = lost.longest_s.max(current_s);
            } else {
                current_s = 0.0;
            }
        }
        lost
    }
}
