//! What the operator does: engages the camera, marks a place, presses Go or holds the helm, and does what the
//! faults of the operator and of the page are.

use barrelman_vocab::{
    CameraRequest, OperatorRequest, StopCause, Timestamp, VesselCommand, VesselRequest, VesselStopper,
};

use super::super::fault::{self, Fault, FaultKind};
use super::super::mutant::Mutant;
use super::console::SIGN_INTERVAL_MS;
use super::oracle::{VesselLicence, VesselOracle};
use super::program::VesselProgram;

const ENGAGES_CAMERA_AT_MS: u64 = 1_500;
const MARKS_AT_MS: u64 = 2_000;
const ENGAGES_AT_MS: u64 = 3_000;
/// A second Go, for a boat that was asked for GUIDED by the first, ms.
const GO_AGAIN_MS: u64 = 600;
/// The operator engages again this long after the faults, in half of the runs, ms.
const ENGAGES_AGAIN_MS: u64 = 1_000;
/// From letting the helm go to the next press, ms.
const PRESSES_AGAIN_MS: u64 = 300;
/// A helm that is held is renewed at this interval, ms.
const HELM_INTERVAL_MS: u64 = 100;

/// What the operator does in a run.
pub(super) struct Script {
    /// `None`: the boat is never engaged.
    pub(super) licence: Option<VesselLicence>,
    pub(super) engages_again: bool,
    pub(super) mutant: Mutant,
    pub(super) is_helm_held: bool,
}

/// What the operator has before them.
pub(super) struct Desk<'a> {
    pub(super) program: &'a mut VesselProgram,
    pub(super) oracle: &'a mut VesselOracle,
    pub(super) faults: &'a [Fault],
    pub(super) now: Timestamp,
    pub(super) at_ms: u64,
}

impl Desk<'_> {
    fn begins(&self, kind: FaultKind) -> bool {
        self.faults.iter().any(|fault| fault.begins(kind, self.at_ms))
    }

    fn ends(&self, kind: FaultKind) -> bool {
        self.faults.iter().any(|fault| fault.ends(kind, self.at_ms))
    }

    /// Since when the page that controls has been gone, ms.
    fn gone_since_ms(&self) -> Option<u64> {
        let is_of_page = |fault: &&Fault| {
            matches!(fault.kind, FaultKind::ConsoleClosed | FaultKind::ConsoleSilent)
                && fault.is_active(self.at_ms)
        };
        self.faults.iter().filter(is_of_page).map(|fault| fault.from_ms).min()
    }

    fn ask(&mut self, request: OperatorRequest) {
        self.program.request(request, self.now);
    }

    fn mark(&mut self) {
        let is_marked = self.program.mark(self.now);
        self.oracle.set_destination(is_marked);
    }
}

impl Script {
    /// Lets the operator act for a millisecond.
    pub(super) fn act(&mut self, desk: &mut Desk<'_>) {
        let at_ms = desk.at_ms;
        let gone_since_ms = desk.gone_since_ms();
        desk.oracle.set_console(gone_since_ms, at_ms);
        if gone_since_ms.is_none() && at_ms.is_multiple_of(SIGN_INTERVAL_MS) {
            desk.program.console.hear(desk.now);
        }
        if at_ms == ENGAGES_CAMERA_AT_MS {
            desk.ask(OperatorRequest::Camera(CameraRequest::Engage));
        }
        if at_ms == MARKS_AT_MS || desk.ends(FaultKind::MarkRemoved) {
            desk.mark();
        }
        if desk.begins(FaultKind::ConsoleClosed) {
            // A page that is closed holds no helm, and cannot say so.
            self.is_helm_held = false;
        }
        self.act_by_faults(desk);
        if gone_since_ms.is_none() {
            let ends_ms = fault::last_end_ms(desk.faults);
            let again_ms = ends_ms + ENGAGES_AGAIN_MS;
            match self.licence {
                Some(VesselLicence::Guided) => self.guide(desk, again_ms),
                Some(VesselLicence::ByHand) => self.steer(desk, again_ms),
                None => {}
            }
        }
    }

    fn act_by_faults(&self, desk: &mut Desk<'_>) {
        if desk.begins(FaultKind::MarkRemoved) {
            desk.oracle.set_destination(false);
            desk.ask(OperatorRequest::Vessel(VesselRequest::UnmarkAll));
        }
        if desk.begins(FaultKind::TargetDeselected) {
            desk.oracle.withdraw_guidance();
            desk.ask(OperatorRequest::Camera(CameraRequest::Deselect));
        }
        if desk.begins(FaultKind::BoatReleased) {
            desk.oracle.withdraw_guidance();
            desk.ask(OperatorRequest::Vessel(VesselRequest::ReleaseVessel));
        }
        let stops = [
            (FaultKind::OperatorStops, OperatorRequest::Stop(StopCause::Operator)),
            (
                FaultKind::OperatorStopsBoat,
                OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::Operator }),
            ),
        ];
        for (kind, stop) in stops {
            if !desk.begins(kind) {
                continue;
            }
            desk.oracle.withdraw();
            desk.ask(stop);
            if self.mutant == Mutant::NoLatch {
                // A stop that does not last: the pilot goes on as if it had not been stopped.
                match self.licence {
                    Some(VesselLicence::Guided) => desk.program.go(desk.now),
                    _ => desk.ask(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand::NEUTRAL))),
                }
            }
        }
    }

    fn guide(&self, desk: &mut Desk<'_>, again_ms: u64) {
        let at_ms = desk.at_ms;
        let is_again = |ms: u64| self.engages_again && at_ms == ms;
        if is_again(again_ms) {
            desk.ask(OperatorRequest::Camera(CameraRequest::Engage));
        }
        if at_ms == ENGAGES_AT_MS
            || at_ms == ENGAGES_AT_MS + GO_AGAIN_MS
            || is_again(again_ms)
            || is_again(again_ms + GO_AGAIN_MS)
        {
            desk.oracle.consent(VesselLicence::Guided, at_ms);
            desk.program.go(desk.now);
        }
    }

    /// Holds the helm, lets it go after a stop, and presses it again; also on a page that is opened anew.
    fn steer(&mut self, desk: &mut Desk<'_>, again_ms: u64) {
        let at_ms = desk.at_ms;
        let stopped_until_ms = desk
            .faults
            .iter()
            .filter(|fault| matches!(fault.kind, FaultKind::OperatorStops | FaultKind::OperatorStopsBoat))
            .map(|fault| fault.until_ms);
        let mut let_go_ms = stopped_until_ms.chain([again_ms]);
        let mut presses = at_ms == ENGAGES_AT_MS
            || desk.faults.iter().any(|fault| {
                fault.kind == FaultKind::ConsoleClosed && at_ms == fault.until_ms + PRESSES_AGAIN_MS
            });
        if let_go_ms.any(|ms| {
            presses |= self.engages_again && at_ms == ms + PRESSES_AGAIN_MS;
            ms == at_ms
        }) {
            self.is_helm_held = false;
            desk.ask(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand::NEUTRAL)));
        }
        if presses {
            self.is_helm_held = true;
            desk.oracle.consent(VesselLicence::ByHand, at_ms);
        }
        // A page sends the press of a key at once.
        if self.is_helm_held && (presses || at_ms.is_multiple_of(HELM_INTERVAL_MS)) {
            desk.oracle.steered(at_ms);
            let rudder = if at_ms % 4_000 < 2_000 { 0.5 } else { -0.5 };
            desk.ask(OperatorRequest::Vessel(VesselRequest::Steer(VesselCommand { throttle: 0.7, rudder })));
        }
    }
}
