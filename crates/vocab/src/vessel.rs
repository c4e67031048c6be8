//! Commands to a vessel, and what a vessel may be commanded.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use core::time::Duration;

/// The commanded throttle and rudder of a vessel. The signs are independent of the vehicle's own; the vehicle
/// boundary applies those.
///
/// ```
/// use barrelman_vocab::VesselCommand;
///
/// let command = VesselCommand { throttle: f64::NAN, rudder: 1.7 }.clamped();
/// assert_eq!(command, VesselCommand { throttle: 0.0, rudder: 1.0 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VesselCommand {
    /// -1 (full astern) to 1 (full ahead).
    pub throttle: f64,
    /// -1 (full left) to 1 (full right).
    pub rudder: f64,
}

impl VesselCommand {
    /// No thrust, rudder amidships.
    pub const NEUTRAL: Self = Self { throttle: 0.0, rudder: 0.0 };

    /// Whether both are zero.
    pub fn is_neutral(self) -> bool {
        self.throttle == 0.0 && self.rudder == 0.0
    }

    /// Both clamped to -1..=1. NaN becomes 0: an invalid command must not move a vessel. So does -0: a stored
    /// 0 has no sign.
    #[must_use]
    pub const fn clamped(self) -> Self {
        const fn share(value: f64) -> f64 {
            if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) + 0.0 }
        }
        Self { throttle: share(self.throttle), rudder: share(self.rudder) }
    }
}

/// What is asked of the link to a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum VesselOrder {
    /// The vessel is not commanded: another program or a person may steer it.
    #[default]
    Released,
    /// The vessel is commanded.
    Commanded(VesselCommand),
}

impl VesselOrder {
    /// Commanded to be neutral.
    pub const NEUTRAL: Self = Self::Commanded(VesselCommand::NEUTRAL);

    /// The command; neutral where the vessel is not commanded.
    pub const fn command(self) -> VesselCommand {
        match self {
            Self::Released => VesselCommand::NEUTRAL,
            Self::Commanded(command) => command,
        }
    }
}

/// Limits of the commands to a vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselLimits {
    /// Largest throttle ahead, 0 to 1.
    pub ahead: f64,
    /// Largest throttle astern, 0 (a vessel that cannot go astern) to 1.
    pub astern: f64,
    /// Largest rudder, 0 to 1.
    pub rudder: f64,
    /// Largest speed, m/s; `None`: that of the throttle.
    pub speed_m_per_s: Option<f64>,
}

impl VesselLimits {
    /// The laboratory's throttle, ahead and astern, and all of the rudder.
    pub const DEFAULT: Self = Self { ahead: 0.6, astern: 0.6, rudder: 1.0, speed_m_per_s: None };

    /// The command within these limits. NaN becomes 0.
    #[must_use]
    pub const fn applied_to(&self, command: VesselCommand) -> VesselCommand {
        let VesselCommand { throttle, rudder } = command.clamped();
        VesselCommand {
            throttle: throttle.max(-self.astern).min(self.ahead) + 0.0,
            rudder: rudder.max(-self.rudder).min(self.rudder) + 0.0,
        }
    }
}

impl Default for VesselLimits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a vessel that goes by itself does when the guidance does not see it any more. Whatever else ends a
/// command leaves the vessel neutral.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum FailSafe {
    /// Neutral: the vessel drifts.
    #[default]
    Neutral,
    /// Way on for a while, then neutral: surf turns a boat without way broadside, and rolls it over.
    KeepWay(KeepWay),
}

/// Ahead with the rudder amidships, for a limited time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeepWay {
    /// Throttle ahead, above 0, at most [`KeepWay::MAX_THROTTLE`]. The throttle is never raised to it.
    pub throttle: f64,
    /// For how long, at most [`KeepWay::MAX_LASTS`].
    pub lasts: Duration,
}

impl KeepWay {
    /// Largest throttle: half of the guidance's.
    pub const MAX_THROTTLE: f64 = 0.3;
    /// Longest time: a boat of 1.2 m goes three metres in it.
    pub const MAX_LASTS: Duration = Duration::from_secs(3);
}

/// A vessel: what differs between two of them for a program that commands them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselProfile {
    /// Name on the command line.
    pub name: &'static str,
    /// Limits of the guidance.
    pub limits: VesselLimits,
    /// Largest throttle by hand, ahead and astern, 0 to 1.
    pub hand_throttle: f64,
    /// Largest growth of the throttle, ahead or astern, per second. Less throttle takes effect at once.
    pub throttle_rise_per_s: f64,
    /// Distance that the vessel keeps from the person that it goes to, metres.
    pub stand_off_m: f64,
    /// Distance that the vessel keeps from every other person, metres.
    pub keep_out_m: f64,
    /// What the vessel does when the guidance does not see it any more.
    pub fail_safe: FailSafe,
}

impl VesselProfile {
    /// Names of the built-in profiles.
    pub const NAMES: [&'static str; 4] = ["mavlink-rover", "mavlink-rover-manual", "lab-udp", "simulator"];

    /// Limits of what an operator commands by hand.
    pub const fn hand_limits(&self) -> VesselLimits {
        VesselLimits {
            ahead: self.hand_throttle,
            astern: self.hand_throttle,
            rudder: 1.0,
            speed_m_per_s: None,
        }
    }

    /// The built-in profile of a name. They differ in the protocol only: a jet boat of 1.2 m in the class of
    /// EMILY.
    pub fn named(name: &str) -> Option<Self> {
        let name = Self::NAMES.into_iter().find(|known| *known == name)?;
        Some(Self { name, ..Self::SIMULATOR })
    }

    /// The boat of a simulated world.
    pub const SIMULATOR: Self = Self {
        name: "simulator",
        limits: VesselLimits::DEFAULT,
        hand_throttle: 1.0,
        throttle_rise_per_s: 2.0,
        stand_off_m: 2.0,
        keep_out_m: 3.0,
        fail_safe: FailSafe::Neutral,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_held_to_the_limits_and_no_number_is_neutral() {
        let limits = VesselLimits { ahead: 0.6, astern: 0.0, rudder: 0.5, speed_m_per_s: None };
        for (throttle, rudder, expected) in [
            (1.0, -1.0, (0.6, -0.5)),
            (-1.0, 0.2, (0.0, 0.2)),
            (-0.0, -0.0, (0.0, 0.0)),
            (f64::NAN, f64::INFINITY, (0.0, 0.5)),
            (0.3, f64::NAN, (0.3, 0.0)),
        ] {
            let held = limits.applied_to(VesselCommand { throttle, rudder });
            assert_eq!((held.throttle, held.rudder), expected, "{throttle}, {rudder}");
            assert!(
                held.throttle.is_sign_positive() || held.throttle < 0.0,
                "{throttle}: -0 cannot be stored"
            );
        }
    }
}
