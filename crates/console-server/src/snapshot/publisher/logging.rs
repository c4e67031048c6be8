//! What goes from a step to the event log: changes of mode, track, link and boat, and notices.

use barrelman_pilot::vessel::gate::Said;
use barrelman_pilot::{Mode, Notice, Outcome, Refusal, VesselMode};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::vehicle_text::VehicleText;
use barrelman_vocab::{Named as _, Telemetry, Timestamp, Track, UsedEquipment};

use super::super::event_log::Level;
use super::super::vehicle::{LinkStatus, VehicleSnapshot};
use super::{Publisher, link_state_text};

impl Publisher {
    pub(super) fn log_outcome(&self, outcome: &Outcome) {
        let before = self.state.outcome.as_ref();
        let add = |level, key, text: String| self.events.add(outcome.at, level, key, text);
        if before.map(|before| before.mode) != Some(outcome.mode) {
            let level = match outcome.mode {
                Mode::Holding(_) | Mode::Stopped(_) => Level::Warning,
                _ => Level::Info,
            };
            add(level, "mode", outcome.mode.to_string());
        }
        let mode = outcome.vessel.mode;
        if before.map_or(VesselMode::Absent, |before| before.vessel.mode) != mode {
            let level = match mode {
                VesselMode::Holding(_) | VesselMode::KeepingWay(_) | VesselMode::Stopped(_) => Level::Warning,
                _ => Level::Info,
            };
            add(level, "boat", mode.to_string());
        }
        let track = track_name(outcome.track);
        if track != before.map_or("unseeded", |before| track_name(before.track)) {
            add(Level::Info, "track", format!("track: {track}"));
        }
        match &outcome.notice {
            None => {}
            Some(notice @ Notice::RequestRefused(Refusal::PictureOnly(_))) => {
                add(Level::Warning, "picture-only", notice.to_string());
            }
            Some(notice @ Notice::Going(Some(_))) => add(Level::Warning, "notice", notice.to_string()),
            Some(
                notice @ (Notice::RequestRefused(_)
                | Notice::SelectionRefused(_)
                | Notice::SelectionUnconfirmed(_)),
            ) => {
                add(Level::Warning, "refused", notice.to_string());
            }
            Some(notice) => add(Level::Info, "notice", notice.to_string()),
        }
    }

    pub(super) fn log_acceptance(&self, before: Option<Acceptance>, now: Timestamp) {
        if let Some(said) = self.state.vehicle.acceptance.filter(|said| before != Some(*said)) {
            let level = if said == Acceptance::Accepted { Level::Info } else { Level::Warning };
            self.events.add(now, level, "acceptance", said.text());
        }
    }

    pub(super) fn log_equipment(&self, mut before: UsedEquipment, telemetry: &Telemetry) {
        let Report::Equipment(used) = telemetry.report else { return };
        if let Some(change) = before.on_used(used) {
            let level = if change.before.is_some() { Level::Warning } else { Level::Info };
            self.events.add(telemetry.at, level, used.kind.key(), change.to_string());
        }
    }

    /// What the boat says: whether it takes commands, at each change, and its texts.
    pub(super) fn log_vessel(&mut self, before: &VehicleSnapshot, telemetry: &Telemetry) {
        let at = telemetry.at;
        match telemetry.report {
            Report::Acceptance(acceptance) => {
                let said = Said { acceptance, mode: self.state.vessel.drive_mode };
                let is_new = (before.acceptance, self.logged_mode) != (Some(acceptance), said.mode);
                self.logged_mode = said.mode;
                let was_ours = before.acceptance.is_some_and(|before| !before.is_elsewhere());
                match (acceptance, was_ours) {
                    _ if !is_new => {}
                    (Acceptance::Accepted, _) => {
                        self.events.add(at, Level::Info, "boat", "the boat takes commands");
                    }
                    (said_now, true) if said_now.is_elsewhere() => {
                        let text =
                            format!("the boat has left the mode in which it is steered from here; {said}");
                        self.events.add(at, Level::Warning, "boat", text);
                    }
                    _ => self.events.add(at, Level::Warning, "boat", said.to_string()),
                }
            }
            Report::Text(text) if self.texts.takes(text.as_str(), at) => {
                self.state.vessel_text = Some((text, at));
                let is_warning = text.severity() <= VehicleText::WARNING;
                let level = if is_warning { Level::Warning } else { Level::Info };
                self.events.add(at, level, "boat-says", format!("the boat says: {text}"));
            }
            _ => {}
        }
    }

    /// Logs a change of the link to the camera (`link`) or to the boat (`boat-link`).
    pub(super) fn log_link_change(&self, key: &str, before: LinkStatus, link: LinkStatus, now: Timestamp) {
        if let LinkStatus::Link(state) = link
            && before != link
        {
            let level = if state == LinkState::Up { Level::Info } else { Level::Warning };
            let whose = if key == "boat-link" { "boat: " } else { "" };
            self.events.add(now, level, key, format!("{whose}{}", link_state_text(state)));
        }
    }
}

const fn track_name(track: Track) -> &'static str {
    match track {
        Track::Unseeded => "unseeded",
        Track::Tracking(_) => "tracking",
        Track::Coasting(_) => "coasting",
        Track::Lost { .. } => "lost",
    }
}
