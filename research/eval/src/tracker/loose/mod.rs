//! How much the score depends on the operator's selection: selections that are too small or too large and
//! beside the target.
//!
//! Each clip is tracked from every loose selection in the frame of the exact one. In a clip whose selection
//! is refused every frame counts as lost. Judged are the means over all clips beside those of the exact
//! selections.

mod selections;

use serde_json::{Value, json};

use super::clip_sets::ClipSet;
use super::clips::Clip;
use super::reliability::{LabelledFrame, labelled_frames};
use super::requirements::Requirements;
use super::scoring::Score;
use super::text_table::{Table, cell};
use super::tracker_run::run_tracker;
use super::tracker_under_test::TrackerFactory;
use crate::output::print_line;
use crate::statistics::mean;
use selections::{SIZES, loose_selections};

/// The means must be at least these shares of the exact selections'.
const MIN_AUC_SHARE: f64 = 0.85;
const MIN_PRECISION_SHARE: f64 = 0.88;
/// The mean share lost may be larger than the exact selections' by at most this.
const MAX_LOST_EXCESS: f64 = 0.02;

/// The runs of a clip from loose selections.
pub(crate) struct LooseRuns {
    /// The score of each selection, size by size.
    scores: Vec<Score>,
    /// How many selections were refused.
    refused: usize,
    /// The labelled frames of all runs.
    pub(crate) labelled: Vec<LabelledFrame>,
}

impl LooseRuns {
    /// Tracks a clip from every loose selection.
    pub(crate) fn measure(factory: TrackerFactory<'_>, clip: &Clip) -> Self {
        let mut runs = Self { scores: Vec::new(), refused: 0, labelled: Vec::new() };
        for selection in loose_selections(clip.selection) {
            let run = run_tracker(factory(&clip.name).as_mut(), clip, selection);
            runs.scores.push(run.score(clip));
            runs.refused += usize::from(run.selection_error.is_some());
            runs.labelled.extend(labelled_frames(clip, &run));
        }
        runs
    }
}

/// A clip with the score of its exact selection.
pub(crate) struct LooseClip<'a> {
    pub(crate) name: &'a str,
    pub(crate) exact: Score,
    pub(crate) loose: &'a LooseRuns,
}

/// Mean scores of exact and loose selections.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Comparison {
    exact: Quality,
    loose: Quality,
    refused: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Quality {
    auc: f64,
    precision: f64,
    lost: f64,
}

impl Quality {
    fn mean(qualities: &[Self]) -> Self {
        let mean_of = |value: fn(&Self) -> f64| mean(&qualities.iter().map(value).collect::<Vec<_>>());
        Self {
            auc: mean_of(|quality| quality.auc),
            precision: mean_of(|quality| quality.precision),
            lost: mean_of(|quality| quality.lost),
        }
    }

    const fn from_score(score: &Score) -> Self {
        Self { auc: score.auc, precision: score.precision, lost: score.lost }
    }
}

impl Comparison {
    fn of_clip(clip: &LooseClip<'_>) -> Self {
        let loose: Vec<Quality> = clip.loose.scores.iter().map(Quality::from_score).collect();
        Self {
            exact: Quality::from_score(&clip.exact),
            loose: Quality::mean(&loose),
            refused: clip.loose.refused,
        }
    }

    fn mean(clips: &[Self]) -> Self {
        Self {
            exact: Quality::mean(&clips.iter().map(|clip| clip.exact).collect::<Vec<_>>()),
            loose: Quality::mean(&clips.iter().map(|clip| clip.loose).collect::<Vec<_>>()),
            refused: clips.iter().map(|clip| clip.refused).sum(),
        }
    }

    fn cells(&self, name: &str) -> Vec<String> {
        let Self { exact, loose, refused } = self;
        vec![
            name.to_owned(),
            cell(exact.auc, 3),
            cell(loose.auc, 3),
            cell(loose.auc / exact.auc, 2),
            cell(exact.precision, 3),
            cell(loose.precision, 3),
            cell(loose.precision / exact.precision, 2),
            cell(exact.lost, 3),
            cell(loose.lost, 3),
            cell(loose.lost - exact.lost, 3),
            refused.to_string(),
        ]
    }
}

