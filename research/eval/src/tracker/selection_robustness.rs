//! How much the score depends on the operator's selection: spatial robustness (Wu, Lim and Yang, Online
//! object tracking: a benchmark, 2013) with slightly moved and scaled selections.

use barrelman_vocab::PixelBox;
use barrelman_vocab::rng::SplitMix64;

use super::clips::Clip;
use super::scoring::Score;
use super::text_table::{Table, cell};
use super::tracker_run::run_tracker;
use super::tracker_under_test::TrackerFactory;
use crate::rng_of_name::rng_of_name;
use crate::statistics::mean;

/// Selections of each clip.
const SELECTIONS: u64 = 5;
/// Largest shift of the centre, as a share of the side.
const MAX_SHIFT: f64 = 0.05;
/// Largest change of each side, as a share of the side.
const MAX_SCALING: f64 = 0.05;

/// The scores of perturbed selections.
pub(crate) fn score_perturbed_selections(factory: TrackerFactory<'_>, clip: &Clip) -> Vec<Score> {
    let mut scores = Vec::new();
    for number in 0..SELECTIONS {
        let selection = perturbed(clip.selection, &mut rng_of_name(&clip.name, number));
        scores.push(run_tracker(factory(&clip.name).as_mut(), clip, selection).score(clip));
    }
    scores
}

fn perturbed(selection: PixelBox, rng: &mut SplitMix64) -> PixelBox {
    let mut centre = selection.centre();
    centre.u += selection.w * rng.between(-MAX_SHIFT, MAX_SHIFT);
    centre.v += selection.h * rng.between(-MAX_SHIFT, MAX_SHIFT);
    let w = selection.w * rng.between(1.0 - MAX_SCALING, 1.0 + MAX_SCALING);
    let h = selection.h * rng.between(1.0 - MAX_SCALING, 1.0 + MAX_SCALING);
    PixelBox { u: centre.u - w / 2.0, v: centre.v - h / 2.0, w, h }
}

/// Prints for each clip: its name, the AUC with the label as selection, and the scores of the perturbed
/// selections.
pub(crate) fn print_table<'a>(clips: impl Iterator<Item = (&'a str, f64, &'a [Score])>) {
    let mut table = Table::new(&["clip", "label", "moved: AUC", "least", "most", "P20", "lost"]);
    let mut rows = Vec::new();
    for (name, auc, scores) in clips {
        let values = |value: fn(&Score) -> f64| scores.iter().map(value).collect::<Vec<_>>();
        let aucs = values(|score| score.auc);
        let row = [
            auc,
            mean(&aucs),
            aucs.iter().copied().fold(f64::INFINITY, f64::min),
            aucs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean(&values(|score| score.precision)),
            mean(&values(|score| score.lost)),
        ];
        table.row(cells(name, &row));
        rows.push(row);
    }
    let means: Vec<f64> =
        (0..6).map(|column| mean(&rows.iter().map(|row| row[column]).collect::<Vec<_>>())).collect();
    table.row(cells("mean over clips", &means));
    table.print(&format!("{SELECTIONS} slightly moved selections a clip"));
}

fn cells(name: &str, row: &[f64]) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(row.iter().map(|value| cell(*value, 3))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perturbed_selection_stays_close() {
        let selection = PixelBox { u: 100.0, v: 50.0, w: 40.0, h: 20.0 };
        let perturbed: Vec<PixelBox> =
            (0..100).map(|number| perturbed(selection, &mut rng_of_name("clip", number))).collect();
        for other in &perturbed {
            assert!((other.centre().u - selection.centre().u).abs() <= 2.0, "{other}");
            assert!((other.centre().v - selection.centre().v).abs() <= 1.0, "{other}");
            assert!((38.0..=42.0).contains(&other.w) && (19.0..=21.0).contains(&other.h), "{other}");
        }
        assert_ne!(perturbed[0], perturbed[1]);
    }
}
