//! What a gimbal manager's messages mean.

use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers};
use barrelman_vocab::telemetry::Report;
use barrelman_vocab::{Angle, Timestamp};
use barrelman_wire::mavlink::frame::FrameWriter;
use barrelman_wire::mavlink::gimbal_reader::{Holder, Received};
use barrelman_wire::mavlink::{Gimbal, GimbalReader};
use mavlink::dialects::common::{
    ATTITUDE_DATA, CAMERA_INFORMATION_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA,
    GIMBAL_MANAGER_INFORMATION_DATA, GIMBAL_MANAGER_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GimbalDeviceFlags,
    GimbalManagerCapFlags,
};

const AUTOPILOT: Address = Address::new(1, 1);
const NONE: GimbalManagerCapFlags = GimbalManagerCapFlags::empty();
const PAN: GimbalManagerCapFlags = GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS;
const TILT: GimbalManagerCapFlags = GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS;
const ROLL: GimbalManagerCapFlags = GimbalManagerCapFlags::GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS;
const BOTH: GimbalManagerCapFlags = PAN.union(TILT);

struct Vehicle {
    reader: GimbalReader,
}

impl Vehicle {
    fn new() -> Self {
        Self { reader: GimbalReader::new(MavlinkPeers::DEFAULT, None, Timestamp::ZERO) }
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

    /// The gimbal device is known.
    fn known(device: u8) -> Self {
        let mut vehicle = Self::new();
        vehicle.describe(device, BOTH, 900);
        vehicle.describe(device, BOTH, 900);
        vehicle
    }

    /// The autopilot describes a gimbal.
    fn describe(&mut self, device: u8, axes: GimbalManagerCapFlags, time_boot_ms: u32) -> Vec<Received> {
        self.says(
            AUTOPILOT,
            &GIMBAL_MANAGER_INFORMATION_DATA {
                time_boot_ms,
                gimbal_device_id: device,
                cap_flags: axes,
                ..GIMBAL_MANAGER_INFORMATION_DATA::DEFAULT
            },
        )
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

/// What is said of gimbals, and when by the vehicle's clock, ms.
#[derive(Clone, Copy)]
enum Says {
    Axes(u8, GimbalManagerCapFlags, u32),
    Status(u8, u32),
}

use Says::{Axes, Status};

/// The device that is chosen; `wanted`: the one of the configuration.
fn chosen(wanted: Option<u8>, said: &[Says]) -> Option<u8> {
    let peers = MavlinkPeers { device: wanted, ..MavlinkPeers::DEFAULT };
    let mut vehicle = Vehicle { reader: GimbalReader::new(peers, None, Timestamp::ZERO) };
    let mut found = Vec::new();
    for says in said {
        let heard = match *says {
            Axes(device, axes, ms) => vehicle.describe(device, axes, ms),
            Status(device, ms) => vehicle.status(ms, device, Address::EVERYONE),
        };
        found.extend(heard.iter().filter_map(|received| match received {
            Received::Gimbal(gimbal) => Some(gimbal.device),
            _ => None,
        }));
    }
    assert!(found.len() <= 1, "{found:?}");
    found.first().copied()
}

#[test]
fn the_gimbal_is_the_first_one_that_pans_and_tilts_in_whatever_order_they_answer() {
    let both_first = [Axes(2, BOTH, 1_000), Axes(1, ROLL, 1_000), Axes(2, BOTH, 1_500)];
    for (wanted, said, expected) in [
        // The ordinary one.
        (None, &[Axes(1, BOTH, 1_000)][..], Some(1)),
        // Seen: device 1 only rolls, and its status comes first and often.
        (
            None,
            &[
                Status(1, 1_000),
                Status(2, 1_000),
                Axes(1, ROLL, 1_100),
                Axes(2, BOTH, 1_100),
                Axes(1, ROLL, 1_600),
                Axes(2, BOTH, 1_600),
            ],
            Some(2),
        ),
        (None, &both_first, Some(2)),
        // Late, and with its axes only in the second message.
        (
            None,
            &[
                Axes(1, ROLL, 1_000),
                Axes(1, ROLL, 1_500),
                Axes(1, ROLL, 2_000),
                Axes(2, BOTH, 2_400),
                Axes(2, BOTH, 2_900),
            ],
            Some(2),
        ),
        (
            None,
            &[Axes(2, NONE, 1_000), Axes(1, ROLL, 1_000), Axes(2, BOTH, 1_500), Axes(2, BOTH, 1_900)],
            Some(2),
        ),
        (None, &[Axes(1, NONE, 1_000), Axes(1, BOTH, 1_500)], Some(1)),
        // Three, in any order; one without pan.
        (
            None,
            &[Axes(3, BOTH, 1_000), Axes(2, BOTH, 1_000), Axes(1, TILT, 1_000), Axes(3, BOTH, 1_500)],
            Some(2),
        ),
        (None, &[Axes(3, BOTH, 1_000), Axes(1, BOTH, 1_100)], Some(1)),
        // Components of their own.
        (None, &[Axes(171, BOTH, 1_000), Axes(154, ROLL, 1_000), Axes(171, BOTH, 1_500)], Some(171)),
        (None, &[Axes(154, BOTH, 1_000), Status(154, 1_100), Status(154, 2_100)], Some(154)),
        // The information got lost: a status alone waits a second.
        (None, &[Status(1, 1_000), Status(1, 1_900)], None),
        (None, &[Status(1, 1_000), Status(1, 2_000)], Some(1)),
        (None, &[Status(1, 1_000), Axes(1, ROLL, 1_500), Status(1, 9_000)], None),
        (None, &[Status(1, 1_000), Status(2, 1_000), Axes(1, ROLL, 1_500), Status(2, 2_000)], Some(2)),
        // A time that falls before anything was chosen.
        (None, &[Status(1, 600_000), Status(1, 1_000), Status(1, 1_900), Status(1, 2_000)], Some(1)),
        // None can.
        (
            None,
            &[Axes(1, ROLL, 1_000), Axes(2, TILT, 1_000), Axes(1, ROLL, 9_000), Axes(2, TILT, 9_000)],
            None,
        ),
        // The configuration names one.
        (Some(2), &[Axes(1, BOTH, 1_000), Axes(2, BOTH, 1_000)], Some(2)),
        (Some(1), &[Axes(1, ROLL, 1_000), Axes(2, BOTH, 1_000), Axes(1, ROLL, 9_000)], None),
        (Some(5), &[Axes(1, BOTH, 1_000), Axes(1, BOTH, 9_000), Status(1, 9_000)], None),
        (Some(3), &[Status(3, 1_000), Status(3, 2_000)], Some(3)),
    ] {
        let names: Vec<String> = said
            .iter()
            .map(|says| match says {
                Axes(device, axes, ms) => format!("{device} {axes:?} {ms}"),
                Status(device, ms) => format!("{device} status {ms}"),
            })
            .collect();
        assert_eq!(chosen(wanted, said), expected, "{wanted:?} {names:?}");
    }
}

#[test]
fn a_gimbal_that_cannot_be_used_is_refused_with_the_names_and_axes_of_all() {
    let refused = |wanted, said: &[(u8, GimbalManagerCapFlags)]| {
        let peers = MavlinkPeers { device: wanted, ..MavlinkPeers::DEFAULT };
        let mut vehicle = Vehicle { reader: GimbalReader::new(peers, None, Timestamp::ZERO) };
        for (device, axes) in said {
            vehicle.describe(*device, *axes, 1_000);
        }
        assert!(vehicle.reader.choice().is_hopeless());
        vehicle.reader.choice().to_string()
    };
    let text = refused(None, &[(1, ROLL), (2, TILT.union(ROLL))]);
    assert!(text.starts_with("no gimbal device can both pan and tilt: device 1 of 1/1 has roll, device 2 of 1/1 has tilt and roll"), "{text}");
    let text = refused(Some(1), &[(1, ROLL), (2, BOTH)]);
    assert!(text.starts_with("gimbal device 1 cannot both pan and tilt: "), "{text}");
    let text = refused(Some(4), &[(2, BOTH)]);
    assert!(text.starts_with("gimbal device 4 was not heard: device 2 of 1/1 has pan and tilt"), "{text}");
}

#[test]
fn a_status_of_another_device_does_not_count() {
    let mut vehicle = Vehicle::known(1);
    assert!(vehicle.status(1_000, 1, Address::EVERYONE).contains(&Received::Holder(Holder::Nobody)));
    let others = vehicle.status(1_100, 2, MavlinkPeers::DEFAULT.own);
    assert!(others.iter().all(|heard| *heard == Received::Other));
}

#[test]
fn parts_of_a_vehicle_with_clocks_of_their_own_are_no_restart() {
    let mut vehicle = Vehicle::known(154);
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
fn an_attitude_from_the_device_and_one_from_its_manager_are_no_restarts() {
    let mut vehicle = Vehicle::known(154);
    let mut heard = vehicle.status(600_000, 154, Address::EVERYONE);
    for turn in 0..5 {
        heard.extend(vehicle.attitude(AUTOPILOT, 600_000 + 100 * turn, 154));
        heard.extend(vehicle.attitude(Address::new(1, 154), 5_000 + 100 * turn, 0));
    }
    assert!(!heard.contains(&Received::Restarted), "{heard:?}");
    // A device of the manager's own is not another component.
    let mut vehicle = Vehicle::known(1);
    vehicle.status(600_000, 1, Address::EVERYONE);
    assert!(is_attitude(&vehicle.attitude(AUTOPILOT, 600_000, 1)));
    assert_eq!(vehicle.attitude(Address::new(1, 154), 5_000, 0), []);
}

#[test]
fn after_a_restart_the_gimbal_is_one_of_the_same_vehicle() {
    let mut vehicle = Vehicle::known(1);
    vehicle.status(600_000, 1, Address::EVERYONE);
    // The message that shows the restart is one of the manager that was forgotten with it.
    assert!(vehicle.status(1_000, 1, Address::EVERYONE).contains(&Received::Restarted));
    let other = GIMBAL_MANAGER_STATUS_DATA { gimbal_device_id: 1, ..GIMBAL_MANAGER_STATUS_DATA::default() };
    assert_eq!(vehicle.says(Address::new(2, 1), &other), []);
    assert!(
        vehicle
            .describe(1, BOTH, 1_100)
            .contains(&Received::Gimbal(Gimbal { manager: AUTOPILOT, device: 1 }))
    );
}

#[test]
fn a_status_that_a_newer_one_has_overtaken_does_not_count() {
    let mut vehicle = Vehicle::known(1);
    let (own, other) = (MavlinkPeers::DEFAULT.own, Address::new(255, 190));
    assert!(vehicle.status(1_000, 1, own).contains(&Received::Holder(Holder::Us)));
    assert!(vehicle.status(1_200, 1, other).contains(&Received::Holder(Holder::Other(other))));
    assert_eq!(vehicle.status(1_100, 1, own), [Received::Other], "the control is the other's");
    // Of two with the same time the last one counts: a vehicle may leave the time out.
    assert!(vehicle.status(1_200, 1, own).contains(&Received::Holder(Holder::Us)));
}

#[test]
fn the_attitude_of_another_gimbal_does_not_count() {
    assert!(!is_attitude(&Vehicle::new().attitude(AUTOPILOT, 900, 1)), "no gimbal is known yet");
    let mut vehicle = Vehicle::known(154);
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
    vehicle.describe(1, BOTH, 1_000);
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
    assert_eq!(reports(vehicle.says(AUTOPILOT, &nowhere)), vec![Report::CameraHeight(0.0)], "no fix");
    assert_eq!(reports(vehicle.says(Address::new(9, 1), &position(2_000, 541_000_000, 0))), vec![]);
    assert_eq!(reports(vehicle.says(Address::new(1, 100), &position(2_000, 541_000_000, 0))), vec![]);

    let attitude = |yaw: f32| ATTITUDE_DATA { time_boot_ms: 3_000, yaw, ..ATTITUDE_DATA::default() };
    let turned = reports(vehicle.says(AUTOPILOT, &attitude(core::f32::consts::PI)));
    assert!(
        matches!(turned[..], [Report::VehicleAttitude(q)] if q.w.abs() < 1e-6 && (q.z - 1.0).abs() < 1e-6),
        "{turned:?}"
    );
    let mut vehicle = Vehicle::known(1);
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
        let mut vehicle = Vehicle::known(1);
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
    let mut vehicle = Vehicle::known(1);
    vehicle.status(1_000, 1, Address::EVERYONE);
    let heard = vehicle.says(AUTOPILOT, &attitude(-40.0, nose));
    let has_heading = |received: &Received| matches!(received, Received::Report(Report::CameraHeading(_)));
    assert!(!heard.iter().any(has_heading), "before the first position");
}

#[test]
fn the_pan_is_told_in_the_frame_in_which_the_gimbal_holds_it() {
    use GimbalDeviceFlags as Flags;
    let (nose, north, lock) = (
        Flags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
        Flags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME,
        Flags::GIMBAL_DEVICE_FLAGS_YAW_LOCK,
    );
    // Yaw by 30 degrees; the vehicle's nose is 20 degrees from north by its attitude, and turns by 10 degrees
    // a second.
    let told = |flags: Flags, delta_yaw_deg: f32, attitude_ms: Option<u32>| {
        let (sin, cos) = 15_f32.to_radians().sin_cos();
        let mut vehicle = Vehicle::known(1);
        if let Some(time_boot_ms) = attitude_ms {
            let (yaw, yawspeed) = (20_f32.to_radians(), 10_f32.to_radians());
            vehicle
                .says(AUTOPILOT, &ATTITUDE_DATA { time_boot_ms, yaw, yawspeed, ..ATTITUDE_DATA::default() });
        }
        let heard = vehicle.says(
            AUTOPILOT,
            &GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
                time_boot_ms: 1_000,
                q: [cos, 0.0, 0.0, sin],
                flags,
                delta_yaw: delta_yaw_deg.to_radians(),
                ..GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::default()
            },
        );
        heard.iter().find_map(|received| match received {
            Received::Report(Report::CameraPan(pan)) => Some(pan.degrees().round()),
            _ => None,
        })
    };
    for (flags, delta, attitude_ms, expected) in [
        (nose, f32::NAN, None, Some(30.0)),
        (north | lock, f32::NAN, None, Some(30.0)),
        (lock, f32::NAN, None, Some(30.0)),
        (Flags::empty(), f32::NAN, None, Some(30.0)),
        (north, 12.0, None, Some(18.0)),
        (north, f32::NAN, Some(1_000), Some(10.0)),
        (north, f32::NAN, Some(800), Some(8.0)),
        (north, 0.0, Some(1_000), Some(10.0)),
        (north, f32::NAN, Some(500), None),
        (north, f32::NAN, None, None),
        (nose | lock, 12.0, None, Some(42.0)),
    ] {
        assert_eq!(told(flags, delta, attitude_ms), expected, "{flags:?} {delta} {attitude_ms:?}");
    }
}

/// The names of the gimbals that are reported.
fn used(received: &[Received]) -> Vec<String> {
    let name = |received: &Received| match received {
        Received::Report(Report::Equipment(used)) => Some(used.name.to_string()),
        _ => None,
    };
    received.iter().filter_map(name).collect()
}

/// The status of device 2 at these times, ms; whether the gimbal is chosen anew.
fn is_exchanged(vehicle: &mut Vehicle, times: &[u32]) -> bool {
    let mut heard = Vec::new();
    for ms in times {
        heard.extend(vehicle.status(*ms, 2, Address::EVERYONE));
    }
    heard.contains(&Received::Restarted)
}

#[test]
fn a_device_whose_manager_speaks_of_others_alone_for_three_seconds_is_exchanged() {
    let mut vehicle = Vehicle::known(1);
    assert!(!is_exchanged(&mut vehicle, &[1_000, 2_000, 3_000, 3_800]));
    vehicle.status(3_900, 1, Address::EVERYONE);
    assert!(!is_exchanged(&mut vehicle, &[4_000, 5_000, 6_000, 6_800]));
    vehicle.attitude(AUTOPILOT, 6_800, 1);
    assert!(!is_exchanged(&mut vehicle, &[7_000, 8_000, 9_000, 9_700]));
    assert!(is_exchanged(&mut vehicle, &[9_900]));
    vehicle.describe(2, BOTH, 10_000);
    assert_eq!(used(&vehicle.describe(2, BOTH, 10_500)), ["device 2 of 1/1"]);
}

#[test]
fn the_device_of_the_configuration_is_not_replaced_by_another_one() {
    let peers = MavlinkPeers { device: Some(1), ..MavlinkPeers::DEFAULT };
    let mut vehicle = Vehicle { reader: GimbalReader::new(peers, None, Timestamp::ZERO) };
    assert_eq!(used(&vehicle.describe(1, BOTH, 900)), ["device 1 of 1/1"]);
    assert!(is_exchanged(&mut vehicle, &[1_000, 4_000]));
    for ms in [5_000, 6_000, 7_000] {
        assert_eq!(used(&vehicle.describe(2, BOTH, ms)), [""; 0]);
    }
    assert_eq!(used(&vehicle.describe(1, BOTH, 8_000)), ["device 1 of 1/1"]);
}

#[test]
fn a_vehicle_that_restarts_with_another_device_is_moved_by_that_one() {
    let mut vehicle = Vehicle::known(1);
    vehicle.status(9_000, 1, Address::EVERYONE);
    vehicle.attitude(AUTOPILOT, 9_100, 1);
    assert!(vehicle.attitude(AUTOPILOT, 100, 1).contains(&Received::Restarted));
    let mut found = Vec::new();
    for ms in (1_000..8_000).step_by(500) {
        found.extend(used(&vehicle.describe(2, BOTH, ms)));
    }
    assert_eq!(found, ["device 2 of 1/1"]);
}

#[test]
fn another_camera_at_the_same_component_is_reported() {
    let peers = MavlinkPeers { camera: Some(ComponentId(100)), ..MavlinkPeers::DEFAULT };
    let mut vehicle = Vehicle { reader: GimbalReader::new(peers, None, Timestamp::ZERO) };
    vehicle.describe(1, BOTH, 900);
    let mut named = |component, model: &[u8; 6]| {
        let mut information = CAMERA_INFORMATION_DATA::DEFAULT;
        information.vendor_name[..4].copy_from_slice(b"Acme");
        information.model_name[..6].copy_from_slice(model);
        used(&vehicle.says(Address::new(1, component), &information))
    };
    assert_eq!(named(100, b"Zoom30"), ["1/100 Acme Zoom30"]);
    assert_eq!((named(100, b"Zoom30"), named(101, b"Zoom20")), (vec![], vec![]));
    assert_eq!(named(100, b"Zoom20"), ["1/100 Acme Zoom20"]);
}
