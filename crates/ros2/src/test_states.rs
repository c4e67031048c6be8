//! A state of the console, for tests.

use crate::console::api::{Link, Mode, Rates, Snapshot, Track, Video};

/// Time of capture of the newest video frame.
pub(crate) const FRAME_NS: u64 = 1_000_000_000;

/// A confirmed track.
pub(crate) fn tracking(bounds: [f64; 4], confidence: f64) -> Track {
    Track {
        state: "tracking".to_owned(),
        confirming: false,
        doubted: false,
        captured_ns: Some(FRAME_NS),
        bounds: Some(bounds),
        confidence: Some(confidence),
        lost_s: None,
    }
}

/// An engaged state with this track.
pub(crate) fn snapshot(track: Track) -> Snapshot {
    Snapshot {
        at_ns: FRAME_NS + 20_000_000,
        mode: Mode { name: "servoing".to_owned(), cause: None, engaged: true },
        track,
        command: Rates { pan: 0.25, tilt: -0.125 },
        video: Video {
            state: "up".to_owned(),
            reason: None,
            captured_ns: Some(FRAME_NS),
            age_ms: Some(20.0),
            fps: 30.0,
        },
        boat: None,
        vessel: None,
        earth: "no-position".to_owned(),
        link: Link { state: "up".to_owned(), in_control: None, battery_v: None },
        alarms: Vec::new(),
    }
}
