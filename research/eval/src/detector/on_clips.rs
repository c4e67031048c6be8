//! Detections in real clips: in each, one object is labelled.
//!
//! Recall is that of the labelled object. Precision counts every other detection as false, though many are
//! objects, too, that have no label: it is a lower bound.

use std::collections::BTreeMap;

use anyhow::Result;
use barrelman_detector::Object;

use super::measured::{LEAST_SCORE, MeasuredDetector};
use super::tally::{Tally, Wanted};
use crate::statistics::mean;
use crate::tracker::clip_sets::{class_of, is_on_water, recording_of};
use crate::tracker::clips::ClipFolder;
use crate::tracker::labelled_pictures::labelled_pictures;
use crate::tracker::text_table::{Table, cell};

/// The detections and the label of each picture of a clip.
struct ClipRun {
    name: String,
    class: &'static str,
    pictures: Vec<(Vec<Object>, Wanted)>,
}

impl ClipRun {
    fn tally(&self, score: f32) -> Tally {
        let mut tally = Tally::default();
        for (found, wanted) in &self.pictures {
            tally.add(found, std::slice::from_ref(wanted), score);
        }
        tally
    }
}

/// Prints a row for each clip, and a row for each threshold.
///
/// # Errors
/// If a clip cannot be used, or has no class.
pub(super) fn measure(detector: &mut MeasuredDetector, clips: &[ClipFolder], frames: usize) -> Result<()> {
    let mut runs = Vec::new();
    for folder in clips {
        let class = class_of(&folder.name)?;
        let clip = folder.load()?;
        let index = detector.class(class);
        let pictures = labelled_pictures(&clip, frames)
            .map(|(picture, label)| Ok((detector.detect(picture)?, (label, index))))
            .collect::<Result<_>>()?;
        runs.push(ClipRun { name: clip.name, class, pictures });
    }
    print_clips(&runs, detector.score);
    for (set, is_meant) in [("on water", true), ("elsewhere", false)] {
        let members = |class: &str| {
            let is_member = |run: &&ClipRun| {
                is_on_water(&run.name) == is_meant && (class.is_empty() || run.class == class)
            };
            runs.iter().filter(is_member).collect::<Vec<_>>()
        };
        for class in ["", "person", "boat"] {
            let (members, set) = (members(class), format!("{set} {class}"));
            if !members.is_empty() {
                print_thresholds(set.trim_end(), &members);
            }
        }
    }
    Ok(())
}

fn print_clips(runs: &[ClipRun], score: f32) {
    let mut table =
        Table::new(&["clip", "class", "pictures", "recall 0.5", "recall 0.3", "precision", "detections"]);
    for run in runs {
        let tally = run.tally(score);
        let is_known = run.class != "other";
        let known = |value: f64| cell(if is_known { value } else { f64::NAN }, 2);
        table.row(vec![
            run.name.clone(),
            run.class.to_owned(),
            tally.pictures.to_string(),
            known(tally.recall()),
            known(tally.near_recall()),
            known(tally.precision()),
            cell(tally.detections_a_picture(), 2),
        ]);
    }
    table.print(&format!(
        "Clips, score at least {score}: recall of the labelled object at IoU 0.5 and 0.3, precision (objects without \
         a label count as false), detections a picture"
    ));
}

/// A row for each threshold: means in which each recording counts once.
fn print_thresholds(set: &str, runs: &[&ClipRun]) {
    let mut table = Table::new(&["score", "recall 0.5", "recall 0.3", "precision", "detections"]);
    for tenth in 1..10_u8 {
        let score = f32::from(tenth) * LEAST_SCORE;
        let mut recordings: BTreeMap<&str, Vec<Tally>> = BTreeMap::new();
        for run in runs {
            recordings.entry(recording_of(&run.name)).or_default().push(run.tally(score));
        }
        let of = |figure: fn(&Tally) -> f64| {
            let means =
                recordings.values().map(|tallies| mean(&tallies.iter().map(figure).collect::<Vec<_>>()));
            mean(&means.collect::<Vec<_>>())
        };
        let detections = of(Tally::detections_a_picture);
        let right = of(|tally| tally.right as f64 / tally.pictures as f64);
        table.row(vec![
            cell(score.into(), 1),
            cell(of(Tally::recall), 2),
            cell(of(Tally::near_recall), 2),
            cell(right / detections, 2),
            cell(detections, 2),
        ]);
    }
    let recordings: std::collections::BTreeSet<_> = runs.iter().map(|run| recording_of(&run.name)).collect();
    table.print(&format!("Clips {set}, {} recordings, each counts once", recordings.len()));
}
