//! The way from a pad to units, through whatever demultiplexers, parsers and decoders `decodebin` finds.

use std::sync::Arc;

use barrelman_media_protocol::failure::SourceFailure;
use gst::prelude::*;
use gstreamer as gst;

use super::failure::{self, unlinked};
use super::play::{Play, Way};
use super::units;

/// Largest number of bytes that wait between a demultiplexer and its streams.
const QUEUED_BYTES: u32 = 8 << 20;

/// Compressed video that is passed on as it is.
const KEPT: &str = "video/x-h264; video/x-h265; video/x-vp9; video/x-av1; image/jpeg";

/// Leads whatever comes out of a pad through `decodebin` to units.
pub(super) fn decode(play: &Arc<Play>, pad: &gst::Pad, way: &Way) -> Result<(), SourceFailure> {
    let decode = decodebin(play, way)?;
    let sink = decode.static_pad("sink").ok_or_else(|| unlinked("decodebin has no sink"))?;
    pad.link(&sink).map_err(unlinked)?;
    decode.sync_state_with_parent().map_err(unlinked)
}

fn decodebin(play: &Arc<Play>, way: &Way) -> Result<gst::Element, SourceFailure> {
    let decode = play.add("decodebin")?;
    let mut kept: gst::Caps = KEPT.parse().map_err(unlinked)?;
    kept.make_mut().append(gst::Caps::builder("video/x-raw").any_features().build());
    decode.set_property("caps", &kept);
    decode.set_property("max-size-bytes", QUEUED_BYTES);
    // What is no video is left as it is, so that no decoder of it is looked for.
    decode.connect("autoplug-continue", false, |arguments| {
        let caps: gst::Caps = arguments.get(2)?.get().ok()?;
        let name = caps.structure(0)?.name();
        let is_other = ["audio/", "text/", "subpicture/", "closedcaption/"];
        Some((!is_other.iter().any(|prefix| name.starts_with(prefix))).to_value())
    });
    if let Some(bin) = decode.downcast_ref::<gst::Bin>() {
        bin.connect_element_added(|_, element| set_up(element));
    }
    let (weak, way) = (Arc::downgrade(play), way.clone());
    decode.connect_pad_added(move |_, pad| {
        if let Some(play) = weak.upgrade() {
            take(&play, pad, &way);
        }
    });
    let weak = Arc::downgrade(play);
    decode.connect_no_more_pads(move |_| {
        if let Some(play) = weak.upgrade()
            && !play.has_video()
        {
            play.outbox.fail(failure::permanent("has no video", "Give the address of a video"));
        }
    });
    Ok(decode)
}

/// Sets the properties of an element that `decodebin` has found.
fn set_up(element: &gst::Element) {
    // Otherwise the demultiplexer expects further streams, and `decodebin` shows none of them until its queue
    // is full.
    if is_multipart(element) {
        element.set_property("single-stream", true);
    }
}

/// Whether an element takes parts from a multipart stream (HTTP: `multipart/x-mixed-replace`).
pub(super) fn is_multipart(element: &gst::Element) -> bool {
    element.factory().is_some_and(|factory| factory.name() == "multipartdemux")
}

/// Whether an element fetches a video in segments (HLS, DASH).
pub(super) fn is_in_segments(element: &gst::Element) -> bool {
    let is_adaptive = |class: &str| class.contains("Adaptive");
    element.factory().is_some_and(|factory| factory.metadata("klass").is_some_and(is_adaptive))
}

/// Takes the stream of a pad, if it is the first video.
pub(super) fn take(play: &Arc<Play>, pad: &gst::Pad, way: &Way) {
    let caps = pad.current_caps().unwrap_or_else(|| pad.query_caps(None));
    let Some(name) = caps.structure(0).map(|structure| structure.name().to_string()) else { return };
    if !(name.starts_with("video/") || name == "image/jpeg") {
        return;
    }
    if !play.takes_video()
        && let Err(failure) = units::attach(play, pad, &name, way)
    {
        play.outbox.fail(failure);
    }
}
