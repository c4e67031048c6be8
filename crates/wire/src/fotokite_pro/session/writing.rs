//! The lines that are due in each state of a session, and the states that follow from sending them.

use core::cmp::Ordering;

use barrelman_vocab::{AngularRate, Timestamp};

use super::{FotokiteProSession, State};
use crate::closing_zeros::{ClosingZeros, SWAY};
use crate::fotokite_pro::command::Command;
use crate::fotokite_pro::pacing::{ZERO_REFRESH, ZERO_REPEATS, ZERO_SPACING};
use crate::fotokite_pro::session_times::{
    OPENING_ZEROS, PROMPT_DELAY, PROMPT_REQUESTS, PROMPT_TIMEOUT, REPORT_TIMEOUT, STOP_DELAY,
    TELEMETRY_TIMEOUT, UNREST_SPACING,
};
use crate::fotokite_pro::start_up::start_up;
use crate::framing::Framing;
use crate::session::{NextAction, RestEvidence};

const UNANSWERED: NextAction = NextAction::Reopen { reason: "the ground station does not answer" };

impl FotokiteProSession {
    /// Appends the lines that are due now to `out`, and returns the worker's next action.
    pub(super) fn write_due(&mut self, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        match self.state {
            State::Stopping { next_at, .. } if now < next_at => NextAction::WaitUntil(next_at),
            State::Stopping { zeros_sent, .. } if zeros_sent <= OPENING_ZEROS => {
                self.write_opening_zeros(zeros_sent, now, out)
            }
            State::Stopping { .. } => self.request_prompt(now, out),
            State::AwaitingPrompt { until, .. } if until <= now => {
                self.state = State::Unresponsive;
                UNANSWERED
            }
            State::AwaitingPrompt { until, mut zeros_at } => {
                if zeros_at <= now {
                    self.send_zeros(out);
                    zeros_at = now.plus(ZERO_REFRESH);
                    self.state = State::AwaitingPrompt { until, zeros_at };
                }
                NextAction::WaitUntil(until.min(zeros_at))
            }
            State::Starting { next, at } => self.write_start_up(next, at, now, out),
            State::Up { since } => self.poll_up(since, now, out),
            State::Yielded { since } => match self.silent_at(since) {
                Some(at) if at <= now => self.fall_silent(),
                at => NextAction::WaitUntil(at.unwrap_or_else(|| now.plus(TELEMETRY_TIMEOUT))),
            },
            State::Closing { next_at, .. } if now < next_at => NextAction::WaitUntil(next_at),
            State::Closing { since, zeros_sent, .. } if self.needs_zeros(since, zeros_sent, now) => {
                self.write_closing_zeros(since, zeros_sent, now, out)
            }
            State::Closing { since, zeros_sent, stop_at, .. } if now < stop_at => {
                self.wait_for_stop(since, zeros_sent, stop_at, now, out)
            }
            State::Closing { .. } => {
                self.send(Command::Stop, out);
                self.state = State::Closed;
                NextAction::Closed
            }
            State::Closed => NextAction::Closed,
            State::Unresponsive => UNANSWERED,
        }
    }

    /// Sends zeros on the newly opened port, and `stop` with the last of the first ones.
    fn write_opening_zeros(&mut self, zeros_sent: u32, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        self.send_zeros(out);
        let wait = match zeros_sent.cmp(&(OPENING_ZEROS - 1)) {
            Ordering::Less => ZERO_SPACING,
            Ordering::Equal => {
                self.send(Command::Stop, out);
                ZERO_REFRESH
            }
            Ordering::Greater => PROMPT_DELAY.saturating_sub(ZERO_REFRESH),
        };
        let next_at = now.plus(wait);
        self.state = State::Stopping { zeros_sent: zeros_sent + 1, next_at };
        NextAction::WaitUntil(next_at)
    }

    /// Sends zeros once more, and requests the prompt.
    fn request_prompt(&mut self, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        self.send_zeros(out);
        for _ in 0..PROMPT_REQUESTS {
            self.send(Command::PromptRequest, out);
        }
        let (until, zeros_at) = (now.plus(PROMPT_TIMEOUT), now.plus(ZERO_REFRESH));
        self.state = State::AwaitingPrompt { until, zeros_at };
        NextAction::WaitUntil(zeros_at)
    }

