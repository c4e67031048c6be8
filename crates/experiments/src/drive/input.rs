//! The inputs of a drive: the actions of a person, each before a tick.

use barrelman_sim::boat::HelmCommand;
use barrelman_trial::campaign::{Simulation, StepObserver};
use barrelman_vocab::{OperatorRequest, StopCause};
use serde::{Deserialize, Serialize};

/// An action of a person in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum DriveInput {
    /// Steers the boat: percent of the throttle (negative: astern) and of the rudder (positive: to the left).
    Helm {
        /// -100 to 100.
        thrust: i8,
        /// -100 to 100.
        rudder: i8,
    },
    /// Returns control to the scenario's helmsman.
    Helmsman,
    /// Engages: the camera may move.
    Engage,
    /// Stops the camera.
    Stop,
    /// Pauses the time. The world and the pilot are not affected.
    Pause,
    /// Resumes the time.
    Resume,
}

impl DriveInput {
    /// The helm after the input: `Some(Some(helm))` if a person steers, `Some(None)` if the helmsman does, `None` if
    /// the input does not change it.
    pub(super) fn helm_change(self) -> Option<Option<HelmCommand>> {
        let share = |percent: i8| f64::from(percent.clamp(-100, 100)) / 100.0;
        match self {
            Self::Helm { thrust, rudder } => {
                Some(Some(HelmCommand { throttle: share(thrust), rudder: share(rudder) }))
            }
            Self::Helmsman => Some(None),
            Self::Engage | Self::Stop | Self::Pause | Self::Resume => None,
        }
    }

    /// Applies the input to a trial, before the next tick of the trial.
    pub fn apply(self, simulation: &mut Simulation<'_>, observer: &mut dyn StepObserver) {
        if let Some(helm) = self.helm_change() {
            simulation.steer(helm);
        }
        match self {
            Self::Engage => simulation.request(OperatorRequest::Engage, observer),
            Self::Stop => simulation.request(OperatorRequest::Stop(StopCause::Operator), observer),
            // A pause changes only when the next tick runs.
            Self::Pause | Self::Resume | Self::Helm { .. } | Self::Helmsman => {}
        }
    }
}
