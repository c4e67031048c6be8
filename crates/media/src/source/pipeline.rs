//! A pipeline that the user wrote, in the notation of `gst-launch-1.0`.

use std::sync::Arc;

use barrelman_media_protocol::failure::SourceFailure;
use gst::prelude::*;
use gstreamer as gst;

use super::autoplug;
use super::failure::{permanent, unlinked};
use super::play::{Play, Times, Way};

pub(super) fn open(play: &Arc<Play>, text: &str) -> Result<(), SourceFailure> {
    // Caps at the end need an element behind them.
    let with_end = || gst::parse::bin_from_description(&format!("{text} ! identity"), false);
    let parsed = gst::parse::bin_from_description(text, false).or_else(|error| with_end().map_err(|_| error));
    let bin = parsed.map_err(|error| {
        let what = format!("cannot be built: {}", error.message());
        permanent(what, "Try the same text with gst-launch-1.0, followed by ! fakesink")
    })?;
    play.pipeline.add(&bin).map_err(unlinked)?;
    let times = if play.is_live { Times::Captured } else { Times::SinceStart };
    let way = Way { name: "from a pipeline".to_owned(), times };
    if let Some(end) = bin.find_unlinked_pad(gst::PadDirection::Src) {
        autoplug::decode(play, &expose(&bin, &end)?, &way)?;
        play.start();
        return Ok(());
    }
    let has_end = await_pads(play, &bin, &way);
    if !has_end {
        return Err(permanent("has no end that video comes out of", "Leave out the sink at its end"));
    }
    play.start();
    Ok(())
}

/// Makes the pad of an inner element one of the bin.
fn expose(bin: &gst::Bin, end: &gst::Pad) -> Result<gst::Pad, SourceFailure> {
    let ghost = gst::GhostPad::with_target(end).map_err(unlinked)?;
    ghost.set_active(true).map_err(unlinked)?;
    bin.add_pad(&ghost).map_err(unlinked)?;
    Ok(ghost.upcast())
}

/// Waits for the pads of elements that have them only when they know the stream. Returns whether there are
/// such elements.
fn await_pads(play: &Arc<Play>, bin: &gst::Bin, way: &Way) -> bool {
    let mut has_some = false;
    for element in bin.children() {
        let is_late = element.pad_template_list().iter().any(|template| {
            template.presence() == gst::PadPresence::Sometimes
                && template.direction() == gst::PadDirection::Src
        });
        if !is_late {
            continue;
        }
        has_some = true;
        let (play, bin, way) = (Arc::downgrade(play), bin.downgrade(), way.clone());
        element.connect_pad_added(move |_, pad| {
            let (Some(play), Some(bin)) = (play.upgrade(), bin.upgrade()) else { return };
            let name = pad.current_caps().unwrap_or_else(|| pad.query_caps(None));
            let name = name.structure(0).map(|structure| structure.name().to_string()).unwrap_or_default();
            let is_video = name.starts_with("video/") || name.starts_with("image/");
            // A pad of RTP packets tells its media in a field; `decodebin` decides.
            if pad.is_linked() || !(is_video || name == "application/x-rtp") {
                return;
            }
            if let Err(failure) = expose(&bin, pad).and_then(|pad| autoplug::decode(&play, &pad, &way)) {
                play.outbox.fail(failure);
            }
        });
    }
    has_some
}
