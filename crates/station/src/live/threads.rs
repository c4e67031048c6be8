//! Threads that cannot die unseen: a panic in one becomes an event.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;

use barrelman_vocab::Timestamp;

use super::event::Event;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// Starts a named thread; if it panics, [`Event::ThreadPanicked`] says so.
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
            // If nobody listens any more, everything is ending already.
            let _ = events.send(Event::ThreadPanicked { thread });
        }
    })
}

/// Faults that were asked for in the program's own threads, to test that each ends in zeros.
#[derive(Debug, Clone, Default)]
pub struct FaultInjector {
    plans: Vec<(String, FaultPlan)>,
}

/// The threads that can be broken on purpose by `--fault`; the video's and the link's have it in their URLs.
pub const FAULT_THREADS: [&str; 5] = ["pilot", "recorder", "overlay", "terminal", "status"];

impl FaultInjector {
    /// Reads `THREAD:panic@SECONDS` or `THREAD:stall@SECONDS+DURATION`, several times.
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

    /// Panics, or holds the thread up, if that was asked for of this thread by now.
    pub fn apply_faults(&self, thread: &str, now: Timestamp) {
        let since_start = now.since(Timestamp::ZERO);
        let plans = self.plans.iter().filter(|(name, _)| name == thread);
        let stalls = plans.flat_map(|(_, plan)| plan.faults()).filter(|fault| fault.kind == FaultKind::Stall);
        let ends = stalls.filter_map(|fault| Some((fault.start, fault.start + fault.duration?)));
        if let Some((_, end)) = ends.into_iter().find(|(from, end)| (*from..*end).contains(&since_start)) {
            std::thread::sleep(end - since_start);
        }
        let struck =
            |(name, plan): &(String, FaultPlan)| name == thread && plan.is_active(FaultKind::Panic, now);
        #[allow(clippy::panic, reason = "asked for on the command line, to test the stops")]
        if self.plans.iter().any(struck) {
            panic!("the {thread} thread panics on purpose");
        }
    }
}
