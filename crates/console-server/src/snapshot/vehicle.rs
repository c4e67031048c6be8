//! The newest state of the vehicle and its link, from telemetry.

use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::drive_mode::DriveMode;
use barrelman_vocab::telemetry::{ControlState, FlightState, LinkState, Report};
use barrelman_vocab::{Angle, Telemetry, UsedEquipment};

/// Where commands go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LinkStatus {
    /// Nowhere: a dry run.
    #[default]
    DryRun,
    /// To the camera of a demo's world, which cannot be lost.
    Simulated,
    /// To a link in this state.
    Link(LinkState),
}

impl LinkStatus {
    /// Whether commands do not arrive.
    pub fn is_down(self) -> bool {
        matches!(self, Self::Link(state) if state != LinkState::Up)
    }

    /// The name in the console's API.
    pub const fn key(self) -> &'static str {
        match self {
            Self::DryRun => "dry-run",
            Self::Simulated => "simulated",
            Self::Link(LinkState::Opening) => "opening",
            Self::Link(LinkState::Starting) => "starting",
            Self::Link(LinkState::Up) => "up",
            Self::Link(LinkState::Silent) => "silent",
            Self::Link(LinkState::Closing) => "closing",
            Self::Link(LinkState::Closed) => "closed",
        }
    }
}

/// Position of the vehicle on Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehiclePosition {
    /// Latitude, positive to the north.
    pub latitude: Angle,
    /// Longitude, positive to the east.
    pub longitude: Angle,
    /// Direction of the vehicle's nose from north, positive to the east.
    pub heading: Option<Angle>,
}

/// The newest state of the vehicle and its link.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleSnapshot {
    /// The link.
    pub link: LinkStatus,
    /// Whether the vehicle accepts commands from this program.
    pub control: Option<ControlState>,
    /// What a vehicle that answers commands says to them.
    pub acceptance: Option<Acceptance>,
    /// The mode of a boat's autopilot.
    pub drive_mode: Option<DriveMode>,
    /// Battery voltage, volts.
    pub battery_v: Option<f64>,
    /// Whether the vehicle says that one of its batteries is low.
    pub is_battery_low: bool,
    /// Elevation of the camera's axis.
    pub tilt: Option<Angle>,
    /// Direction of the camera's axis over the water from north, positive to the east.
    pub camera_heading: Option<Angle>,
    /// Horizontal angle of view of the camera, of a vehicle that reports a zoom.
    pub field_of_view: Option<Angle>,
    /// Horizontal angle of view of the camera of the video that is followed, where that is not the vehicle's.
    pub other_field_of_view: Option<Angle>,
    /// Height above the place of the start, metres.
    pub altitude_m: Option<f64>,
    /// Position on Earth.
    pub position: Option<VehiclePosition>,
    /// Flight state.
    pub flight: Option<FlightState>,
    /// The gimbal, the camera and the stream that are used; also of a link that was lost.
    pub equipment: UsedEquipment,
    /// Whether nothing reaches a camera that was turning, or a boat that was under way.
    pub may_be_moving: bool,
}

