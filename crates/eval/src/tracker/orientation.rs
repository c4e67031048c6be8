//! Where the bow points: axes and headings of generated boats that turn, stop and go.
//!
//! The *axis error* is the angle between the reported major axis and the hull's centre line, at most 90 degrees; the
//! *heading error* that between the reported and the true heading, at most 180. A heading that is off by more than 90
//! degrees takes the stern for the bow: the *wrong end*. The share of frames with a heading counts frames in which
//! the boat has been under way, and followed, for 3 s on end: a bow is told by its motion.

use anyhow::Result;
use barrelman_sim::water_scene::{SceneKind, SceneScript, SceneTruth};
use barrelman_vocab::{Angle, Track};
use serde_json::{Value, json};

use super::Options;
use super::figures::{mean, quantile};
use super::generated::{self, SIZE, Watcher, paint, watch_together};
use super::parallel;
use super::report::{Requirements, Table, cell};
use super::under_test::{self, Config};
use crate::say;

/// Lengths of the hull at the scene's start, pixels: the smallest an operator selects, to one that fills a third of
/// the picture.
const BOATS_PX: [f64; 5] = [20.0, 40.0, 80.0, 140.0, 200.0];

const SEEDS: u64 = 12;

const SCENE_S: f64 = 12.0;

/// Hulls shorter than this in a frame have no axis worth judging, pixels.
const AXIS_FROM_PX: f64 = 40.0;

/// A boat must have been under way this long before its heading is asked for, seconds.
const UNDER_WAY_FOR_S: f64 = 3.0;

/// Heading errors above this take the stern for the bow, degrees.
const WRONG_END_DEG: f64 = 90.0;

const AXIS_DEG_WANTED: f64 = 5.0;
const PRESENT_WANTED: f64 = 0.8;
const HEADING_DEG_WANTED: f64 = 10.0;
const WRONG_END_WANTED: f64 = 0.01;
const CENTRE_PX_WANTED: f64 = 2.0;

/// What was measured over some scenes.
#[derive(Debug, Clone, PartialEq, Default)]
struct Measured {
    frames: usize,
    reported: usize,
    overlaps: Vec<f64>,
    axis_deg: Vec<f64>,
    /// Frames in which a heading is asked for, and those in which there was one.
    asked: usize,
    present: usize,
    heading_deg: Vec<f64>,
    centre_px: Vec<f64>,
}

impl Measured {
    fn of(frames: &[(SceneTruth, Track)]) -> Self {
        let mut measured = Self::default();
        let mut under_way_since_s = None;
        for (truth, track) in frames {
            let since_s = truth.is_under_way.then(|| *under_way_since_s.get_or_insert(truth.time_s));
            if since_s.is_none() {
                under_way_since_s = None;
            }
            let seen = track.localisation();
            let heading = seen.and_then(|seen| seen.heading);
            measured.frames += 1;
            if since_s.is_some_and(|since_s| truth.time_s - since_s >= UNDER_WAY_FOR_S) {
                measured.asked += 1;
                measured.present += usize::from(heading.is_some());
            }
            let Some(seen) = seen else { continue };
            measured.reported += 1;
            measured.overlaps.push(seen.bounds.iou(truth.bounds));
            measured.centre_px.push((seen.centre.u - truth.centre.u).hypot(seen.centre.v - truth.centre.v));
            if let Some(shape) = seen.shape
                && truth.major_px >= AXIS_FROM_PX
            {
                let error_deg = apart_deg(shape.axis, truth.heading);
                measured.axis_deg.push(error_deg.min(180.0 - error_deg));
            }
            if let Some(heading) = heading {
                measured.heading_deg.push(apart_deg(heading, truth.heading));
            }
        }
        measured
    }

    fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.reported += other.reported;
        self.overlaps.extend(&other.overlaps);
        self.axis_deg.extend(&other.axis_deg);
        self.asked += other.asked;
        self.present += other.present;
        self.heading_deg.extend(&other.heading_deg);
        self.centre_px.extend(&other.centre_px);
    }

    fn present_share(&self) -> f64 {
        self.present as f64 / self.asked as f64
    }

    fn wrong_end_share(&self) -> f64 {
        let wrong = self.heading_deg.iter().filter(|error_deg| **error_deg > WRONG_END_DEG).count();
        wrong as f64 / self.heading_deg.len() as f64
    }

    /// In the table's order.
    fn figures(&self) -> [(&'static str, f64, usize); 9] {
        [
            ("reported", self.reported as f64 / self.frames as f64, 3),
            ("IoU mean", mean(&self.overlaps), 3),
            ("axis error deg mean", mean(&self.axis_deg), 1),
            ("p90", quantile(&self.axis_deg, 0.9), 1),
            ("heading present", self.present_share(), 3),
            ("heading error deg median", quantile(&self.heading_deg, 0.5), 1),
            ("wrong end", self.wrong_end_share(), 3),
            ("centre error px mean", mean(&self.centre_px), 2),
            ("p99", quantile(&self.centre_px, 0.99), 2),
        ]
    }
}

/// The angle between two directions, 0 to 180 degrees.
fn apart_deg(a: Angle, b: Angle) -> f64 {
    let apart = (a.degrees() - b.degrees()).rem_euclid(360.0);
    apart.min(360.0 - apart)
}

/// Runs all scenes, prints the table, judges the requirements, and returns the figures.
///
/// # Errors
/// If the tracker refuses its settings.
pub(crate) fn run(options: &Options, config: &Config, requirements: &mut Requirements) -> Result<Value> {
    let seeds = SEEDS.min(options.scenes.unwrap_or(SEEDS));
    let jobs: Vec<(usize, u64)> =
        (0..BOATS_PX.len()).flat_map(|boat| (0..seeds).map(move |seed| (boat, seed))).collect();
    let results = parallel::map(&jobs, |&(boat, seed)| {
        let script = SceneScript {
            kind: SceneKind::Manoeuvre,
            size: SIZE,
            boat_px: BOATS_PX[boat],
            seconds: SCENE_S,
            target: paint(seed),
        };
        // Scenes of different sizes differ in everything.
        let seed = boat as u64 * SEEDS + seed;
        let watcher = |told| anyhow::Ok(Watcher { tracker: under_test::make(config)?, told });
        let mut watchers = [watcher(true)?, watcher(false)?];
        let said = watch_together(&mut watchers, script, seed);
        let measured: Vec<Measured> = said.iter().map(|said| Measured::of(said)).collect();
        anyhow::Ok((boat, seed, measured))
    });
    let mut by_boat = [vec![Measured::default(); BOATS_PX.len()], vec![Measured::default(); BOATS_PX.len()]];
    let mut scenes = Vec::new();
    for result in results {
        let (boat, seed, measured) = result?;
        let name = generated::name_of(paint(seed % SEEDS));
        for ((by_boat, measured), told) in by_boat.iter_mut().zip(&measured).zip([true, false]) {
            by_boat[boat].add(measured);
            scenes.push(json!({
                "seed": seed, "boat_px": BOATS_PX[boat], "paint": name, "told": told, "figures": figures_json(measured)
            }));
        }
    }
    let [told, untold] = &by_boat;
    let sizes = say_table(seeds, told, "told how the camera moved, to within 1 px", Some(requirements));
    let untold = say_table(seeds, untold, "not told: it measures the shift in the picture", None);
    Ok(json!({ "sizes": sizes, "sizes_untold": untold, "scenes": scenes }))
}

/// The table's row, and how many frames it rests on.
fn figures_json(measured: &Measured) -> Value {
    let figures = measured.figures().map(|(figure, value, _)| json!({ "name": figure, "value": value }));
    json!({ "frames": measured.frames, "figures": figures })
}

