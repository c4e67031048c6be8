//! The threads that render the pictures of a simulated world.

use anyhow::{Context, Result};
use barrelman_sim::render::ParallelFor;
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};

/// Number of rendering threads.
const COUNT: usize = 2;

/// Threads that share the work of one picture. The picture does not depend on their number.
#[derive(Debug)]
pub struct RenderThreads(rayon::ThreadPool);

impl RenderThreads {
    /// Starts two threads: enough for 30 pictures per second, and few enough for a small computer.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn new() -> Result<Self> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(COUNT)
            .thread_name(|index| format!("render-{index}"))
            .build()
            .map(Self)
            .context("the rendering threads cannot be started")
    }
}

impl ParallelFor for RenderThreads {
    fn run(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| (0..count).into_par_iter().for_each(work));
    }
}
