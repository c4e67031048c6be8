//! The API's form of a track.

use barrelman_vocab::{PixelBox, Timestamp, Track};

use super::api::TrackStatus;

pub(super) const NO_TRACK: TrackStatus = TrackStatus {
    state: "unseeded",
    confirming: false,
    doubted: false,
    captured_ns: None,
    bounds: None,
    centre: None,
    axes: None,
    axis_deg: None,
    heading_deg: None,
    confidence: None,
    lost_s: None,
};

/// A track at a time; `confirming` and `doubted` are not known from it.
pub(super) fn track_of(track: &Track, at: Timestamp) -> TrackStatus {
    let (state, seen) = match *track {
        Track::Unseeded => return NO_TRACK,
        Track::Lost { since, confidence } => {
            let lost_s = at.since(since).as_secs_f64();
            return TrackStatus {
                state: "lost",
                confidence: Some(confidence),
                lost_s: Some(lost_s),
                ..NO_TRACK
            };
        }
        Track::Tracking(seen) => ("tracking", seen),
        Track::Coasting(seen) => ("coasting", seen),
    };
    let PixelBox { u, v, w, h } = seen.bounds;
    TrackStatus {
        state,
        confirming: false,
        doubted: false,
        captured_ns: Some(seen.captured.as_nanos()),
        bounds: Some([u, v, w, h]),
        centre: Some([seen.centre.u, seen.centre.v]),
        axes: seen.shape.map(|shape| [shape.major_px, shape.minor_px]),
        axis_deg: seen.shape.map(|shape| shape.axis.radians().to_degrees()),
        heading_deg: seen.heading.map(|heading| heading.radians().to_degrees()),
        confidence: Some(seen.confidence),
        lost_s: None,
    }
}
