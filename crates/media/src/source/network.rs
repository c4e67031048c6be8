//! Streams over the network for which GStreamer has a source element.

use std::sync::Arc;

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::SourceLogin;
use gst::prelude::*;
use gstreamer as gst;
use url::Url;

use super::autoplug;
use super::failure::{permanent, unlinked};
use super::play::{Play, Times, Way};
use super::reach;

/// Longest wait for an HTTP server, seconds.
const HTTP_TIMEOUT_S: u32 = 5;

/// Longest wait of an SRT receiver for a packet that is sent again.
const SRT_LATENCY_MS: i32 = 120;

pub(super) fn open(play: &Arc<Play>, url: &str, login: Option<SourceLogin>) -> Result<(), SourceFailure> {
    let parsed = Url::parse(url).map_err(|error| permanent(format!("is no address ({error})"), ""))?;
    let (source, name) = match parsed.scheme() {
        "srt" => (srt(play, url)?, "by SRT"),
        "rtmp" | "rtmps" => (rtmp(play, parsed.clone(), login)?, "by RTMP"),
        "http" | "https" => (http(play, &parsed, login)?, "by HTTP"),
        scheme => {
            let what = format!("has a scheme that is not read here ({scheme}://)");
            return Err(permanent(what, "Use rtsp://, srt://, rtmp:// or https://"));
        }
    };
    let pad = source.static_pad("src").ok_or_else(|| unlinked("a source has no pad"))?;
    let times = if play.is_live { Times::Sender } else { Times::SinceStart };
    autoplug::decode(play, &pad, &Way { name: name.to_owned(), times })?;
    explain_failure(play, parsed);
    play.start();
    Ok(())
}

/// The elements do not tell why a host cannot be reached. Another attempt to reach it does.
fn explain_failure(play: &Arc<Play>, url: Url) {
    let port = match url.scheme() {
        "http" => 80,
        "https" => 443,
        "rtmp" => 1935,
        _ => return,
    };
    play.set_second_attempt(Box::new(move |play, _| match reach::connect(&url, port) {
        Ok(_) => false,
        Err(error) => {
            play.outbox.fail(reach::unreachable(&error));
            true
        }
    }));
}

fn srt(play: &Play, url: &str) -> Result<gst::Element, SourceFailure> {
    let source = play.add("srtsrc")?;
    source.set_property("uri", url);
    if !url.contains("latency=") {
        source.set_property("latency", SRT_LATENCY_MS);
    }
    Ok(source)
}

fn rtmp(play: &Play, mut url: Url, login: Option<SourceLogin>) -> Result<gst::Element, SourceFailure> {
    let source = play.add("rtmp2src")?;
    if let Some(login) = login {
        // The element takes the login from the address. The protocol sends no password as it is.
        let is_set = url.set_username(&login.user).is_ok() && url.set_password(Some(&login.password)).is_ok();
        if !is_set {
            return Err(permanent("cannot have a login", ""));
        }
    }
    source.set_property("location", url.as_str());
    Ok(source)
}

fn http(play: &Arc<Play>, url: &Url, login: Option<SourceLogin>) -> Result<gst::Element, SourceFailure> {
    // A camera sends pictures in parts until the connection is closed. Other content of HTTP may be a file.
    let weak = Arc::downgrade(play);
    play.pipeline.connect_deep_element_added(move |_, _, element| {
        let Some(play) = weak.upgrade() else { return };
        if autoplug::is_multipart(element) {
            play.set_is_endless();
        }
        if autoplug::is_in_segments(element) {
            play.outbox.fail(permanent(
                "comes in segments (HLS, DASH): its pictures are many seconds old, and nothing tells how old",
                "Use the camera's rtsp:// address",
            ));
        }
    });
    let source = play.add("souphttpsrc")?;
    source.set_property("location", url.as_str());
    source.set_property("user-agent", "barrelman");
    source.set_property("is-live", play.is_live);
    source.set_property("timeout", HTTP_TIMEOUT_S);
    // A login goes to the host that it is for.
    source.set_property("automatic-redirect", false);
    if let Some(login) = login {
        if url.scheme() == "http" && !login.permits_basic {
            return Err(permanent(
                "could take the password in clear text (HTTP without TLS), and everybody on the network could read it",
                "Use its https:// address; on a network that you trust, video.allow_basic_login = true in the \
                 configuration sends it in clear",
            ));
        }
        source.set_property("user-id", &login.user);
        source.set_property("user-pw", &login.password);
    }
    Ok(source)
}
