//! What the operator's requests do to the gate, and which of them it refuses.

use barrelman_vocab::{HoldCause, Timestamp, VesselCommand, VesselStopper};

use super::{Helm, Holder, VesselGate, VesselStop};
use crate::refusal::Refusal;

impl VesselGate {
    /// The operator stops the boat, also one that this program did not command so far: from now on it does.
    pub fn stop_vessel(&mut self, by: VesselStopper) {
        match by {
            VesselStopper::ConsoleLost => self.stop(VesselStop::ConsoleLost),
            VesselStopper::Operator if self.holder == Holder::Released => {
                self.bar_helm();
                self.holder = Holder::Stopped { cause: VesselStop::Operator };
            }
            VesselStopper::Operator => self.stop(VesselStop::Operator),
        }
    }

    /// Commands the boat no more.
    pub const fn release(&mut self) {
        self.holder = Holder::Released;
    }

    /// The operator engages the guidance of a boat that is seen. The guidance needs fresh video: without it,
    /// a boat that was last seen long ago would set off when the video comes back.
    ///
    /// # Errors
    /// The reason, if the boat cannot be commanded now.
    pub fn guide(&mut self, now: Timestamp) -> Result<(), Refusal> {
        self.refuse_without_way()?;
        if !self.has_video(now) {
            return Err(Refusal::NoFreshVideo);
        }
        if !self.is_guiding() {
            // Neutral until the next localisation, which has to come in time.
            self.holder =
                Holder::Guided { advised: VesselCommand::NEUTRAL, fresh_at: Some(now), holding: None };
        }
        Ok(())
    }

    /// The operator steers by hand; neutral lets go.
    ///
    /// # Errors
    /// The reason, if the boat cannot be commanded now.
    pub fn steer(&mut self, wanted: VesselCommand, now: Timestamp) -> Result<(), Refusal> {
        let wanted = wanted.clamped();
        if wanted.is_neutral() {
            self.helm = Helm::Free;
            if matches!(self.holder, Holder::ByHand { .. }) {
                self.holder = Holder::Neutral;
            }
            return Ok(());
        }
        if let Err(refusal) = self.refuse_without_way() {
            self.helm = Helm::Barred;
            return Err(refusal);
        }
        if self.helm == Helm::Barred {
            return Err(Refusal::HelmHeld);
        }
        self.helm = Helm::Held;
        if !self.has_video(now) {
            return Err(Refusal::NoFreshVideo);
        }
        self.holder = Holder::ByHand { wanted, renewed_at: now };
        Ok(())
    }

    fn refuse_without_way(&self) -> Result<(), Refusal> {
        match (self.vessel.obstacle(), self.said) {
            (None, _) => Ok(()),
            (Some(HoldCause::NoControl), Some(said)) => Err(Refusal::NotAccepted(said)),
            (Some(cause), _) => Err(Refusal::NoVesselMotion(cause)),
        }
    }
}
