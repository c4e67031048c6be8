//! Entries as stored messages, and back. What a stored message lacks or says in a number that means nothing is
//! [`Malformed`], with its name.

use core::time::Duration;

use barrelman_control::{Percept, Sector};
use barrelman_pilot::outcome::HoldCause;
use barrelman_pilot::{Advice, Mode};
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Quaternion, Report};
use barrelman_vocab::track::Shape;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, EncodedUnit, ImagePoint, Localisation, OperatorRequest, PictureSize,
    PixelBox, PixelPoint, StopCause, Telemetry, Timestamp, Track, VehicleRates,
};
use bytes::Bytes;

use super::entry::{Entry, RecordedOutcome, RecordedTruth, RecordingStart};
use super::recorded_input::{FrameFingerprint, RecordedInput};
use super::stored;

/// What is wrong with a stored message.
#[derive(Debug)]
pub struct Malformed(pub(super) String);

impl From<prost::DecodeError> for Malformed {
    fn from(error: prost::DecodeError) -> Self {
        Self(error.to_string())
    }
}

fn missing(field: &str) -> Malformed {
    Malformed(format!("{field} is missing, or has a value that this version does not know"))
}

/// Pairs of our variants and the stored ones, both ways.
macro_rules! variants {
    ($ours:ty, $stored:ident, $name:literal, [$($our:path => $theirs:ident),+ $(,)?]) => {
        impl From<$ours> for stored::$stored {
            fn from(value: $ours) -> Self {
                match value { $($our => Self::$theirs),+ }
            }
        }
        impl TryFrom<stored::$stored> for $ours {
            type Error = Malformed;
            fn try_from(value: stored::$stored) -> Result<Self, Malformed> {
                match value {
                    $(stored::$stored::$theirs => Ok($our),)+
                    #[allow(unreachable_patterns, reason = "not every stored enum has a variant for unknown")]
                    _ => Err(missing($name)),
                }
            }
        }
    };
}

variants!(CaptureQuality, CaptureQuality, "capture_quality", [
    CaptureQuality::Sensor => Sensor,
    CaptureQuality::Sender => Sender,
    CaptureQuality::Arrival => Arrival,
]);
variants!(ColourMatrix, ColourMatrix, "matrix", [
    ColourMatrix::Bt601 => Bt601,
    ColourMatrix::Bt709 => Bt709,
]);
variants!(SampleRange, SampleRange, "range", [
    SampleRange::Limited => Limited,
    SampleRange::Full => Full,
]);
variants!(StopCause, StopCause, "stop_cause", [
    StopCause::Operator => Operator,
    StopCause::Ending => Ending,
    StopCause::VideoEnded => VideoEnded,
    StopCause::Fault => Fault,
]);
variants!(LinkState, LinkState, "link", [
    LinkState::Opening => Opening,
    LinkState::Starting => Starting,
    LinkState::Up => Up,
    LinkState::Closing => Closing,
    LinkState::Closed => Closed,
]);
variants!(HoldCause, HoldCause, "hold_cause", [
    HoldCause::NoSelection => NoSelection,
    HoldCause::TrackLost => TrackLost,
    HoldCause::Coasting => Coasting,
    HoldCause::VideoStale => VideoStale,
    HoldCause::VideoSilent => VideoSilent,
]);
variants!(Sector, Sector, "sector", [
    Sector::Right => Right,
    Sector::Top => Top,
    Sector::Left => Left,
    Sector::Bottom => Bottom,
]);

fn nanos(span: Duration) -> u64 {
    u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)
}

fn capture(at_ns: u64, quality: stored::CaptureQuality) -> Result<Capture, Malformed> {
    Ok(Capture { at: Timestamp::from_nanos(at_ns), quality: quality.try_into()? })
}

fn stored_capture(capture: Capture) -> (u64, i32) {
    (capture.at.as_nanos(), stored::CaptureQuality::from(capture.quality) as i32)
}

impl From<&RecordingStart> for stored::RecordingStart {
    fn from(start: &RecordingStart) -> Self {
        Self {
            program_version: start.program_version.clone(),
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration.clone(),
            video: start.video.clone(),
            link: start.link.clone(),
            live_video: start.live_video,
        }
    }
}

impl From<stored::RecordingStart> for RecordingStart {
    fn from(start: stored::RecordingStart) -> Self {
        Self {
            program_version: start.program_version,
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration,
            video: start.video,
            link: start.link,
            live_video: start.live_video,
        }
    }
}

