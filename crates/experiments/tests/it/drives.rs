//! Drives: the same inputs give the same drive, and a stored drive is read as it was written.

use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::drive_requests::DriveRequests;
use barrelman_experiments::campaign::plan::CampaignRequest;
use barrelman_experiments::campaign::{CampaignPlan, Perception};
use barrelman_experiments::drive::{Drive, DriveSetup, DriveWriter, StoredDrive};
use barrelman_experiments::drive::{DriveHasher, DriveObserver};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::output::OutputFile;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_simd::SimdLevel;
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::logs::TrialLog;
use barrelman_trial::shadow::MotorSchemaShadow;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_trial::work_step::WorkStep;
use barrelman_vocab::{
    CameraRequest, LawId, OperatorRequest, PictureSize, Timestamp, VehicleRates, VesselCommand, VesselRequest,
};

const SMALL: PictureSize = PictureSize::new(192, 108);

fn setup(law: LawChoice, encoded: bool) -> DriveSetup {
    let url = WorldUrl { size: Some(SMALL), ..WorldUrl::new("open") };
    DriveSetup::new(url, TrackerName::Camshift, law, encoded).unwrap()
}

/// The hash of a drive of one second with these inputs.
fn hash_of_drive(setup: &DriveSetup, requests: &[(u64, OperatorRequest)]) -> String {
    let threads = RenderThreads::new().unwrap();
    let mut drive = Drive::new(setup, &threads).unwrap();
    let mut hash = DriveHasher::default();
    for tick in 0..120 {
        for (_, request) in requests.iter().filter(|(at, _)| *at == tick) {
            drive.request(*request, &mut hash);
        }
        drive.tick(&mut hash);
    }
    hash.hex()
}

const ENGAGE: OperatorRequest = OperatorRequest::Camera(CameraRequest::Engage);
const AHEAD: OperatorRequest = steer(1.0, -0.2);

const fn steer(throttle: f64, rudder: f64) -> OperatorRequest {
    OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand { throttle, rudder }))
}

#[test]
fn the_same_inputs_at_the_same_ticks_give_the_same_drive() {
    for (law, encoded) in [(LawChoice::OPTIMAL, false), (LawChoice::MOTOR_SCHEMA, true)] {
        let setup = setup(law, encoded);
        let first = hash_of_drive(&setup, &[(0, ENGAGE), (30, AHEAD)]);
        assert_eq!(hash_of_drive(&setup, &[(0, ENGAGE), (30, AHEAD)]), first);
        assert_ne!(hash_of_drive(&setup, &[(0, ENGAGE), (31, AHEAD)]), first);
    }
}

/// Observes a drive with the motor schema's shadow beside it.
struct ShadowObserver {
    shadow: MotorSchemaShadow,
    /// P, and P under the motor schema.
    values: Vec<(f64, f64)>,
}

impl StepObserver for ShadowObserver {
    fn on_step(&mut self, now: Timestamp, _input: &Input<'_>, outcome: &Outcome, _rates: VehicleRates) {
        self.shadow.step(&WorkStep { at: now, ..outcome.into() });
        self.values.extend(outcome.percept.map(|percept| percept.p).zip(self.shadow.p()));
    }

    fn on_truth(&mut self, _truth: &Truth, _target: Option<&TargetInPicture>) {}
}

impl DriveObserver for ShadowObserver {}

#[test]
fn the_schemas_shadow_is_the_schema_and_another_law_differs_from_it() {
    let values = |law| {
        let (setup, threads) = (setup(law, false), RenderThreads::new().unwrap());
        let mut drive = Drive::new(&setup, &threads).unwrap();
        let mut observer =
            ShadowObserver { shadow: MotorSchemaShadow::new(&setup.profile), values: Vec::new() };
        drive.request(ENGAGE, &mut observer);
        for tick in 0..1200 {
            if tick % 30 == 0 {
                drive.request(steer(1.0, 0.0), &mut observer);
            }
            drive.tick(&mut observer);
        }
        observer.values
    };
    let apart = |(p, schema): &(f64, f64)| (p - schema).abs();
    let of_schema = values(LawChoice::MOTOR_SCHEMA);
    assert!(of_schema.iter().any(|(p, _)| *p > 1.0), "the schema moves the camera");
    // The camera's past direction is interpolated between stored times, and the two models store different
    // times.
    let max = of_schema.iter().map(apart).fold(0.0, f64::max);
    assert!(max < 1.0e-3, "{max}");
    assert!(values(LawChoice::OPTIMAL).iter().map(apart).fold(0.0, f64::max) > 0.2);
}

