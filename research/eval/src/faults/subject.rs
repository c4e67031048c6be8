//! What a campaign is about: the camera of a vehicle, or a boat.

use anyhow::Result;
use clap::ValueEnum;
use clap::builder::PossibleValue;

#[cfg(test)]
use super::fault::FaultKind;
use super::mutant::Mutant;
use super::oracle::Licence;
use super::run::run as run_camera;
use super::run_result::RunResult;
use super::vessel::oracle::{KEEPS_WAY, VesselLicence, WIRE_LIMIT_MS};
use super::vessel::run::run as run_boat;
use super::vessel::vessel_kind::Vessel;
use crate::vehicle::Vehicle;

/// What a campaign is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Subject {
    Camera(Vehicle),
    Boat(Vessel),
}

impl ValueEnum for Subject {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Camera(Vehicle::FotokitePro),
            Self::Camera(Vehicle::MavlinkGimbal),
            Self::Camera(Vehicle::FotokiteSigma),
            Self::Camera(Vehicle::OnvifPtz),
            Self::Boat(Vessel::LabUdp),
            Self::Boat(Vessel::LabUdpKeepingWay),
            Self::Boat(Vessel::MavlinkRover),
            Self::Boat(Vessel::MavlinkRoverManual),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Camera(vehicle) => vehicle.to_possible_value(),
            Self::Boat(vessel) => Some(PossibleValue::new(vessel.name()).help(vessel.help())),
        }
    }
}

impl Subject {
    /// Runs the run with this number. `trace` takes what the vehicle receives.
    pub(super) fn run(
        self,
        number: u64,
        seed: u64,
        mutant: Mutant,
        trace: &mut dyn FnMut(&str),
    ) -> Result<RunResult> {
        match self {
            Self::Camera(vehicle) => run_camera(vehicle, number, seed, mutant, trace),
            Self::Boat(vessel) => run_boat(vessel, number, seed, mutant, trace),
        }
    }

    /// The kinds of faults that there can be.
    #[cfg(test)]
    pub(super) fn faults(self) -> Vec<FaultKind> {
        match self {
            Self::Camera(vehicle) => vehicle.faults(),
            Self::Boat(vessel) => vessel.faults(),
        }
    }

    /// What can be taken out.
    pub(super) const fn mutants(self) -> &'static [Mutant] {
        match self {
            Self::Camera(vehicle) => vehicle.mutants(),
            Self::Boat(_) => Vessel::mutants(),
        }
    }

    /// The names of the licences that must move the vehicle.
    pub(super) fn licences(self) -> Vec<&'static str> {
        match self {
            Self::Camera(_) => Licence::ALL.iter().map(|licence| licence.name()).collect(),
            Self::Boat(vessel) => {
                let licences = VesselLicence::ALL.iter().map(|licence| licence.name());
                licences.chain((vessel == Vessel::LabUdpKeepingWay).then_some(KEEPS_WAY)).collect()
            }
        }
    }

    /// The names of the measured times to rest.
    pub(super) const fn figures(self) -> &'static [&'static str] {
        match self {
            Self::Camera(_) => &[""],
            Self::Boat(_) => &["wire", "console", "boat"],
        }
    }

    /// The longest time to rest, ms; of a boat, to neutral on the wire.
    pub(super) const fn rest_limit_ms(self) -> u64 {
        match self {
            Self::Camera(vehicle) => vehicle.rest_limit_ms(),
            Self::Boat(_) => WIRE_LIMIT_MS,
        }
    }
}
