//! What the tracker said, beside the truth: rows of 0.5 s, one character each.

use barrelman_control::LawSettings;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::{Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{RenderedCamera, Simulation, StepObserver};
use barrelman_trial::logs::recorded::LogBuilder;
use barrelman_trial::logs::{RowTruth, TrialLog};
use barrelman_trial::metrics::{PerceptionMetrics, TrialMetrics, measure};
use barrelman_trial::records::{RecordedInput, RecordedOutcome, RecordedTruth};
use barrelman_trial::target_in_picture::{JudgedTrack, TargetInPicture};
use barrelman_vocab::{ImagePoint, Timestamp, VehicleProfile, VehicleRates};

use crate::simulated_trials::{pilot, scenario};
use crate::trial_logs::{PICTURE, REGION, log_from};

/// `t` tracked, `l` tracking with a loose box, `n` nothing, `c` coasting on the place, `w` sure and wrong,
/// `s` wrong and not sure; in capitals the same while the target is hidden.
fn judged(row: char) -> JudgedTrack {
    let track = |is_tracking, iou, confidence| (is_tracking, Some(iou), confidence);
    let (is_tracking, iou, confidence) = match row.to_ascii_lowercase() {
        't' => track(true, 0.8, 0.9),
        'l' => track(true, 0.25, 0.9),
        'n' => (false, None, 0.0),
        'c' => track(false, 0.6, 0.7),
        'w' => track(true, 0.0, 0.95),
        's' => track(true, 0.0, 0.5),
        other => panic!("unknown row {other}"),
    };
    let position = ImagePoint { x: 0.0, y: 0.0 };
    JudgedTrack {
        position,
        visible_share: if row.is_lowercase() { 0.6 } else { 0.4 },
        is_tracking,
        iou,
        confidence,
    }
}

fn log_of(rows: &str) -> TrialLog {
    let truth = rows.chars().map(|row| RowTruth {
        track: Some(judged(row)),
        out_of_picture: false,
        achieved_rates: None,
        target_m: (0.0, 0.0),
        camera_m: (0.0, 0.0),
    });
    TrialLog { truth: Some(truth.collect()), selections: Some(1), ..log_from(&".".repeat(rows.len())) }
}

fn metrics_of(rows: &str) -> TrialMetrics {
    measure(&log_of(rows), REGION, PICTURE)
}

#[track_caller]
fn check(rows: &str, tracked: f64, blind_s: f64, sure_wrong: f64) {
    let found = metrics_of(rows).perception;
    assert_eq!((found.tracked, found.blind_s), (Some(tracked), Some(blind_s)), "{rows}");
    let sure = found.sure_wrong.unwrap();
    assert!((sure - sure_wrong).abs() < 1e-12, "{rows}: {sure}");
}

#[test]
fn a_target_is_tracked_where_the_box_is_on_it() {
    check("tttt", 1.0, 0.0, 0.0);
    check("ttll", 0.5, 1.0, 0.0);
    check("ttcc", 0.5, 1.0, 0.0);
    check("nttt", 0.75, 0.5, 0.0);
    check("ttww", 0.5, 1.0, 0.5);
    check("ttss", 0.5, 1.0, 0.0);
    check("nnnn", 0.0, 2.0, 0.0);
}

#[test]
fn a_hidden_target_is_not_blindness_but_can_be_followed_wrongly() {
    check("ttNNtt", 1.0, 0.0, 0.0);
    check("ttWWWttt", 1.0, 0.0, 3.0 / 8.0);
    // The time in which the target is hidden neither counts nor ends the interval.
    check("tnnNNnnt", 2.0 / 6.0, 2.0, 0.0);
    check("tnntnnt", 3.0 / 7.0, 1.0, 0.0);
    let never = metrics_of("NNNN").perception;
    assert_eq!((never.tracked, never.blind_s, never.first_track_s), (None, Some(0.0), None));
}

#[test]
fn first_tracked_and_tracked_again() {
    let figures = |rows| {
        let found = metrics_of(rows).perception;
        (found.first_track_s, found.reacquire_s)
    };
    assert_eq!(figures("tttt"), (Some(0.0), None));
    assert_eq!(figures("nntt"), (Some(1.0), None), "the first time is no return");
    assert_eq!(figures("NNNNnntt"), (Some(3.0), None));
    assert_eq!(figures("ttNNtt"), (Some(0.0), Some(0.0)));
    assert_eq!(figures("ttNNnnntt"), (Some(0.0), Some(1.5)));
    assert_eq!(figures("ttNnnntt"), (Some(0.0), None), "hidden for half a second only");
    assert_eq!(figures("ttNNntNNnnntt"), (Some(0.0), Some(1.0)), "the mean");
    assert_eq!(figures("ttNNnnnn"), (Some(0.0), Some(2.0)), "never again: until the end");
    assert_eq!(
        figures("ttNNnnNNNtt"),
        (Some(0.0), Some(0.5)),
        "hidden again before: until then, and at once"
    );
}

#[test]
fn a_trial_in_pixels_succeeds_only_where_the_target_was_tracked() {
    let success = |rows: &str| metrics_of(rows).is_success();
    let tracked = "t".repeat(400);
    assert!(success(&tracked));
    assert!(success(&(tracked.clone() + &"n".repeat(10))), "5 s");
    assert!(!success(&(tracked.clone() + &"n".repeat(11))), "5.5 s");
    assert!(success(&("tttttttttttttttttttn".repeat(5))), "95 %");
    assert!(!success(&("ttttttttttttttttttn".repeat(5))));
    assert!(!success("NNNN"), "never seen");
    let mut lost = log_of(&tracked);
    lost.truth.as_mut().unwrap()[100..105].iter_mut().for_each(|row| row.out_of_picture = true);
    assert!(!measure(&lost, REGION, PICTURE).is_success(), "2.5 s out of the picture");
    let without = TrialLog { selections: None, ..log_of("nnnn") };
    assert_eq!(measure(&without, REGION, PICTURE).perception, PerceptionMetrics::default());
}

/// Builds the log of a trial from what a recording of it would hold.
#[derive(Default)]
struct Recorder(LogBuilder);

impl StepObserver for Recorder {
    fn on_step(&mut self, _now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.0.add_input(&RecordedInput::from_input(input));
        self.0.add_outcome(&RecordedOutcome::new(0, outcome, rates));
    }

    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        self.0.add_truth(RecordedTruth::new(truth, target));
    }
}

