//! A drill that goes on: what the page shows of it, and its result.

use anyhow::Result;
use barrelman_experiments::drill::{DrillJudge, DrillResult, DrillState};
use barrelman_experiments::drive::{Drive, DriveSetup};
use barrelman_vocab::OperatorRequest;

/// A drill that goes on, or is over.
#[derive(Debug)]
pub(super) struct Drill {
    judge: DrillJudge,
    /// The result, once the drill is over.
    result: Option<DrillResult>,
}

impl Drill {
    pub(super) const fn new(judge: DrillJudge) -> Self {
        Self { judge, result: None }
    }

    /// Whether the drill has begun: before, ticks are not paced.
    pub(super) const fn has_begun(&self) -> bool {
        self.judge.has_begun()
    }

    pub(super) const fn on_request(&mut self, request: &OperatorRequest) {
        self.judge.on_request(request);
    }

    /// The drive made a tick. Returns whether the drill has just ended.
    ///
    /// # Errors
    /// The worlds to compare with cannot be made.
    pub(super) fn after_tick(&mut self, drive: &Drive<'_>, setup: &DriveSetup) -> Result<bool> {
        if self.result.is_some() {
            return Ok(false);
        }
        self.judge.after_tick(drive);
        if !self.judge.is_over() {
            return Ok(false);
        }
        let result = self.judge.result(drive, setup)?;
        tracing::info!("drill {}: {}", if result.passed { "passed" } else { "not passed" }, result.sentence);
        self.result = Some(result);
        Ok(true)
    }

    /// What the page shows.
    pub(super) fn state(&self) -> DrillState {
        self.judge.state(self.result.clone())
    }
}
