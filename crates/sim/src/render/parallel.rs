//! Work in parallel without threads of our own: the caller says who does it.

/// Whoever does pieces of work, at once or one after the other.
pub trait ParallelFor {
    /// Calls `work` once for every number below `count`, in any order, on any thread, and returns when all are done.
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync));
}

/// One after the other, on the caller's thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct Serial;

impl ParallelFor for Serial {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        (0..count).for_each(work);
    }
}
