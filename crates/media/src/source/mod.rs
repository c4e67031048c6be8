//! A source: an address to encoded units.
//!
//! ```text
//!  front (by address) -> decodebin, or depayloader -> parser -> appsink -> Outbox -> channel
//!  rtsp, udp, sdp, device,    stops at compressed      units      one thread that sends
//!  network, file, pipeline    video that is kept
//! ```
//! The first video stream is played; everything else is left alone. Video in H.264, H.265, VP9, AV1 and JPEG
//! passes as it is. Other video is decoded here and sent uncompressed, or as JPEG where the source is live
//! ([`units`]).
//!
//! The process plays one connection. When that ends, for whatever reason, it sends why and ends.

mod outbox;

mod failure;

mod reach;

mod play;

mod autoplug;

mod units;

mod rtp_times;

mod rtp_repair;

mod nal_heads;
mod rtp;

mod rtsp;

mod udp;

mod device;

mod network;

mod file;

mod pipeline;

use std::fs::File;
use std::path::PathBuf;

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{FromSource, SourceAddress, SourceSettings};
use gst::prelude::*;
use gstreamer as gst;

use crate::rights::{self, Kept, Network};
use outbox::Outbox;
use play::Play;

/// Plays until the channel is closed or the stream ends. Does not return while the source plays.
pub(crate) fn serve(mut channel: Channel, settings: SourceSettings) -> Result<(), ChannelError> {
    if let Err(error) = gst::init() {
        let what = format!("cannot be played: GStreamer does not start ({error})");
        return refuse(&mut channel, &what, "Install gstreamer1.0-plugins-base");
    }
    // Elements print nothing: what matters comes over the bus.
    gst::log::remove_default_log_function();
    // A pipe of another process has no name that the rights below reach.
    let pipe = file::open_pipe(&settings.address);
    rights::give_up(&kept(&settings.address));
    if !settings.is_live {
        channel.wait_for_reader().map_err(ChannelError::Io)?;
    }
    let pipeline = gst::Pipeline::new();
    // Times of capture are those of the system's monotonic clock.
    pipeline.use_clock(Some(&gst::SystemClock::obtain()));
    let outbox = Outbox::start(channel, settings.is_live, pipeline.clone());
    let play = Play::new(pipeline, outbox, settings.is_live);
    if let Err(failure) = open(&play, settings.address, pipe) {
        play.outbox.fail(failure);
    }
    play.follow_bus();
    // The thread of the outbox ends the process.
    loop {
        std::thread::park();
    }
}

/// Says that the source cannot be played at all.
pub(crate) fn refuse(channel: &mut Channel, what: &str, remedy: &str) -> Result<(), ChannelError> {
    channel.send(&FromSource::Failed(failure::permanent(what, remedy)), &[])
}

fn open(
    play: &std::sync::Arc<Play>,
    address: SourceAddress,
    pipe: Option<File>,
) -> Result<(), SourceFailure> {
    match address {
        SourceAddress::Rtsp { url, transport, login } => rtsp::open(play, &url, transport, login),
        SourceAddress::Udp { bind, format } => udp::open(play, bind, format),
        SourceAddress::Sdp(path) => file::open_sdp(play, &path),
        SourceAddress::Device(settings) => device::open(play, &settings),
        SourceAddress::Network { url, login } => network::open(play, &url, login),
        SourceAddress::File(path) => file::open(play, &path, pipe),
        SourceAddress::Pipeline(text) => pipeline::open(play, &text),
    }
}

/// The rights that an address needs: libraries and certificates of the system, and what it names.
fn kept(address: &SourceAddress) -> Kept {
    let system = ["/usr", "/lib", "/lib64", "/etc", "/run/systemd/resolve", "/sys", "/proc", "/dev/urandom"];
    let mut kept = Kept {
        readable: system.map(PathBuf::from).into(),
        devices: ["/dev/null", "/dev/dri"].map(PathBuf::from).into(),
        network: Network::All,
    };
    match address {
        SourceAddress::File(path) | SourceAddress::Sdp(path) => kept.readable.push(path.clone()),
        SourceAddress::Device(settings) => kept.devices.push(settings.path.clone()),
        // What a pipeline reads is known to its elements only.
        SourceAddress::Pipeline(_) => {
            kept.readable.push(PathBuf::from("/"));
            kept.devices.push(PathBuf::from("/dev"));
        }
        SourceAddress::Rtsp { .. } | SourceAddress::Udp { .. } | SourceAddress::Network { .. } => {}
    }
    kept
}