impl From<&EncodedUnit> for stored::VideoUnit {
    fn from(unit: &EncodedUnit) -> Self {
        let (captured_ns, capture_quality) = stored_capture(unit.capture);
        let mut message = Self {
            epoch: unit.epoch,
            index: unit.index,
            captured_ns,
            capture_quality,
            key: unit.key,
            shown: unit.shown,
            rotation_deg: match unit.rotation {
                Rotation::None => 0,
                Rotation::Clockwise90 => 90,
                Rotation::Half => 180,
                Rotation::Clockwise270 => 270,
            },
            ..Self::default()
        };
        message.codec = match unit.codec {
            UnitCodec::H264AnnexB => stored::UnitCodec::H264,
            UnitCodec::Jpeg => stored::UnitCodec::Jpeg,
            UnitCodec::Png => stored::UnitCodec::Png,
            UnitCodec::RawYuv420 { size, colour } => {
                message.width = size.width;
                message.height = size.height;
                message.matrix = stored::ColourMatrix::from(colour.matrix) as i32;
                message.range = stored::SampleRange::from(colour.range) as i32;
                stored::UnitCodec::Raw
            }
        } as i32;
        message
    }
}

impl stored::VideoUnit {
    /// The unit that this message announced, with its payload.
    pub(super) fn with_payload(self, payload: Bytes) -> Result<EncodedUnit, Malformed> {
        let unit = self;
        let codec = match unit.codec() {
            stored::UnitCodec::H264 => UnitCodec::H264AnnexB,
            stored::UnitCodec::Jpeg => UnitCodec::Jpeg,
            stored::UnitCodec::Png => UnitCodec::Png,
            stored::UnitCodec::Raw => UnitCodec::RawYuv420 {
                size: PictureSize::new(unit.width, unit.height),
                colour: ColourEncoding { matrix: unit.matrix().try_into()?, range: unit.range().try_into()? },
            },
            stored::UnitCodec::Unknown => return Err(missing("codec")),
        };
        let rotation = match unit.rotation_deg {
            0 => Rotation::None,
            90 => Rotation::Clockwise90,
            180 => Rotation::Half,
            270 => Rotation::Clockwise270,
            _ => return Err(missing("rotation_deg")),
        };
        Ok(EncodedUnit {
            epoch: unit.epoch,
            index: unit.index,
            capture: capture(unit.captured_ns, unit.capture_quality())?,
            key: unit.key,
            shown: unit.shown,
            rotation,
            codec,
            payload,
        })
    }
}

impl From<&FrameFingerprint> for stored::FrameInput {
    fn from(stamp: &FrameFingerprint) -> Self {
        let (captured_ns, capture_quality) = stored_capture(stamp.capture);
        Self {
            step: 0,
            now_ns: 0,
            sequence: stamp.sequence,
            captured_ns,
            capture_quality,
            width: stamp.size.width,
            height: stamp.size.height,
            matrix: stored::ColourMatrix::from(stamp.colour.matrix) as i32,
            range: stored::SampleRange::from(stamp.colour.range) as i32,
            luma_hash: stamp.luma_hash,
        }
    }
}

fn input(step: u64, now_ns: u64, input: RecordedInput) -> Entry {
    Entry::Input { step, now: Timestamp::from_nanos(now_ns), input }
}

impl TryFrom<stored::FrameInput> for Entry {
    type Error = Malformed;

    fn try_from(frame: stored::FrameInput) -> Result<Self, Malformed> {
        let stamp = FrameFingerprint {
            sequence: frame.sequence,
            capture: capture(frame.captured_ns, frame.capture_quality())?,
            size: PictureSize::new(frame.width, frame.height),
            colour: ColourEncoding { matrix: frame.matrix().try_into()?, range: frame.range().try_into()? },
            luma_hash: frame.luma_hash,
        };
        Ok(input(frame.step, frame.now_ns, RecordedInput::Frame(stamp)))
    }
}

impl TryFrom<stored::LocalisationInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::LocalisationInput) -> Result<Self, Malformed> {
        let track = Track::try_from(message.track.ok_or_else(|| missing("track"))?)?;
        Ok(input(message.step, message.now_ns, RecordedInput::Localisation(track)))
    }
}

impl From<stored::TickInput> for Entry {
    fn from(tick: stored::TickInput) -> Self {
        input(tick.step, tick.now_ns, RecordedInput::Tick)
    }
}

impl From<PixelBox> for stored::Box {
    fn from(from: PixelBox) -> Self {
        Self { u: from.u, v: from.v, w: from.w, h: from.h }
    }
}

impl From<stored::Box> for PixelBox {
    fn from(from: stored::Box) -> Self {
        Self { u: from.u, v: from.v, w: from.w, h: from.h }
    }
}

