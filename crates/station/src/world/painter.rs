//! The pictures of a demo's page: frames with the overlay, as JPEG, drawn on a thread of its own.
//!
//! Only the newest frame is drawn, and only while somebody looks. The drive never waits for it.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use barrelman_pilot::Outcome;
use barrelman_vocab::{Picture, VehicleRates, VideoFrame};
use bytes::Bytes;

use super::jpeg;
use super::page::Stage;
use crate::overlay::{Overlay, Scene};

/// From one look at whether somebody has come to the next.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// A frame and what came of it.
pub struct Seen {
    /// The frame.
    pub frame: VideoFrame,
    /// What came of it.
    pub outcome: Outcome,
    /// What was sent.
    pub rates: VehicleRates,
}

/// The place for the newest frame.
#[derive(Default)]
pub struct Easel {
    newest: Mutex<Newest>,
    changed: Condvar,
}

#[derive(Default)]
struct Newest {
    seen: Option<Seen>,
    closed: bool,
}

impl Easel {
    /// Puts a frame in the place of the one before.
    pub fn put(&self, seen: Seen) {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).seen = Some(seen);
        self.changed.notify_all();
    }

    /// Nothing more will come.
    pub fn close(&self) {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        self.changed.notify_all();
    }

    /// Takes the newest frame as soon as somebody looks; `None` when nothing more will come.
    fn take(&self, stage: &Stage) -> Option<Seen> {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if newest.closed {
                return None;
            }
            if newest.seen.is_some() && stage.somebody_looks() {
                return newest.seen.take();
            }
            let (woken, _) =
                self.changed.wait_timeout(newest, LOOK_EVERY).unwrap_or_else(PoisonError::into_inner);
            newest = woken;
        }
    }
}

/// Draws until nothing more comes.
pub fn paint(easel: &Arc<Easel>, stage: &Stage) {
    let mut overlay = Overlay::new();
    let mut picture: Option<Picture> = None;
    while let Some(Seen { frame, outcome, rates }) = easel.take(stage) {
        let Some(scene) = Scene::of_outcome(&outcome) else { continue };
        let scene = Scene { rates: Some(rates), ..scene };
        let picture =
            picture.get_or_insert_with(|| Picture::black(frame.picture.size(), frame.picture.colour()));
        overlay.draw(&frame, &scene, picture);
        match jpeg::encoded(picture) {
            Ok(bytes) => stage.show(Bytes::from(bytes)),
            Err(error) => tracing::error!("no picture for the page: {error}"),
        }
    }
}
