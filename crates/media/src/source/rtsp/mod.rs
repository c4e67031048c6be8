//! RTSP: `rtspsrc`, for an address without TLS behind a relay that guards the login ([`relay`]).
//!
//! Not handled: several video streams of one session (the first one is used); a way through a NAT for packets
//! over UDP.

mod messages;

mod relay;

mod announced;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{RtspTransport, SourceLogin};
use gst::prelude::*;
use gstreamer as gst;
use url::Url;

use super::failure::{self, from_status, permanent, temporary};
use super::play::Play;
use super::rtp::{self, Stream};

/// Longest wait for the server, microseconds.
const TIMEOUT_US: u64 = 5_000_000;

/// Longest wait for a packet that is missing among those over UDP.
const UDP_LATENCY_MS: u32 = 60;

/// Status of a server that does not send packets this way.
const UNSUPPORTED_TRANSPORT: u16 = 461;

/// One attempt to play an address.
#[derive(Clone)]
struct Attempt {
    url: Url,
    login: Option<SourceLogin>,
    transport: RtspTransport,
    /// The encoding that the server sends and does not announce.
    sent: Option<&'static str>,
}

pub(super) fn open(
    play: &Arc<Play>,
    url: &str,
    transport: RtspTransport,
    login: Option<SourceLogin>,
) -> Result<(), SourceFailure> {
    let url = Url::parse(url).map_err(|error| permanent(format!("is no address ({error})"), ""))?;
    Attempt { url, login, transport, sent: None }.start(play)
}

impl Attempt {
    /// The attempt after this one, where another transport or the encoding that is sent may help.
    fn next(&self, failure: &SourceFailure) -> Option<Self> {
        let is_auto = self.transport == RtspTransport::Auto;
        if is_auto && Some(failure) == from_status(UNSUPPORTED_TRANSPORT).as_ref() {
            return Some(Self { transport: RtspTransport::Udp, ..self.clone() });
        }
        let sent = announced::sent(failure).filter(|_| self.sent.is_none())?;
        Some(Self { sent: Some(sent), ..self.clone() })
    }

    /// Begins the next attempt after a failure, if there is one.
    fn begin_next(&self, play: &Arc<Play>, failure: &SourceFailure) -> bool {
        let Some(next) = self.next(failure) else { return false };
        let _ = play.pipeline.set_state(gst::State::Null);
        for element in play.pipeline.children() {
            let _ = play.pipeline.remove(&element);
        }
        play.begin_anew();
        if let Err(failure) = next.start(play) {
            play.outbox.fail(failure);
        }
        true
    }

    fn start(&self, play: &Arc<Play>) -> Result<(), SourceFailure> {
        let attempt = self.clone();
        play.set_second_attempt(Box::new(move |play, failure| attempt.begin_next(play, failure)));
        let source = play.add("rtspsrc")?;
        let location = if self.url.scheme() == "rtsps" {
            watch_redirects(play, &source, &self.url);
            self.url.clone()
        } else {
            let permits_basic = self.login.as_ref().is_some_and(|login| login.permits_basic);
            let server = relay::Server { url: self.url.clone(), permits_basic, sent: self.sent };
            relay::start(play, server)
                .map_err(|error| temporary(format!("cannot be reached: {error}"), ""))?
        };
        self.set_up(&source, &location);
        let stream = Stream::default();
        choose_video(play, &source);
        watch_manager(play, &source, &stream);
        let (way, weak) = (self.way(), Arc::downgrade(play));
        source.connect_pad_added(move |_, pad| {
            let Some(play) = weak.upgrade() else { return };
            announced::watch(&play, pad);
            if let Err(failure) = rtp::take(&play, pad, way, &stream) {
                play.outbox.fail(failure);
            }
        });
        play.start();
        Ok(())
    }

