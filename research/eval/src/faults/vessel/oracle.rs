//! The rule of a boat, judged apart from the program.
//!
//! - **On the wire** a packet that tells the boat to move is sent at most 300 ms after the last moment that
//!   permitted motion. That is, with the guidance, the arrival of a fresh localisation while the operator's
//!   consent lasts and a destination is marked; by hand, the arrival of fresh video while the helm was
//!   renewed within half a second.
//! - **A console that is gone**: at most 1.3 s with the guidance, and 0.8 s by hand, from when the page was
//!   gone.
//! - **At the boat** the command in force is neutral when the neutral packet has arrived, where line and
//!   guard were whole since the last permitted moment. Where they were not, the boat's own time-out is the
//!   limit, whatever else is gone.
//! - **Way that is kept**, where the profile says so: the guidance of a boat that is not seen any more
//!   permits motion for the profile's time beyond the 250 ms of its last command, while consent, destination
//!   and link last, and the program runs. Longer than the limit on the wire after the last fresh
//!   localisation, the command at the boat is no more than the profile's throttle, amidships.
//! - **A guard that hangs** permits no motion: the time to neutral at the boat counts from the beginning of
//!   the hang, where a new guard can speak at once. A boat that has to be heard first has its own time-out,
//!   as after the death of a guard.
//! - After a suspension, times count from the end of it: the clock stood still.
//! - Consent to the guidance ends by each stop, by a boat that another commander took, by a console that is
//!   gone, and by a wait for the boat of more than 5 s.
//! - Consent by hand ends by each stop, by a boat that takes no commands, and by a lost link: until the helm
//!   is pressed anew.

use barrelman_vocab::{FailSafe, VesselCommand};

use super::super::permitted::Permitted;

/// A packet after the last permitted moment, ms.
pub(crate) const WIRE_LIMIT_MS: u64 = 300;
/// A packet after the console was gone, with the guidance, ms.
const CONSOLE_LIMIT_MS: u64 = 1_300;
/// A packet after the console was gone, by hand, ms.
const HELM_LIMIT_MS: u64 = 800;
/// The time of a packet on the line, and the millisecond in which the boat takes it, ms.
const ON_THE_LINE_MS: u64 = 4;
/// A helm permits motion for this time, ms.
const HELM_LASTS_MS: u64 = 500;
/// Consent to the guidance ends without a boat in the picture for this time, ms: 5 s after the command has
/// ended.
const CONSENT_LASTS_MS: u64 = 5_000 + WIRE_LIMIT_MS;
/// The console's silence ends the consent to the guidance after this time, ms.
const CONSOLE_LASTS_MS: u64 = 1_000;

/// The guidance's last command lasts for this time, ms.
const GUIDED_LASTS_MS: u64 = 250;
/// A throttle on the line is rounded by less than this.
const ROUNDING: f64 = 0.01;
/// The name of way that was kept, among the licences.
pub(crate) const KEEPS_WAY: &str = "keeping way";

/// What the operator lets the boat move by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum VesselLicence {
    Guided,
    ByHand,
}

impl VesselLicence {
    /// Every licence.
    pub(crate) const ALL: [Self; 2] = [Self::Guided, Self::ByHand];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Guided => "guided",
            Self::ByHand => "by hand",
        }
    }
}

/// What a video frame that arrived showed.
#[derive(Debug, Clone, Copy)]
pub(super) struct VideoArrival {
    /// Whether the video frame was new.
    pub(super) is_fresh: bool,
    /// Whether the boat was found in it.
    pub(super) is_boat_found: bool,
}

/// The judge of one run.
#[derive(Debug)]
pub(super) struct VesselOracle {
    /// The longest time of motion at a boat that hears nothing any more, from the last permitted moment, ms.
    own_limit_ms: u64,
    fail_safe: FailSafe,
    /// The last moment at which way could be kept, ms.
    way_ms: Option<u64>,
    /// Whether something ended the way since the last fresh localisation.
    has_way_ended: bool,
    has_kept_way: bool,
    consent: Option<VesselLicence>,
    has_destination: bool,
    /// The last fresh localisation while the consent to the guidance lasts, ms.
    boat_seen_ms: u64,
    helm_ms: Option<u64>,
    video_ms: Option<u64>,
    permitted: Permitted,
    /// The end of the last suspension: the clock of every time to live stood still before it, ms.
    resumed_ms: u64,
    /// The beginning of the last hang of a guard, ms.
    hung_ms: u64,
    console_gone_ms: Option<u64>,
    /// When line and guard were last not whole, ms.
    disturbed_ms: Option<u64>,
    /// On the wire, after the console was gone, at the boat.
    worst_ms: [u64; 3],
    moved: Vec<VesselLicence>,
    violation: Option<(u64, String)>,
}