impl From<&OperatorRequest> for stored::RequestInput {
    fn from(request: &OperatorRequest) -> Self {
        let mut message = Self::default();
        message.kind = match request {
            OperatorRequest::Select(selection) => {
                message.selection = Some((*selection).into());
                stored::RequestKind::Select
            }
            OperatorRequest::Engage => stored::RequestKind::Engage,
            OperatorRequest::Disengage => stored::RequestKind::Disengage,
            OperatorRequest::Stop(cause) => {
                message.stop_cause = stored::StopCause::from(*cause) as i32;
                stored::RequestKind::Stop
            }
        } as i32;
        message
    }
}

impl TryFrom<stored::RequestInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::RequestInput) -> Result<Self, Malformed> {
        let request = match message.kind() {
            stored::RequestKind::Select => {
                OperatorRequest::Select(message.selection.ok_or_else(|| missing("selection"))?.into())
            }
            stored::RequestKind::Engage => OperatorRequest::Engage,
            stored::RequestKind::Disengage => OperatorRequest::Disengage,
            stored::RequestKind::Stop => OperatorRequest::Stop(message.stop_cause().try_into()?),
            stored::RequestKind::Unknown => return Err(missing("kind")),
        };
        Ok(input(message.step, message.now_ns, RecordedInput::Request(request)))
    }
}

fn stored_quaternion(q: Quaternion) -> stored::Quaternion {
    stored::Quaternion { w: q.w, x: q.x, y: q.y, z: q.z }
}

fn quaternion(q: stored::Quaternion) -> Quaternion {
    Quaternion { w: q.w, x: q.x, y: q.y, z: q.z }
}

impl From<&Telemetry> for stored::TelemetryInput {
    fn from(telemetry: &Telemetry) -> Self {
        use stored::telemetry_input::Report as Stored;
        let report = match telemetry.report {
            Report::Link(state) => Stored::Link(stored::LinkState::from(state) as i32),
            Report::Ground { control, uptime_s, battery_v, tether_m } => {
                let in_control = control == ControlState::Ours;
                Stored::Ground(stored::GroundReport { in_control, uptime_s, battery_v, tether_m })
            }
            Report::VehicleAttitude(q) => Stored::VehicleAttitude(stored_quaternion(q)),
            Report::GimbalAttitude(q) => Stored::GimbalAttitude(stored_quaternion(q)),
            Report::CameraTilt(tilt) => Stored::CameraTiltRad(tilt.radians()),
            Report::FieldOfView(angle) => Stored::FieldOfViewRad(angle.radians()),
            Report::Tether { elevation, azimuth, altitude_m } => Stored::Tether(stored::TetherReport {
                elevation_rad: elevation.radians(),
                azimuth_rad: azimuth.radians(),
                altitude_m,
            }),
            Report::Flight { state, on_time_s, backup_battery_v, warnings } => {
                let (state, mode) = match state {
                    FlightState::Idle => (stored::FlightState::Idle, 0),
                    FlightState::Flying => (stored::FlightState::Flying, 0),
                    FlightState::Emergency => (stored::FlightState::Emergency, 0),
                    FlightState::Other(mode) => (stored::FlightState::Other, mode),
                };
                let state = state as i32;
                Stored::Flight(stored::FlightReport { state, mode, on_time_s, backup_battery_v, warnings })
            }
        };
        Self { step: 0, now_ns: 0, at_ns: telemetry.at.as_nanos(), report: Some(report) }
    }
}

impl TryFrom<stored::TelemetryInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::TelemetryInput) -> Result<Self, Malformed> {
        use stored::telemetry_input::Report as Stored;
        let report = match message.report.ok_or_else(|| missing("report"))? {
            Stored::Link(state) => {
                Report::Link(stored::LinkState::try_from(state).map_err(|_| missing("link"))?.try_into()?)
            }
            Stored::Ground(ground) => Report::Ground {
                control: if ground.in_control { ControlState::Ours } else { ControlState::NotOurs },
                uptime_s: ground.uptime_s,
                battery_v: ground.battery_v,
                tether_m: ground.tether_m,
            },
            Stored::VehicleAttitude(q) => Report::VehicleAttitude(quaternion(q)),
            Stored::GimbalAttitude(q) => Report::GimbalAttitude(quaternion(q)),
            Stored::CameraTiltRad(tilt) => Report::CameraTilt(Angle::from_radians(tilt)),
            Stored::FieldOfViewRad(angle) => Report::FieldOfView(Angle::from_radians(angle)),
            Stored::Tether(tether) => Report::Tether {
                elevation: Angle::from_radians(tether.elevation_rad),
                azimuth: Angle::from_radians(tether.azimuth_rad),
                altitude_m: tether.altitude_m,
            },
            Stored::Flight(flight) => Report::Flight {
                state: match stored::FlightState::try_from(flight.state).map_err(|_| missing("state"))? {
                    stored::FlightState::Idle => FlightState::Idle,
                    stored::FlightState::Flying => FlightState::Flying,
                    stored::FlightState::Emergency => FlightState::Emergency,
                    stored::FlightState::Other => FlightState::Other(flight.mode),
                },
                on_time_s: flight.on_time_s,
                backup_battery_v: flight.backup_battery_v,
                warnings: flight.warnings,
            },
        };
        let telemetry = Telemetry { at: Timestamp::from_nanos(message.at_ns), report };
        Ok(input(message.step, message.now_ns, RecordedInput::Telemetry(telemetry)))
    }
}

