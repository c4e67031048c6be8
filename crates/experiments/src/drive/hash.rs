//! The hash of a drive: two drives with the same hash are the same, bit for bit.

use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_trial::campaign::StepObserver;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{Timestamp, VehicleRates};
use xxhash_rust::xxh3::Xxh3;

use super::lockstep::DriveObserver;

/// Hashes each step of a drive with its time, its picture, its percept and the rates sent, and the ground
/// truth of each picture (XXH3-64).
#[derive(Default)]
pub struct DriveHasher(Xxh3);

impl DriveHasher {
    /// The hash so far, in hexadecimal digits.
    pub fn hex(&self) -> String {
        format!("{:016x}", self.0.digest())
    }
}

impl DriveObserver for DriveHasher {}

impl StepObserver for DriveHasher {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.0.update(&now.as_nanos().to_le_bytes());
        match input {
            Input::Frame(frame) => {
                self.0.update(b"frame");
                self.0.update(&frame.capture.at.as_nanos().to_le_bytes());
                self.0.update(frame.picture.samples());
            }
            Input::Localisation(_) => self.0.update(b"localisation"),
            Input::Telemetry(_) | Input::VesselTelemetry(_) => self.0.update(b"telemetry"),
            Input::Detections(_) => self.0.update(b"detections"),
            Input::Request(_) => self.0.update(b"request"),
            Input::Tick => self.0.update(b"tick"),
        }
        if let Some(percept) = outcome.percept {
            for value in [percept.position.x, percept.position.y, percept.p] {
                self.0.update(&value.to_bits().to_le_bytes());
            }
        }
        for rate in [rates.yaw, rates.pitch] {
            self.0.update(&rate.radians_per_second().to_bits().to_le_bytes());
        }
    }

    fn on_truth(&mut self, truth: &Truth, _target: Option<&TargetInPicture>) {
        let place = truth.target.position;
        for value in [truth.image.x, truth.image.y, place.x, place.y, place.z, truth.rates.0, truth.rates.1] {
            self.0.update(&value.to_bits().to_le_bytes());
        }
    }
}
