//! Axis and heading in real clips, at bows that were labelled by eye (`data/bows.csv`: anticlockwise from
//! image right, degrees). A boat is followed from its first label on, without a motion prior.

use anyhow::{Context, Result};
use barrelman_vocab::Angle;

use super::clips::Clip;
use super::labelled_pictures::chosen_clips;
use super::orientation::{WRONG_END_DEG, angle_deg, axis_error_deg};
use super::text_table::{Table, cell};
use super::tracker_run::run_tracker;
use super::tracker_under_test::{TrackerConfig, build_tracker};
use crate::parallel;
use crate::statistics::quantile;

const BOWS: &str = include_str!("../../data/bows.csv");

/// What was reported at the labelled bows of a clip.
#[derive(Debug, Default)]
struct Reported {
    bows: usize,
    axis_errors_deg: Vec<f64>,
    heading_errors_deg: Vec<f64>,
}

impl Reported {
    fn add(&mut self, other: &Self) {
        self.bows += other.bows;
        self.axis_errors_deg.extend(&other.axis_errors_deg);
        self.heading_errors_deg.extend(&other.heading_errors_deg);
    }

    fn row(&self, name: &str) -> Vec<String> {
        let wrong = self.heading_errors_deg.iter().filter(|error| **error > WRONG_END_DEG).count();
        vec![
            name.to_owned(),
            self.bows.to_string(),
            self.axis_errors_deg.len().to_string(),
            cell(quantile(&self.axis_errors_deg, 0.5), 1),
            cell(quantile(&self.axis_errors_deg, 1.0), 1),
            self.heading_errors_deg.len().to_string(),
            wrong.to_string(),
        ]
    }
}

/// Prints the table.
///
/// # Errors
/// If a clip cannot be used, or the tracker refuses its settings.
pub(super) fn run(config: &TrackerConfig) -> Result<()> {
    let rows = BOWS.lines().skip(1).map(bow_of).collect::<Result<Vec<_>>>()?;
    let mut names: Vec<String> = rows.iter().map(|(clip, ..)| (*clip).to_owned()).collect();
    names.dedup();
    let clips = chosen_clips(None, &names)?;
    let reported = parallel::map(&clips, |folder| {
        let clip = folder.load()?;
        let bows = rows.iter().filter(|(name, ..)| *name == clip.name).map(|&(_, frame, bow)| (frame, bow));
        reported_at(&clip, bows, config)
    });
    let mut all = Reported::default();
    let mut table =
        Table::new(&["clip", "bows", "axis", "error deg median", "largest", "heading", "wrong end"]);
    for (folder, reported) in clips.iter().zip(reported) {
        let reported = reported?;
        table.row(reported.row(&folder.name));
        all.add(&reported);
    }
    table.row(all.row("all"));
    table.print("Bows that were labelled by eye in real clips");
    Ok(())
}

fn bow_of(line: &str) -> Result<(&str, usize, Angle)> {
    let (clip, rest) = line.split_once(',').context("data/bows.csv has three columns")?;
    let (frame, bow) = rest.split_once(',').context("data/bows.csv has three columns")?;
    Ok((clip, frame.parse()?, Angle::from_degrees(bow.parse()?)))
}

fn reported_at(
    clip: &Clip,
    bows: impl Iterator<Item = (usize, Angle)>,
    config: &TrackerConfig,
) -> Result<Reported> {
    let run = run_tracker(build_tracker(config)?.as_mut(), clip, clip.selection);
    let mut reported = Reported::default();
    // Nothing is tracked up to the selection.
    for (frame, bow) in bows.filter(|(frame, _)| *frame > clip.start) {
        reported.bows += 1;
        let Some(seen) = run.tracks[frame - clip.start - 1].localisation() else { continue };
        reported.axis_errors_deg.extend(seen.shape.map(|shape| axis_error_deg(shape.axis, bow)));
        reported.heading_errors_deg.extend(seen.heading.map(|heading| angle_deg(heading, bow)));
    }
    Ok(reported)
}
