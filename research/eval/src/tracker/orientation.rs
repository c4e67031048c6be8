//! The accuracy of axis and heading, on generated scenes of boats that turn, stop and go.
//!
//! The *axis error* is the angle between the reported major axis and the hull's centre line, at most 90
//! degrees. The *heading error* is the angle between the reported and the true heading, at most 180 degrees.
//! A heading error above 90 degrees confuses bow and stern: the *wrong end*. The share of frames with a
//! heading counts frames in which the boat has been under way for 3 s without interruption, because the
//! motion tells bow from stern. Judged are the figures over all scenes, for a tracker with a motion prior.

use anyhow::Result;
use barrelman_vocab::{Angle, Track};
use barrelman_water_scene::{SceneKind, SceneScript, SceneTruth};
use serde_json::{Value, json};

use super::options::Options;
use super::requirements::Requirements;
use super::synthetic_scenes::{SIZE, SceneTracker, paint_name, paint_of_scene, run_all_on_scene};
use super::text_table::{Table, cell};
use super::tracker_under_test::{TrackerConfig, build_tracker};
use crate::output::print_line;
use crate::parallel;
use crate::statistics::{mean, quantile};

/// Lengths of the hull at the start of a scene, pixels: from the smallest that an operator selects to a third
/// of the picture.
const BOATS_PX: [f64; 5] = [20.0, 40.0, 80.0, 140.0, 200.0];

/// Scenes of each length.
const SEEDS: u64 = 12;

/// Duration of a scene, seconds.
const SCENE_S: f64 = 12.0;

/// The axis of a hull shorter than this in a frame is not judged, pixels.
const MIN_AXIS_LENGTH_PX: f64 = 40.0;

/// A heading is expected of a boat that has been under way for this long, seconds.
const MIN_UNDER_WAY_S: f64 = 3.0;

/// A larger heading error confuses bow and stern, degrees.
pub(super) const WRONG_END_DEG: f64 = 90.0;

const MAX_AXIS_ERROR_DEG: f64 = 5.0;
const MIN_PRESENT_SHARE: f64 = 0.8;
const MAX_HEADING_ERROR_DEG: f64 = 10.0;
const MAX_WRONG_END_SHARE: f64 = 0.01;
const MAX_CENTRE_ERROR_PX: f64 = 2.0;

/// What was measured over scenes.
#[derive(Debug, Clone, PartialEq, Default)]
struct Measurement {
    frames: usize,
    reported: usize,
    ious: Vec<f64>,
    axis_errors_deg: Vec<f64>,
    /// Frames in which a heading is expected, and those of them that have one.
    expected: usize,
    present: usize,
    heading_errors_deg: Vec<f64>,
    centre_errors_px: Vec<f64>,
}

impl Measurement {
    fn from_frames(frames: &[(SceneTruth, Track)]) -> Self {
        let mut measured = Self::default();
        let mut under_way_since_s = None;
        for (truth, track) in frames {
            let since_s = truth.is_under_way.then(|| *under_way_since_s.get_or_insert(truth.time_s));
            if since_s.is_none() {
                under_way_since_s = None;
            }
            let localisation = track.localisation();
            let heading = localisation.and_then(|localisation| localisation.heading);
            measured.frames += 1;
            if since_s.is_some_and(|since_s| truth.time_s - since_s >= MIN_UNDER_WAY_S) {
                measured.expected += 1;
                measured.present += usize::from(heading.is_some());
            }
            let Some(localisation) = localisation else { continue };
            measured.reported += 1;
            measured.ious.push(localisation.bounds.iou(truth.bounds));
            measured
                .centre_errors_px
                .push((localisation.centre.u - truth.centre.u).hypot(localisation.centre.v - truth.centre.v));
            if let Some(shape) = localisation.shape
                && truth.major_px >= MIN_AXIS_LENGTH_PX
            {
                measured.axis_errors_deg.push(axis_error_deg(shape.axis, truth.heading));
            }
            if let Some(heading) = heading {
                measured.heading_errors_deg.push(angle_deg(heading, truth.heading));
            }
        }
        measured
    }