#[test]
fn a_trial_of_a_stored_drive_is_that_drive_and_a_camera_law_is_tried_on_it() {
    let path = std::env::temp_dir().join(format!("barrelman-driven-{}.jsonl", std::process::id()));
    let setup = setup(LawChoice::MOTOR_SCHEMA, false);
    let requests = [(0, ENGAGE), (30, AHEAD)];
    let hash = hash_of_drive(&setup, &requests);
    let mut writer = DriveWriter::begin(OutputFile::open(&path, true).unwrap(), &setup).unwrap();
    requests.iter().for_each(|(tick, request)| writer.add(*tick, *request).unwrap());
    writer.finish(120, hash.clone()).unwrap();
    let stored = StoredDrive::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let request = CampaignRequest {
        scenario: "open".to_owned(),
        overrides: ScenarioOverrides { size: Some(SMALL), ..ScenarioOverrides::default() },
        law: LawChoice::MOTOR_SCHEMA,
        rate: None,
        guidance: None,
        perception: Perception::Pixels(TrackerName::Camshift),
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    };
    let plan = CampaignPlan::new(&request).unwrap().with_drive(DriveRequests::from_drive(&stored));
    let mut again = DriveHasher::default();
    let log = plan.simulate(setup.url.seed, &mut again).unwrap();
    assert_eq!(again.hex(), hash);
    assert_eq!(plan.run(setup.url.seed).unwrap().campaign.drive.map(|drive| drive.len()), Some(16));
    // The boat's path does not depend on the camera.
    let law = LawChoice::OPTIMAL;
    let other =
        CampaignPlan::new(&CampaignRequest { law, perception: Perception::Truth, ..request }).unwrap();
    let other =
        other.with_drive(DriveRequests::from_drive(&stored)).simulate(setup.url.seed, &mut ()).unwrap();
    let end = |log: &TrialLog| log.truth.as_ref().unwrap().last().unwrap().target_m;
    assert_eq!(end(&other), end(&log));
}

#[test]
fn a_stored_drive_is_read_as_it_was_written() {
    let path = std::env::temp_dir().join(format!("barrelman-drive-{}.jsonl", std::process::id()));
    let law = LawChoice { horizon_s: Some(1.5), ..LawChoice::of(LawId::Eco) };
    let setup = setup(law, true);
    let mut writer = DriveWriter::begin(OutputFile::open(&path, true).unwrap(), &setup).unwrap();
    writer.add(0, ENGAGE).unwrap();
    writer.add(30, AHEAD).unwrap();
    let cut = StoredDrive::read(&path).unwrap();
    writer.finish(120, "0123456789abcdef".to_owned()).unwrap();
    let whole = StoredDrive::read(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let key = r#""law":{"law":"eco","horizon_s":1.5},"#;
    std::fs::write(&path, text.replace("\"eco\"", "\"schema\"")).unwrap();
    let contradicts = format!("{:#}", StoredDrive::read(&path).unwrap_err());
    std::fs::remove_file(&path).unwrap();
    assert!(text.contains(key), "{text}");
    assert!(contradicts.contains("law.horizon_s is for the law"), "{contradicts}");
    assert_eq!((cut.end, cut.requests.len()), (None, 2));
    assert_eq!(whole.requests, [(0, ENGAGE), (30, AHEAD)]);
    assert_eq!(whole.end, Some((120, "0123456789abcdef".to_owned())));
    assert_eq!(
        (whole.setup.url, whole.setup.encoded, whole.setup.tracker, whole.setup.law),
        (setup.url, true, TrackerName::Camshift, law)
    );
}

#[test]
fn a_tick_beyond_the_longest_drive_is_refused_by_its_line() {
    let path = std::env::temp_dir().join(format!("barrelman-long-drive-{}.jsonl", std::process::id()));
    let setup = setup(LawChoice::MOTOR_SCHEMA, false);
    drop(DriveWriter::begin(OutputFile::open(&path, true).unwrap(), &setup).unwrap());
    let header = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let parse = |line: &str| StoredDrive::parse(&format!("{header}{line}\n"));
    // A day of 120 ticks a second.
    for (tick, is_read) in
        [("0", true), ("10368000", true), ("10368001", false), ("18446744073709551615", false)]
    {
        for line in [
            format!(r#"{{"tick":{tick},"request":{{"kind":"engage"}}}}"#),
            format!(r#"{{"tick":{tick},"hash":"0123456789abcdef"}}"#),
        ] {
            match parse(&line) {
                Ok(_) => assert!(is_read, "{line}"),
                Err(error) => {
                    let text = format!("{error:#}");
                    assert!(
                        !is_read && text.contains(&format!("line 2: tick {tick}: a drive has")),
                        "{text}"
                    );
                }
            }
        }
    }
}
