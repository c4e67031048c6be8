//! Runs trials in parallel and returns their results in the order of the seeds.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

use anyhow::Result;

/// Runs `work` for each seed on `threads` threads and passes the results to `receive` in the order of the
/// seeds. When `stop` is set, or after an error, no further trial starts; running trials are finished.
///
/// # Errors
/// The first error of a trial or of `receive`; the results of the seeds before it were received.
pub fn run_in_order<R: Send>(
    seeds: &[u64],
    threads: usize,
    stop: &AtomicBool,
    work: impl Fn(u64) -> Result<R> + Sync,
    mut receive: impl FnMut(R) -> Result<()>,
) -> Result<()> {
    let next = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let (results, received) = sync_channel::<(usize, Result<R>)>(2 * threads.max(1));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, seeds.len().max(1)) {
            let (results, next, failed, work) = (results.clone(), &next, &failed, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !failed.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(seed) = seeds.get(index) else { break };
                    if results.send((index, work(*seed))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(results);
        let mut waiting = BTreeMap::new();
        let mut due = 0;
        let mut outcome = Ok(());
        for (index, result) in received {
            match result {
                Ok(result) => {
                    waiting.insert(index, result);
                }
                Err(error) => {
                    failed.store(true, Ordering::Relaxed);
                    if outcome.is_ok() {
                        outcome = Err(error);
                    }
                }
            }
            while let Some(result) = waiting.remove(&due) {
                due += 1;
                if outcome.is_ok()
                    && let Err(error) = receive(result)
                {
                    failed.store(true, Ordering::Relaxed);
                    outcome = Err(error);
                }
            }
        }
        outcome
    })
}
