//! What a gimbal manager's messages mean.

use barrelman_vocab::Angle;
use barrelman_vocab::mavlink::{Address, MavlinkPeers};
use barrelman_vocab::telemetry::Report;
use barrelman_wire::mavlink::frame::FrameWriter;
use barrelman_wire::mavlink::gimbal_reader::{Holder, Received};
use barrelman_wire::mavlink::{Gimbal, GimbalReader};
use mavlink::dialects::common::{
    ATTITUDE_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_MANAGER_STATUS_DATA, GLOBAL_POSITION_INT_DATA,
    GimbalDeviceFlags,
};

const AUTOPILOT: Address = Address::new(1, 1);

struct Vehicle {
    reader: GimbalReader,
}

impl Vehicle {
    fn new() -> Self {
        Self { reader: GimbalReader::new(MavlinkPeers::DEFAULT, None) }
    }

    fn says<D: mavlink::MessageData>(&mut self, from: Address, message: &D) -> Vec<Received> {
        let packet = FrameWriter::new(from, None).write(message);
        let mut heard = Vec::new();
        self.reader.read(&packet, |received| heard.push(received));
        heard
    }

    fn status(&mut self, time_boot_ms: u32, device: u8, primary: Address) -> Vec<Received> {
        let status = GIMBAL_MANAGER_STATUS_DATA {
            time_boot_ms,
            gimbal_device_id: device,
            primary_control_sysid: primary.system.0,
            primary_control_compid: primary.component.0,
            ..GIMBAL_MANAGER_STATUS_DATA::default()
        };
        self.says(AUTOPILOT, &status)
    }

    fn attitude(&mut self, from: Address, time_boot_ms: u32, device: u8) -> Vec<Received> {
        let attitude = GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
            time_boot_ms,
            q: [1.0, 0.0, 0.0, 0.0],
            gimbal_device_id: device,
            ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
        };
        self.says(from, &attitude)
    }
}

fn is_attitude(received: &[Received]) -> bool {
    received.iter().any(|received| matches!(received, Received::Attitude(_)))
}

#[test]
fn the_first_status_names_the_manager_and_its_device() {
    let mut vehicle = Vehicle::new();
    let heard = vehicle.status(1_000, 1, Address::EVERYONE);
    assert!(heard.contains(&Received::Gimbal(Gimbal { manager: AUTOPILOT, device: 1 })), "{heard:?}");
    assert!(heard.contains(&Received::Holder(Holder::Nobody)));
    assert!(
        vehicle.status(1_100, 2, MavlinkPeers::DEFAULT.own).iter().all(|heard| *heard == Received::Other)
    );
}

#[test]
fn parts_of_a_vehicle_with_clocks_of_their_own_are_no_restart() {
    let mut vehicle = Vehicle::new();
    let gimbal = Address::new(1, 154);
    let mut heard = vehicle.status(600_000, 154, Address::EVERYONE);
    heard.extend(vehicle.attitude(gimbal, 5_000, 0));
    heard.extend(vehicle.status(600_200, 154, Address::EVERYONE));
    heard.extend(vehicle.status(600_000, 154, Address::EVERYONE));
    assert!(is_attitude(&heard));
    assert!(!heard.contains(&Received::Restarted), "{heard:?}");
    assert!(vehicle.status(1_000, 154, Address::EVERYONE).contains(&Received::Restarted));
}

#[test]
fn after_a_restart_the_gimbal_is_one_of_the_same_vehicle() {
    let mut vehicle = Vehicle::new();
    vehicle.status(600_000, 1, Address::EVERYONE);
    // The message that shows the restart is one of the manager that was forgotten with it.
    assert!(vehicle.status(1_000, 1, Address::EVERYONE).contains(&Received::Restarted));
    let other = GIMBAL_MANAGER_STATUS_DATA { gimbal_device_id: 1, ..GIMBAL_MANAGER_STATUS_DATA::default() };
    assert_eq!(vehicle.says(Address::new(2, 1), &other), []);
    assert!(
        vehicle
            .status(1_100, 1, Address::EVERYONE)
            .contains(&Received::Gimbal(Gimbal { manager: AUTOPILOT, device: 1 }))
    );
}

