//! The threads that draw a world's pictures.

use anyhow::{Context, Result};
use barrelman_sim::render::ParallelFor;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

/// A few threads that share the work of a picture. The picture is the same for any number of them.
#[derive(Debug)]
pub struct RenderThreads(rayon::ThreadPool);

impl RenderThreads {
    /// Two threads: what a picture at 30 per second takes, and what a small computer can spare.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn two() -> Result<Self> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(2)
            .thread_name(|index| format!("render-{index}"))
            .build()
            .map(Self)
            .context("the threads that draw cannot be started")
    }
}

impl ParallelFor for RenderThreads {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| (0..count).into_par_iter().for_each(work));
    }
}
