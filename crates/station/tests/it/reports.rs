//! The commands `report`, `metrics` on campaigns, and `render`.

use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::CampaignRequest;
use barrelman_experiments::campaign::{CampaignPlan, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::render::{RenderedTruth, Serial};
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::{Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{FrameSource as _, RenderedCamera, StepObserver};
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_video::{VideoFrames, VideoUrl};
use barrelman_vocab::{PictureSize, Timestamp, VehicleRates};

use crate::program::{barrelman_in, empty_folder, failed, succeeded};

const TRIALS: [&str; 6] = ["trials", "lab1", "--perception", "truth", "--trials", "2"];

#[test]
fn metrics_of_a_campaigns_file_are_what_trials_printed() {
    let folder = empty_folder("campaign-metrics");
    let printed =
        succeeded(&barrelman_in(&folder, &[&TRIALS[..], &["--output", "lab1.jsonl", "--json"]].concat()));
    assert_eq!(succeeded(&barrelman_in(&folder, &["metrics", "lab1.jsonl", "--json"])), printed);
    failed(&barrelman_in(&folder, &["metrics", "lab1.jsonl", "--region", "0.5,0.5"]), 1, &["--region"]);
    // A file whose last line is cut: the trials before it are used, with exit code 1.
    let text = std::fs::read_to_string(folder.join("lab1.jsonl")).unwrap();
    std::fs::write(folder.join("cut.jsonl"), &text[..text.len() - 10]).unwrap();
    failed(&barrelman_in(&folder, &["metrics", "cut.jsonl"]), 1, &["line 2"]);
}

#[test]
fn a_report_shows_recordings_campaigns_and_exported_logs_and_overwrites_nothing() {
    let folder = empty_folder("report");
    succeeded(&barrelman_in(
        &folder,
        &[&TRIALS[..], &["--record", "recordings", "--output", "lab1.jsonl"]].concat(),
    ));
    succeeded(&barrelman_in(&folder, &["export", "recordings/lab1-1.mcap", "--output", "exported"]));
    let world = std::fs::read_to_string(folder.join("exported/truth.csv")).unwrap();
    assert!(
        world.starts_with("log_time_ns,tick,at_ns,target_x_m,target_y_m,target_heading_rad,camera_x_m"),
        "{world}"
    );
    let logs = ["recordings/lab1-1.mcap", "recordings/lab1-2.mcap", "lab1.jsonl", "exported/trial.csv"];
    let arguments = [&["report"][..], &logs, &["--output", "report.html", "--svg", "figures"]].concat();
    succeeded(&barrelman_in(&folder, &arguments));
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    for words in [
        "lab1/1",
        "lab1/2",
        "lab1, schema, truth, indoor, recorded",
        "lab1, schema, truth",
        "exported logs",
        "0.6045",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let mut figures: Vec<String> = std::fs::read_dir(folder.join("figures"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    figures.sort();
    // Two recordings with four figures each, an exported log without truth, and one figure for each group of
    // trials.
    assert_eq!(figures.len(), 4 + 4 + 3 + 2, "{figures:?}");
    for figure in figures {
        let svg = std::fs::read_to_string(folder.join("figures").join(&figure)).unwrap();
        assert!(roxmltree::Document::parse(&svg).is_ok(), "{figure}");
    }
    failed(&barrelman_in(&folder, &arguments), 1, &["--force"]);
    succeeded(&barrelman_in(&folder, &[&arguments[..], &["--force"]].concat()));
}

#[test]
fn a_recorded_trial_is_lost_where_the_simulated_one_was() {
    let folder = empty_folder("recorded-truth");
    let all = ["trials", "lab1", "--perception", "truth", "--trials", "4"];
    succeeded(&barrelman_in(
        &folder,
        &[&all[..], &["--record", "recordings", "--output", "lab1.jsonl"]].concat(),
    ));
    let figures = |arguments: &[&str]| -> Vec<(String, f64)> {
        let text = succeeded(&barrelman_in(&folder, arguments));
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        let trials = document["trials"].as_array().unwrap();
        trials.iter().map(|t| (t["lost"].to_string(), t["out_of_picture_s"].as_f64().unwrap())).collect()
    };
    let simulated = figures(&["metrics", "lab1.jsonl", "--json"]);
    let recordings: Vec<String> = (1..=4).map(|seed| format!("recordings/lab1-{seed}.mcap")).collect();
    let recorded: Vec<&str> = recordings.iter().map(String::as_str).collect();
    let recorded = figures(&[&["metrics"][..], &recorded, &["--json"]].concat());
    for (simulated, recorded) in simulated.iter().zip(&recorded) {
        assert_eq!(simulated.0, recorded.0);
        assert!(
            (simulated.1 - recorded.1).abs() < 1e-6,
            "{simulated:?} {recorded:?}: nanoseconds of rounding a row"
        );
    }
}

/// The truth of each picture, from a renderer of the test's own.
struct OwnTruth {
    camera: CameraSetup,
    simd: Simd,
    renderer: Option<RenderedCamera<'static>>,
    truth: Vec<(Timestamp, RenderedTruth)>,
}

impl StepObserver for OwnTruth {
    fn on_step(&mut self, _: Timestamp, _: &Input<'_>, _: &Outcome, _: VehicleRates) {}
    fn on_truth(&mut self, _: &Truth, _: Option<&TargetInPicture>) {}
    fn on_world(&mut self, world: &World) {
        let renderer = self
            .renderer
            .get_or_insert_with(|| RenderedCamera::new(world, self.camera.clone(), 7, self.simd, &Serial));
        let view = renderer.capture(world);
        self.truth.push((view.frame.capture.at, renderer.truth().clone()));
    }
}

#[test]
fn a_rendered_clip_has_a_row_of_truth_and_a_mask_for_every_frame() {
    let folder = empty_folder("render");
    let size = PictureSize::new(160, 96);
    let arguments = [
        "render",
        "open",
        "--seed",
        "7",
        "--seconds",
        "0.7",
        "--size",
        "160x96",
        "--output",
        "clip.mp4",
        "--truth",
        "truth.csv",
        "--masks",
        "masks",
    ];
    succeeded(&barrelman_in(&folder, &arguments));
    failed(&barrelman_in(&folder, &arguments), 1, &["--force"]);
    let mut frames = VideoFrames::open(&VideoUrl::file(folder.join("clip.mp4"))).unwrap();
    let mut count = 0;
    while let Some(frame) = frames.next_frame().unwrap() {
        assert_eq!(frame.picture.size(), size);
        count += 1;
    }
    let plan = CampaignPlan::new(&CampaignRequest {
        scenario: "open".to_owned(),
        overrides: ScenarioOverrides { size: Some(size), ..ScenarioOverrides::default() },
        law: LawChoice::MOTOR_SCHEMA,
        rate: None,
        guidance: None,
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: SimdLevel::Baseline,
    })
    .unwrap()
    .with_max_duration(0.7);
    let camera = plan.scenario().camera.clone();
    let simd = Simd::at_most(SimdLevel::Baseline);
    let mut own = OwnTruth { camera, simd, renderer: None, truth: Vec::new() };
    plan.simulate(7, &mut own).unwrap();
    let text = std::fs::read_to_string(folder.join("truth.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("frame,time_s,x,y,w,h,cx,cy,visible,heading_deg,range_m"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((rows.len(), own.truth.len()), (count, count));
    for (index, (row, (at, truth))) in rows.iter().zip(&own.truth).enumerate() {
        let (bounds, waterline) = (truth.bounds.unwrap(), truth.waterline.unwrap());
        let expected = [
            index as f64,
            at.as_secs_f64(),
            bounds.u,
            bounds.v,
            bounds.w,
            bounds.h,
            waterline.u,
            waterline.v,
            truth.visible_share,
            truth.heading.unwrap().degrees().rem_euclid(360.0),
            truth.range_m,
        ];
        for (found, expected) in row.iter().zip(expected) {
            assert!((found - expected).abs() <= 0.000_51, "row {index}: {row:?}, {expected}: three decimals");
        }
        let mask = png::Decoder::new(std::io::BufReader::new(
            std::fs::File::open(folder.join(format!("masks/{index:06}.png"))).unwrap(),
        ));
        let mut reader = mask.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut samples).unwrap();
        let shown = samples.iter().filter(|sample| **sample == 255).count();
        assert_eq!((samples.len(), shown), (size.area(), truth.mask.count()), "mask {index}");
        assert!(shown > 0, "the boat is in view");
    }
}
