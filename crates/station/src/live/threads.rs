//! Threads whose panics become events, and deliberate faults in them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;

use barrelman_vocab::Timestamp;

use super::event::Event;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// Starts a named thread. A panic in the thread sends [`Event::ThreadPanicked`].
///
/// # Errors
/// If the system has no more threads.
pub fn spawn(
    name: &str,
    events: SyncSender<Event>,
    work: impl FnOnce() + Send + 'static,
) -> std::io::Result<JoinHandle<()>> {
    let thread = name.to_owned();
    std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        if catch_unwind(AssertUnwindSafe(work)).is_err() {
            // Without a receiver, the run is ending already.
            let _ = events.send(Event::ThreadPanicked { thread });
        }
    })
}

/// Deliberate faults of the program's own threads, to test that each fault ends in zeros.
#[derive(Debug, Clone, Default)]
pub struct FaultInjector {
    plans: Vec<(String, FaultPlan)>,
}

/// The threads that `--fault` applies to. Faults of the video and the link are part of their URLs.
pub const FAULT_THREADS: [&str; 5] = ["pilot", "recorder", "overlay", "terminal", "status"];

impl FaultInjector {
    /// Parses texts of the form `THREAD:panic@SECONDS` or `THREAD:stall@SECONDS+DURATION`.
    ///
    /// # Errors
    /// If a thread or a fault is unknown.
    pub fn parse(texts: &[String]) -> anyhow::Result<Self> {
        let mut plans = Vec::new();
        for text in texts {
            let (thread, plan) =
                text.split_once(':').filter(|(thread, _)| FAULT_THREADS.contains(thread)).ok_or_else(|| {
                    anyhow::anyhow!("{text:?}: use THREAD:panic@SECONDS or THREAD:stall@SECONDS+DURATION with one of {FAULT_THREADS:?}")
                })?;
            plans.push((thread.to_owned(), FaultPlan::parse(plan)?));
        }
        Ok(Self { plans })
    }

    /// Panics or sleeps, if a fault of this thread is active at `now`.
    pub fn apply_faults(&self, thread: &str, now: Timestamp) {
        let since_start = now.since(Timestamp::ZERO);
        let plans = self.plans.iter().filter(|(name, _)| name == thread);
        let stalls = plans.flat_map(|(_, plan)| plan.faults()).filter(|fault| fault.kind == FaultKind::Stall);
        let ends = stalls.filter_map(|fault| Some((fault.start, fault.start + fault.duration?)));
        if let Some((_, end)) = ends.into_iter().find(|(from, end)| (*from..*end).contains(&since_start)) {
            std::thread::sleep(end - since_start);
        }
        let panics =
            |(name, plan): &(String, FaultPlan)| name == thread && plan.is_active(FaultKind::Panic, now);
        #[allow(clippy::panic, reason = "requested on the command line, to test the stops")]
        if self.plans.iter().any(panics) {
            panic!("the {thread} thread panics on purpose");
        }
    }
}
