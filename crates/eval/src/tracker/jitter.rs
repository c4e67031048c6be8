//! Selections that an operator could as well have dragged: how far the score hangs on the one that was.

use barrelman_vocab::PixelBox;

use super::chance::Chance;
use super::clips::Clip;
use super::figures::mean;
use super::follow::follow;
use super::report::{Table, cell};
use super::scoring::Score;
use super::under_test::Factory;

/// Selections a clip.
const SELECTIONS: u64 = 5;
/// Largest shift of the centre, as a share of the side.
const SHIFT: f64 = 0.05;
/// Each side is scaled by up to this share, either way.
const SCALE: f64 = 0.05;

/// Scores of the moved selections.
pub(crate) fn scores(factory: Factory<'_>, clip: &Clip) -> Vec<Score> {
    let mut scores = Vec::new();
    for number in 0..SELECTIONS {
        let selection = moved(clip.selection, &mut Chance::named(&clip.name, number));
        scores.push(follow(factory().as_mut(), clip, selection).score(clip));
    }
    scores
}

fn moved(selection: PixelBox, chance: &mut Chance) -> PixelBox {
    let mut centre = selection.centre();
    centre.u += selection.w * chance.between(-SHIFT, SHIFT);
    centre.v += selection.h * chance.between(-SHIFT, SHIFT);
    let w = selection.w * chance.between(1.0 - SCALE, 1.0 + SCALE);
    let h = selection.h * chance.between(1.0 - SCALE, 1.0 + SCALE);
    PixelBox { u: centre.u - w / 2.0, v: centre.v - h / 2.0, w, h }
}

/// Prints them: name, AUC of the label as selection, and the scores of the moved ones, for each clip.
pub(crate) fn say_table<'a>(clips: impl Iterator<Item = (&'a str, f64, &'a [Score])>) {
    let mut table = Table::new(&["clip", "label", "moved: AUC", "least", "most", "P20", "lost"]);
    let mut means = Vec::new();
    for (name, auc, scores) in clips {
        let all = |part: fn(&Score) -> f64| scores.iter().map(part).collect::<Vec<_>>();
        let aucs = all(|score| score.auc);
        let row = [
            auc,
            mean(&aucs),
            aucs.iter().copied().fold(f64::INFINITY, f64::min),
            aucs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean(&all(|score| score.precision)),
            mean(&all(|score| score.lost)),
        ];
        table.row(cells(name, &row));
        means.push(row);
    }
    let over: Vec<f64> =
        (0..6).map(|column| mean(&means.iter().map(|row| row[column]).collect::<Vec<_>>())).collect();
    table.row(cells("mean over clips", &over));
    table.say(&format!("{SELECTIONS} slightly moved selections a clip"));
}

fn cells(name: &str, row: &[f64]) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(row.iter().map(|value| cell(*value, 3))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_selection_stays_close() {
        let selection = PixelBox { u: 100.0, v: 50.0, w: 40.0, h: 20.0 };
        let moved: Vec<PixelBox> =
            (0..100).map(|number| moved(selection, &mut Chance::named("clip", number))).collect();
        for other in &moved {
            assert!((other.centre().u - selection.centre().u).abs() <= 2.0, "{other}");
            assert!((other.centre().v - selection.centre().v).abs() <= 1.0, "{other}");
            assert!((38.0..=42.0).contains(&other.w) && (19.0..=21.0).contains(&other.h), "{other}");
        }
        assert_ne!(moved[0], moved[1]);
    }
}
