//! The boats of the campaign: what is spoken to them, what is at the other end, and which faults they have.

use core::time::Duration;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use barrelman_vocab::{FailSafe, KeepWay, VesselCommand, VesselOrder, VesselProfile};
use barrelman_wire::mavlink::rover::RoverDrive;
use barrelman_wire::{OpenSession as _, VesselProtocol};

use super::super::fault::{Fault, FaultKind};
use super::super::line::DELAY_MS;
use super::super::link_plan::LinkPlan;
use super::super::mutant::Mutant;
use super::boat::Boat;
use super::lab_receiver::LabBoat;
use super::rover::Rover;

/// The way that a boat keeps.
const KEEP_WAY: KeepWay = KeepWay { throttle: 0.2, lasts: Duration::from_secs(2) };

/// A boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Vessel {
    /// The laboratory's datagrams, to a receiver with a time-out.
    LabUdp,
    /// The same, with a profile that keeps way when the boat is not seen any more.
    LabUdpKeepingWay,
    /// An ArduPilot boat in GUIDED.
    MavlinkRover,
    /// An ArduPilot boat in MANUAL, by manual control.
    MavlinkRoverManual,
}

impl Vessel {
    /// Name on the command line.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::LabUdpKeepingWay => "lab-udp-keep-way",
            _ => self.profile_name(),
        }
    }

    const fn profile_name(self) -> &'static str {
        match self {
            Self::LabUdp | Self::LabUdpKeepingWay => "lab-udp",
            Self::MavlinkRover => "mavlink-rover",
            Self::MavlinkRoverManual => "mavlink-rover-manual",
        }
    }

    /// What it is, for the command line.
    pub(crate) const fn help(self) -> &'static str {
        match self {
            Self::LabUdpKeepingWay => "The same, to a boat that keeps way when it is not seen any more",
            Self::LabUdp => "The laboratory's datagrams to a boat, behind a guard",
            Self::MavlinkRover => "An ArduPilot boat in GUIDED, behind a guard",
            Self::MavlinkRoverManual => "An ArduPilot boat by manual control, behind a guard",
        }
    }

    /// The profile.
    ///
    /// # Errors
    /// If there is none of this name.
    pub(super) fn profile(self) -> Result<VesselProfile> {
        let base = VesselProfile::named(self.profile_name()).context("the vessel has no profile")?;
        let fail_safe = match self {
            Self::LabUdpKeepingWay => FailSafe::KeepWay(KEEP_WAY),
            _ => base.fail_safe,
        };
        Ok(VesselProfile { fail_safe, ..base })
    }

    /// How its link is made, behind a guard.
    ///
    /// # Errors
    /// If the profile has no protocol.
    pub(super) fn link_plan(self, mutant: Mutant) -> Result<LinkPlan<VesselOrder>> {
        let protocol =
            VesselProtocol::of_profile(self.profile_name()).context("the vessel has no protocol")?;
        let profile = self.profile()?;
        let throttle = profile.limits.ahead.max(profile.limits.astern).max(profile.hand_throttle);
        Ok(LinkPlan {
            open_session: Arc::new(move |now| protocol.open(now)),
            guard_limits: Some(VesselOrder::Commanded(VesselCommand { throttle, rudder: 1.0 })),
            mutant,
        })
    }

    /// The longest time of motion at a boat that hears nothing any more, from the last permitted moment, ms:
    /// its own time-out after the last packet. A network that delays adds its delay.
    pub(super) fn own_limit_ms(self, faults: &[Fault]) -> u64 {
        let is_delayed = faults.iter().any(|fault| fault.kind == FaultKind::LineDelays);
        let own_ms = match self {
            Self::LabUdp | Self::LabUdpKeepingWay => 1_000,
            Self::MavlinkRover | Self::MavlinkRoverManual => 3_300,
        };
        if is_delayed { own_ms + DELAY_MS } else { own_ms }
    }

    /// From the return of line or guard until neutral can be sent, ms: a port is opened within 0.1 s, and an
    /// ArduPilot boat has to be heard first, once a second.
    pub(super) const fn settles_ms(self) -> u64 {
        match self {
            Self::LabUdp | Self::LabUdpKeepingWay => 150,
            Self::MavlinkRover | Self::MavlinkRoverManual => 1_150,
        }
    }

    /// Whether neutral can be sent before the boat was heard.
    pub(super) const fn is_spoken_to_unheard(self) -> bool {
        match self {
            Self::LabUdp | Self::LabUdpKeepingWay => true,
            Self::MavlinkRover | Self::MavlinkRoverManual => false,
        }
    }

    /// The swing of the boat before the camera, as a share of that of the other campaigns: a boat that would
    /// pass the camera at 8 m/s has no room to keep way.
    pub(super) const fn swing(self) -> f64 {
        match self {
            Self::LabUdpKeepingWay => 0.15,
            _ => 1.0,
        }
    }

    /// Whether the boat can have this fault. Datagrams have a checksum; the laboratory's receiver answers
    /// nothing.
    fn can_have(self, fault: FaultKind) -> bool {
        match fault {
            FaultKind::LineDamagesBytes | FaultKind::ControlTaken | FaultKind::BoatDisarmed => {
                !matches!(self, Self::LabUdp | Self::LabUdpKeepingWay)
            }
            FaultKind::VideoStalls
            | FaultKind::VideoLate
            | FaultKind::VideoDelayStands
            | FaultKind::VideoDelayCreeps
            | FaultKind::VideoClockJumps
            | FaultKind::TrackLost
            | FaultKind::TrackCoasts
            | FaultKind::PilotHangs
            | FaultKind::ProgramKilled
            | FaultKind::ProgramStopped
            | FaultKind::ProgramEnds
            | FaultKind::GuardKilled
            | FaultKind::GuardHangs
            | FaultKind::Suspension
            | FaultKind::LineCut
            | FaultKind::LineSilent
            | FaultKind::LineLosesPackets
            | FaultKind::LineDelays
            | FaultKind::LineRepeats
            | FaultKind::StationReboots
            | FaultKind::OperatorStops => true,
            _ => fault.is_of_boats(),
        }
    }

    /// The kinds of faults that the boat can have.
    pub(crate) fn faults(self) -> Vec<FaultKind> {
        FaultKind::ALL.into_iter().filter(|kind| self.can_have(*kind)).collect()
    }

    /// What can be taken out for this boat. A pilot that goes on after it was away is not among them: the
    /// silent console stops the boat in nearly every run.
    pub(crate) const fn mutants() -> &'static [Mutant] {
        &[
            Mutant::NoTimeToLive,
            Mutant::NoLatch,
            Mutant::NoGuard,
            Mutant::NoGuardWatch,
            Mutant::NoConsoleTimeOut,
            Mutant::CommandsLast,
            Mutant::ForgetsDelays,
        ]
    }

    /// The far end of the line with these faults; `is_ready`: a boat that takes commands from the start.
    pub(super) fn boat(self, faults: &[Fault], is_ready: bool, mutant: Mutant) -> Box<dyn Boat> {
        match self {
            Self::LabUdp | Self::LabUdpKeepingWay => Box::new(LabBoat::new(faults, mutant)),
            Self::MavlinkRover => Box::new(Rover::new(RoverDrive::Guided, faults, is_ready, mutant)),
            Self::MavlinkRoverManual => Box::new(Rover::new(RoverDrive::Manual, faults, is_ready, mutant)),
        }
    }
}
