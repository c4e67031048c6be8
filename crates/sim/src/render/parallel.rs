//! Parallel loops without threads of our own: the caller supplies the executor.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// An executor of independent pieces of work.
pub trait ParallelFor {
    /// Calls `work` once for each number below `count`, in any order and on any thread. Returns when all
    /// calls have returned.
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync));
}

/// Runs all work on the caller's thread, in order.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl ParallelFor for Serial {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(work);
    }
}

/// Locks a mutex and ignores poisoning: its contents are written anew for each frame.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The contents of a mutex that this thread owns; ignores poisoning as [`lock`] does.
pub(super) fn get_mut<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}