impl VehicleSnapshot {
    /// Takes a report.
    pub(super) fn on_telemetry(&mut self, telemetry: &Telemetry) {
        self.altitude_m = telemetry.report.height_m().or(self.altitude_m);
        match telemetry.report {
            Report::Link(state) => {
                self.link = LinkStatus::Link(state);
                // A session begins with zeros, and is up when the vehicle has answered: before that, the
                // zeros may not have arrived.
                let may_be_moving = self.may_be_moving && state != LinkState::Up;
                *self = match state {
                    LinkState::Up => Self { may_be_moving, ..*self },
                    _ => {
                        let Self { link, equipment, other_field_of_view, .. } = *self;
                        Self { link, may_be_moving, equipment, other_field_of_view, ..Self::default() }
                    }
                };
            }
            Report::Ground { control, battery_v, .. } => {
                (self.control, self.battery_v) = (Some(control), Some(battery_v));
            }
            Report::Acceptance(said) => {
                let is_ours = said == Acceptance::Accepted;
                self.control = Some(if is_ours { ControlState::Ours } else { ControlState::Elsewhere });
                self.acceptance = Some(said);
            }
            Report::DriveMode(mode) => self.drive_mode = Some(mode),
            Report::Control { control, .. } => self.control = Some(control),
            Report::CameraTilt(tilt) => self.tilt = Some(tilt),
            Report::CameraHeading(heading) => self.camera_heading = Some(heading),
            Report::Position { latitude, longitude, heading, .. } => {
                self.position = Some(VehiclePosition { latitude, longitude, heading });
            }
            Report::Flight { state, is_battery_low, .. } | Report::FlightState { state, is_battery_low } => {
                (self.flight, self.is_battery_low) = (Some(state), is_battery_low);
            }
            Report::FieldOfView(angle) => self.field_of_view = Some(angle),
            Report::OtherVideo(field_of_view) => self.other_field_of_view = field_of_view,
            Report::Equipment(used) => {
                self.equipment.on_used(used);
            }
            Report::CameraHeight(_)
            | Report::Tether { .. }
            | Report::VehicleAttitude(_)
            | Report::GimbalAttitude(_)
            | Report::CameraPan(_)
            | Report::Speed(_)
            | Report::Text(_)
            | Report::Zoom(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{Equipment, EquipmentKind, ShortText};

    use super::*;
    use crate::test_scenes::at;

    /// The state after these reports.
    fn after(reports: &[Report]) -> VehicleSnapshot {
        let mut vehicle = VehicleSnapshot::default();
        for report in reports {
            vehicle.on_telemetry(&Telemetry { at: at(0), report: *report });
        }
        vehicle
    }

    const UP: Report = Report::Link(LinkState::Up);
    const GROUND: Report =
        Report::Ground { control: ControlState::Ours, uptime_s: 9.0, battery_v: 15.5, tether_m: 12.0 };
    const CONTROL: Report = Report::Control { control: ControlState::Ours, uptime_s: 9.0 };
    const TETHER: Report = Report::Tether { elevation: Angle::ZERO, azimuth: Angle::ZERO, altitude_m: 10.5 };
    const POSITION: Report = Report::Position {
        latitude: Angle::from_degrees(54.0),
        longitude: Angle::from_degrees(10.0),
        altitude_m: 55.0,
        height_m: 10.5,
        heading: None,
    };
    const FLIGHT: Report = Report::Flight {
        state: FlightState::Flying,
        on_time_s: 9.0,
        backup_battery_v: 8.0,
        warnings: 64,
        is_battery_low: true,
    };
    const TILT: Report = Report::CameraTilt(Angle::from_degrees(-20.0));

    const KNOWN: VehicleSnapshot = VehicleSnapshot {
        link: LinkStatus::Link(LinkState::Up),
        control: Some(ControlState::Ours),
        acceptance: None,
        drive_mode: None,
        battery_v: Some(15.5),
        tilt: Some(Angle::from_degrees(-20.0)),
        camera_heading: None,
        field_of_view: None,
        other_field_of_view: None,
        altitude_m: Some(10.5),
        position: None,
        flight: Some(FlightState::Flying),
        equipment: UsedEquipment { gimbal: None, camera: None, stream: None },
        may_be_moving: false,
        is_battery_low: true,
    };

    #[test]
    fn a_camera_that_may_turn_may_until_the_vehicle_has_answered() {
        let mut vehicle = VehicleSnapshot { may_be_moving: true, ..KNOWN };
        for state in [LinkState::Silent, LinkState::Opening, LinkState::Starting] {
            vehicle.on_telemetry(&Telemetry { at: at(0), report: Report::Link(state) });
            assert!(vehicle.may_be_moving, "{state:?}");
        }
        vehicle.on_telemetry(&Telemetry { at: at(0), report: UP });
        assert!(!vehicle.may_be_moving);
    }

    #[test]
    fn each_report_sets_what_it_tells() {
        let none = VehicleSnapshot::default();
        let up = VehicleSnapshot { link: LinkStatus::Link(LinkState::Up), ..none };
        for (reports, expected) in [
            (&[][..], none),
            (&[UP], up),
            (&[UP, GROUND], VehicleSnapshot { control: KNOWN.control, battery_v: KNOWN.battery_v, ..up }),
            (
                &[UP, Report::Acceptance(Acceptance::Queued)],
                VehicleSnapshot {
                    control: Some(ControlState::Elsewhere),
                    acceptance: Some(Acceptance::Queued),
                    ..up
                },
            ),
            (&[UP, CONTROL], VehicleSnapshot { control: KNOWN.control, ..up }),
            (&[UP, TILT], VehicleSnapshot { tilt: KNOWN.tilt, ..up }),
            (
                &[UP, Report::CameraHeading(Angle::from_degrees(300.0))],
                VehicleSnapshot { camera_heading: Some(Angle::from_degrees(300.0)), ..up },
            ),
            (&[UP, TETHER], VehicleSnapshot { altitude_m: KNOWN.altitude_m, ..up }),
            (
                &[UP, POSITION],
                VehicleSnapshot {
                    altitude_m: Some(10.5),
                    position: Some(VehiclePosition {
                        latitude: Angle::from_degrees(54.0),
                        longitude: Angle::from_degrees(10.0),
                        heading: None,
                    }),
                    ..up
                },
            ),
            (&[UP, FLIGHT], VehicleSnapshot { flight: KNOWN.flight, is_battery_low: true, ..up }),
            (
                &[UP, Report::FieldOfView(Angle::from_degrees(40.0))],
                VehicleSnapshot { field_of_view: Some(Angle::from_degrees(40.0)), ..up },
            ),
            (&[UP, GROUND, TILT, TETHER, FLIGHT], KNOWN),
        ] {
            assert_eq!(after(reports), expected, "{reports:?}");
        }
    }

    #[test]
    fn the_video_that_is_followed_stays_known_while_the_link_is_lost() {
        let other = Some(Angle::from_degrees(40.0));
        let reports = [UP, Report::OtherVideo(other), Report::Link(LinkState::Opening)];
        assert_eq!(after(&reports).other_field_of_view, other);
        assert_eq!(after(&[Report::OtherVideo(other), Report::OtherVideo(None)]).other_field_of_view, None);
    }

    #[test]
    fn what_is_used_stays_known_while_the_link_is_lost() {
        let used = |kind, name| Report::Equipment(Equipment::new(kind, name));
        let reports = [
            UP,
            used(EquipmentKind::Gimbal, "device 1"),
            used(EquipmentKind::Camera, "old"),
            Report::Link(LinkState::Opening),
            used(EquipmentKind::Camera, "new"),
        ];
        let known = after(&reports).equipment;
        let names = [known.gimbal, known.camera, known.stream];
        assert_eq!(
            names,
            [Some("device 1"), Some("new"), None].map(|name| name.map(|name| ShortText::of(name.as_bytes())))
        );
    }

    #[test]
    fn what_was_known_before_the_link_went_down_is_not_known_any_more() {
        for state in [LinkState::Opening, LinkState::Starting, LinkState::Closing, LinkState::Closed] {
            let expected = VehicleSnapshot { link: LinkStatus::Link(state), ..VehicleSnapshot::default() };
            assert_eq!(after(&[UP, GROUND, TILT, TETHER, FLIGHT, Report::Link(state)]), expected);
        }
        assert_eq!(after(&[UP, GROUND, TILT, TETHER, FLIGHT, UP]), KNOWN);
    }
}
