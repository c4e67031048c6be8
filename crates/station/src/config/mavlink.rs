//! The addresses of a MAVLink link, to and from the configuration.

use anyhow::{Result, bail};
use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
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
    let Some(MavlinkPeers { own, vehicle, device }) = protocol.mavlink_peers() else {
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
    let system = link.system_id.unwrap_or(own.system.0);
    let component = link.component_id.unwrap_or(own.component.0);
    let vehicle = link.vehicle_system.map(SystemId).or(vehicle);
    Ok(Protocol::MavlinkGimbal(MavlinkPeers { own: Address::new(system, component), vehicle, device }))
}

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

/// The number of the gimbal device of a protocol; `None`: the protocol has none.
pub(super) fn device_of(protocol: Protocol) -> Option<u8> {
    Some(protocol.mavlink_peers()?.device.unwrap_or(0))
}

/// The keys of a protocol.
pub(super) fn section_of(protocol: Protocol) -> LinkSection {
    let Some(MavlinkPeers { own, vehicle, device: _ }) = protocol.mavlink_peers() else {
        return LinkSection::default();
    };
    LinkSection {
        system_id: Some(own.system.0),
        component_id: Some(own.component.0),
        vehicle_system: vehicle.map(|system| system.0),
        ..LinkSection::default()
    }
}