impl From<&Localisation> for stored::Localisation {
    fn from(seen: &Localisation) -> Self {
        Self {
            captured_ns: seen.captured.as_nanos(),
            picture_width: seen.picture.width,
            picture_height: seen.picture.height,
            u: seen.centre.u,
            v: seen.centre.v,
            bounds: Some(seen.bounds.into()),
            major_px: seen.shape.map(|shape| shape.major_px),
            minor_px: seen.shape.map(|shape| shape.minor_px),
            axis_rad: seen.shape.map(|shape| shape.axis.radians()),
            heading_rad: seen.heading.map(Angle::radians),
        }
    }
}

fn localisation(seen: &stored::Localisation, confidence: f64) -> Result<Localisation, Malformed> {
    let shape = match (seen.major_px, seen.minor_px, seen.axis_rad) {
        (Some(major_px), Some(minor_px), Some(axis)) => {
            Some(Shape { major_px, minor_px, axis: Angle::from_radians(axis) })
        }
        _ => None,
    };
    Ok(Localisation {
        captured: Timestamp::from_nanos(seen.captured_ns),
        picture: PictureSize::new(seen.picture_width, seen.picture_height),
        centre: PixelPoint { u: seen.u, v: seen.v },
        bounds: seen.bounds.ok_or_else(|| missing("bounds"))?.into(),
        shape,
        heading: seen.heading_rad.map(Angle::from_radians),
        confidence,
    })
}

impl From<&Track> for stored::Track {
    fn from(track: &Track) -> Self {
        let (state, lost_since, confidence) = match track {
            Track::Unseeded => (stored::TrackState::Unseeded, 0, 0.0),
            Track::Tracking(seen) => (stored::TrackState::Tracking, 0, seen.confidence),
            Track::Coasting(seen) => (stored::TrackState::Coasting, 0, seen.confidence),
            Track::Lost { since, confidence } => (stored::TrackState::Lost, since.as_nanos(), *confidence),
        };
        Self {
            state: state as i32,
            localisation: track.localisation().map(Into::into),
            lost_since_ns: lost_since,
            confidence,
        }
    }
}

impl TryFrom<stored::Track> for Track {
    type Error = Malformed;

    fn try_from(track: stored::Track) -> Result<Self, Malformed> {
        let seen = || {
            let seen = track.localisation.as_ref().ok_or_else(|| missing("localisation"))?;
            localisation(seen, track.confidence)
        };
        Ok(match stored::TrackState::try_from(track.state).map_err(|_| missing("state"))? {
            stored::TrackState::Unseeded => Self::Unseeded,
            stored::TrackState::Tracking => Self::Tracking(seen()?),
            stored::TrackState::Coasting => Self::Coasting(seen()?),
            stored::TrackState::Lost => {
                Self::Lost { since: Timestamp::from_nanos(track.lost_since_ns), confidence: track.confidence }
            }
        })
    }
}

