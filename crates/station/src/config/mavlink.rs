//! The addresses of a MAVLink link, to and from the configuration.

use anyhow::{Result, bail};
use barrelman_vocab::mavlink::{Address, MavlinkPeers, SystemId};
use barrelman_vocab::profile::Protocol;

use super::file::LinkSection;
use super::range::ensure_names_one;

/// The protocol between the peers of a file; without keys, between those of the profile.
///
/// # Errors
/// If an id is 0, or a key is given for a vehicle of another protocol.
pub(super) fn between_peers(protocol: Protocol, link: &LinkSection) -> Result<Protocol> {
    let ids = [
        ("system_id", link.system_id),
        ("component_id", link.component_id),
        ("vehicle_system", link.vehicle_system),
    ];
    let Protocol::MavlinkGimbal(MavlinkPeers { own, vehicle }) = protocol else {
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
    for (key, id) in ids {
        id.map_or(Ok(()), |id| ensure_names_one(&format!("link.{key}"), id))?;
    }
    let system = link.system_id.unwrap_or(own.system.0);
    let component = link.component_id.unwrap_or(own.component.0);
    let vehicle = link.vehicle_system.map(SystemId).or(vehicle);
    Ok(Protocol::MavlinkGimbal(MavlinkPeers { own: Address::new(system, component), vehicle }))
}

/// The keys of a protocol.
pub(super) fn section_of(protocol: Protocol) -> LinkSection {
    match protocol {
        Protocol::FotokitePro | Protocol::FotokiteSigma => LinkSection::default(),
        Protocol::MavlinkGimbal(MavlinkPeers { own, vehicle }) => LinkSection {
            system_id: Some(own.system.0),
            component_id: Some(own.component.0),
            vehicle_system: vehicle.map(|system| system.0),
            ..LinkSection::default()
        },
    }
}
