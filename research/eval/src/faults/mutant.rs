//! What the campaign must find.

use clap::ValueEnum;

/// What is taken out of program or guard, to see that the campaign finds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Mutant {
    /// Nothing.
    None,
    /// Rates have no time to live.
    NoTimeToLive,
    /// A stop does not last.
    NoLatch,
    /// The link is a thread of the program.
    NoGuard,
    /// A guard that hangs is not replaced.
    NoGuardWatch,
    /// A pilot that was away for a second goes on.
    NoAbsenceWatch,
    /// A session does not begin with zeros.
    NoZerosFirst,
    /// The vehicle's commands last ten seconds.
    CommandsLast,
    /// A late picture counts as a fresh one.
    ForgetsDelays,
    /// A camera that turns although zero is commanded is not told.
    NoMotionWatch,
    /// A boat whose console is gone is not stopped.
    NoConsoleTimeOut,
}
