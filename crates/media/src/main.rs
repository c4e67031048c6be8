//! `barrelman-media`: the part of Barrelman that links GStreamer.
//!
//! `barrelman` starts this program as a process of its own for each source, each decoder, each share and each
//! list of decoders ([`Role`]), and talks to it over the socket that is its standard input
//! (`barrelman_media_protocol`). The process reads what strangers send, so it gives up the rights that its
//! role does not need ([`rights`]), and it ends when the socket is closed.
//!
//! What must not be here: decisions about when to connect, a recording, a clock other than `CLOCK_MONOTONIC`.
#![forbid(unsafe_code)]

mod log;
mod rights;

mod monotonic;

mod picture;

mod decoder;

mod source;

mod share;

use std::io::{self, IsTerminal as _};
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::role::{BUILD, Role, Start};

/// Longest wait for the first message.
const FIRST_MESSAGE: Duration = Duration::from_secs(5);

const USAGE: &str = "barrelman-media is started by `barrelman`: it reads and decodes video with GStreamer, in a process of its own";

const OTHER_BUILD: &str = "is of another build than barrelman";
const INSTALL_BOTH: &str = "Install both together";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            log::print_line(&reason);
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), String> {
    if io::stdin().is_terminal() {
        return Err(USAGE.to_owned());
    }
    // Out of the program's session and terminal: the closed socket ends this process, and nothing else does.
    // A process that leads its group already needs no other.
    let _ = rustix::process::setsid();
    rights::keep_memory_private();
    // Libraries complain of folders that they may not write: what matters comes over GStreamer's bus.
    gstreamer::glib::log_set_writer_func(|_, _| gstreamer::glib::LogWriterOutput::Handled);
    let stdin = io::stdin().as_fd().try_clone_to_owned().map_err(|error| error.to_string())?;
    let mut channel = Channel::over(UnixStream::from(stdin)).map_err(|error| format!("{USAGE} ({error})"))?;
    let start = match channel.receive::<Start>(Instant::now() + FIRST_MESSAGE) {
        Ok(Some((start, 0))) => start,
        Ok(Some(_)) | Err(ChannelError::Malformed) => return Err(format!("{OTHER_BUILD}. {INSTALL_BOTH}")),
        Ok(None) => return Err("no first message has come".to_owned()),
        Err(error) => return Err(format!("no first message has come: {error}")),
    };
    let is_other_build = start.build != BUILD;
    let ended = match start.role {
        Role::Decoder(_) if is_other_build => decoder::refuse(&mut channel, OTHER_BUILD, INSTALL_BOTH),
        Role::Source(_) if is_other_build => source::refuse(&mut channel, OTHER_BUILD, INSTALL_BOTH),
        Role::Share(_) if is_other_build => share::refuse(&mut channel, OTHER_BUILD, INSTALL_BOTH),
        Role::ListDecoders if is_other_build => return Err(format!("{OTHER_BUILD}. {INSTALL_BOTH}")),
        Role::Decoder(settings) => decoder::serve(channel, settings),
        Role::ListDecoders => decoder::list(&mut channel),
        Role::Source(settings) => source::serve(channel, settings),
        Role::Share(settings) => share::serve(channel, &settings),
    };
    match ended {
        Ok(()) | Err(ChannelError::Closed) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}
