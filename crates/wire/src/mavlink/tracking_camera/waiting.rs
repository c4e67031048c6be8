//! Track commands that wait for the operator gateway's answer, and those that were answered a moment ago.
//!
//! A ground station that has not heard an acknowledgement sends its command again. A repeated selection must
//! not select again: the target has moved on since. A command that stops the tracking is taken each time.

use core::time::Duration;

use barrelman_vocab::Timestamp;
use mavlink::dialects::common::MavResult;

use super::command::Command;
use super::request::RequestNumber;
use super::times::ANSWER_WITHIN;

/// Within this time the same command of the same sender is the same request. Ground stations repeat after 0.5
/// to 3 s; an operator needs longer to draw the same box to the bit.
const REPEATED_WITHIN: Duration = Duration::from_secs(4);
/// Largest number of commands that are kept.
const CAPACITY: usize = 8;

/// Track commands of the last seconds.
#[derive(Debug, Default)]
pub(super) struct WaitingCommands {
    commands: Vec<WaitingCommand>,
    numbers: u32,
}

#[derive(Debug)]
struct WaitingCommand {
    number: RequestNumber,
    command: Command,
    asked_at: Timestamp,
    /// What the ground station was told; `None`: nothing yet.
    result: Option<MavResult>,
}

impl WaitingCommands {
    /// Whether a selection repeats the newest one, which was not refused: `Some` with what the ground station
    /// was told, if it was.
    pub(super) fn repeated(&self, command: &Command, now: Timestamp) -> Option<Option<MavResult>> {
        let newest = self.commands.last()?;
        let is_in_force = matches!(newest.result, None | Some(MavResult::MAV_RESULT_ACCEPTED));
        let is_repeated = newest.command.repeats(command) && now.since(newest.asked_at) < REPEATED_WITHIN;
        (is_in_force && is_repeated).then_some(newest.result)
    }

    /// Whether the commands that wait are too many for another selection.
    pub(super) fn is_full(&self) -> bool {
        self.next_due().is_some() && self.commands.len() >= CAPACITY
    }

    /// Keeps a command until it is answered. The oldest one gives way.
    pub(super) fn add(&mut self, command: Command, now: Timestamp) -> RequestNumber {
        self.commands.retain(|waiting| waiting.result.is_none());
        if self.commands.len() >= CAPACITY {
            self.commands.remove(0);
        }
        self.numbers = self.numbers.wrapping_add(1);
        let number = RequestNumber(self.numbers);
        self.commands.push(WaitingCommand { number, command, asked_at: now, result: None });
        number
    }

    /// The gateway has answered. Returns the command, if the ground station was not told anything yet.
    pub(super) fn answered(&mut self, number: RequestNumber, result: MavResult) -> Option<Command> {
        let waiting = self.commands.iter_mut().find(|waiting| waiting.number == number)?;
        let was_told = waiting.result.replace(result).is_some();
        (!was_told).then_some(waiting.command)
    }

    /// The commands whose ground station has waited long enough. Each is returned once.
    pub(super) fn overdue(&mut self, now: Timestamp) -> Vec<Command> {
        let mut overdue = Vec::new();
        for waiting in &mut self.commands {
            if waiting.result.is_none() && waiting.asked_at.plus(ANSWER_WITHIN) <= now {
                waiting.result = Some(MavResult::MAV_RESULT_ACCEPTED);
                overdue.push(waiting.command);
            }
        }
        overdue
    }

    /// When the next command is overdue.
    pub(super) fn next_due(&self) -> Option<Timestamp> {
        let unanswered = self.commands.iter().filter(|waiting| waiting.result.is_none());
        unanswered.map(|waiting| waiting.asked_at.plus(ANSWER_WITHIN)).min()
    }
}