/// Prints each clip and the means, judges the mean over all clips if `is_judged`, and returns the figures.
pub(crate) fn report(
    clips: &[LooseClip<'_>],
    sets: &[ClipSet],
    is_judged: bool,
    requirements: &mut Requirements,
) -> Value {
    let compared: Vec<Comparison> = clips.iter().map(Comparison::of_clip).collect();
    let mut table = Table::new(&[
        "clip", "AUC", "loose", "ratio", "P20", "loose", "ratio", "lost", "loose", "excess", "refused",
    ]);
    for (clip, comparison) in clips.iter().zip(&compared) {
        table.row(comparison.cells(clip.name));
    }
    for set in sets {
        let members: Vec<Comparison> = clips
            .iter()
            .zip(&compared)
            .filter(|(clip, _)| set.contains(clip.name))
            .map(|(_, comparison)| *comparison)
            .collect();
        table.row(Comparison::mean(&members).cells(&format!("mean: {} ({})", set.name, set.len())));
    }
    let selections: usize = clips.iter().map(|clip| clip.loose.scores.len()).sum();
    table.print(&format!("Loose selections ({selections} in all)"));
    print_sizes(clips);
    print_line("");
    let mean = Comparison::mean(&compared);
    if is_judged {
        judge(&mean, requirements);
    }
    json!({
        "refused": mean.refused,
        "clips": clips.iter().zip(&compared).map(|(clip, comparison)| json!({
            "clip": clip.name, "refused": comparison.refused,
            "exact": quality_json(&comparison.exact), "loose": quality_json(&comparison.loose),
            "aucs": clip.loose.scores.iter().map(|score| score.auc).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
    })
}

/// Prints the means over all clips by the size of the selection.
fn print_sizes(clips: &[LooseClip<'_>]) {
    let mut table = Table::new(&["size of the selection", "AUC", "P20", "lost"]);
    for (index, size) in SIZES.into_iter().enumerate() {
        let of_size = |clip: &LooseClip<'_>| {
            let each = clip.loose.scores.len() / SIZES.len();
            clip.loose.scores[index * each..][..each].iter().map(Quality::from_score).collect::<Vec<_>>()
        };
        let mean = Quality::mean(&clips.iter().flat_map(of_size).collect::<Vec<_>>());
        table.row(vec![size.to_string(), cell(mean.auc, 3), cell(mean.precision, 3), cell(mean.lost, 3)]);
    }
    table.print("Loose selections by size, mean over all clips");
}

fn quality_json(quality: &Quality) -> Value {
    json!({ "auc": quality.auc, "precision": quality.precision, "lost": quality.lost })
}

fn judge(mean: &Comparison, requirements: &mut Requirements) {
    let Comparison { exact, loose, .. } = mean;
    requirements.at_least(
        "loose selections: AUC as a share of the exact",
        loose.auc / exact.auc,
        MIN_AUC_SHARE,
    );
    let share = loose.precision / exact.precision;
    requirements.at_least("loose selections: precision as a share of the exact", share, MIN_PRECISION_SHARE);
    let excess = loose.lost - exact.lost;
    requirements.at_most("loose selections: share lost above the exact", excess, MAX_LOST_EXCESS);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(auc: f64, precision: f64, lost: f64) -> Score {
        Score { auc, precision, lost, scored: 10, ..Score::default() }
    }

    fn runs(scores: Vec<Score>) -> LooseRuns {
        LooseRuns { scores, refused: 1, labelled: Vec::new() }
    }

    #[test]
    fn a_clip_counts_as_the_mean_of_its_selections() {
        let loose = runs(vec![score(0.6, 1.0, 0.0), score(0.2, 0.5, 0.5)]);
        let clip = LooseClip { name: "clip", exact: score(0.8, 1.0, 0.0), loose: &loose };
        let comparison = Comparison::of_clip(&clip);
        assert_eq!(
            (comparison.loose.auc, comparison.loose.precision, comparison.loose.lost),
            (0.4, 0.75, 0.25)
        );
        assert_eq!(comparison.cells("clip")[3], "0.50");
        assert_eq!(Comparison::mean(&[comparison, comparison]).refused, 2);
    }

    #[test]
    fn means_that_are_too_far_below_the_exact_are_missed() {
        let comparison = |loose| {
            let exact = Quality { auc: 0.8, precision: 1.0, lost: 0.0 };
            let mut requirements = Requirements::default();
            judge(&Comparison { exact, loose, refused: 0 }, &mut requirements);
            requirements.finish()
        };
        assert!(comparison(Quality { auc: 0.7, precision: 0.9, lost: 0.02 }));
        assert!(!comparison(Quality { auc: 0.66, precision: 0.9, lost: 0.02 }));
        assert!(!comparison(Quality { auc: 0.7, precision: 0.87, lost: 0.02 }));
        assert!(!comparison(Quality { auc: 0.7, precision: 0.9, lost: 0.03 }));
    }
}
