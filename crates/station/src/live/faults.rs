//! Deliberate faults of the program's own threads: a wrapper of whatever a thread waits for.
//!
//! A thread takes its work from an [`Inbox`], the run loop from an [`EventSource`]. Where faults of a thread
//! are planned, the [`FaultInjector`] wraps that source: its calls panic, stall or hang, and the thread knows
//! nothing of it.

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_host::fault_lines::PlacedFaults;
use barrelman_vocab::Timestamp;

use super::event::{Event, EventSource};
use super::inbox::Inbox;

/// Deliberate faults of the program's own threads, to test that each fault ends in zeros.
#[derive(Debug, Clone, Default)]
pub struct FaultInjector {
    plans: BTreeMap<String, FaultPlan>,
    /// Suspends that were begun.
    suspended: Arc<AtomicUsize>,
}

/// The thread of the run loop.
const PILOT: &str = "pilot";
/// The thread that also suspends the process.
pub(super) const TERMINAL: &str = "terminal";
/// The thread that records.
pub(super) const RECORDER: &str = "recorder";
/// The thread of the annotated video.
pub(super) const OVERLAY: &str = "overlay";
/// The thread of the status line.
pub(super) const STATUS: &str = "status";
/// The threads that `--fault` applies to. Faults of the video and the link are part of their URLs.
pub const FAULT_THREADS: [&str; 5] = [PILOT, RECORDER, OVERLAY, TERMINAL, STATUS];
/// The place of faults of the whole process.
const PROGRAM: &str = "program";

impl FaultInjector {
    /// Parses texts of the form `THREAD:panic@SECONDS` or `THREAD:stall@SECONDS+DURATION`.
    ///
    /// # Errors
    /// If a thread or a fault is unknown.
    pub fn parse(texts: &[String]) -> anyhow::Result<Self> {
        let mut plans = BTreeMap::<_, FaultPlan>::new();
        for text in texts {
            let (thread, plan) =
                text.split_once(':').filter(|(thread, _)| FAULT_THREADS.contains(thread)).ok_or_else(|| {
                    anyhow::anyhow!("{text:?}: use THREAD:panic@SECONDS or THREAD:stall@SECONDS+DURATION with one of {FAULT_THREADS:?}")
                })?;
            plans.entry(thread.to_owned()).or_default().extend(FaultPlan::parse(plan)?);
        }
        let injector = Self { plans, ..Self::default() };
        injector.require_effect()?;
        Ok(injector)
    }

    /// Adds the plan of a place of a file of faults; a plan of another place is given back.
    ///
    /// # Errors
    /// A fault without effect there.
    pub fn add(&mut self, placed: PlacedFaults) -> anyhow::Result<Option<PlacedFaults>> {
        if !FAULT_THREADS.contains(&placed.place.as_str()) && placed.place != PROGRAM {
            return Ok(Some(placed));
        }
        self.plans.entry(placed.place).or_default().extend(placed.plan);
        self.require_effect()?;
        Ok(None)
    }

    fn require_effect(&self) -> anyhow::Result<()> {
        for (place, plan) in &self.plans {
            let (what, known): (_, &[FaultKind]) = if place == PROGRAM {
                ("the program".to_owned(), &[FaultKind::Suspend])
            } else {
                (format!("the thread {place}"), &[FaultKind::Panic, FaultKind::Stall, FaultKind::Hang])
            };
            plan.require_effect(&what, known)?;
        }
        Ok(())
    }

    /// Where a thread waits for its work, with the planned faults of the thread, if there are any.
    pub fn inbox<'a, T: 'a>(
        &self,
        thread: &'static str,
        clock: Clock,
        inbox: impl Inbox<T> + 'a,
    ) -> Box<dyn Inbox<T> + 'a> {
        if self.has_plan(thread) { Box::new(self.wrap(thread, clock, inbox)) } else { Box::new(inbox) }
    }

    /// The events of the run loop, with the planned faults of the pilot, if there are any.
    pub fn events<'a>(&self, clock: Clock, events: impl EventSource + 'a) -> Box<dyn EventSource + 'a> {
        if self.has_plan(PILOT) { Box::new(self.wrap(PILOT, clock, events)) } else { Box::new(events) }
    }

    fn has_plan(&self, thread: &str) -> bool {
        self.plans.contains_key(thread) || (thread == TERMINAL && self.plans.contains_key(PROGRAM))
    }

    fn wrap<I>(&self, thread: &'static str, clock: Clock, inner: I) -> Faulty<I> {
        Faulty { inner, injector: self.clone(), thread, clock }
    }

    /// Suspends the whole process, if that is due: a child continues the process after the duration.
    fn suspend(&self, now: Timestamp) {
        let Some(plan) = self.plans.get(PROGRAM) else { return };
        let mut due: Vec<_> =
            plan.faults().iter().filter(|fault| now >= Timestamp::ZERO.plus(fault.start)).collect();
        due.sort_by_key(|fault| fault.start);
        let Some(fault) = due.get(self.suspended.load(Ordering::Relaxed)) else { return };
        self.suspended.fetch_add(1, Ordering::Relaxed);
        let process = rustix::process::getpid();
        let seconds = fault.duration.unwrap_or(Duration::from_secs(1)).as_secs_f64();
        let command = format!("sleep {seconds}; kill -CONT {}", process.as_raw_nonzero());
        // Without the child nobody would continue the process.
        if Command::new("sh").args(["-c", &command]).spawn().is_ok() {
            let _ = rustix::process::kill_process(process, rustix::process::Signal::STOP);
        }
    }

    /// Panics or sleeps, if a fault of this thread is active at `now`.
    fn apply(&self, thread: &str, now: Timestamp) {
        if thread == TERMINAL {
            self.suspend(now);
        }
        let Some(plan) = self.plans.get(thread) else { return };
        let since_start = now.since(Timestamp::ZERO);
        let stalls = plan.faults().iter().filter(|fault| fault.kind == FaultKind::Stall);
        // Without a duration a fault lasts without end.
        let mut ends = stalls
            .map(|fault| (fault.start, fault.start.saturating_add(fault.duration.unwrap_or(Duration::MAX))));
        if let Some((_, end)) = ends.find(|(from, end)| (*from..*end).contains(&since_start)) {
            std::thread::sleep(end - since_start);
        }
        while plan.is_active(FaultKind::Hang, now) {
            std::thread::park();
        }
        #[allow(clippy::panic, reason = "requested on the command line, to test the stops")]
        if plan.is_active(FaultKind::Panic, now) {
            panic!("the {thread} thread panics on purpose");
        }
    }
}

/// What a thread waits for, with the faults of the thread.
struct Faulty<I> {
    inner: I,
    injector: FaultInjector,
    thread: &'static str,
    clock: Clock,
}

impl<I> Faulty<I> {
    fn apply(&self) {
        self.injector.apply(self.thread, self.clock.now());
    }
}

impl<T, I: Inbox<T>> Inbox<T> for Faulty<I> {
    fn next(&mut self, wait: Duration) -> Result<T, RecvTimeoutError> {
        let next = self.inner.next(wait);
        self.apply();
        next
    }
}

impl<I: EventSource> EventSource for Faulty<I> {
    fn now(&self) -> Timestamp {
        self.inner.now()
    }

    fn next_event(&mut self, wait: Duration) -> Result<Event, RecvTimeoutError> {
        self.inner.next_event(wait)
    }

    /// The first call of each turn of the loop: here the loop is held up, and sees afterwards that it was
    /// away.
    fn suspension(&mut self) -> Option<Duration> {
        self.apply();
        self.inner.suspension()
    }
}
