//! The vessel in the configuration: the boat that is steered from the video, or goes to a mark by itself.

use core::time::Duration;

use anyhow::{Context, Result, ensure};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{CommandPath, VesselSettings};
use barrelman_vocab::mavlink::SystemId;
use barrelman_vocab::{FailSafe, KeepWay, VesselLimits, VesselProfile};
use barrelman_wire::VesselProtocol;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Address of the boat of a simulated world.
pub const SIMULATED: &str = "sim:";

/// The boat.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VesselSection {
    /// Address: `udp://host:port` (every profile), `tcp://host:port` or `serial:/dev/ttyACM0?baud=57600`
    /// (both of MAVLink), or `sim:`, the boat of a simulated world; without an address no boat is commanded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub url: Option<String>,
    /// Name of the profile: `mavlink-rover` (in GUIDED), `mavlink-rover-manual` (MANUAL_CONTROL), `lab-udp`
    /// or `simulator`; default: `simulator` at `sim:`, else `mavlink-rover`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// The boat's MAVLink system; default: the first boat that is heard.
    #[schemars(range(min = 1, max = 255))]
    #[schemars(example = 2)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vehicle_system: Option<u8>,
    /// How the boat goes to a mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guidance: Option<GuidanceName>,
    /// Largest throttle of the guidance ahead.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttle_ahead: Option<f64>,
    /// Largest throttle of the guidance astern (0: the boat cannot go astern).
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttle_astern: Option<f64>,
    /// Largest throttle by hand.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttle_by_hand: Option<f64>,
    /// Largest growth of the throttle, 1/s. Less throttle takes effect at once.
    #[schemars(range(min = 0.1, max = 20.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub throttle_rise_per_s: Option<f64>,
    /// Largest speed of the guidance, m/s; default: that of the throttle.
    #[schemars(range(min = 0.2, max = 20.0))]
    #[schemars(example = 2.0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_per_s: Option<f64>,
    /// Distance that the boat keeps from the person that it goes to, metres.
    #[schemars(range(min = 0.5, max = 50.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stand_off_m: Option<f64>,
    /// Distance that the boat keeps from every other marked person, metres.
    #[schemars(range(min = 0.5, max = 50.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_out_m: Option<f64>,
    /// Throttle ahead, rudder amidships, with which a boat that goes by itself keeps way when it is not seen
    /// any more (0: neutral at once). For surf, which rolls over a boat without way;
    /// docs/safety.md#a-boat-that-keeps-way says what that gives up.
    #[schemars(range(min = 0.0, max = KeepWay::MAX_THROTTLE), extend("unit" = "a share"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_way_throttle: Option<f64>,
    /// For how long the boat keeps way, seconds.
    #[schemars(range(min = 0.1, max = KeepWay::MAX_LASTS.as_secs_f64()))]
    #[schemars(example = KEEP_WAY_S)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_way_s: Option<f64>,
}

/// How long a boat keeps way that may, seconds, unless the configuration says otherwise.
const KEEP_WAY_S: f64 = 2.0;

/// How the boat goes to a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum GuidanceName {
    /// Along a line over the water; in the picture, by the laboratory's law, where height or tilt are not
    /// known.
    Los,
    /// The law of the paper's laboratory, in the picture.
    Lab,
    /// Not at all: the boat is steered by hand.
    Hand,
}

impl From<GuidanceName> for GuidanceLaw {
    fn from(name: GuidanceName) -> Self {
        match name {
            GuidanceName::Los => Self::LineOfSight,
            GuidanceName::Lab => Self::Laboratory,
            GuidanceName::Hand => Self::ByHand,
        }
    }
}

/// The effective settings of the boat.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselConfig {
    /// Address of the boat.
    pub url: String,
    /// The boat.
    pub profile: VesselProfile,
    /// The boat's MAVLink system; `None`: that of the first boat that is heard.
    pub vehicle: Option<SystemId>,
    /// How the boat goes to a mark.
    pub guidance: GuidanceName,
}

impl VesselConfig {
    /// The boat of a simulated world.
    pub fn simulated() -> Self {
        Self {
            url: SIMULATED.to_owned(),
            profile: VesselProfile::SIMULATOR,
            vehicle: None,
            guidance: GuidanceName::Los,
        }
    }

    /// What the pilot has to know.
    pub fn settings(&self) -> VesselSettings {
        VesselSettings {
            profile: self.profile,
            guidance: self.guidance.into(),
            path: if self.url == SIMULATED { CommandPath::Simulated } else { CommandPath::Link },
        }
    }
}

