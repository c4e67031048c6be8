//! What a gimbal manager's messages mean.

use barrelman_vocab::mavlink::{Address, MavlinkPeers};
use barrelman_wire::mavlink::frame::FrameWriter;
use barrelman_wire::mavlink::gimbal_reader::{Holder, Received};
use barrelman_wire::mavlink::{Gimbal, GimbalReader};
use mavlink::dialects::common::{GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_MANAGER_STATUS_DATA};

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
