//! Enums without data, to and from their stored forms.

use barrelman_control::Sector;
use barrelman_pilot::CommandPath;
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, LinkState};
use barrelman_vocab::video::{CaptureQuality, ColourMatrix, SampleRange};
use barrelman_vocab::{EquipmentKind, HoldCause, MarkKind, StopCause, ZoomAbility};

use super::malformed::{Malformed, missing};
use crate::records::stored;

/// Implements the conversions between an enum and its stored form, from pairs of variants.
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
    StopCause::ControlLost => ControlLost,
    StopCause::VehicleRestarted => VehicleRestarted,
    StopCause::Emergency => Emergency,
    StopCause::Landing => Landing,
    StopCause::BatteryLow => BatteryLow,
    StopCause::VehicleSilent => VehicleSilent,
    StopCause::Exchanged => Exchanged,
    StopCause::Suspended => Suspended,
    StopCause::PanOpposed => PanOpposed,
    StopCause::TiltOpposed => TiltOpposed,
]);
variants!(EquipmentKind, EquipmentKind, "equipment", [
    EquipmentKind::Gimbal => Gimbal,
    EquipmentKind::Camera => Camera,
    EquipmentKind::Stream => Stream,
]);
variants!(ZoomAbility, ZoomAbility, "zoom", [
    ZoomAbility::NotKnown => NotKnown,
    ZoomAbility::Absent => Absent,
    ZoomAbility::Present => Present,
]);
variants!(ControlState, ControlState, "control", [
    ControlState::Elsewhere => Elsewhere,
    ControlState::Ours => Ours,
    ControlState::Unclaimed => Unclaimed,
]);
variants!(LinkState, LinkState, "link", [
    LinkState::Opening => Opening,
    LinkState::Starting => Starting,
    LinkState::Up => Up,
    LinkState::Closing => Closing,
    LinkState::Closed => Closed,
    LinkState::Silent => Silent,
]);
variants!(Acceptance, Acceptance, "acceptance", [
    Acceptance::Accepted => Accepted,
    Acceptance::Queued => Queued,
    Acceptance::OtherClient => OtherClient,
    Acceptance::FlightState => FlightState,
    Acceptance::NotReady => NotReady,
    Acceptance::Fault => Fault,
    Acceptance::NoCamera => NoCamera,
    Acceptance::TokenRefused => TokenRefused,
    Acceptance::LoginRefused => LoginRefused,
    Acceptance::NotCalibrated => NotCalibrated,
    Acceptance::Unusable => Unusable,
    Acceptance::Unanswered => Unanswered,
    Acceptance::Disarmed => Disarmed,
    Acceptance::ChecksFail => ChecksFail,
    Acceptance::StartingUp => StartingUp,
    Acceptance::ModeRefused => ModeRefused,
]);
variants!(HoldCause, HoldCause, "hold_cause", [
    HoldCause::NoSelection => NoSelection,
    HoldCause::TrackLost => TrackLost,
    HoldCause::Coasting => Coasting,
    HoldCause::Doubted => Doubted,
    HoldCause::VideoStale => VideoStale,
    HoldCause::VideoSilent => VideoSilent,
    HoldCause::Confirming => Confirming,
    HoldCause::DryRun => DryRun,
    HoldCause::LinkDown => LinkDown,
    HoldCause::NoControl => NoControl,
    HoldCause::Emergency => Emergency,
    HoldCause::Landing => Landing,
]);
variants!(CommandPath, CommandPath, "command_path", [
    CommandPath::Simulated => Simulated,
    CommandPath::Link => Link,
    CommandPath::DryRun => DryRun,
]);
variants!(MarkKind, MarkKind, "mark_kind", [
    MarkKind::Place => Place,
    MarkKind::Person => Person,
    MarkKind::WayPoint => WayPoint,
    MarkKind::Forbidden => Forbidden,
    MarkKind::Home => Home,
]);
variants!(Sector, Sector, "sector", [
    Sector::Right => Right,
    Sector::Top => Top,
    Sector::Left => Left,
    Sector::Bottom => Bottom,
]);
