//! Replay of a recording.

use core::time::Duration;

use barrelman_pilot::{Input, LawSettings, Pilot, PilotSettings};
use barrelman_sim::practice::{FRAMES_PER_SECOND, PracticeClip};
use barrelman_trial::records::{Entry, RecordedInput, RecordedOutcome, RecordingWriter};
use barrelman_trial::replay::{Replay, ReplayComparison};
use barrelman_vision::{CamShift, CamShiftConfig};
use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{
    AngularRate, CameraRequest, Localisation, OperatorRequest, PictureSize, StopCause, Telemetry, Timestamp,
    Track, VehicleProfile,
};

use crate::entries::{read, start};

const SIZE: PictureSize = PictureSize::new(640, 480);

fn pilot(profile: &VehicleProfile) -> Pilot {
    let tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    Pilot::new(PilotSettings { profile: profile.clone(), law: LawSettings::MotorSchema }, Box::new(tracker))
}

fn input(recorded: &RecordedInput) -> Input<'_> {
    recorded.to_input(|_| Err("this trial has no video")).unwrap()
}

/// A recording of the practice clip: true localisations with gaps, requests, telemetry, and the ticks that
/// the pilot asks for.
fn trial(profile: &VehicleProfile) -> Vec<u8> {
    let clip = PracticeClip::new(SIZE, 1);
    let latency = Duration::from_millis(180);
    let mut events: Vec<(Timestamp, RecordedInput)> = Vec::new();
    for frame in 0..clip.frames() {
        let captured = Timestamp::from_secs_f64(1.0 + f64::from(frame) / f64::from(FRAMES_PER_SECOND));
        let truth = clip.truth(frame);
        let seen = Localisation {
            captured,
            picture: SIZE,
            centre: truth.centre.in_pixels(SIZE),
            bounds: truth.bounds,
            shape: None,
            heading: Some(truth.heading),
            confidence: 1.0,
        };
        let now = captured.plus(latency);
        let track = match frame % 100 {
            60..70 => Track::Coasting(seen),
            70..80 => Track::Lost { since: captured, confidence: 0.0 },
            80..95 => continue,
            _ => Track::Tracking(seen),
        };
        events.push((now, RecordedInput::Localisation(track)));
        let request = match frame {
            10 | 450 => Some(OperatorRequest::Camera(CameraRequest::Engage)),
            300 => Some(OperatorRequest::Camera(CameraRequest::Disengage)),
            320 => Some(OperatorRequest::Camera(CameraRequest::Engage)),
            400 => Some(OperatorRequest::Stop(StopCause::Operator)),
            500 => Some(OperatorRequest::Camera(CameraRequest::SelectNext(truth.bounds))),
            _ => None,
        };
        events.extend(request.map(|request| (now, RecordedInput::Request(request))));
        if frame % 30 == 0 {
            let report = Report::Link(LinkState::Up);
            events.push((now, RecordedInput::Telemetry(Telemetry { at: now, report })));
        }
    }
    let mut pilot = pilot(profile);
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    let (mut step, mut wake_at) = (0, None::<Timestamp>);
    let mut record_step = |now: Timestamp, recorded: RecordedInput| {
        let outcome = pilot.step(input(&recorded), now);
        writer.write(&Entry::Input { step, now, input: recorded }).unwrap();
        let rates = profile.to_vehicle(outcome.command);
        writer.write(&Entry::Outcome(RecordedOutcome::new(step, &outcome, rates))).unwrap();
        step += 1;
        outcome.wake_at
    };
    for (now, recorded) in events {
        while let Some(tick_at) = wake_at.filter(|tick_at| *tick_at <= now) {
            wake_at = record_step(tick_at, RecordedInput::Tick);
        }
        wake_at = record_step(now, recorded);
    }
    writer.finish().unwrap();
    bytes
}

fn replayed(recording: &[u8], profile: &VehicleProfile) -> ReplayComparison {
    let (entries, error) = read(recording);
    assert!(error.is_none(), "{error:?}");
    let mut replay = Replay::new(pilot(profile), profile.clone());
    let mut comparison = ReplayComparison::default();
    let mut again = None;
    for entry in entries {
        match entry {
            Entry::Input { step, now, input: recorded } => {
                again = Some(replay.step(step, now, input(&recorded)));
            }
            Entry::Outcome(recorded) => comparison.add(&recorded, &again.take().unwrap()),
            Entry::Start(_) | Entry::Unit(..) | Entry::Truth(_) | Entry::Note { .. } => {}
        }
    }
    comparison
}

#[test]
fn a_recorded_trial_is_repeated_to_the_bit() {
    let profile = VehicleProfile::fotokite_pro();
    let recording = trial(&profile);
    let comparison = replayed(&recording, &profile);
    assert!(comparison.outcomes > 600, "{} outcomes", comparison.outcomes);
    assert_eq!(
        (comparison.commands_differ, comparison.outcomes_differ),
        (0, 0),
        "{:?}",
        comparison.first_difference
    );
    assert_eq!(comparison.first_difference, None);
    // The camera moves in this trial, and a second recording of it gives the same file.
    let commands = read(&recording).0.into_iter().filter_map(|entry| match entry {
        Entry::Outcome(outcome) => Some(outcome.command),
        _ => None,
    });
    let moving = commands.filter(|command| !command.is_rest()).count();
    assert!(moving > 100, "{moving} moving");
    assert!(recording == trial(&profile));
}

#[test]
fn a_changed_profile_shows_in_the_commands() {
    let profile = VehicleProfile::fotokite_pro();
    let recording = trial(&profile);
    let slow = AngularRate::from_radians_per_second(0.2);
    let slower =
        VehicleProfile { motor_schema_rates: AxisRates { pan: slow, tilt: slow }, ..profile.clone() };
    let comparison = replayed(&recording, &slower);
    assert!(comparison.commands_differ > 100, "{}", comparison.commands_differ);
    let (recorded, replayed_outcome) = *comparison.first_difference.unwrap();
    assert_eq!(recorded.step, replayed_outcome.step);
    assert_eq!(recorded.command.pan.abs().radians_per_second(), 0.3);
    assert_eq!(replayed_outcome.command.pan.abs().radians_per_second(), 0.2);

    let limited = VehicleProfile { limits: AxisRates { pan: slow, tilt: slow }, ..profile };
    let comparison = replayed(&recording, &limited);
    let (recorded, replayed_outcome) = *comparison.first_difference.unwrap();
    // The command is what the vehicle can execute, so that law and recording know what leaves.
    assert_eq!(recorded.command.pan.abs().radians_per_second(), 0.3);
    assert_eq!(replayed_outcome.command.pan.abs().radians_per_second(), 0.2);
    assert_eq!(replayed_outcome.rates.yaw.abs().radians_per_second(), 0.2);
}

#[test]
fn a_difference_in_the_command_comes_before_one_in_anything_else() {
    let one = crate::entries::outcome(0.25);
    let noticed = RecordedOutcome { notice: "other".to_owned(), ..one.clone() };
    let faster = RecordedOutcome { command: crate::entries::outcome(0.5).command, ..one.clone() };
    let mut comparison = ReplayComparison::default();
    comparison.add(&one, &one);
    comparison.add(&one, &noticed);
    comparison.add(&one, &faster);
    comparison.add(&one, &noticed);
    assert_eq!((comparison.outcomes, comparison.commands_differ, comparison.outcomes_differ), (4, 1, 3));
    assert_eq!(comparison.first_difference, Some(Box::new((one, faster))));
}
