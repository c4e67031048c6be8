//! Selections of the background: water, land, sky, and whatever else is not the target. A tracker should
//! refuse them, or soon say that there is nothing to follow.
//!
//! Six selections of each clip and of each generated scene, at frames spread over it, of 0.7 to 2 times the
//! target's size, anywhere in the picture where the target does not come near within the next second. A
//! selection is *right* if it is refused, or if in the frame next to 1 s later the track is lost or its
//! confidence is below 0.5.

mod generated;
mod outcome;
mod placement;
mod target_extent;

use anyhow::Result;
use serde_json::{Value, json};

use super::clips::Clip;
use super::requirements::Requirements;
use super::text_table::{Table, cell};
use super::tracker_under_test::TrackerFactory;
use crate::output::print_line;
use crate::parallel;
use generated::generated_clips;
use outcome::{JudgedSelection, MIN_CLAIM, Outcome, Tally};
use placement::JUDGED_AFTER_S;
pub(crate) use placement::draw_selections;

/// Selections of each clip and of each generated scene: 300 on 38 clips and 12 scenes. A target that fills a
/// clip's picture leaves no room for any.
const SELECTIONS: usize = 6;

/// Least share of right selections.
const MIN_RIGHT: f64 = 0.97;

/// The selections of a clip.
pub(crate) struct BackgroundRuns {
    name: String,
    selections: Vec<JudgedSelection>,
}

impl BackgroundRuns {
    /// Draws, tracks and judges the selections of a clip.
    pub(crate) fn measure(factory: TrackerFactory<'_>, clip: &Clip) -> Self {
        let selections = draw_selections(clip, SELECTIONS, 0)
            .into_iter()
            .map(|selection| JudgedSelection::measure(factory(&clip.name).as_mut(), clip, selection));
        Self { name: clip.name.clone(), selections: selections.collect() }
    }

    fn tally(&self) -> Tally {
        Tally::of(self.selections.iter().map(|selection| selection.outcome))
    }
}

/// Draws, tracks and judges the selections of all generated scenes.
///
/// # Errors
/// If a scene cannot be rendered.
pub(crate) fn measure_generated(factory: TrackerFactory<'_>) -> Result<Vec<BackgroundRuns>> {
    let results = parallel::map(&generated_clips(), |generated| {
        anyhow::Ok(BackgroundRuns::measure(factory, &generated.render()?))
    });
    results.into_iter().collect()
}

/// Prints each clip and the totals, judges the share over all if `is_judged`, and returns the figures.
pub(crate) fn report(
    clips: &[&BackgroundRuns],
    generated: &[BackgroundRuns],
    is_judged: bool,
    requirements: &mut Requirements,
) -> Value {
    let all: Vec<&BackgroundRuns> = clips.iter().copied().chain(generated).collect();
    let total = |runs: &[&BackgroundRuns]| {
        Tally::of(runs.iter().flat_map(|runs| &runs.selections).map(|selection| selection.outcome))
    };
    let mut table =
        Table::new(&["clip", "selections", "right", "refused", "lost", "low confidence", "wrong"]);
    for runs in &all {
        table.row(cells(&runs.name, runs.tally()));
    }
    table.row(cells("all clips", total(clips)));
    table.row(cells("all generated", total(&generated.iter().collect::<Vec<_>>())));
    table.row(cells("all", total(&all)));
    table.print(&format!(
        "Selections of the background, judged after {JUDGED_AFTER_S} s (wrong: confidence of at least {MIN_CLAIM})"
    ));
    print_line("");
    if is_judged {
        let name = "background selections: share right";
        requirements.at_least(name, total(&all).right_share(), MIN_RIGHT);
    }
    to_json(&all)
}

fn cells(name: &str, tally: Tally) -> Vec<String> {
    let counts = [tally.refused, tally.lost, tally.low_confidence, tally.wrong];
    let mut cells = vec![name.to_owned(), tally.count().to_string(), cell(tally.right_share(), 3)];
    cells.extend(counts.map(|count| count.to_string()));
    cells
}

/// All selections, and the wrong ones by confidence, the highest first.
fn to_json(all: &[&BackgroundRuns]) -> Value {
    let selections = || {
        all.iter().flat_map(|runs| runs.selections.iter().map(|selection| (runs.name.as_str(), selection)))
    };
    let rows = |selections: &[(&str, &JudgedSelection)]| {
        selections.iter().map(|(name, selection)| selection.to_json(name)).collect::<Vec<_>>()
    };
    let mut worst: Vec<_> =
        selections().filter(|(_, selection)| selection.outcome == Outcome::Wrong).collect();
    worst
        .sort_by(|(_, a), (_, b)| f64::total_cmp(&b.confidence.unwrap_or(0.0), &a.confidence.unwrap_or(0.0)));
    json!({ "worst": rows(&worst), "selections": rows(&selections().collect::<Vec<_>>()) })
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::placement::BackgroundSelection;
    use super::*;

    fn runs(outcomes: &[(Outcome, f64)]) -> BackgroundRuns {
        let selection = BackgroundSelection { frame: 0, bounds: PixelBox::default(), judged: 10 };
        let judged = |&(outcome, confidence): &(Outcome, f64)| JudgedSelection {
            selection,
            outcome,
            confidence: Some(confidence),
        };
        BackgroundRuns { name: "clip".to_owned(), selections: outcomes.iter().map(judged).collect() }
    }

    #[test]
    fn the_worst_are_the_wrong_with_the_highest_confidence_first() {
        let runs = runs(&[(Outcome::Wrong, 0.6), (Outcome::Lost, 0.95), (Outcome::Wrong, 0.9)]);
        let json = to_json(&[&runs]);
        let confidences: Vec<f64> =
            json["worst"].as_array().unwrap().iter().map(|row| row["confidence"].as_f64().unwrap()).collect();
        assert_eq!(confidences, [0.9, 0.6]);
        assert_eq!(json["selections"].as_array().unwrap().len(), 3);
    }

    #[test]
    fn too_many_wrong_selections_are_missed() {
        let mut requirements = Requirements::default();
        let mostly_lost = runs(&[(Outcome::Lost, 0.0); 97]);
        report(&[&mostly_lost, &runs(&[(Outcome::Wrong, 0.9); 3])], &[], true, &mut requirements);
        assert!(requirements.finish());
        report(&[&mostly_lost, &runs(&[(Outcome::Wrong, 0.9); 4])], &[], true, &mut requirements);
        assert!(!requirements.finish());
    }
}
