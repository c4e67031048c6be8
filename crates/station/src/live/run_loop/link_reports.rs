//! What the loop makes of the reports of the links.

use barrelman_console_server::snapshot::link_state_text;
use barrelman_pilot::Input;
use barrelman_vocab::EquipmentChange;
use barrelman_vocab::telemetry::{LinkState, Report};

use super::{Ending, LoopState, RunLoop, failed};
use crate::link::LinkReport;

impl RunLoop<'_> {
    pub(super) fn on_link_report(&mut self, state: &mut LoopState, report: LinkReport) -> Option<Ending> {
        match report {
            LinkReport::Telemetry(telemetry) => {
                if let Report::Link(link) = telemetry.report {
                    tracing::info!("{}", link_state_text(link));
                }
                if let Report::Equipment(used) = telemetry.report {
                    let mut known = self.publisher.newest().vehicle.equipment;
                    match known.on_used(used) {
                        None => {}
                        Some(change @ EquipmentChange { before: None, .. }) => tracing::info!("{change}"),
                        Some(change) => tracing::warn!("{change}"),
                    }
                }
                self.step(state, Input::Telemetry(telemetry));
            }
            LinkReport::NotReached(reason) => {
                tracing::warn!(
                    "the vehicle is not reached ({reason}); trying on. Nothing engages until it is there"
                );
            }
            LinkReport::Lost { reason, may_be_turning: false } => {
                tracing::warn!("the link was lost ({reason}); reopening it");
            }
            LinkReport::Lost { reason, may_be_turning: true } => self.warn_of_turning(&format!(
                "the link was lost ({reason}): the camera may be turning; reopening it, zeros first"
            )),
            LinkReport::GuardLost(reason) => self.warn_of_turning(&format!(
                "the guard is gone ({reason}): the camera may be turning; starting another guard, zeros first"
            )),
            LinkReport::HeldUp => tracing::error!("the pilot is held up: the link rests the camera"),
            LinkReport::Suspended(gap) => self.on_suspension(state, gap),
            // Told where it is reported: the loop may have ended.
            LinkReport::Stopped(_) => {}
            // The pilot reads it from the telemetry.
            LinkReport::Control { .. } => {}
            LinkReport::Panicked => return Some(failed("the link thread panicked")),
        }
        None
    }

    pub(super) fn on_vessel_report(&mut self, state: &mut LoopState, report: LinkReport) -> Option<Ending> {
        match report {
            LinkReport::Telemetry(telemetry) => {
                if let Report::Link(link) = telemetry.report
                    && (link == LinkState::Up || !state.is_vessel_loss_told)
                {
                    tracing::info!("boat: {}", link_state_text(link));
                    state.is_vessel_loss_told &= link != LinkState::Up;
                }
                let before = self.publisher.newest().vessel_text;
                self.step(state, Input::VesselTelemetry(telemetry));
                let said = self.publisher.newest().vessel_text;
                if let Some((text, _)) = said.filter(|_| said != before) {
                    tracing::info!("the boat says: {text}");
                }
            }
            LinkReport::NotReached(reason) => {
                tracing::warn!("the boat is not reached ({reason}); trying on");
            }
            // A port that is refused repeatedly is reported once.
            LinkReport::Lost { reason, may_be_turning } => {
                if may_be_turning {
                    self.publisher.set_boat_may_move(self.events.now());
                }
                if !std::mem::replace(&mut state.is_vessel_loss_told, true) {
                    tracing::error!("the link to the boat was lost ({reason}); reopening it, neutral first");
                }
            }
            LinkReport::GuardLost(reason) => {
                tracing::error!(
                    "the guard of the boat is gone ({reason}); starting another one, neutral first"
                );
                self.publisher.set_boat_may_move(self.events.now());
            }
            LinkReport::HeldUp => tracing::error!("the pilot is held up: the link makes the boat neutral"),
            LinkReport::Suspended(gap) => self.on_suspension(state, gap),
            LinkReport::Stopped(_) | LinkReport::Control { .. } => {}
            LinkReport::Panicked => return Some(failed("the thread of the boat's link panicked")),
        }
        None
    }

    /// Tells the operator, on every way there is, that the camera may be turning.
    fn warn_of_turning(&mut self, text: &str) {
        tracing::error!("{text}");
        self.publisher.set_may_be_turning(text, self.events.now());
    }
}
