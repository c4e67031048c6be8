//! The metrics of one trial.

use barrelman_control::Region;
use barrelman_vocab::{ImagePoint, PictureSize, VehicleRates};
use serde::{Deserialize, Serialize};

use super::excursion::{Excursion, excursions};
use crate::logs::{RowTruth, TrialLog};

/// A target within this share of half the picture's width or height from its border counts as at the border.
pub const BORDER_SHARE: f64 = 0.05;
/// A track that was lost for longer than this at a stretch makes the trial a lost one, seconds.
pub const LOST_AFTER_S: f64 = 2.0;

/// The metrics of one trial. Fields are `null` where the log cannot tell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialMetrics {
    /// Rows.
    pub samples: usize,
    /// From the first row to the end of the last, seconds.
    pub duration_s: f64,
    /// Maximal runs of rows with P > 1.
    pub excursions: usize,
    /// Those after which the log goes on.
    pub complete_excursions: usize,
    /// Time with P > 1, seconds.
    pub time_outside_s: f64,
    /// Largest P.
    pub max_p: Option<f64>,
    /// Mean of the largest P less 1 over the complete excursions.
    pub mean_h: Option<f64>,
    /// Mean duration of the complete excursions, seconds.
    pub mean_b_s: Option<f64>,
    /// Share of time with a command in force.
    pub duty: Option<f64>,
    /// Integral of |rate| over both axes, rad.
    pub travel_rad: Option<f64>,
    /// Integral of the squared rate over both axes, rad²/s.
    pub effort_rad2_per_s: Option<f64>,
    /// Starts of a command from rest.
    pub moves: Option<usize>,
    /// A command followed at once by a different one that is not zero.
    pub switches: Option<usize>,
    /// Share of the moving time with both axes moving.
    pub both_axes: Option<f64>,
    /// Time with a command in force, seconds.
    pub movement_s: Option<f64>,
    /// Sum of |change| of the command over both axes, rad/s.
    pub variation_rad_per_s: Option<f64>,
    /// RMS second derivative of the achieved rate, rad/s³; simulator only.
    pub jerk_rad_per_s3: Option<f64>,
    /// Time at the picture's border, seconds.
    pub border_s: f64,
    /// Time out of the picture (recordings: track lost), seconds.
    pub out_of_picture_s: Option<f64>,
    /// The last known position is outside of the region.
    pub ends_outside: bool,
    /// The target was out of the picture for over 2 s at a stretch, or at the end.
    pub lost: Option<bool>,
    /// Mean of h/b over the complete excursions, 1/s.
    pub sensitivity: Option<f64>,
}

impl TrialMetrics {
    /// Whether the trial succeeded: the target was not lost, or, where that is not known, it does not end
    /// outside of the region.
    pub fn succeeded(&self) -> bool {
        !self.lost.unwrap_or(self.ends_outside)
    }
}

/// The metrics of a trial for a region, in a picture of that size.
pub fn measure(log: &TrialLog, region: Region, picture: PictureSize) -> TrialMetrics {
    let all = excursions(log, region);
    let complete: Vec<&Excursion> = all.iter().filter(|excursion| excursion.complete).collect();
    let ps = || log.rows.iter().filter_map(|row| row.position).map(|position| region.p(position));
    let time_where = |condition: &dyn Fn(ImagePoint) -> bool| -> f64 {
        let rows = log.rows.iter().enumerate();
        rows.filter(|(_, row)| row.position.is_some_and(condition))
            .fold(0.0, |sum, (index, _)| sum + log.step_s(index))
    };
    let camera = CameraWork::of(log);
    let lost = match &log.truth {
        Some(truth) => Some(LostTime::of(log, |index| truth[index].out_of_picture)),
        None => log.knows_lost.then(|| LostTime::of(log, |index| log.rows[index].position.is_none())),
    };
    let duration_s = log.duration_s();
    TrialMetrics {
        samples: log.rows.len(),
        duration_s,
        excursions: all.len(),
        complete_excursions: complete.len(),
        // A sum of nothing would be a negative zero.
        time_outside_s: all.iter().fold(0.0, |sum, excursion| sum + excursion.b_s),
        max_p: ps().reduce(f64::max),
        mean_h: mean(complete.iter().map(|excursion| excursion.h)),
        mean_b_s: mean(complete.iter().map(|excursion| excursion.b_s)),
        duty: camera.as_ref().and_then(|work| (duration_s > 0.0).then(|| work.movement_s / duration_s)),
        travel_rad: camera.as_ref().map(|work| work.travel_rad),
        effort_rad2_per_s: camera.as_ref().map(|work| work.effort_rad2_per_s),
        moves: camera.as_ref().map(|work| work.moves),
        switches: camera.as_ref().map(|work| work.switches),
        both_axes: camera
            .as_ref()
            .and_then(|work| (work.movement_s > 0.0).then(|| work.both_axes_s / work.movement_s)),
        movement_s: camera.as_ref().map(|work| work.movement_s),
        variation_rad_per_s: camera.as_ref().map(|work| work.variation_rad_per_s),
        jerk_rad_per_s3: log.truth.as_ref().and_then(|truth| jerk(log, truth)),
        border_s: time_where(&|position| at_border(position, picture)),
        out_of_picture_s: lost.as_ref().map(|lost| lost.total_s),
        ends_outside: ps().next_back().is_some_and(|p| p > 1.0),
        lost: lost.map(|lost| lost.longest_s > LOST_AFTER_S || lost.at_end),
        sensitivity: mean(complete.iter().filter_map(|excursion| excursion.sensitivity())),
    }
}

