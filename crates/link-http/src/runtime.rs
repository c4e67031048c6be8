//! The asynchronous runtime of a port, an inquiry or a relay.

use std::io;
use std::ops::Deref;

use tokio::runtime::{Builder, Runtime};

/// A runtime of the thread that drives it. Dropping it ends its tasks, and does not wait for a name that is
/// being looked up: that takes up to half a minute, and cannot be broken off.
#[derive(Debug)]
pub(crate) struct LinkRuntime(Option<Runtime>);

impl LinkRuntime {
    pub(crate) fn new() -> io::Result<Self> {
        Builder::new_current_thread().enable_all().build().map(|runtime| Self(Some(runtime)))
    }
}

impl Deref for LinkRuntime {
    type Target = Runtime;

    fn deref(&self) -> &Runtime {
        self.0.as_ref().expect("only a drop takes the runtime")
    }
}

impl Drop for LinkRuntime {
    fn drop(&mut self) {
        if let Some(runtime) = self.0.take() {
            runtime.shutdown_background();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    /// The runtime looks names up on a thread for work that blocks.
    #[test]
    fn the_end_of_a_runtime_waits_for_no_work_that_blocks() {
        let runtime = LinkRuntime::new().unwrap();
        let (started, has_started) = channel();
        let (release, released) = channel::<()>();
        runtime.spawn_blocking(move || {
            started.send(()).unwrap();
            let _ = released.recv();
        });
        has_started.recv().unwrap();
        drop(runtime);
        drop(release);
    }

    #[test]
    fn the_end_of_a_runtime_ends_its_tasks() {
        let runtime = LinkRuntime::new().unwrap();
        let (kept, is_kept) = channel::<()>();
        runtime.spawn(async move {
            std::future::pending::<()>().await;
            drop(kept);
        });
        drop(runtime);
        assert!(is_kept.recv().is_err(), "the task is gone, with what it held");
    }
}
