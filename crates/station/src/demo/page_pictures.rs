//! The pictures of a demo's page: frames with the overlay, as JPEG, on a thread of its own.
//!
//! Only the newest frame is rendered, and only while there is a viewer. The drive never waits for the thread.

use std::time::Duration;

use barrelman_host::latest::Latest;
use barrelman_overlay::{Overlay, Scene};
use barrelman_pilot::Outcome;
use barrelman_vocab::{Picture, VehicleRates, VideoFrame};
use bytes::Bytes;

use super::jpeg;
use super::page::PageState;

/// Interval at which the thread looks for a viewer.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A frame with its outcome.
pub struct AnnotatedFrame {
    /// The frame.
    pub frame: VideoFrame,
    /// The outcome of its step.
    pub outcome: Outcome,
    /// The rates that were sent, in the vehicle's own signs.
    pub rates: VehicleRates,
}

/// Renders the newest frame for the page until the slot is closed.
pub fn render_page_pictures(frames: &Latest<AnnotatedFrame>, page: &PageState) {
    let mut overlay = Overlay::new();
    let mut picture: Option<Picture> = None;
    while let Some(annotated) = frames.wait_until_wanted(POLL_INTERVAL, || page.has_viewer()) {
        let AnnotatedFrame { frame, outcome, rates } = annotated;
        let Some(scene) = Scene::of_outcome(&outcome) else { continue };
        let scene = Scene { rates: Some(rates), ..scene };
        let picture =
            picture.get_or_insert_with(|| Picture::black(frame.picture.size(), frame.picture.colour()));
        overlay.draw(&frame, &scene, picture);
        match jpeg::encode(picture) {
            Ok(bytes) => page.set_picture(Bytes::from(bytes)),
            Err(error) => tracing::error!("the page's picture cannot be encoded: {error}"),
        }
    }
}