#[test]
fn a_recorded_trial_in_pixels_has_the_figures_of_the_trial() {
    let mut scenario = scenario(0.8);
    scenario.max_s = 4.0;
    let profile = VehicleProfile::fotokite_pro();
    let world = World::new(&scenario, 5).expect("a path");
    let simd = Simd::at_most(SimdLevel::Avx512);
    let bands = &barrelman_sim::render::Serial;
    let mut camera = RenderedCamera::new(&world, scenario.camera.clone(), 5, simd, bands);
    let mut recorder = Recorder::default();
    let log = Simulation::new(&scenario, world, 5, pilot(&profile, LawSettings::MotorSchema), &profile)
        .with_selection_by_hand(5)
        .run(Some(&mut camera), &mut recorder);
    let region = log.region(profile.region);
    let figures = |log: &TrialLog| {
        let TrialMetrics { perception, max_p, time_outside_s, lost, .. } = measure(log, region, log.picture);
        assert!(perception.tracked.is_some_and(|share| share > 0.5), "{perception:?}");
        assert_eq!(perception.selections, Some(1));
        (perception.tracked, perception.sure_wrong, max_p, time_outside_s, lost, log.rows.len())
    };
    let recorded = recorder.0.finish().expect("a log");
    let (of_trial, of_recording) = (figures(&log), figures(&recorded));
    let close = |a: f64, b: f64| (a - b).abs() < 0.02;
    assert!(
        of_trial.0.zip(of_recording.0).is_some_and(|(a, b)| close(a, b)),
        "{of_trial:?} {of_recording:?}"
    );
    assert_eq!((of_trial.2, of_trial.4, of_trial.5), (of_recording.2, of_recording.4, of_recording.5));
}

#[test]
fn the_figures_go_on_while_the_target_is_out_of_the_picture() {
    let mut scenario = scenario(9.0);
    scenario.max_s = 6.0;
    let profile = VehicleProfile::fotokite_pro();
    let world = World::new(&scenario, 3).expect("a path");
    let simd = Simd::at_most(SimdLevel::Avx512);
    let bands = &barrelman_sim::render::Serial;
    let mut camera = RenderedCamera::new(&world, scenario.camera.clone(), 3, simd, bands);
    let log = Simulation::new(&scenario, world, 3, pilot(&profile, LawSettings::MotorSchema), &profile)
        .run(Some(&mut camera), &mut ());
    assert!(log.rows.iter().all(|row| row.position.is_some()), "the truth is known throughout");
    let metrics = measure(&log, log.region(profile.region), log.picture);
    assert!(metrics.out_of_picture_s.is_some_and(|s| s > 0.5), "{metrics:?}");
    assert!(metrics.max_p.is_some_and(|p| p > 2.8), "out of the picture, P is known: {metrics:?}");
    assert!(metrics.time_outside_s > metrics.out_of_picture_s.unwrap(), "{metrics:?}");
}
