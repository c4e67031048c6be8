//! The inputs of a drive: what a person does, each before a tick.

use barrelman_sim::boat::HelmCommand;
use barrelman_trial::campaign::{Simulation, StepObserver};
use barrelman_vocab::{OperatorRequest, StopCause};
use serde::{Deserialize, Serialize};

/// What somebody does in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum DriveInput {
    /// Steers: percent of the throttle (astern below 0) and of the rudder (to the left above 0).
    Helm {
        /// -100 to 100.
        thrust: i8,
        /// -100 to 100.
        rudder: i8,
    },
    /// Leaves the boat to the scenario's helmsman again.
    Helmsman,
    /// Lets the camera be moved.
    Engage,
    /// Stops the camera.
    Stop,
    /// Stops the time. Nothing in the world knows of it.
    Pause,
    /// Lets it go on.
    Resume,
}

impl DriveInput {
    /// What it does to the helm: somebody steers so, or nobody but the helmsman; `None` where it stays as it is.
    pub(super) fn helm(self) -> Option<Option<HelmCommand>> {
        let share = |percent: i8| f64::from(percent.clamp(-100, 100)) / 100.0;
        match self {
            Self::Helm { thrust, rudder } => {
                Some(Some(HelmCommand { throttle: share(thrust), rudder: share(rudder) }))
            }
            Self::Helmsman => Some(None),
            Self::Engage | Self::Stop | Self::Pause | Self::Resume => None,
        }
    }

    /// Does it in a trial, before its next tick.
    pub fn act(self, simulation: &mut Simulation<'_>, observer: &mut dyn StepObserver) {
        if let Some(helm) = self.helm() {
            simulation.steer(helm);
        }
        match self {
            Self::Engage => simulation.request(OperatorRequest::Engage, observer),
            Self::Stop => simulation.request(OperatorRequest::Stop(StopCause::Operator), observer),
            // Of time that stands still nothing in the world knows.
            Self::Pause | Self::Resume | Self::Helm { .. } | Self::Helmsman => {}
        }
    }
}
