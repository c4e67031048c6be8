//! What the log says of events that could not be sent: each failure once, until it is another one or is over.

use std::fmt::Display;

/// What became of the events of one turn.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Sent {
    /// Events that were not sent.
    pub(super) lost: u64,
    /// Why.
    pub(super) failure: Option<String>,
}

/// A line for the log.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum LogLine {
    Warning(String),
    Info(String),
}

impl LogLine {
    pub(super) fn write(self) {
        match self {
            Self::Warning(text) => tracing::warn!("{text}"),
            Self::Info(text) => tracing::info!("{text}"),
        }
    }
}

/// The failures so far.
#[derive(Debug, Default)]
pub(super) struct SendLog {
    lost: u64,
    failure: Option<String>,
}

impl SendLog {
    /// Takes what became of a turn's events. Returns what is new.
    pub(super) fn on_sent(&mut self, sent: Sent, address: &impl Display) -> Option<LogLine> {
        self.lost += sent.lost;
        if sent.failure == self.failure {
            return None;
        }
        self.failure = sent.failure;
        Some(match &self.failure {
            Some(failure) => LogLine::Warning(format!(
                "--tak {address}: {failure}; events lost so far: {}. Sending is tried again",
                self.lost
            )),
            None => LogLine::Info(format!("--tak {address}: events are sent again; {} were lost", self.lost)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_told_once_and_so_is_its_end() {
        let mut log = SendLog::default();
        let mut after = |lost, failure: Option<&str>| {
            let line = log.on_sent(Sent { lost, failure: failure.map(str::to_owned) }, &"udp://tak");
            line.map(|line| match line {
                LogLine::Warning(text) => ("warning", text),
                LogLine::Info(text) => ("info", text),
            })
        };
        assert_eq!(after(0, None), None, "all is well from the start");
        let (level, text) = after(2, Some("no route")).unwrap();
        assert!(level == "warning" && text.contains("no route; events lost so far: 2"), "{text}");
        assert_eq!(after(2, Some("no route")), None);
        let (_, text) = after(2, Some("refused")).unwrap();
        assert!(text.contains("refused; events lost so far: 6"), "{text}");
        let (level, text) = after(0, None).unwrap();
        assert!(level == "info" && text.contains("sent again; 6 were lost"), "{text}");
        assert_eq!(after(0, None), None);
    }
}
