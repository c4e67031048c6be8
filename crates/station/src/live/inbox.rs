//! Where a thread waits for its work.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// A wait without an end.
pub(super) const FOREVER: Duration = Duration::MAX;

/// Where a thread waits for its work.
pub trait Inbox<T> {
    /// Waits for the next piece of work, at most for `wait`.
    ///
    /// # Errors
    /// `Timeout` if none came, `Disconnected` if none can come any more.
    fn next(&mut self, wait: Duration) -> Result<T, RecvTimeoutError>;
}

impl<T> Inbox<T> for Receiver<T> {
    fn next(&mut self, wait: Duration) -> Result<T, RecvTimeoutError> {
        self.recv_timeout(wait)
    }
}
