//! Drift of the camera's electronics: brightness and the gains of red and blue vary during a trial.

use crate::random::{CounterRng, OrnsteinUhlenbeck, OrnsteinUhlenbeckProcess, Stream};
use crate::snapshot::SensorState;

/// Parameters of the drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElectronicsModel {
    /// Logarithm of the brightness factor.
    pub brightness: OrnsteinUhlenbeck,
    /// Logarithms of the gains of red and of blue.
    pub white_balance: OrnsteinUhlenbeck,
    /// Exposure time of each row, seconds.
    pub exposure_s: f64,
}

/// Drifting electronics.
#[derive(Debug, Clone)]
pub struct Electronics {
    brightness: OrnsteinUhlenbeckProcess,
    red: OrnsteinUhlenbeckProcess,
    blue: OrnsteinUhlenbeckProcess,
    exposure_s: f64,
}

impl Electronics {
    /// The electronics of a trial.
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

    /// Advances by a tick.
    pub fn advance(&mut self, tick: u64) {
        self.brightness.advance(tick);
        self.red.advance(tick);
        self.blue.advance(tick);
    }

    /// Present state.
    pub fn state(&self) -> SensorState {
        SensorState {
            exposure: libm::exp(self.brightness.value()),
            red: libm::exp(self.red.value()),
            blue: libm::exp(self.blue.value()),
            exposure_s: self.exposure_s,
        }
    }
}