    /// Adds the frames of other scenes.
    fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.reported += other.reported;
        self.ious.extend(&other.ious);
        self.axis_errors_deg.extend(&other.axis_errors_deg);
        self.expected += other.expected;
        self.present += other.present;
        self.heading_errors_deg.extend(&other.heading_errors_deg);
        self.centre_errors_px.extend(&other.centre_errors_px);
    }

    fn present_share(&self) -> f64 {
        self.present as f64 / self.expected as f64
    }

    fn wrong_end_share(&self) -> f64 {
        let wrong = self.heading_errors_deg.iter().filter(|error_deg| **error_deg > WRONG_END_DEG).count();
        wrong as f64 / self.heading_errors_deg.len() as f64
    }

    /// Name, value and decimals of each figure, in the table's order.
    fn figures(&self) -> [(&'static str, f64, usize); 9] {
        [
            ("reported", self.reported as f64 / self.frames as f64, 3),
            ("IoU mean", mean(&self.ious), 3),
            ("axis error deg mean", mean(&self.axis_errors_deg), 1),
            ("p90", quantile(&self.axis_errors_deg, 0.9), 1),
            ("heading present", self.present_share(), 3),
            ("heading error deg median", quantile(&self.heading_errors_deg, 0.5), 1),
            ("wrong end", self.wrong_end_share(), 3),
            ("centre error px mean", mean(&self.centre_errors_px), 2),
            ("p99", quantile(&self.centre_errors_px, 0.99), 2),
        ]
    }
}

/// The angle between two directions, 0 to 180 degrees.
pub(super) fn angle_deg(a: Angle, b: Angle) -> f64 {
    let difference = (a.degrees() - b.degrees()).rem_euclid(360.0);
    difference.min(360.0 - difference)
}

/// The angle between an axis and a heading, 0 to 90 degrees: either end may be the bow.
pub(super) fn axis_error_deg(axis: Angle, heading: Angle) -> f64 {
    let error_deg = angle_deg(axis, heading);
    error_deg.min(180.0 - error_deg)
}

/// Runs all scenes, prints the table, judges the requirements, and returns the figures.
///
/// # Errors
/// If the tracker refuses its settings.
pub(crate) fn run(
    options: &Options,
    config: &TrackerConfig,
    requirements: &mut Requirements,
) -> Result<Value> {
    let seeds = SEEDS.min(options.scenes.unwrap_or(SEEDS));
    let jobs: Vec<(usize, u64)> =
        (0..BOATS_PX.len()).flat_map(|boat| (0..seeds).map(move |seed| (boat, seed))).collect();
    let results = parallel::map(&jobs, |&(boat, seed)| {
        let script = SceneScript {
            kind: SceneKind::Manoeuvre,
            size: SIZE,
            boat_px: BOATS_PX[boat],
            seconds: SCENE_S,
            target: paint_of_scene(seed),
        };
        // Each scene has a seed of its own.
        let seed = boat as u64 * SEEDS + seed;
        let tracker =
            |has_motion_prior| anyhow::Ok(SceneTracker { tracker: build_tracker(config)?, has_motion_prior });
        let mut trackers = [tracker(true)?, tracker(false)?];
        let results = run_all_on_scene(&mut trackers, script, seed);
        let measured: Vec<Measurement> =
            results.iter().map(|frames| Measurement::from_frames(frames)).collect();
        anyhow::Ok((boat, seed, measured))
    });
    let mut by_boat =
        [vec![Measurement::default(); BOATS_PX.len()], vec![Measurement::default(); BOATS_PX.len()]];
    let mut scenes = Vec::new();
    for result in results {
        let (boat, seed, measured) = result?;
        let name = paint_name(paint_of_scene(seed % SEEDS));
        for ((by_boat, measured), has_motion_prior) in by_boat.iter_mut().zip(&measured).zip([true, false]) {
            by_boat[boat].add(measured);
            scenes.push(json!({
                "seed": seed, "boat_px": BOATS_PX[boat], "paint": name, "told": has_motion_prior,
                "figures": figures_json(measured),
            }));
        }
    }
    let [with_prior, without_prior] = &by_boat;
    let sizes =
        print_table(seeds, with_prior, "told how the camera moved, to within 1 px", Some(requirements));
    let sizes_untold =
        print_table(seeds, without_prior, "not told: it measures the shift in the picture", None);
    Ok(json!({ "sizes": sizes, "sizes_untold": sizes_untold, "scenes": scenes }))
}

/// The figures of a row, and the number of its frames.
fn figures_json(measured: &Measurement) -> Value {
    let figures = measured.figures().map(|(figure, value, _)| json!({ "name": figure, "value": value }));
    json!({ "frames": measured.frames, "figures": figures })
}

