//! Threads whose panics become events.

use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;

use barrelman_host::threads;

use super::event::{Event, report_panics};

/// Starts a named thread. A panic in the thread sends [`Event::ThreadPanicked`].
///
/// # Errors
/// If the system has no more threads.
pub fn spawn(
    name: &str,
    events: SyncSender<Event>,
    work: impl FnOnce() + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    threads::spawn(name, report_panics(events), work)
}
