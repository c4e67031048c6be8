//! Which gimbal is moved, of those on a line: the first one that can pan and tilt, or the one that the
//! configuration names.
//!
//! Managers describe their gimbals in any order, late, or with no axes at first, and packets get lost. So the
//! choice waits:
//!
//! | what was heard | the gimbal is chosen |
//! |---|---|
//! | the device of the least number that there can be (1), or the one that is named, which pans and tilts | at once |
//! | another device that pans and tilts | when a device describes itself for the second time: all have had their turn |
//! | a device that says nothing of its axes | [`UNDESCRIBED_S`] after it was heard first, if no other one pans and tilts |
//! | a device that cannot pan, or cannot tilt | never |
//!
//! Times are those of the vehicle's clock, so that two readers of the same packets choose the same gimbal.

use core::fmt;

use barrelman_vocab::mavlink::Address;

use super::command::Gimbal;
use super::gimbal_information::Information;

/// How long a device that says nothing of its axes waits for one that does, seconds.
pub const UNDESCRIBED_S: f64 = 1.0;
/// Largest number of devices that are remembered.
const MAX_DEVICES: usize = 16;
/// The least number of a device.
const FIRST_DEVICE: u8 = 1;

/// A gimbal device that was heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    /// The device and its manager.
    pub gimbal: Gimbal,
    /// What its manager says of it; `None`: nothing of its axes.
    pub information: Option<Information>,
    /// How often it was described.
    described: u32,
    /// When it was heard first, by the vehicle's clock.
    first_s: f64,
}

/// The devices that were heard, and which one is wanted.
#[derive(Debug, Clone, Default)]
pub struct GimbalChoice {
    /// The number of the device; `None`: any.
    wanted: Option<u8>,
    devices: Vec<Device>,
}

impl GimbalChoice {
    /// Nothing was heard yet.
    pub const fn new(wanted: Option<u8>) -> Self {
        Self { wanted, devices: Vec::new() }
    }

    /// From now on no other device counts.
    pub const fn want(&mut self, device: u8) {
        if device != 0 {
            self.wanted = Some(device);
        }
    }

    /// The device that was chosen is no more. `wanted`: the device of the configuration.
    pub fn begin_anew(&mut self, wanted: Option<u8>) {
        *self = Self::new(wanted);
    }

    /// From now on the device counts that the configuration wants.
    pub const fn no_longer_want(&mut self, wanted: Option<u8>) {
        self.wanted = wanted;
    }

    /// The vehicle has started anew.
    pub fn forget(&mut self) {
        self.devices.clear();
    }

    /// The devices that were heard, in the order of their numbers.
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// A manager describes its gimbal. Returns the gimbal that is chosen by it.
    pub fn on_information(&mut self, information: Information, uptime_s: f64) -> Option<Gimbal> {
        if !information.has_axes() {
            return self.on_status(information.gimbal, uptime_s);
        }
        let device = self.device(information.gimbal, uptime_s)?;
        device.information = Some(information);
        device.described = device.described.saturating_add(1);
        let is_second_turn = device.described > 1;
        let chosen = self.usable().find(|device| device.can_pan_and_tilt())?.gimbal;
        let is_least = chosen.device <= FIRST_DEVICE || self.wanted.is_some();
        (is_least || is_second_turn).then_some(chosen)
    }

    /// A manager says who has the control of a gimbal. Returns the gimbal that is chosen by it.
    pub fn on_status(&mut self, gimbal: Gimbal, uptime_s: f64) -> Option<Gimbal> {
        let device = self.device(gimbal, uptime_s)?;
        if uptime_s < device.first_s {
            device.first_s = uptime_s;
        }
        let has_waited = |device: &&Device| uptime_s - device.first_s >= UNDESCRIBED_S;
        let best = self.usable().find(|device| device.can_pan_and_tilt());
        let best =
            best.or_else(|| self.usable().find(|device| device.information.is_none() && has_waited(device)));
        // One that pans and tilts, and describes itself once only, waits no longer than one that says
        // nothing.
        best.filter(has_waited).map(|device| device.gimbal)
    }

    fn device(&mut self, gimbal: Gimbal, uptime_s: f64) -> Option<&mut Device> {
        let key = |gimbal: Gimbal| (gimbal.device, gimbal.manager);
        let at = self.devices.binary_search_by_key(&key(gimbal), |device| key(device.gimbal));
        let index = match at {
            Ok(index) => index,
            Err(_) if self.devices.len() == MAX_DEVICES => return None,
            Err(index) => {
                let device = Device { gimbal, information: None, described: 0, first_s: uptime_s };
                self.devices.insert(index, device);
                index
            }
        };
        self.devices.get_mut(index)
    }

    /// The devices that may be chosen. Number 0 is every device of its manager.
    fn usable(&self) -> impl Iterator<Item = &Device> {
        self.devices.iter().filter(|device| {
            self.wanted.is_none_or(|wanted| device.gimbal.device == wanted || device.gimbal.device == 0)
        })
    }

    /// Whether devices were described, and none of them can be moved.
    pub fn is_hopeless(&self) -> bool {
        !self.devices.is_empty()
            && !self.usable().any(|device| device.information.is_none() || device.can_pan_and_tilt())
    }
}

impl Device {
    fn can_pan_and_tilt(&self) -> bool {
        self.information.is_some_and(|information| information.can_pan_and_tilt())
    }
}

/// Why no gimbal is moved, with all devices that were heard.
impl fmt::Display for GimbalChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wanted = self.wanted;
        let is_heard =
            wanted.is_some_and(|wanted| self.devices.iter().any(|device| device.gimbal.device == wanted));
        match wanted {
            Some(device) if is_heard => write!(f, "gimbal device {device} cannot both pan and tilt")?,
            Some(device) => write!(f, "gimbal device {device} was not heard")?,
            None => f.write_str("no gimbal device can both pan and tilt")?,
        }
        for (index, device) in self.devices.iter().enumerate() {
            write!(f, "{} {device}", if index == 0 { ":" } else { "," })?;
        }
        f.write_str("; set up a gimbal with both axes, or choose a device with vehicle.gimbal_device")
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Gimbal { manager: Address { system, component }, device } = self.gimbal;
        write!(f, "device {device} of {}/{} has ", system.0, component.0)?;
        let Some(information) = self.information else { return f.write_str("said nothing of its axes") };
        let axes =
            [(information.has_yaw, "pan"), (information.has_pitch, "tilt"), (information.has_roll, "roll")];
        let mut names = axes.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name);
        f.write_str(names.next().unwrap_or("no axis"))?;
        names.try_for_each(|name| write!(f, " and {name}"))
    }
}
