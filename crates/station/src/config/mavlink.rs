//! The addresses of a MAVLink link, to and from the configuration.

use anyhow::{Result, bail};
use barrelman_vocab::mavlink::{Address, ComponentId, MavlinkPeers, SystemId};
use barrelman_vocab::profile::Protocol;

use super::file::LinkSection;

/// The protocol between the peers of a file; without keys, between those of the profile.
///
/// # Errors
/// If a key is given for a vehicle of another protocol.
pub(super) fn between_peers(protocol: Protocol, link: &LinkSection) -> Result<Protocol> {
    let ids = [
        ("system_id", link.system_id),
        ("component_id", link.component_id),
        ("vehicle_system", link.vehicle_system),
    ];
    let Some(peers) = protocol.mavlink_peers() else {
        let key = ids.iter().find(|(_, id)| id.is_some()).map(|(key, _)| *key);
        let key = key.or(link.signing_key_file.is_some().then_some("signing_key_file"));
        return match key {
            Some(key) => {
                bail!(
                    "link.{key} has no effect on this vehicle: omit it, or use vehicle.profile = \"mavlink-gimbal\""
                )
            }
            None => Ok(protocol),
        };
    };
    let system = link.system_id.unwrap_or(peers.own.system.0);
    let component = link.component_id.unwrap_or(peers.own.component.0);
    let vehicle = link.vehicle_system.map(SystemId).or(peers.vehicle);
    let own = Address::new(system, component);
    Ok(Protocol::MavlinkGimbal(MavlinkPeers { own, vehicle, ..peers }))
}

/// The component of a vehicle's first camera.
const FIRST_CAMERA: u8 = 100;

/// Whether this is a number of a gimbal device: 1 to 6, or that of a component of its own.
const fn is_device(number: u8) -> bool {
    matches!(number, 1..=6 | 154 | 171..=175)
}

/// The protocol with the gimbal device of this number; 0: the first one that can pan and tilt.
///
/// # Errors
/// If the number is not one of a device, or is given for a vehicle of another protocol.
pub(super) fn with_device(protocol: Protocol, device: Option<u8>) -> Result<Protocol> {
    let Some(device) = device else { return Ok(protocol) };
    let Some(peers) = protocol.mavlink_peers() else {
        bail!(
            "vehicle.gimbal_device has no effect on this vehicle: omit it, or use vehicle.profile = \"mavlink-gimbal\""
        )
    };
    if device != 0 && !is_device(device) {
        bail!(
            "vehicle.gimbal_device is {device}: 0 chooses the first device that can pan and tilt; 1 to 6, 154 and 171 to 175 name one"
        )
    }
    let device = Some(device).filter(|device| *device != 0);
    Ok(Protocol::MavlinkGimbal(MavlinkPeers { device, ..peers }))
}

/// The protocol with the camera of this component, where the vehicle's camera zooms.
///
/// # Errors
/// If the number is not one of a camera, or is given for a vehicle of another protocol.
pub(super) fn with_camera(protocol: Protocol, camera: Option<u8>, zooms: bool) -> Result<Protocol> {
    let Some(peers) = protocol.mavlink_peers() else {
        if camera.is_some() {
            bail!(
                "vehicle.camera has no effect on this vehicle: omit it, or use vehicle.profile = \"mavlink-gimbal\""
            )
        }
        return Ok(protocol);
    };
    let camera = camera.unwrap_or(FIRST_CAMERA);
    if !matches!(camera, 1 | 100..=105) {
        bail!(
            "vehicle.camera is {camera}: 1 is the camera of the autopilot itself; 100 to 105 name another component"
        )
    }
    let camera = zooms.then_some(ComponentId(camera));
    Ok(Protocol::MavlinkGimbal(MavlinkPeers { camera, ..peers }))
}

/// The component of the camera of a protocol; `None`: it has none, or none that zooms.
pub(super) fn camera_of(protocol: Protocol) -> Option<u8> {
    protocol.mavlink_peers()?.camera.map(|camera| camera.0)
}

/// The number of the gimbal device of a protocol; `None`: the protocol has none.
pub(super) fn device_of(protocol: Protocol) -> Option<u8> {
    Some(protocol.mavlink_peers()?.device.unwrap_or(0))
}

/// The keys of a protocol.
pub(super) fn section_of(protocol: Protocol) -> LinkSection {
    let Some(MavlinkPeers { own, vehicle, .. }) = protocol.mavlink_peers() else {
        return LinkSection::default();
    };
    LinkSection {
        system_id: Some(own.system.0),
        component_id: Some(own.component.0),
        vehicle_system: vehicle.map(|system| system.0),
        ..LinkSection::default()
    }
}