impl From<&RecordedOutcome> for stored::Outcome {
    fn from(outcome: &RecordedOutcome) -> Self {
        let (mut hold, mut stop) = (stored::HoldCause::None, stored::StopCause::None);
        let mode = match outcome.mode {
            Mode::Idle => stored::Mode::Idle,
            Mode::Servoing => stored::Mode::Servoing,
            Mode::Holding(why) => {
                hold = why.into();
                stored::Mode::Holding
            }
            Mode::Stopped(cause) => {
                stop = cause.into();
                stored::Mode::Stopped
            }
        };
        let sector = outcome.advice.and_then(|advice| advice.sector);
        Self {
            step: outcome.step,
            now_ns: outcome.at.as_nanos(),
            mode: mode as i32,
            hold_cause: hold as i32,
            stop_cause: stop as i32,
            track: Some((&outcome.track).into()),
            age_ns: outcome.age.map(nanos),
            percept: outcome.percept.map(|percept| stored::Percept {
                x: percept.position.x,
                y: percept.position.y,
                p: percept.p,
                r_px: percept.r_px,
                direction_rad: percept.direction.radians(),
            }),
            advised_pan: outcome.advice.map(|advice| advice.command.pan.radians_per_second()),
            advised_tilt: outcome.advice.map(|advice| advice.command.tilt.radians_per_second()),
            sector: sector.map_or(stored::Sector::None, Into::into) as i32,
            pan: outcome.command.pan.radians_per_second(),
            tilt: outcome.command.tilt.radians_per_second(),
            yaw_rate: outcome.rates.yaw.radians_per_second(),
            pitch_rate: outcome.rates.pitch.radians_per_second(),
            wake_at_ns: outcome.wake_at.map(Timestamp::as_nanos),
            notice: outcome.notice.clone(),
        }
    }
}

impl TryFrom<stored::Outcome> for RecordedOutcome {
    type Error = Malformed;

    fn try_from(outcome: stored::Outcome) -> Result<Self, Malformed> {
        let rate = AngularRate::from_radians_per_second;
        let mode = match stored::Mode::try_from(outcome.mode).map_err(|_| missing("mode"))? {
            stored::Mode::Idle => Mode::Idle,
            stored::Mode::Servoing => Mode::Servoing,
            stored::Mode::Holding => Mode::Holding(outcome.hold_cause().try_into()?),
            stored::Mode::Stopped => Mode::Stopped(outcome.stop_cause().try_into()?),
        };
        let sector = match stored::Sector::try_from(outcome.sector).map_err(|_| missing("sector"))? {
            stored::Sector::None => None,
            sector => Some(sector.try_into()?),
        };
        let advice = match (outcome.advised_pan, outcome.advised_tilt) {
            (Some(pan), Some(tilt)) => {
                Some(Advice { command: CameraCommand { pan: rate(pan), tilt: rate(tilt) }, sector })
            }
            _ => None,
        };
        Ok(Self {
            step: outcome.step,
            at: Timestamp::from_nanos(outcome.now_ns),
            mode,
            age: outcome.age_ns.map(Duration::from_nanos),
            percept: outcome.percept.as_ref().map(|percept| Percept {
                position: ImagePoint { x: percept.x, y: percept.y },
                p: percept.p,
                r_px: percept.r_px,
                direction: Angle::from_radians(percept.direction_rad),
            }),
            advice,
            command: CameraCommand { pan: rate(outcome.pan), tilt: rate(outcome.tilt) },
            rates: VehicleRates { yaw: rate(outcome.yaw_rate), pitch: rate(outcome.pitch_rate) },
            wake_at: outcome.wake_at_ns.map(Timestamp::from_nanos),
            track: outcome.track.ok_or_else(|| missing("track"))?.try_into()?,
            notice: outcome.notice,
        })
    }
}

impl From<&RecordedTruth> for stored::WorldTruth {
    fn from(truth: &RecordedTruth) -> Self {
        Self {
            tick: truth.tick,
            at_ns: truth.at.as_nanos(),
            target_x_m: truth.target_m.0,
            target_y_m: truth.target_m.1,
            target_heading_rad: truth.target_heading.radians(),
            camera_x_m: truth.camera_m.0,
            camera_y_m: truth.camera_m.1,
            camera_z_m: truth.camera_m.2,
            camera_pan_rad: truth.camera_pan.radians(),
            camera_tilt_rad: truth.camera_tilt.radians(),
            image_x: truth.target_position.x,
            image_y: truth.target_position.y,
            in_picture: truth.in_picture,
            range_m: truth.range_m,
        }
    }
}

impl From<stored::WorldTruth> for RecordedTruth {
    fn from(truth: stored::WorldTruth) -> Self {
        Self {
            tick: truth.tick,
            at: Timestamp::from_nanos(truth.at_ns),
            target_m: (truth.target_x_m, truth.target_y_m),
            target_heading: Angle::from_radians(truth.target_heading_rad),
            camera_m: (truth.camera_x_m, truth.camera_y_m, truth.camera_z_m),
            camera_pan: Angle::from_radians(truth.camera_pan_rad),
            camera_tilt: Angle::from_radians(truth.camera_tilt_rad),
            target_position: ImagePoint { x: truth.image_x, y: truth.image_y },
            in_picture: truth.in_picture,
            range_m: truth.range_m,
        }
    }
}
