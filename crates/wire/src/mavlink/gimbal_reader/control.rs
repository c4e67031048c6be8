//! Who has the control of the gimbal: what a status and the answer to a claim say, and the reports of it.

use barrelman_vocab::mavlink::{Address, SystemId};
use barrelman_vocab::telemetry::{ControlState, Report};
use mavlink::dialects::common::{COMMAND_ACK_DATA, GIMBAL_MANAGER_STATUS_DATA, MavCmd, MavResult};

use super::{Claim, Facts, Holder, Received};

/// The control is reported again after this time, seconds.
const CONTROL_REPORT_S: f64 = 0.5;

impl Facts {
    /// Whether a command of this program to zoom was taken, or is one that the camera does not know. One that
    /// failed is sent again.
    pub(super) fn is_of_zoom(&self, answer: &COMMAND_ACK_DATA) -> bool {
        let has_failed = matches!(
            answer.result,
            MavResult::MAV_RESULT_TEMPORARILY_REJECTED
                | MavResult::MAV_RESULT_FAILED
                | MavResult::MAV_RESULT_IN_PROGRESS
                | MavResult::MAV_RESULT_CANCELLED
        );
        answer.command == MavCmd::MAV_CMD_SET_CAMERA_ZOOM && self.is_to_us(answer) && !has_failed
    }

    fn is_to_us(&self, answer: &COMMAND_ACK_DATA) -> bool {
        let to = Address::new(answer.target_system, answer.target_component);
        to == self.peers.own || to == Address::EVERYONE
    }

    pub(super) fn is_of_claim(&self, answer: &COMMAND_ACK_DATA) -> bool {
        answer.command == MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE && self.is_to_us(answer)
    }

    pub(super) fn on_status(&mut self, status: &GIMBAL_MANAGER_STATUS_DATA, each: &mut impl FnMut(Received)) {
        let primary = Address::new(status.primary_control_sysid, status.primary_control_compid);
        let holder = match primary {
            primary if primary == self.peers.own => {
                self.is_named = true;
                Holder::Us
            }
            Address { system: SystemId(0), .. } if self.is_claimed && !self.is_named => Holder::Us,
            Address { system: SystemId(0), .. } => Holder::Nobody,
            primary => Holder::Other(primary),
        };
        match holder {
            Holder::Us => self.control = Some(ControlState::Ours),
            Holder::Nobody => self.lose_control(ControlState::Unclaimed),
            Holder::Other(_) => self.lose_control(ControlState::Elsewhere),
        }
        each(Received::Holder(holder));
        self.report_control(each);
    }

    pub(super) fn lose_control(&mut self, control: ControlState) {
        (self.is_claimed, self.is_named) = (false, false);
        self.control = Some(control);
    }

    pub(super) fn on_claim_answered(&mut self, result: MavResult, each: &mut impl FnMut(Received)) {
        match result {
            MavResult::MAV_RESULT_IN_PROGRESS | MavResult::MAV_RESULT_TEMPORARILY_REJECTED => return,
            MavResult::MAV_RESULT_ACCEPTED => {
                self.is_claimed = true;
                self.control = Some(ControlState::Ours);
                each(Received::ClaimAnswered(Claim::Accepted));
            }
            _ => {
                self.lose_control(ControlState::Elsewhere);
                each(Received::ClaimAnswered(Claim::Refused));
            }
        }
        self.report_control(each);
    }

    pub(super) fn report_control(&mut self, each: &mut impl FnMut(Received)) {
        if let (Some(control), Some(uptime_s)) = (self.control, self.uptime_s) {
            self.control_reported_s = uptime_s;
            each(Received::Report(Report::Control { control, uptime_s }));
        }
    }

    /// Reports the control again now and then: a manager may send its status at changes only.
    pub(super) fn report_control_again(&mut self, each: &mut impl FnMut(Received)) {
        if self.uptime_s.is_some_and(|uptime_s| uptime_s >= self.control_reported_s + CONTROL_REPORT_S) {
            self.report_control(each);
        }
    }
}
