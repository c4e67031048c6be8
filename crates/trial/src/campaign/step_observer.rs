//! Observation of a simulated trial, for recorders and displays.

use barrelman_pilot::{Input, Outcome};
use barrelman_sim::{Truth, World};
use barrelman_vocab::{Timestamp, VehicleRates};

use crate::target_in_picture::TargetInPicture;

/// Receives what happens in a simulated trial, in order.
pub trait StepObserver {
    /// The pilot made a step. `rates` are the rates sent, in the vehicle's own signs.
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates);
    /// The camera captured a picture; `truth` is the state of the world at that moment.
    /// `target` is what the picture shows of the target, in a trial in pixels.
    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>);
    /// The camera captured a picture of this world; follows [`Self::on_truth`].
    fn on_world(&mut self, _world: &World) {}
}

/// Ignores every event.
impl StepObserver for () {
    fn on_step(&mut self, _now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, _rates: VehicleRates) {}
    fn on_truth(&mut self, _truth: &Truth, _target: Option<&TargetInPicture>) {}
}