#[test]
fn a_status_that_a_newer_one_has_overtaken_does_not_count() {
    let mut vehicle = Vehicle::new();
    let (own, other) = (MavlinkPeers::DEFAULT.own, Address::new(255, 190));
    assert!(vehicle.status(1_000, 1, own).contains(&Received::Holder(Holder::Us)));
    assert!(vehicle.status(1_200, 1, other).contains(&Received::Holder(Holder::Other(other))));
    assert_eq!(vehicle.status(1_100, 1, own), [Received::Other], "the control is the other's");
    // Of two with the same time the last one counts: a vehicle may leave the time out.
    assert!(vehicle.status(1_200, 1, own).contains(&Received::Holder(Holder::Us)));
}

#[test]
fn the_attitude_of_another_gimbal_does_not_count() {
    let mut vehicle = Vehicle::new();
    assert!(!is_attitude(&vehicle.attitude(AUTOPILOT, 900, 1)), "no gimbal is known yet");
    vehicle.status(1_000, 154, Address::EVERYONE);
    assert!(is_attitude(&vehicle.attitude(Address::new(1, 154), 1_000, 0)));
    assert!(is_attitude(&vehicle.attitude(AUTOPILOT, 1_000, 154)));
    assert!(is_attitude(&vehicle.attitude(AUTOPILOT, 1_000, 0)));
    assert!(!is_attitude(&vehicle.attitude(Address::new(1, 171), 1_000, 0)));
    assert!(!is_attitude(&vehicle.attitude(AUTOPILOT, 1_000, 171)));
    assert!(!is_attitude(&vehicle.attitude(Address::new(2, 154), 1_000, 0)));
}

#[test]
fn position_and_attitude_of_the_gimbals_vehicle_are_reported_at_most_five_times_a_second() {
    let position = |time_boot_ms: u32, lat: i32, hdg: u16| GLOBAL_POSITION_INT_DATA {
        time_boot_ms,
        lat,
        lon: -102_500_000,
        alt: 55_000,
        relative_alt: 12_500,
        hdg,
        ..GLOBAL_POSITION_INT_DATA::default()
    };
    let reports = |heard: Vec<Received>| -> Vec<Report> {
        let report = |received: &Received| match received {
            Received::Report(report) => Some(*report),
            _ => None,
        };
        heard.iter().filter_map(report).collect()
    };
    let mut vehicle = Vehicle::new();
    let before = vehicle.says(AUTOPILOT, &position(500, 541_000_000, 9_000));
    assert_eq!(reports(before), vec![], "before the gimbal is known, so is not its vehicle");
    vehicle.status(1_000, 1, Address::EVERYONE);
    let known = Report::Position {
        latitude: Angle::from_degrees(541_000_000.0 * 1e-7),
        longitude: Angle::from_degrees(-102_500_000.0 * 1e-7),
        altitude_m: 55.0,
        height_m: 12.5,
        heading: Some(Angle::from_degrees(90.0)),
    };
    assert_eq!(reports(vehicle.says(AUTOPILOT, &position(1_000, 541_000_000, 9_000))), vec![known]);
    assert_eq!(reports(vehicle.says(AUTOPILOT, &position(1_199, 541_000_000, 9_000))), vec![]);
    let without_heading = reports(vehicle.says(AUTOPILOT, &position(1_200, 541_000_000, u16::MAX)));
    assert!(matches!(without_heading[..], [Report::Position { heading: None, .. }]), "{without_heading:?}");
    assert_eq!(reports(vehicle.says(AUTOPILOT, &position(1_400, 910_000_000, 0))), vec![], "no place");
    let nowhere = GLOBAL_POSITION_INT_DATA { time_boot_ms: 1_600, ..GLOBAL_POSITION_INT_DATA::default() };
    assert_eq!(reports(vehicle.says(AUTOPILOT, &nowhere)), vec![], "no fix");
    assert_eq!(reports(vehicle.says(Address::new(9, 1), &position(2_000, 541_000_000, 0))), vec![]);
    assert_eq!(reports(vehicle.says(Address::new(1, 100), &position(2_000, 541_000_000, 0))), vec![]);

    let attitude = |yaw: f32| ATTITUDE_DATA { time_boot_ms: 3_000, yaw, ..ATTITUDE_DATA::default() };
    let turned = reports(vehicle.says(AUTOPILOT, &attitude(core::f32::consts::PI)));
    assert!(
        matches!(turned[..], [Report::VehicleAttitude(q)] if q.w.abs() < 1e-6 && (q.z - 1.0).abs() < 1e-6),
        "{turned:?}"
    );
    let mut vehicle = Vehicle::new();
    vehicle.status(1_000, 1, Address::EVERYONE);
    assert_eq!(reports(vehicle.says(AUTOPILOT, &attitude(f32::NAN))), vec![]);
}

