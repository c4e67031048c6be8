//! The addresses of MAVLink: each packet names the system and the component that sent it.

use core::fmt;

/// A system: a vehicle, or a ground station. 0 addresses all systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SystemId(pub u8);

/// A component of a system: autopilot 1, cameras 100 to 105, gimbals 154 and 171 to 175, onboard computers
/// 191 to 194. 0 addresses all components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ComponentId(pub u8);

/// The address of a component.
///
/// ```
/// use barrelman_vocab::mavlink::Address;
///
/// assert_eq!(Address::new(1, 154).to_string(), "1/154");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The system.
    pub system: SystemId,
    /// The component of the system.
    pub component: ComponentId,
}

impl Address {
    /// All components of all systems.
    pub const EVERYONE: Self = Self::new(0, 0);

    /// The address with these numbers.
    pub const fn new(system: u8, component: u8) -> Self {
        Self { system: SystemId(system), component: ComponentId(component) }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.system.0, self.component.0)
    }
}

/// Who speaks to whom on a MAVLink link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MavlinkPeers {
    /// This program's own address. No other component of the link may have it.
    pub own: Address,
    /// The system whose gimbal is moved; `None`: the first that has a gimbal manager.
    pub vehicle: Option<SystemId>,
    /// The number of the gimbal device that is moved; `None`: the first that can pan and tilt. Without an
    /// effect on boats.
    pub device: Option<u8>,
    /// The component of the vehicle whose camera zooms; `None`: nothing is told to zoom. Without an effect on
    /// boats.
    pub camera: Option<ComponentId>,
}

impl MavlinkPeers {
    /// An onboard computer of a system of its own, and the first gimbal.
    pub const DEFAULT: Self = Self { own: Address::new(245, 191), vehicle: None, device: None, camera: None };
}