impl VesselOracle {
    pub(super) const fn new(own_limit_ms: u64, fail_safe: FailSafe) -> Self {
        Self {
            own_limit_ms,
            fail_safe,
            way_ms: None,
            has_way_ended: false,
            has_kept_way: false,
            consent: None,
            has_destination: false,
            boat_seen_ms: 0,
            helm_ms: None,
            video_ms: None,
            permitted: Permitted::new(),
            resumed_ms: 0,
            hung_ms: 0,
            console_gone_ms: None,
            disturbed_ms: None,
            worst_ms: [0; 3],
            moved: Vec::new(),
            violation: None,
        }
    }

    /// The program runs: way can be kept now, or not.
    pub(super) fn program_runs(&mut self, at_ms: u64) {
        if let (FailSafe::KeepWay(keep), Some(permitted_ms)) = (self.fail_safe, self.permitted.heard_ms())
            && self.consent == Some(VesselLicence::Guided)
            && self.has_destination
            && !self.has_way_ended
            && at_ms <= permitted_ms + GUIDED_LASTS_MS + keep.lasts.as_millis() as u64
        {
            self.way_ms = Some(at_ms);
        }
    }

    /// The link is not up: the way ends, and does not begin again.
    pub(super) const fn end_way(&mut self) {
        self.has_way_ended = true;
    }

    /// The last moment that permitted motion, ms; `None`: there was none.
    fn last_permitted_ms(&self) -> Option<u64> {
        self.permitted.heard_ms().map(|permitted_ms| permitted_ms.max(self.way_ms.unwrap_or(0)))
    }

    /// The operator presses Go, or takes the helm.
    pub(super) const fn consent(&mut self, licence: VesselLicence, at_ms: u64) {
        self.consent = Some(licence);
        self.boat_seen_ms = at_ms;
    }

    /// The consent ends.
    pub(super) const fn withdraw(&mut self) {
        self.consent = None;
    }

    /// The consent to the guidance ends; a helm is the operator's.
    pub(super) fn withdraw_guidance(&mut self) {
        self.consent = self.consent.filter(|licence| *licence != VesselLicence::Guided);
    }

    /// The consent by hand ends until the helm is pressed again; that to the guidance lasts.
    pub(super) fn withdraw_helm(&mut self) {
        self.consent = self.consent.filter(|licence| *licence != VesselLicence::ByHand);
    }

    /// A destination is marked, or no more.
    pub(super) const fn set_destination(&mut self, is_marked: bool) {
        self.has_destination = is_marked;
    }

    /// The page that controls is there, or has been gone since.
    pub(super) fn set_console(&mut self, gone_since_ms: Option<u64>, at_ms: u64) {
        self.console_gone_ms = gone_since_ms;
        if gone_since_ms.is_some_and(|since| at_ms > since + CONSOLE_LASTS_MS) {
            self.withdraw_guidance();
        }
    }

    /// A suspension has ended.
    pub(super) const fn resume(&mut self, at_ms: u64) {
        self.resumed_ms = at_ms;
    }

    /// A guard begins to hang, or is killed.
    pub(super) const fn strike_guard(&mut self, at_ms: u64) {
        self.hung_ms = at_ms;
    }

    /// Whether a guard carries out what the program asks for.
    pub(super) fn set_live_guard(&mut self, is_live: bool) {
        self.permitted.set_live_guard(is_live);
    }

    /// Line or guard are not whole.
    pub(super) const fn disturb(&mut self, at_ms: u64) {
        self.disturbed_ms = Some(at_ms);
    }

    /// The helm was renewed.
    pub(super) fn steered(&mut self, at_ms: u64) {
        self.helm_ms = Some(at_ms);
        if let (Some(VesselLicence::ByHand), Some(video_ms)) = (self.consent, self.video_ms)
            && self.permitted.newest_ms() < Some(video_ms)
        {
            self.permitted.permit(video_ms);
        }
    }

    /// A video frame arrived.
    pub(super) fn saw(&mut self, arrival: VideoArrival, at_ms: u64) {
        if !arrival.is_fresh {
            return;
        }
        self.video_ms = Some(at_ms);
        match self.consent {
            Some(VesselLicence::Guided) if at_ms > self.boat_seen_ms + CONSENT_LASTS_MS => self.withdraw(),
            Some(VesselLicence::Guided) if arrival.is_boat_found => {
                self.boat_seen_ms = at_ms;
                if self.has_destination {
                    self.permitted.permit(at_ms);
                    self.has_way_ended = false;
                }
            }
            Some(VesselLicence::ByHand) if self.helm_ms.is_some_and(|helm| at_ms <= helm + HELM_LASTS_MS) => {
                self.permitted.permit(at_ms);
            }
            _ => {}
        }
    }