/// Prints the table of one kind of tracker, judges it where there are requirements, and returns the figures.
fn print_table(
    seeds: u64,
    by_boat: &[Measurement],
    prior: &str,
    requirements: Option<&mut Requirements>,
) -> Value {
    let mut all = Measurement::default();
    by_boat.iter().for_each(|measured| all.add(measured));
    let mut headings = vec!["boat px", "frames"];
    headings.extend(all.figures().map(|(name, _, _)| name));
    let mut table = Table::new(&headings);
    let mut json = Vec::new();
    let names = BOATS_PX.map(|boat_px| boat_px.to_string());
    for (name, measured) in names.iter().map(String::as_str).zip(by_boat).chain([("all", &all)]) {
        let figures = measured.figures();
        let mut cells = vec![name.to_owned(), measured.frames.to_string()];
        cells.extend(figures.map(|(_, value, decimals)| cell(value, decimals)));
        table.row(cells);
        json.push(json!({ "boat_px": name, "figures": figures_json(measured) }));
    }
    table.print(&format!(
        "Generated boats that manoeuvre, the tracker {prior} ({seeds} scenes of each size; axes of hulls from \
         {MIN_AXIS_LENGTH_PX} px on)"
    ));
    print_line("");
    let Some(requirements) = requirements else { return Value::Array(json) };
    requirements.at_most("axis error, mean, degrees", mean(&all.axis_errors_deg), MAX_AXIS_ERROR_DEG);
    let name = "share of frames with a heading, boats under way for 3 s";
    requirements.at_least(name, all.present_share(), MIN_PRESENT_SHARE);
    let median_deg = quantile(&all.heading_errors_deg, 0.5);
    requirements.at_most("heading error, median, degrees", median_deg, MAX_HEADING_ERROR_DEG);
    requirements.at_most("share of headings at the wrong end", all.wrong_end_share(), MAX_WRONG_END_SHARE);
    requirements.at_most("centre error, mean, pixels", mean(&all.centre_errors_px), MAX_CENTRE_ERROR_PX);
    Value::Array(json)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::track::Shape;
    use barrelman_vocab::{Localisation, PixelBox, PixelPoint, Timestamp};

    use super::*;

    const BOUNDS: PixelBox = PixelBox { u: 100.0, v: 100.0, w: 80.0, h: 40.0 };

    /// A frame of a boat that is localised 1 px too far to the right.
    fn frame(
        time_s: f64,
        is_under_way: bool,
        axis_deg: f64,
        heading_deg: Option<f64>,
    ) -> (SceneTruth, Track) {
        let truth = SceneTruth {
            time_s,
            bounds: BOUNDS,
            visible_share: 1.0,
            centre: BOUNDS.centre(),
            heading: Angle::from_degrees(-170.0),
            major_px: 80.0,
            minor_px: 30.0,
            is_under_way,
            camera_shift: (0.0, 0.0),
            distractors: Default::default(),
        };
        let localisation = Localisation {
            captured: Timestamp::from_secs_f64(time_s),
            picture: SIZE,
            centre: PixelPoint { u: BOUNDS.centre().u + 1.0, ..BOUNDS.centre() },
            bounds: BOUNDS,
            shape: Some(Shape { major_px: 80.0, minor_px: 30.0, axis: Angle::from_degrees(axis_deg) }),
            heading: heading_deg.map(Angle::from_degrees),
            confidence: 0.9,
        };
        (truth, Track::Tracking(localisation))
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn an_axis_has_no_ends_and_a_heading_has() {
        // The hull lies at 10 degrees, and its bow points to -170, which is 190.
        let measured = Measurement::from_frames(&[
            frame(0.0, true, 5.0, Some(185.0)),
            frame(0.1, true, 175.0, Some(5.0)),
        ]);
        assert!(
            close(measured.axis_errors_deg[0], 5.0) && close(measured.axis_errors_deg[1], 15.0),
            "{measured:?}"
        );
        assert!(
            close(measured.heading_errors_deg[0], 5.0) && close(measured.heading_errors_deg[1], 175.0),
            "{measured:?}"
        );
        assert_eq!(measured.wrong_end_share(), 0.5);
        assert!(close(measured.centre_errors_px[0], 1.0));
    }

    #[test]
    fn a_heading_is_expected_after_three_seconds_under_way() {
        let frames: Vec<_> = (0..=100)
            .map(|step| frame(f64::from(step) / 10.0, step != 50, 10.0, (step >= 40).then_some(190.0)))
            .collect();
        let measured = Measurement::from_frames(&frames);
        // Under way from 0 to 4.9 s and from 5.1 to 10 s: expected from 3.0 and from 8.1 s on.
        assert_eq!((measured.expected, measured.present), (20 + 20, 10 + 20));
    }

    #[test]
    fn a_lost_boat_has_no_errors() {
        let (truth, _) = frame(0.0, true, 0.0, None);
        let measured = Measurement::from_frames(&[(truth, Track::Unseeded)]);
        assert_eq!((measured.frames, measured.reported, measured.centre_errors_px.len()), (1, 0, 0));
    }
}