#[test]
fn the_direction_of_the_camera_from_north_needs_a_yaw_whose_zero_is_known() {
    use GimbalDeviceFlags as Flags;
    let position = |hdg: u16| GLOBAL_POSITION_INT_DATA {
        time_boot_ms: 1_000,
        lat: 541_000_000,
        lon: -102_500_000,
        hdg,
        ..GLOBAL_POSITION_INT_DATA::default()
    };
    // Yaw by 30 degrees to the right, then pitch.
    let attitude = |pitch_deg: f32, flags: Flags| {
        let ((sy, cy), (sp, cp)) = (15_f32.to_radians().sin_cos(), (0.5 * pitch_deg).to_radians().sin_cos());
        GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
            time_boot_ms: 1_000,
            q: [cy * cp, -sy * sp, cy * sp, sy * cp],
            gimbal_device_id: 1,
            flags,
            ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
        }
    };
    let nose = Flags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME;
    let north = Flags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME;
    let lock = Flags::GIMBAL_DEVICE_FLAGS_YAW_LOCK;
    for (hdg, pitch_deg, flags, expected) in [
        (34_000, -40.0, nose, Some(10.0)),
        (34_000, -40.0, nose | lock, Some(10.0)),
        (34_000, -40.0, Flags::empty(), Some(10.0)),
        (34_000, -40.0, north, Some(30.0)),
        (34_000, -40.0, lock, Some(30.0)),
        (u16::MAX, -40.0, nose, None),
        (u16::MAX, -40.0, Flags::empty(), None),
        (u16::MAX, -40.0, north, Some(30.0)),
        (34_000, -89.0, nose, None),
    ] {
        let mut vehicle = Vehicle::new();
        vehicle.status(1_000, 1, Address::EVERYONE);
        vehicle.says(AUTOPILOT, &position(hdg));
        let heard = vehicle.says(AUTOPILOT, &attitude(pitch_deg, flags));
        let heading = heard.iter().find_map(|received| match received {
            Received::Report(Report::CameraHeading(heading)) => Some(heading.degrees()),
            _ => None,
        });
        let is_as_expected = match (heading, expected) {
            (Some(heading), Some(expected)) => (heading - expected).abs() < 1e-3,
            (heading, expected) => heading.is_none() && expected.is_none(),
        };
        assert!(is_as_expected, "{hdg} {flags:?}: {heading:?}, not {expected:?}");
    }
    let mut vehicle = Vehicle::new();
    vehicle.status(1_000, 1, Address::EVERYONE);
    let heard = vehicle.says(AUTOPILOT, &attitude(-40.0, nose));
    let has_heading = |received: &Received| matches!(received, Received::Report(Report::CameraHeading(_)));
    assert!(!heard.iter().any(has_heading), "before the first position");
}