/// The mean; `None` of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / count as f64)
}

fn at_border(position: ImagePoint, picture: PictureSize) -> bool {
    let inner = 1.0 - BORDER_SHARE;
    position.x.abs() >= inner * f64::from(picture.width) / 2.0
        || position.y.abs() >= inner * f64::from(picture.height) / 2.0
}

/// What the camera was told over a trial.
#[derive(Debug, Default)]
struct CameraWork {
    travel_rad: f64,
    effort_rad2_per_s: f64,
    moves: usize,
    switches: usize,
    both_axes_s: f64,
    movement_s: f64,
    variation_rad_per_s: f64,
}

impl CameraWork {
    /// `None` where a row does not say what was commanded.
    fn of(log: &TrialLog) -> Option<Self> {
        let mut work = Self::default();
        let mut before = VehicleRates::REST;
        for (index, row) in log.rows.iter().enumerate() {
            let rates = row.rates?;
            let step_s = log.step_s(index);
            let (yaw, pitch) = (rates.yaw.radians_per_second(), rates.pitch.radians_per_second());
            work.travel_rad += (yaw.abs() + pitch.abs()) * step_s;
            work.effort_rad2_per_s += (yaw * yaw + pitch * pitch) * step_s;
            work.variation_rad_per_s += (yaw - before.yaw.radians_per_second()).abs()
                + (pitch - before.pitch.radians_per_second()).abs();
            if !rates.is_rest() {
                work.movement_s += step_s;
                work.moves += usize::from(before.is_rest());
                work.switches += usize::from(!before.is_rest() && rates != before);
                if !rates.yaw.is_zero() && !rates.pitch.is_zero() {
                    work.both_axes_s += step_s;
                }
            }
            before = rates;
        }
        Some(work)
    }
}

/// RMS second derivative of the achieved rates, both axes together, rad/s³; `None` of fewer than three rows.
fn jerk(log: &TrialLog, truth: &[RowTruth]) -> Option<f64> {
    let squares = (1..truth.len().saturating_sub(1)).map(|index| {
        let (before_s, after_s) = (log.step_s(index - 1), log.step_s(index));
        let (before, now, after) =
            (truth[index - 1].achieved?, truth[index].achieved?, truth[index + 1].achieved?);
        let second = |before: f64, now: f64, after: f64| {
            ((after - now) / after_s - (now - before) / before_s) / (0.5 * (before_s + after_s))
        };
        let (pan, tilt) = (second(before.0, now.0, after.0), second(before.1, now.1, after.1));
        Some(pan * pan + tilt * tilt)
    });
    mean(squares.flatten().filter(|square| square.is_finite())).map(f64::sqrt)
}

/// Time without a position.
struct LostTime {
    total_s: f64,
    longest_s: f64,
    at_end: bool,
}

impl LostTime {
    fn of(log: &TrialLog, is_lost: impl Fn(usize) -> bool) -> Self {
        let mut lost = Self { total_s: 0.0, longest_s: 0.0, at_end: false };
        let mut stretch_s = 0.0;
        for index in 0..log.rows.len() {
            lost.at_end = is_lost(index);
            if lost.at_end {
                let step_s = log.step_s(index);
                stretch_s += step_s;
                lost.total_s += step_s;
                lost.longest_s = lost.longest_s.max(stretch_s);
            } else {
                stretch_s = 0.0;
            }
        }
        lost
    }
}