impl VesselSection {
    /// The effective settings; `None`: no boat is commanded, as there is no address. The values are checked
    /// nevertheless.
    ///
    /// # Errors
    /// If there is no such profile, or a value is out of range; the message names the key and the range.
    pub(super) fn resolve(&self) -> Result<Option<VesselConfig>> {
        let is_simulated = self.url.as_deref() == Some(SIMULATED);
        let default = if is_simulated { "simulator" } else { "mavlink-rover" };
        let name = self.profile.as_deref().unwrap_or(default);
        let base = VesselProfile::named(name).with_context(|| {
            let names = VesselProfile::NAMES.join(", ");
            format!("vessel.profile: there is no vessel profile {name:?}: use one of {names}")
        })?;
        let profile = VesselProfile {
            limits: VesselLimits {
                ahead: self.throttle_ahead.unwrap_or(base.limits.ahead),
                astern: self.throttle_astern.unwrap_or(base.limits.astern),
                speed_m_per_s: self.speed_m_per_s,
                ..base.limits
            },
            hand_throttle: self.throttle_by_hand.unwrap_or(base.hand_throttle),
            throttle_rise_per_s: self.throttle_rise_per_s.unwrap_or(base.throttle_rise_per_s),
            stand_off_m: self.stand_off_m.unwrap_or(base.stand_off_m),
            keep_out_m: self.keep_out_m.unwrap_or(base.keep_out_m),
            fail_safe: self.fail_safe()?,
            ..base
        };
        let vehicle = self.vehicle(name)?;
        let guidance = self.guidance.unwrap_or(GuidanceName::Los);
        Ok(self.url.clone().map(|url| VesselConfig { url, profile, vehicle, guidance }))
    }

    fn vehicle(&self, profile: &str) -> Result<Option<SystemId>> {
        let Some(system) = self.vehicle_system else { return Ok(None) };
        ensure!(
            VesselProtocol::of_profile(profile).is_some_and(VesselProtocol::has_systems),
            "vessel.vehicle_system has no effect on the boat {profile}: omit it, or use vessel.profile = \"mavlink-rover\""
        );
        Ok(Some(SystemId(system)))
    }

    fn fail_safe(&self) -> Result<FailSafe> {
        Ok(match self.keep_way_throttle {
            None | Some(0.0) => {
                ensure!(
                    self.keep_way_s.is_none(),
                    "vessel.keep_way_s has no effect without vessel.keep_way_throttle: give a throttle, or omit both"
                );
                FailSafe::Neutral
            }
            Some(throttle) => FailSafe::KeepWay(KeepWay {
                throttle,
                lasts: Duration::from_secs_f64(self.keep_way_s.unwrap_or(KEEP_WAY_S)),
            }),
        })
    }

    /// A complete section.
    pub(super) fn from_config(config: Option<&VesselConfig>) -> Self {
        let Some(VesselConfig { url, profile, vehicle, guidance }) = config else { return Self::default() };
        let (keep_way_throttle, keep_way_s) = match profile.fail_safe {
            FailSafe::Neutral => (0.0, None),
            FailSafe::KeepWay(keep) => (keep.throttle, Some(keep.lasts.as_secs_f64())),
        };
        Self {
            url: Some(url.clone()),
            profile: Some(profile.name.to_owned()),
            vehicle_system: vehicle.map(|system| system.0),
            guidance: Some(*guidance),
            throttle_ahead: Some(profile.limits.ahead),
            throttle_astern: Some(profile.limits.astern),
            throttle_by_hand: Some(profile.hand_throttle),
            throttle_rise_per_s: Some(profile.throttle_rise_per_s),
            speed_m_per_s: profile.limits.speed_m_per_s,
            stand_off_m: Some(profile.stand_off_m),
            keep_out_m: Some(profile.keep_out_m),
            keep_way_throttle: Some(keep_way_throttle),
            keep_way_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complete_section_is_read_back_as_it_was() {
        let section = VesselSection {
            url: Some("udp://boat.example:5007".to_owned()),
            profile: Some("lab-udp".to_owned()),
            guidance: Some(GuidanceName::Lab),
            throttle_ahead: Some(0.5),
            speed_m_per_s: Some(1.5),
            keep_way_throttle: Some(0.2),
            ..VesselSection::default()
        };
        let config = section.resolve().unwrap().unwrap();
        assert_eq!(config.settings().path, CommandPath::Link);
        assert_eq!(VesselSection::from_config(Some(&config)).resolve().unwrap(), Some(config.clone()));
        assert_eq!(VesselSection::default().resolve().unwrap(), None);
        let keep = KeepWay { throttle: 0.2, lasts: Duration::from_secs(2) };
        assert_eq!(config.profile.fail_safe, FailSafe::KeepWay(keep));
        let neutral = VesselSection { keep_way_throttle: None, ..section }.resolve().unwrap().unwrap();
        assert_eq!(neutral.profile.fail_safe, FailSafe::Neutral);
        let of_two = VesselSection {
            url: Some("udp://boat.example:14550".to_owned()),
            vehicle_system: Some(3),
            ..VesselSection::default()
        };
        let config = of_two.resolve().unwrap();
        assert_eq!(config.as_ref().and_then(|config| config.vehicle), Some(SystemId(3)));
        assert_eq!(VesselSection::from_config(config.as_ref()).resolve().unwrap(), config);
    }

    #[test]
    fn unknown_profiles_and_idle_keys_are_named() {
        let at = |section: VesselSection| {
            VesselSection { url: Some(SIMULATED.to_owned()), ..section }.resolve().unwrap_err().to_string()
        };
        let none = VesselSection::default;
        assert!(at(VesselSection { vehicle_system: Some(3), ..none() }).contains("the boat simulator"));
        assert!(at(VesselSection { profile: Some("raft".to_owned()), ..none() }).contains("lab-udp"));
    }
}