    fn set_up(&self, source: &gst::Element, location: &Url) {
        let (protocols, latency_ms) = match self.transport {
            RtspTransport::Auto | RtspTransport::Tcp => ("tcp", 0),
            RtspTransport::Udp => ("udp", UDP_LATENCY_MS),
            RtspTransport::Multicast => ("udp-mcast", UDP_LATENCY_MS),
        };
        source.set_property("location", location.as_str());
        source.set_property_from_str("protocols", protocols);
        source.set_property("latency", latency_ms);
        source.set_property("drop-on-latency", false);
        source.set_property("do-rtsp-keep-alive", true);
        source.set_property("udp-reconnect", false);
        source.set_property("timeout", TIMEOUT_US);
        source.set_property("tcp-timeout", TIMEOUT_US);
        source.set_property("user-agent", "barrelman");
        if let Some(login) = &self.login {
            source.set_property("user-id", &login.user);
            source.set_property("user-pw", &login.password);
        }
    }

    fn way(&self) -> &'static str {
        match (self.transport, self.url.scheme() == "rtsps") {
            (RtspTransport::Auto | RtspTransport::Tcp, false) => "RTP over TCP",
            (RtspTransport::Auto | RtspTransport::Tcp, true) => "RTP over TLS",
            (RtspTransport::Udp, _) => "RTP over UDP",
            (RtspTransport::Multicast, _) => "RTP over UDP to a group",
        }
    }
}

/// Asks the server for its first video stream only.
fn choose_video(play: &Arc<Play>, source: &gst::Element) {
    let chosen = Arc::new(AtomicBool::new(false));
    let has_video = chosen.clone();
    source.connect("select-stream", false, move |arguments| {
        let caps: Option<gst::Caps> = arguments.get(2).and_then(|caps| caps.get().ok());
        let media = caps.as_ref().and_then(|caps| caps.structure(0)?.get::<String>("media").ok());
        let is_first = media.as_deref() == Some("video") && !chosen.swap(true, Ordering::Relaxed);
        Some(is_first.to_value())
    });
    let weak = Arc::downgrade(play);
    source.connect("on-sdp", false, move |_| {
        has_video.store(false, Ordering::Relaxed);
        None
    });
    source.connect_no_more_pads(move |source| {
        if let Some(play) = weak.upgrade()
            && source.src_pads().is_empty()
        {
            let remedy = "Give the address of a profile of the camera that has video";
            play.outbox.fail(failure::permanent("offers no video", remedy));
        }
    });
}

/// Notes the arrival of packets and the sender's reports where they enter the session manager.
fn watch_manager(play: &Arc<Play>, source: &gst::Element, stream: &Stream) {
    let (play, stream) = (Arc::downgrade(play), stream.clone());
    source.connect("new-manager", false, move |arguments| {
        let manager: gst::Element = arguments.get(1)?.get().ok()?;
        let (play, stream) = (play.clone(), stream.clone());
        manager.connect_pad_added(move |_, pad| {
            let name = pad.name();
            if name.starts_with("recv_rtp_sink") {
                rtp::note_arrivals(pad);
            } else if name.starts_with("recv_rtcp_sink")
                && let Some(play) = play.upgrade()
            {
                rtp::watch_reports(&play, pad, &stream);
            }
        });
        None
    });
}

/// Ends where the server leads to another host, before anything is sent there. (Without TLS, the relay does
/// this.)
fn watch_redirects(play: &Arc<Play>, source: &gst::Element, url: &Url) {
    let (play, url) = (Arc::downgrade(play), url.clone());
    source.connect("before-send", false, move |arguments| {
        let source: gst::Element = arguments.first()?.get().ok()?;
        let location = source.property::<Option<String>>("location").unwrap_or_default();
        let is_same = Url::parse(&location).is_ok_and(|to| {
            (to.scheme(), to.host_str(), to.port()) == (url.scheme(), url.host_str(), url.port())
        });
        if !is_same && let (Some(play), Some(failure)) = (play.upgrade(), from_status(302)) {
            play.outbox.fail(failure);
        }
        Some(is_same.to_value())
    });
}
