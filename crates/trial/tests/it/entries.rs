//! Sample entries, and writing and reading them.

use core::time::Duration;

use barrelman_control::{Percept, Sector};
use barrelman_pilot::{
    Advice, ClassName, Classification, CommandPath, Detection, Detections, MAX_DETECTIONS, Mode,
};
use barrelman_trial::records::{
    Entry, FrameFingerprint, ReadError, RecordedInput, RecordedMark, RecordedOutcome, RecordedProgress,
    RecordedTruth, RecordedVessel, RecordedVideo, RecordingReader, RecordingStart, RecordingWriter,
};
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::VehicleProfile;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Quaternion, Report};
use barrelman_vocab::track::Shape;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::vehicle_text::VehicleText;
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, CameraRequest, DrawnMark, EncodedUnit, Equipment, EquipmentKind,
    HoldCause, ImagePoint, Localisation, MarkKind, MovedMark, Note, OperatorRequest, PictureSize, PixelBox,
    PixelPoint, StopCause, Telemetry, Timestamp, Track, VesselCommand, VesselRequest, VesselStopper,
    VideoNumber, WaterPoint, ZoomAbility,
};
use bytes::Bytes;

use crate::trial_logs::rates;

pub(crate) fn start() -> RecordingStart {
    RecordingStart {
        program: "0.1.0".to_owned(),
        monotonic_ns: 123,
        unix_ns: 1_493_598_415_000_000_000,
        configuration: "[video]\nurl = \"file:clip.mp4\" # a, b\n".to_owned(),
        videos: RecordedVideo::only("file:clip.mp4", true),
        link: String::new(),
        command_path: CommandPath::Link,
        trial: None,
    }
}

pub(crate) fn written(entries: &[Entry]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = RecordingWriter::begin(&mut bytes, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    for entry in entries {
        writer.write(entry).unwrap();
    }
    writer.finish().unwrap();
    bytes
}

/// The entries that can be read, and the error that stopped the reader.
pub(crate) fn read(bytes: &[u8]) -> (Vec<Entry>, Option<ReadError>) {
    let mut entries = Vec::new();
    let mut reader = RecordingReader::new(bytes);
    for entry in &mut reader {
        match entry {
            Ok(entry) => entries.push(entry),
            Err(error) => {
                assert!(reader.next().is_none(), "a reader that failed returns nothing more");
                return (entries, Some(error));
            }
        }
    }
    (entries, None)
}

/// Writes and reads entries and checks that they are equal to the bit: the debug text of a float is exact and
/// distinguishes -0.0 from 0.0.
#[track_caller]
pub(crate) fn check(entries: &[Entry]) {
    let (found, error) = read(&written(entries));
    assert!(error.is_none(), "{error:?}");
    let expected = [&[Entry::Start(start())], entries].concat();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(format!("{found:?}"), format!("{expected:?}"));
    }
}

pub(crate) fn ns(nanos: u64) -> Timestamp {
    Timestamp::from_nanos(nanos)
}

pub(crate) const SENSOR: Capture = Capture { at: Timestamp::from_nanos(77), quality: CaptureQuality::Sensor };
pub(crate) const COLOURS: [ColourEncoding; 2] =
    [ColourEncoding::JPEG, ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited }];

pub(crate) fn unit(codec: UnitCodec, payload: &'static [u8]) -> EncodedUnit {
    EncodedUnit {
        epoch: 3,
        index: 41,
        capture: SENSOR,
        key: true,
        shown: false,
        rotation: Rotation::None,
        codec,
        payload: Bytes::from_static(payload),
    }
}

/// A localisation with `value` for every number.
pub(crate) fn localisation(value: f64) -> Localisation {
    Localisation {
        captured: ns(5),
        picture: PictureSize::new(640, 480),
        centre: PixelPoint { u: value, v: value },
        bounds: PixelBox { u: value, v: value, w: value, h: value },
        shape: Some(Shape { major_px: value, minor_px: value, axis: Angle::from_radians(value) }),
        heading: Some(Angle::from_radians(value)),
        confidence: value,
    }
}