    /// Sends the next line of the start-up. After the last one, the session is up.
    fn write_start_up(
        &mut self,
        next: usize,
        at: Timestamp,
        now: Timestamp,
        out: &mut Vec<u8>,
    ) -> NextAction {
        if now < at {
            return NextAction::WaitUntil(at);
        }
        let script = start_up(self.settings.telemetry_per_second);
        let Some(&(command, pause)) = script.get(next) else {
            let report_until = at.plus(REPORT_TIMEOUT);
            if !self.has_reported && now < report_until {
                return NextAction::WaitUntil(report_until);
            }
            self.state = State::Up { since: now };
            self.has_started = true;
            self.last_telemetry = None;
            self.pacing.send_zeros_first(now, encoder(self.settings.framing, out));
            return self.poll_up(now, now, out);
        };
        self.send(command, out);
        let at = now.plus(pause);
        self.state = State::Starting { next: next + 1, at };
        NextAction::WaitUntil(at)
    }

    /// Sends zeros of the shut-down.
    fn write_closing_zeros(
        &mut self,
        since: Timestamp,
        zeros_sent: u32,
        now: Timestamp,
        out: &mut Vec<u8>,
    ) -> NextAction {
        self.send_zeros(out);
        let zeros_sent = zeros_sent + 1;
        let is_burst = zeros_sent <= u32::from(ZERO_REPEATS);
        let next_at = now.plus(if is_burst { ZERO_SPACING } else { UNREST_SPACING });
        let stop_at = now.plus(STOP_DELAY);
        self.state = State::Closing { since, zeros_sent, next_at, stop_at };
        NextAction::WaitUntil(next_at)
    }

    /// The wait from the last zeros that count to `stop`. A camera that may only sway may also turn after all,
    /// and is sent zeros meanwhile as often as one under way.
    fn wait_for_stop(
        &mut self,
        since: Timestamp,
        zeros_sent: u32,
        stop_at: Timestamp,
        now: Timestamp,
        out: &mut Vec<u8>,
    ) -> NextAction {
        let RestEvidence::Moving { .. } = self.motion.since(since, now) else {
            return NextAction::WaitUntil(stop_at);
        };
        let zeros_at = stop_at.minus(STOP_DELAY).plus(ZERO_REFRESH);
        if now < zeros_at {
            return NextAction::WaitUntil(zeros_at);
        }
        self.send_zeros(out);
        self.state = State::Closing { since, zeros_sent, next_at: stop_at, stop_at };
        NextAction::WaitUntil(stop_at)
    }

    fn poll_up(&mut self, since: Timestamp, now: Timestamp, out: &mut Vec<u8>) -> NextAction {
        self.pacing.poll(now, encoder(self.settings.framing, out));
        let silent_at = self.silent_at(since);
        if silent_at.is_some_and(|at| at <= now) {
            return self.fall_silent();
        }
        let wake_at = self.pacing.wake_at();
        NextAction::WaitUntil(silent_at.map_or(wake_at, |silent_at| wake_at.min(silent_at)))
    }

    /// When a session that is up since then counts as silent.
    fn silent_at(&self, since: Timestamp) -> Option<Timestamp> {
        self.last_telemetry.map(|at| at.max(since).plus(TELEMETRY_TIMEOUT))
    }

    fn fall_silent(&mut self) -> NextAction {
        self.fell_silent = true;
        self.state = State::Unresponsive;
        UNANSWERED
    }

    /// Whether the shut-down has to send zeros once more.
    fn needs_zeros(&self, since: Timestamp, zeros_sent: u32, now: Timestamp) -> bool {
        let is_silent = self.last_heard.is_none_or(|heard| heard < since);
        ClosingZeros {
            sent: zeros_sent,
            least: self.least_zeros,
            sway: SWAY,
            evidence: self.motion.since(since, now),
            has_seen: self.motion.has_seen(),
            is_missing: is_silent && (self.needs_answer || self.last_telemetry.is_some()),
        }
        .needs_more()
    }

    pub(super) fn send_zeros(&self, out: &mut Vec<u8>) {
        self.send(Command::GimbalRest, out);
        self.send(Command::Yaw(AngularRate::ZERO), out);
    }

    pub(super) fn send(&self, command: Command, out: &mut Vec<u8>) {
        command.encode(self.settings.framing, out);
    }
}

fn encoder(framing: Framing, out: &mut Vec<u8>) -> impl FnMut(Command) {
    move |command| command.encode(framing, out)
}
