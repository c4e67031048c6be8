//! Detections in rendered scenes, in which all people and boats are labelled, and on empty water, where each
//! is false.

use anyhow::Result;
use barrelman_detector::Object;

use super::measured::{LEAST_SCORE, MeasuredDetector};
use super::scene::{Kind, render_sea};
use super::tally::{Tally, Wanted};
use crate::output::print_line;
use crate::tracker::empty_water::{SEA_STATES, SECONDS, for_frames};
use crate::tracker::text_table::{Table, cell};

/// The seed of the scenes, on which no model is trained.
const SEED: u64 = 1_000_003;
/// Pictures a second on empty water: as often as a model runs.
const PICTURES: u32 = 3;
/// Labels with a shorter side are left out, pixels of 640 across.
const LEAST_SIDE_PX: f64 = 5.0;

/// Prints precision and recall of each class, on scenes of so many seas.
///
/// # Errors
/// If a scene cannot be rendered, or the model not be computed.
pub(super) fn measure_scenes(detector: &mut MeasuredDetector, seas: u64) -> Result<()> {
    let mut pictures: Vec<(Vec<Object>, Vec<Wanted>)> = Vec::new();
    for sea in 0..seas {
        render_sea(SEED, sea, |_, picture, labelled| {
            let wanted =
                labelled.iter().filter(|object| object.bounds.w.min(object.bounds.h) >= LEAST_SIDE_PX);
            let class = |kind| detector.class(if kind == Kind::Person { "person" } else { "boat" });
            let wanted = wanted.map(|object| (object.bounds, class(object.kind))).collect();
            pictures.push((detector.detect(picture)?, wanted));
            Ok(())
        })?;
    }
    for name in ["person", "boat"] {
        let Some(class) = detector.class(name) else { continue };
        let mut table = Table::new(&["score", "recall 0.5", "recall 0.3", "precision"]);
        let mut labels = 0;
        for tenth in 1..10_u8 {
            let score = f32::from(tenth) * LEAST_SCORE;
            let mut tally = Tally::default();
            for (found, wanted) in &pictures {
                let found: Vec<Object> =
                    found.iter().filter(|object| object.class == class).copied().collect();
                let wanted: Vec<Wanted> =
                    wanted.iter().filter(|(_, wanted)| *wanted == Some(class)).copied().collect();
                tally.add(&found, &wanted, score);
            }
            labels = tally.wanted;
            table.row(vec![
                cell(score.into(), 1),
                cell(tally.recall(), 2),
                cell(tally.near_recall(), 2),
                cell(tally.precision(), 2),
            ]);
        }
        table.print(&format!("Rendered scenes, {} pictures: {name}, {labels} labels", pictures.len()));
    }
    Ok(())
}

/// Prints the false detections on empty water for each sea state, from so many seas each.
///
/// # Errors
/// If a sea cannot be simulated, or the model not be computed.
pub(super) fn measure_empty_water(detector: &mut MeasuredDetector, seas: u64) -> Result<()> {
    let score = detector.score;
    print_line(&format!(
        "\nEmpty water, {seas} seas a state, {SECONDS} s each, {PICTURES} pictures a second, score at least {score}"
    ));
    for state in 0..SEA_STATES {
        let mut detections = 0;
        for sea in 0..seas {
            for_frames(state, 80_000 + sea, PICTURES, |frame| {
                let found = detector.detect(&frame.picture)?;
                detections += found.iter().filter(|object| object.score >= score).count();
                Ok(())
            })?;
        }
        let seconds = seas as f64 * f64::from(SECONDS);
        print_line(&format!(
            "sea state {state}: {:.2} false detections a second",
            detections as f64 / seconds
        ));
    }
    Ok(())
}