/// An outcome with `value` for every number.
pub(crate) fn outcome(value: f64) -> RecordedOutcome {
    let rate = AngularRate::from_radians_per_second(value);
    let command = CameraCommand::turning(rate, rate);
    RecordedOutcome {
        step: 9,
        at: ns(1_000),
        mode: Mode::Servoing,
        track: Track::Tracking(localisation(value)),
        age: Some(Duration::from_nanos(200_000_001)),
        percept: Some(Percept {
            position: ImagePoint { x: value, y: value },
            p: value,
            r_px: value,
            direction: Angle::from_radians(value),
        }),
        advice: Some(Advice { command, sector: Some(Sector::Left) }),
        command,
        rates: rates(value, value),
        wake_at: Some(ns(250_001_000)),
        vessel: Some(Box::new(RecordedVessel {
            mode: "boat guided".to_owned(),
            command: VesselCommand { throttle: value, rudder: value },
            renew_by: Some(ns(300_000_000)),
            progress: Some(RecordedProgress {
                boat: WaterPoint { x: value, y: value },
                speed_m_per_s: value,
                course_rad: Some(value),
                distance_m: value,
                cross_track_m: value,
            }),
            destination: Some((3, Some(WaterPoint { x: value, y: value }))),
            marks: vec![RecordedMark {
                id: 3,
                kind: MarkKind::Person,
                at: WaterPoint { x: value, y: value },
                radius_m: value,
                std_dev_m: value,
                on_earth: Some(place(value)),
                held: Some(Track::Lost { since: Timestamp::from_nanos(7), confidence: value }),
            }],
            view: Some([WaterPoint { x: value, y: value }; 4]),
            boat_on_earth: Some(place(value)),
        })),
        notice: "following, \"it\"".to_owned(),
    }
}

fn place(value: f64) -> GeoPoint {
    GeoPoint { latitude: Angle::from_radians(value), longitude: Angle::from_radians(value) }
}

fn detections(value: f64) -> Detections {
    let bounds = PixelBox { u: value, v: value, w: value, h: value };
    let class = ClassName::new("person").unwrap();
    let detection = Detection { bounds, classification: Classification { class, score: value } };
    let picture = PictureSize::new(640, 360);
    Detections { captured: ns(3), picture, found: vec![detection; MAX_DETECTIONS] }
}

pub(crate) fn input(input: RecordedInput) -> Entry {
    Entry::Input { step: 7, now: ns(1_000), input }
}

pub(crate) fn telemetry(report: Report) -> Entry {
    input(RecordedInput::Telemetry(Telemetry { at: ns(999), report }))
}

/// An entry of every kind that has floats, with `value` for each.
pub(crate) fn entries_with(value: f64) -> Vec<Entry> {
    let q = Quaternion { w: value, x: value, y: value, z: value };
    let mut entries = vec![
        input(RecordedInput::Localisation(Track::Tracking(localisation(value)))),
        input(RecordedInput::Detections(Box::new(detections(value)))),
        input(RecordedInput::Localisation(Track::Coasting(localisation(value)))),
        input(RecordedInput::Localisation(Track::Lost { since: ns(4), confidence: value })),
        telemetry(Report::VehicleAttitude(q)),
        telemetry(Report::GimbalAttitude(q)),
        telemetry(Report::CameraTilt(Angle::from_radians(value))),
        telemetry(Report::CameraHeading(Angle::from_radians(value))),
        telemetry(Report::CameraPan(Angle::from_radians(value))),
        telemetry(Report::CameraHeight(value)),
        telemetry(Report::Speed(value)),
        telemetry(Report::DriveMode(DriveMode(u32::MAX))),
        telemetry(Report::Text(VehicleText::of(4, b"PreArm: check the compass"))),
        telemetry(Report::Equipment(Equipment::new(EquipmentKind::Stream, "main (source 1)"))),
        telemetry(Report::Zoom(ZoomAbility::Absent)),
        input(RecordedInput::VesselTelemetry(Telemetry { at: ns(999), report: Report::CameraHeight(value) })),
        telemetry(Report::FieldOfView(Angle::from_radians(value))),
        telemetry(Report::OtherVideo(Some(Angle::from_radians(value)))),
        telemetry(Report::OtherVideo(None)),
        telemetry(Report::FlightState { state: FlightState::Other(u32::MAX), is_battery_low: true }),
        telemetry(Report::Acceptance(Acceptance::ModeRefused)),
        telemetry(Report::Ground {
            control: ControlState::Ours,
            uptime_s: value,
            battery_v: value,
            tether_m: value,
        }),
        telemetry(Report::Control { control: ControlState::Elsewhere, uptime_s: value }),
        telemetry(Report::Control { control: ControlState::Unclaimed, uptime_s: value }),
        telemetry(Report::Position {
            latitude: Angle::from_radians(value),
            longitude: Angle::from_radians(value),
            altitude_m: value,
            height_m: value,
            heading: Some(Angle::from_radians(value)),
        }),
        telemetry(Report::Tether {
            elevation: Angle::from_radians(value),
            azimuth: Angle::from_radians(value),
            altitude_m: value,
        }),
        telemetry(Report::Flight {
            state: FlightState::Other(u32::MAX),
            on_time_s: value,
            backup_battery_v: value,
            warnings: u32::MAX,
            is_battery_low: true,
        }),
        Entry::Outcome(outcome(value)),
    ];
    // JSON carries finite numbers alone.
    if value.is_finite() {
        entries.extend(requests_with(value));
    }
    entries
}

