//! A vehicle in the campaign: what is spoken to it, what is at the other end, and which faults it has.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use barrelman_vocab::mavlink::{ComponentId, MavlinkPeers};
use barrelman_vocab::profile::{Protocol, SizeKeeping};
use barrelman_vocab::{Timestamp, VehicleProfile, VehicleRates, ZoomDynamics};
use barrelman_wire::fotokite_sigma::FotokiteSigmaSession;
use barrelman_wire::onvif::{OnvifSession, OnvifSettings};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing, OpenSession as _};

use super::fault::{Fault, FaultKind};
use super::fotokite_pro_station::FotokiteProStation;
use super::fotokite_sigma_station::FotokiteSigmaStation;
use super::gimbal_station::GimbalStation;
use super::http_network::SessionOverNetwork;
use super::link_plan::{LinkPlan, Opener};
use super::mutant::Mutant;
use super::onvif_station::{self, OnvifStation};
use super::station::Station;
use super::without_first_zeros::WithoutFirstZeros;
use crate::vehicle::Vehicle;

impl Vehicle {
    /// Whether requests and answers go over HTTP, on TCP.
    const fn is_over_http(self) -> bool {
        matches!(self, Self::FotokiteSigma | Self::OnvifPtz)
    }

    /// The vehicle, whose camera zooms where one can, to keep the size of a boat that is always too small:
    /// each licence moves the zoom, too.
    pub(super) fn subject(self) -> VehicleProfile {
        let profile = self.profile();
        let protocol = match profile.protocol {
            Protocol::MavlinkGimbal(peers) => {
                Protocol::MavlinkGimbal(MavlinkPeers { camera: Some(ComponentId(100)), ..peers })
            }
            other => other,
        };
        VehicleProfile {
            protocol,
            zoom: (self != Self::FotokitePro).then_some(ZoomDynamics::usual(1e6)),
            size: SizeKeeping { smallest: 0.4, largest: 0.9, is_on_at_start: true },
            ..profile
        }
    }

    /// Whether a guard owns the link; a thread of the program does otherwise.
    pub(super) fn has_guard(self) -> bool {
        self.subject().keeps_last_rate()
    }

    /// The longest time to rest, ms. The last command of a Sigma or an ONVIF camera has to expire: one that
    /// left when the licence was about to end adds its time-out, 1 s for an ONVIF camera, to the
    /// licence's 0.25 s and the link's 0.05 s.
    pub(super) const fn rest_limit_ms(self) -> u64 {
        match self {
            Self::FotokitePro | Self::MavlinkGimbal => 350,
            Self::FotokiteSigma => 500,
            Self::OnvifPtz => 1_300,
        }
    }

    /// How its link is made.
    ///
    /// # Errors
    /// If the profile names a protocol that has no session here.
    pub(super) fn link_plan(self, mutant: Mutant) -> Result<LinkPlan> {
        let profile = self.subject();
        let limits = profile.protocol.rate_limits();
        let limits = VehicleRates::turning(limits.pan, limits.tilt).zooming(profile.largest_rates().zoom);
        let open_session = self.session_opener()?;
        let without_zeros = Arc::clone(&open_session);
        Ok(LinkPlan {
            open_session: match mutant {
                Mutant::NoZerosFirst => {
                    Arc::new(move |now| Box::new(WithoutFirstZeros::new(self, without_zeros(now))))
                }
                _ => open_session,
            },
            guard_limits: self.has_guard().then_some(limits),
            mutant,
        })
    }

    fn session_opener(self) -> Result<Opener<VehicleRates>> {
        if self == Self::FotokiteSigma {
            let full_zoom = self.subject().max_zoom_rate();
            return Ok(Arc::new(move |now| {
                Box::new(SessionOverNetwork(FotokiteSigmaSession::open(None, full_zoom, now)))
            }));
        }
        if self == Self::OnvifPtz {
            let settings = OnvifSettings {
                login: Some(onvif_station::login()),
                speeds: self.subject().speeds,
                profile: None,
            };
            // A conversation begins at a time of its own: no nonce is used twice.
            let seed = |now: Timestamp| {
                let nanos = now.as_nanos().to_le_bytes();
                core::array::from_fn(|at| nanos[at % nanos.len()])
            };
            return Ok(Arc::new(move |now| {
                Box::new(SessionOverNetwork(OnvifSession::open(&settings, seed(now), now)))
            }));
        }
        let protocol = ByteProtocolName::of(self.subject().protocol);
        let protocol = protocol.context("the vehicle's port carries no bytes")?;
        let protocol = ByteProtocol { protocol, framing: Framing::CarriageReturns, baud: 115_200 };
        Ok(Arc::new(move |now| protocol.open(now)))
    }

    /// Whether the vehicle can have this fault. TCP damages and repeats nothing; only a Fotokite Pro reports
    /// its flight state and its battery with each status.
    pub(super) fn can_have(self, fault: FaultKind) -> bool {
        match fault {
            FaultKind::GuardKilled | FaultKind::GuardHangs => self.has_guard(),
            // The others' commands end by themselves.
            FaultKind::CommandsLost => self.has_guard(),
            FaultKind::LineDamagesBytes | FaultKind::LineRepeats => !self.is_over_http(),
            FaultKind::Emergency => !matches!(self, Self::MavlinkGimbal | Self::OnvifPtz),
            FaultKind::ControlTaken => self != Self::OnvifPtz,
            FaultKind::BatteryLow => self == Self::FotokitePro,
            FaultKind::InformationWithheld
            | FaultKind::StatusWithheld
            | FaultKind::ClaimsDenied
            | FaultKind::ClaimsLost => self == Self::MavlinkGimbal,
            FaultKind::TokenExpired | FaultKind::ServerNotReady | FaultKind::ServerHangs => {
                self.is_over_http()
            }
            FaultKind::WebSocketMissing => self == Self::FotokiteSigma,
            FaultKind::StopsIgnored | FaultKind::ClockJumps => self == Self::OnvifPtz,
            _ => !fault.is_of_boats(),
        }
    }

    /// The kinds of faults that the vehicle can have.
    pub(super) fn faults(self) -> Vec<FaultKind> {
        FaultKind::ALL.into_iter().filter(|kind| self.can_have(*kind)).collect()
    }

    /// What can be taken out for this vehicle.
    pub(super) const fn mutants(self) -> &'static [Mutant] {
        match self {
            Self::FotokitePro | Self::MavlinkGimbal => &[
                Mutant::NoTimeToLive,
                Mutant::NoLatch,
                Mutant::NoGuard,
                Mutant::NoGuardWatch,
                Mutant::NoAbsenceWatch,
                Mutant::NoZerosFirst,
                Mutant::ForgetsDelays,
                Mutant::NoMotionWatch,
            ],
            Self::FotokiteSigma | Self::OnvifPtz => &[
                Mutant::NoTimeToLive,
                Mutant::NoLatch,
                Mutant::NoAbsenceWatch,
                Mutant::CommandsLast,
                Mutant::ForgetsDelays,
            ],
        }
    }

    /// The far end of the line with these faults; `is_worst`: the kind that rests for nothing but zeros.
    pub(super) fn station(self, faults: &[Fault], is_worst: bool, mutant: Mutant) -> Box<dyn Station> {
        match self {
            Self::FotokitePro => Box::new(FotokiteProStation::new(faults, is_worst)),
            Self::MavlinkGimbal => Box::new(GimbalStation::new(faults, is_worst)),
            Self::FotokiteSigma => Box::new(FotokiteSigmaStation::new(faults, mutant)),
            Self::OnvifPtz => Box::new(OnvifStation::new(faults, mutant)),
        }
    }
}