    fn violates(&mut self, at_ms: u64, text: String) {
        self.violation.get_or_insert((at_ms, text));
    }

    /// A packet that tells the boat to move was sent.
    pub(super) fn sent_motion(&mut self, at_ms: u64) {
        let Some(permitted_ms) = self.last_permitted_ms() else {
            return self.violates(at_ms, "a command without ever an engagement of the boat".to_owned());
        };
        let since_ms = at_ms.saturating_sub(permitted_ms.max(self.resumed_ms));
        self.worst_ms[0] = self.worst_ms[0].max(since_ms);
        if since_ms > WIRE_LIMIT_MS {
            self.violates(at_ms, format!("a command {since_ms} ms after the last moment that permitted it"));
        }
        if let Some(gone_ms) = self.console_gone_ms {
            let since_ms = at_ms.saturating_sub(gone_ms.max(self.resumed_ms));
            self.worst_ms[1] = self.worst_ms[1].max(since_ms);
            let is_by_hand = self.consent == Some(VesselLicence::ByHand);
            let limit_ms = if is_by_hand { HELM_LIMIT_MS } else { CONSOLE_LIMIT_MS };
            if since_ms > limit_ms {
                self.violates(at_ms, format!("a command {since_ms} ms after the console was gone"));
            }
        }
    }

    /// Judges a millisecond of the boat.
    pub(super) fn judge(&mut self, at_ms: u64, command: VesselCommand) {
        if command.is_neutral() {
            return;
        }
        self.judge_way(at_ms, command);
        if let Some(licence) = self.consent
            && !self.moved.contains(&licence)
        {
            self.moved.push(licence);
        }
        let Some(permitted_ms) = self.last_permitted_ms() else {
            return self.violates(at_ms, "moves without ever an engagement of the boat".to_owned());
        };
        let since_ms = at_ms.saturating_sub(permitted_ms.max(self.resumed_ms).max(self.hung_ms));
        self.worst_ms[2] = self.worst_ms[2].max(since_ms);
        let is_whole = self.disturbed_ms.is_none_or(|disturbed| disturbed < permitted_ms);
        let limit_ms = if is_whole { WIRE_LIMIT_MS + ON_THE_LINE_MS } else { self.own_limit_ms };
        if since_ms > limit_ms {
            self.violates(
                at_ms,
                format!("still moves {since_ms} ms after the last moment that permitted it"),
            );
        }
    }

    /// Way that is kept is slow, and amidships.
    fn judge_way(&mut self, at_ms: u64, command: VesselCommand) {
        let (FailSafe::KeepWay(keep), Some(fresh_ms)) = (self.fail_safe, self.permitted.heard_ms()) else {
            return;
        };
        let is_whole = self.disturbed_ms.is_none_or(|disturbed| disturbed < fresh_ms);
        let counted_ms = fresh_ms.max(self.resumed_ms).max(self.hung_ms);
        let is_kept = at_ms > counted_ms + WIRE_LIMIT_MS + ON_THE_LINE_MS;
        if !(is_whole && is_kept && self.consent == Some(VesselLicence::Guided)) {
            return;
        }
        self.has_kept_way = true;
        if !(0.0..=keep.throttle + ROUNDING).contains(&command.throttle) || command.rudder != 0.0 {
            self.violates(at_ms, format!("keeps way with {command:?}"));
        }
    }

    /// A command came to a boat that another commander has steered for this time.
    pub(super) fn meddles(&mut self, at_ms: u64, after_ms: u64) {
        self.violates(at_ms, format!("commands a boat that another commander has steered for {after_ms} ms"));
    }

    /// The longest times to neutral: on the wire, after the console was gone, at the boat, ms.
    pub(super) const fn worst_ms(&self) -> [u64; 3] {
        self.worst_ms
    }

    /// The licences with which the boat moved, and whether it kept way.
    pub(super) fn moved(&self) -> Vec<&'static str> {
        let licences = self.moved.iter().map(|licence| licence.name());
        licences.chain(self.has_kept_way.then_some(KEEPS_WAY)).collect()
    }

    /// The first violation of the rule: when, and how.
    pub(super) const fn violation(&self) -> Option<&(u64, String)> {
        self.violation.as_ref()
    }
}
