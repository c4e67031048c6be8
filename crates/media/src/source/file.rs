//! Files and pipes, and SDP files that describe RTP streams.

use std::fs::File;
use std::os::fd::IntoRawFd as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;
use std::sync::Arc;

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::SourceAddress;
use gst::prelude::*;
use gstreamer as gst;
use rustix::fs::{Mode, OFlags};

use super::autoplug;
use super::failure::{permanent, unlinked};
use super::play::{Play, Times, Way};
use super::rtp::{self, Stream};

/// Longest wait for a packet that is missing.
const LATENCY_MS: u32 = 60;

/// Longest SDP file.
const MAX_SDP: u64 = 64 << 10;

/// The open pipe, where an address names one. The name of an open pipe of another process (`/proc/PID/fd/N`)
/// leads nowhere once rights have been given up.
pub(super) fn open_pipe(address: &SourceAddress) -> Option<File> {
    let SourceAddress::File(path) = address else { return None };
    if !std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo()) {
        return None;
    }
    // Opening waits for no writer: there may be none yet, or none any more. `fdsrc` waits for bytes.
    let flags = OFlags::NONBLOCK | OFlags::CLOEXEC;
    let pipe = rustix::fs::open(path, flags, Mode::empty()).ok()?;
    rustix::fs::fcntl_setfl(&pipe, OFlags::empty()).ok()?;
    Some(pipe.into())
}

/// Plays a file, or a pipe. `pipe`: see [`open_pipe`].
pub(super) fn open(play: &Arc<Play>, path: &Path, pipe: Option<File>) -> Result<(), SourceFailure> {
    let is_pipe = pipe.is_some();
    let source = match pipe {
        Some(pipe) => {
            let source = play.add("fdsrc")?;
            // The process keeps the pipe until its end.
            source.set_property("fd", pipe.into_raw_fd());
            source
        }
        None => {
            let kind = std::fs::metadata(path).map_err(|error| unreadable(&error))?.file_type();
            if kind.is_dir() {
                return Err(permanent("is a folder", "Give the path of a file"));
            }
            if kind.is_file() {
                play.set_is_file();
            }
            file_source(play, path)?
        }
    };
    // A pipe has an end that writes, perhaps now: its pictures have the times of their writer.
    let (name, times) = match (is_pipe, play.is_live) {
        (true, true) => ("from a pipe", Times::Sender),
        (true, false) => ("from a pipe", Times::SinceStart),
        (false, _) => ("from a file", Times::SinceStart),
    };
    let pad = source.static_pad("src").ok_or_else(|| unlinked("the source has no output"))?;
    autoplug::decode(play, &pad, &Way { name: name.to_owned(), times })?;
    play.start();
    Ok(())
}

fn unreadable(error: &std::io::Error) -> SourceFailure {
    match error.kind() {
        std::io::ErrorKind::NotFound => permanent("does not exist", "Check the path"),
        std::io::ErrorKind::PermissionDenied => {
            permanent("may not be read by this user", "Give this user the right to read the file")
        }
        _ => permanent(format!("cannot be read: {error}"), ""),
    }
}

fn file_source(play: &Play, path: &Path) -> Result<gst::Element, SourceFailure> {
    let source = play.add("filesrc")?;
    source.set_property("location", path);
    Ok(source)
}

/// Receives the streams that an SDP file describes, on the ports of this machine that it names. `sdpdemux`
/// opens nothing else: it does not follow an RTSP address in the file.
pub(super) fn open_sdp(play: &Arc<Play>, path: &Path) -> Result<(), SourceFailure> {
    let length = std::fs::metadata(path).map_err(|error| unreadable(&error))?.len();
    if length > MAX_SDP {
        return Err(permanent("is too long for an SDP file", "Check the path"));
    }
    let source = file_source(play, path)?;
    let demux = play.add("sdpdemux")?;
    demux.set_property("latency", LATENCY_MS);
    demux.set_property("redirect", true);
    source.link(&demux).map_err(unlinked)?;
    let (weak, stream) = (Arc::downgrade(play), Stream::default());
    demux.connect_pad_added(move |_, pad| {
        if let Some(play) = weak.upgrade()
            && let Err(failure) = rtp::take(&play, pad, "RTP over UDP", &stream)
        {
            play.outbox.fail(failure);
        }
    });
    play.start();
    Ok(())
}