fn say_table(seeds: u64, by_boat: &[Measured], told: &str, requirements: Option<&mut Requirements>) -> Value {
    let mut all = Measured::default();
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
    table.say(&format!(
        "Generated boats that manoeuvre, the tracker {told} ({seeds} scenes of each size; axes of hulls from {AXIS_FROM_PX} px on)"
    ));
    say("");
    let Some(requirements) = requirements else { return Value::Array(json) };
    requirements.at_most("axis error, mean, degrees", mean(&all.axis_deg), AXIS_DEG_WANTED);
    let name = "share of frames with a heading, boats under way for 3 s";
    requirements.at_least(name, all.present_share(), PRESENT_WANTED);
    let median_deg = quantile(&all.heading_deg, 0.5);
    requirements.at_most("heading error, median, degrees", median_deg, HEADING_DEG_WANTED);
    requirements.at_most("share of headings at the wrong end", all.wrong_end_share(), WRONG_END_WANTED);
    requirements.at_most("centre error, mean, pixels", mean(&all.centre_px), CENTRE_PX_WANTED);
    Value::Array(json)
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::track::Shape;
    use barrelman_vocab::{Localisation, PixelBox, PixelPoint, Timestamp};

    use super::*;

    const BOUNDS: PixelBox = PixelBox { u: 100.0, v: 100.0, w: 80.0, h: 40.0 };

    /// A frame of a boat that is seen 1 px too far to the right.
    fn frame(time_s: f64, under_way: bool, axis_deg: f64, heading_deg: Option<f64>) -> (SceneTruth, Track) {
        let truth = SceneTruth {
            time_s,
            bounds: BOUNDS,
            visible_share: 1.0,
            centre: BOUNDS.centre(),
            heading: Angle::from_degrees(-170.0),
            major_px: 80.0,
            minor_px: 30.0,
            is_under_way: under_way,
            camera_shift: (0.0, 0.0),
            distractors: Default::default(),
        };
        let seen = Localisation {
            captured: Timestamp::from_secs_f64(time_s),
            picture: SIZE,
            centre: PixelPoint { u: BOUNDS.centre().u + 1.0, ..BOUNDS.centre() },
            bounds: BOUNDS,
            shape: Some(Shape { major_px: 80.0, minor_px: 30.0, axis: Angle::from_degrees(axis_deg) }),
            heading: heading_deg.map(Angle::from_degrees),
            confidence: 0.9,
        };
        (truth, Track::Tracking(seen))
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn an_axis_has_no_ends_and_a_heading_has() {
        // The hull lies at 10 degrees, and its bow points to -170, which is 190.
        let measured =
            Measured::of(&[frame(0.0, true, 5.0, Some(185.0)), frame(0.1, true, 175.0, Some(5.0))]);
        assert!(close(measured.axis_deg[0], 5.0) && close(measured.axis_deg[1], 15.0), "{measured:?}");
        assert!(close(measured.heading_deg[0], 5.0) && close(measured.heading_deg[1], 175.0), "{measured:?}");
        assert_eq!(measured.wrong_end_share(), 0.5);
        assert!(close(measured.centre_px[0], 1.0));
    }

    #[test]
    fn a_heading_is_asked_for_after_three_seconds_under_way() {
        let frames: Vec<_> = (0..=100)
            .map(|step| frame(f64::from(step) / 10.0, step != 50, 10.0, (step >= 40).then_some(190.0)))
            .collect();
        let measured = Measured::of(&frames);
        // Under way from 0 to 4.9 s and from 5.1 to 10 s: asked for from 3.0 and from 8.1 s on.
        assert_eq!((measured.asked, measured.present), (20 + 20, 10 + 20));
    }

    #[test]
    fn a_lost_boat_has_no_errors() {
        let (truth, _) = frame(0.0, true, 0.0, None);
        let measured = Measured::of(&[(truth, Track::Unseeded)]);
        assert_eq!((measured.frames, measured.reported, measured.centre_px.len()), (1, 0, 0));
    }
}
