//! How the camera's electronics drift: brightness and the gains of red and blue wander while it runs.

use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::snapshot::SensorState;

/// How much they drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElectronicsModel {
    /// Of the logarithm of the brightness.
    pub brightness: OrnsteinUhlenbeck,
    /// Of the logarithms of the gains of red and of blue.
    pub white_balance: OrnsteinUhlenbeck,
    /// How long each row is exposed, seconds.
    pub exposure_s: f64,
}

/// Electronics that drift.
#[derive(Debug, Clone)]
pub struct Electronics {
    brightness: OrnsteinUhlenbeckProcess,
    red: OrnsteinUhlenbeckProcess,
    blue: OrnsteinUhlenbeckProcess,
    exposure_s: f64,
}

impl Electronics {
    /// Those of a trial.
    pub fn new(script: &ElectronicsModel, seed: u64) -> Self {
        let process = |model, which: u64| {
            OrnsteinUhlenbeckProcess::new(
                model,
                CounterRng::new(seed.wrapping_add(which << 48), Stream::Electronics),
            )
        };
        Self {
            brightness: process(script.brightness, 0),
            red: process(script.white_balance, 1),
            blue: process(script.white_balance, 2),
            exposure_s: script.exposure_s,
        }
    }

    /// Advances through a tick.
    pub fn advance(&mut self, tick: u64) {
        self.brightness.advance(tick);
        self.red.advance(tick);
        self.blue.advance(tick);
    }

    /// As they are now.
    pub fn state(&self) -> SensorState {
        SensorState {
            exposure: libm::exp(self.brightness.value()),
            red: libm::exp(self.red.value()),
            blue: libm::exp(self.blue.value()),
            exposure_s: self.exposure_s,
        }
    }
}