/// Requests with `value` for every number.
fn requests_with(value: f64) -> Vec<Entry> {
    let bounds = PixelBox { u: value, v: value, w: value, h: value };
    vec![
        input(RecordedInput::Request(OperatorRequest::Camera(CameraRequest::SelectNext(bounds)))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand {
            throttle: value,
            rudder: value,
        })))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::MoveMark(MovedMark {
            id: 3,
            at: PixelPoint { u: value, v: value },
            captured_ns: ns(8),
        })))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::Mark(DrawnMark {
            mark: MarkKind::Person,
            at: PixelPoint { u: value, v: value },
            captured_ns: ns(7),
        })))),
    ]
}

/// Entries of every kind, with every variant.
pub(crate) fn every_kind() -> Vec<Entry> {
    let mut entries = entries_with(0.25);
    let size = PictureSize::new(3, 1);
    let codecs: [(UnitCodec, &'static [u8]); 8] = [
        (UnitCodec::H264AnnexB, &[0, 0, 0, 1, 9, 0xf0]),
        (UnitCodec::H265AnnexB, &[0, 0, 0, 1, 0x46, 1]),
        (UnitCodec::Vp9, &[0x82, 0x49]),
        (UnitCodec::Av1, &[0x12, 0]),
        (UnitCodec::Jpeg, &[0xff, 0xd8]),
        (UnitCodec::Png, b"\x89PNG"),
        (UnitCodec::RawYuv420 { size, colour: COLOURS[0] }, &[1, 2, 3, 4, 5, 6, 7]),
        (UnitCodec::RawYuv420 { size: PictureSize::new(0, 0), colour: COLOURS[1] }, &[]),
    ];
    for video in VideoNumber::ALL {
        entries.extend(codecs.map(|(codec, payload)| Entry::Unit(video, unit(codec, payload))));
    }
    let rotations = [Rotation::Clockwise90, Rotation::Half, Rotation::Clockwise270];
    entries.extend(rotations.map(|rotation| {
        Entry::Unit(
            VideoNumber::Second,
            EncodedUnit { rotation, key: false, shown: true, ..unit(UnitCodec::Jpeg, &[1]) },
        )
    }));
    let qualities = [CaptureQuality::Sensor, CaptureQuality::Sender, CaptureQuality::Arrival];
    entries.extend(qualities.map(|quality| {
        let video = VideoNumber::Second;
        let capture = Capture { at: ns(77), quality };
        let (sequence, luma_hash) = (u64::MAX, u64::MAX);
        input(RecordedInput::Frame(FrameFingerprint {
            video,
            sequence,
            capture,
            size,
            colour: COLOURS[1],
            luma_hash,
        }))
    }));
    let bare = Localisation { shape: None, heading: None, ..localisation(0.5) };
    entries.extend([
        input(RecordedInput::Localisation(Track::Unseeded)),
        input(RecordedInput::Localisation(Track::Tracking(bare))),
        input(RecordedInput::Request(OperatorRequest::Camera(CameraRequest::Engage))),
        input(RecordedInput::Request(OperatorRequest::Camera(CameraRequest::Disengage))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::Unmark { id: 7 }))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::UnmarkAll))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::NextMark))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::Guide))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::GoHome))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::StopVessel {
            by: VesselStopper::Operator,
        }))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::StopVessel {
            by: VesselStopper::ConsoleLost,
        }))),
        input(RecordedInput::Request(OperatorRequest::Vessel(VesselRequest::ReleaseVessel))),
        input(RecordedInput::Tick),
    ]);
    let causes = [
        StopCause::Operator,
        StopCause::Ending,
        StopCause::VideoEnded,
        StopCause::Fault,
        StopCause::ControlLost,
        StopCause::VehicleRestarted,
        StopCause::Emergency,
        StopCause::Landing,
        StopCause::BatteryLow,
        StopCause::Exchanged,
    ];
    entries.extend(causes.map(|cause| input(RecordedInput::Request(OperatorRequest::Stop(cause)))));
    let links =
        [LinkState::Opening, LinkState::Starting, LinkState::Up, LinkState::Closing, LinkState::Closed];
    entries.extend(links.map(|state| telemetry(Report::Link(state))));
    let flights = [
        FlightState::Idle,
        FlightState::Flying,
        FlightState::Landing,
        FlightState::Emergency,
        FlightState::Other(0),
    ];
    entries.extend(flights.map(|state| {
        telemetry(Report::Flight {
            state,
            on_time_s: 1.0,
            backup_battery_v: 12.0,
            warnings: 0,
            is_battery_low: false,
        })
    }));
    let (uptime_s, battery_v, tether_m) = (1.0, 2.0, 3.0);
    let control = ControlState::Elsewhere;
    entries.push(telemetry(Report::Ground { control, uptime_s, battery_v, tether_m }));
    let holds = [
        HoldCause::NoSelection,
        HoldCause::TrackLost,
        HoldCause::Coasting,
        HoldCause::VideoStale,
        HoldCause::VideoSilent,
        HoldCause::Confirming,
        HoldCause::DryRun,
        HoldCause::LinkDown,
        HoldCause::NoControl,
        HoldCause::Emergency,
        HoldCause::Landing,
    ];
    let modes = holds.map(Mode::Holding).into_iter().chain(causes.map(Mode::Stopped)).chain([
        Mode::Idle,
        Mode::Nudging,
        Mode::Searching,
        Mode::Calibrating,
    ]);
    entries.extend(modes.map(|mode| Entry::Outcome(RecordedOutcome { mode, ..outcome(0.125) })));
    let sectors =
        [Sector::Right, Sector::Top, Sector::Left, Sector::Bottom].map(Some).into_iter().chain([None]);
    entries.extend(sectors.map(|sector| {
        let advice = Some(Advice { command: CameraCommand::REST, sector });
        Entry::Outcome(RecordedOutcome { advice, ..outcome(0.125) })
    }));
    entries.push(Entry::Outcome(RecordedOutcome {
        track: Track::Unseeded,
        age: None,
        percept: None,
        advice: None,
        wake_at: None,
        notice: String::new(),
        ..outcome(0.0)
    }));
    for text in ["", "smoke at the pier"] {
        let note = Note { text: text.to_owned().try_into().unwrap() };
        entries.push(Entry::Note { at: ns(1_900), note });
    }
    entries.push(Entry::Truth(truth(ns(2_000))));
    for bounds in [None, Some(PixelBox { u: 1.5, v: -2.0, w: 30.0, h: 12.0 })] {
        let target = Some(TargetInPicture { bounds, visible_share: 0.75 });
        entries.push(Entry::Truth(RecordedTruth { target, ..truth(ns(2_100)) }));
    }
    entries
}

/// The truth of a simulated world at a time.
pub(crate) fn truth(at: Timestamp) -> RecordedTruth {
    RecordedTruth {
        tick: 3,
        at,
        target_m: (1.5, -2.0),
        target_heading: Angle::from_radians(0.5),
        camera_m: (0.1, 0.2, 1.83),
        camera_pan: Angle::from_radians(-0.25),
        camera_tilt: Angle::from_radians(-0.4),
        target_position: ImagePoint { x: -300.0, y: 12.5 },
        in_picture: true,
        range_m: 3.5,
        target: None,
    }
}
