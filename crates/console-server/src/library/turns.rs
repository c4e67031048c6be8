//! Turns to read recordings, and the threads that read: a bounded number at a time, at the lowest priority.
//!
//! A request that waits for its turn holds no thread, and gives the turn up when its client goes.

use std::io;
use std::sync::Arc;

use barrelman_host::threads;
use tokio::sync::{Semaphore, oneshot};

/// The nice value of what reads recordings: a run comes first.
pub(super) const LEAST_PRIORITY: i32 = 19;

/// Turns of one kind of work.
#[derive(Debug)]
pub(super) struct Turns(Arc<Semaphore>);

impl Turns {
    /// `count` pieces of work at a time.
    pub(super) fn new(count: usize) -> Self {
        Self(Arc::new(Semaphore::new(count)))
    }

    /// Does the work on a thread of its own, once it is its turn. Work that has begun goes on without its
    /// client.
    ///
    /// # Errors
    /// Those of the work, and if the system has no more threads.
    pub(super) async fn work<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> io::Result<T> + Send + 'static,
    ) -> io::Result<T> {
        let turn = Arc::clone(&self.0).acquire_owned().await.map_err(io::Error::other)?;
        let (done, result) = oneshot::channel();
        let on_panic = |thread| tracing::error!("the thread {thread} panicked: a request of a page failed");
        threads::spawn("library", on_panic, move || {
            // Without a lower priority the recording is read all the same.
            let _ = rustix::process::setpriority_process(None, LEAST_PRIORITY);
            let worked = work();
            drop(turn);
            let _ = done.send(worked);
        })?;
        result
            .await
            .unwrap_or_else(|_| Err(io::Error::other("the recording cannot be read: report this fault")))
    }
}

#[cfg(test)]
mod tests {
    use std::future::Future as _;
    use std::pin::pin;
    use std::sync::mpsc::channel;
    use std::task::{Context, Waker};

    use super::*;
    use crate::in_memory::block_on;

    #[test]
    fn who_waits_for_a_turn_holds_no_thread_and_leaves_it_to_others() {
        let turns = Turns::new(1);
        let (ends, end) = channel::<()>();
        let (begins, begun) = channel();
        let working = |name: &'static str| {
            let begins = begins.clone();
            move || begins.send(name).map_err(io::Error::other)
        };
        let mut first = pin!(turns.work(move || end.recv().map_err(io::Error::other)));
        let waits = &mut Context::from_waker(Waker::noop());
        assert!(first.as_mut().poll(waits).is_pending());
        {
            let mut second = pin!(turns.work(working("second")));
            assert!(second.as_mut().poll(waits).is_pending());
        }
        let mut third = pin!(turns.work(working("third")));
        assert!(third.as_mut().poll(waits).is_pending());
        ends.send(()).unwrap();
        block_on(async {
            first.await.unwrap();
            third.await.unwrap();
        });
        assert_eq!(begun.try_iter().collect::<Vec<_>>(), ["third"]);
    }

    #[test]
    fn work_has_the_lowest_priority_and_its_failure_ends_nothing_else() {
        let turns = Turns::new(1);
        let priority = || Ok(rustix::process::getpriority_process(None)?);
        assert_eq!(block_on(turns.work(priority)).unwrap(), LEAST_PRIORITY);
        assert!(block_on(turns.work(|| -> io::Result<()> { panic!("a fault") })).is_err());
        assert!(matches!(block_on(turns.work(|| Ok(7))), Ok(7)));
    }
}
