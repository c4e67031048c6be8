//! The moments at which pictures were taken, from the thread `world` to the thread `render`.

use std::sync::atomic::{AtomicBool, Ordering};

use barrelman_host::latest::Latest;
use barrelman_sim::World;
use barrelman_sim::video_link::Delivery;

/// A moment at which a picture was taken.
pub(super) struct Moment {
    /// The world at that moment.
    pub(super) world: World,
    /// What the video link does with the picture.
    pub(super) delivery: Delivery,
}

/// The newest moment at which a picture was taken, and whether a thread failed.
#[derive(Default)]
pub(super) struct Moments {
    pub(super) newest: Latest<Moment>,
    failed: AtomicBool,
}

impl Moments {
    /// No further picture will be taken.
    pub(super) fn close(&self, failed: bool) {
        self.failed.fetch_or(failed, Ordering::SeqCst);
        self.newest.close();
    }

    /// Whether a thread panicked or could not be started.
    pub(super) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::SeqCst)
    }
}
