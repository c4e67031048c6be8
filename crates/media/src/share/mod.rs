//! A share: programs of others read the annotated video from an RTSP server.
//!
//! ```text
//!  channel -> main thread -> Audience -> appsrc -> rtph264pay -> connection      for each reader
//!  channel <- Demand <---------'
//!  listening socket (standard output) -> door -> a thread of GStreamer's for each client
//! ```
//! The program encodes while somebody reads, and sends a unit once; each reader has a pipeline of its own.
//! A reader that is slow loses units ([`reader`]). Passwords are asked for by digest alone: a reader proves
//! that it knows the password, which never goes over the line. The process can open no file and no socket
//! ([`crate::rights`]): it takes connections from a socket that the program has opened.
//!
//! Not handled: packets over UDP, encryption.

mod server;

mod door;

mod audience;

mod reader;

use std::io;
use std::net::TcpListener;
use std::os::fd::AsFd as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::share::{FromShare, ShareSettings, ToShare};
use gstreamer as gst;
use gstreamer_rtsp_server::RTSPServer;
use gstreamer_rtsp_server::prelude::*;

use crate::rights::{self, Kept, Network};
use audience::Audience;

/// Longest time between two looks for connections that do nothing.
const TURN: Duration = Duration::from_secs(1);

/// Serves until the channel is closed.
pub(crate) fn serve(mut channel: Channel, settings: &ShareSettings) -> Result<(), ChannelError> {
    let audience = Arc::new(Audience::new(channel.try_clone().map_err(ChannelError::Io)?));
    let (server, listener) = match open(settings, &audience) {
        Ok(opened) => opened,
        Err(reason) => {
            return refuse(
                &mut channel,
                &reason,
                "Install libgstrtspserver-1.0-0 and gstreamer1.0-plugins-good",
            );
        }
    };
    channel.send(&FromShare::Ready, &[])?;
    door::take_connections(listener, server.clone(), audience.clone());
    let sessions = server.session_pool();
    let mut tended_at = Instant::now();
    loop {
        if let Some((message, length)) = channel.receive::<ToShare>(Instant::now() + TURN)? {
            let mut unit = vec![0; length];
            channel.read_payload(&mut unit)?;
            let ToShare::Unit { key } = message;
            audience.feed(unit, key);
        }
        if tended_at.elapsed() >= TURN {
            tended_at = Instant::now();
            audience.end_idle();
            sessions.as_ref().map(RTSPSessionPoolExt::cleanup);
        }
    }
}

/// Says that the video cannot be shared.
pub(crate) fn refuse(channel: &mut Channel, reason: &str, remedy: &str) -> Result<(), ChannelError> {
    channel.send(&FromShare::Failed { reason: reason.to_owned(), remedy: remedy.to_owned() }, &[])
}

/// Opens the server for the socket that is the standard output, and gives up all other rights.
fn open(settings: &ShareSettings, audience: &Arc<Audience>) -> Result<(RTSPServer, TcpListener), String> {
    gst::init().map_err(|error| format!("GStreamer does not start ({error})"))?;
    gst::log::remove_default_log_function();
    server::load_plugins()?;
    let socket = io::stdout().as_fd().try_clone_to_owned().map_err(|error| error.to_string())?;
    let listener = TcpListener::from(socket);
    listener.local_addr().map_err(|error| format!("there is no socket to listen on ({error})"))?;
    rights::give_up(&Kept { network: Network::Accepted, ..Kept::default() });
    Ok((server::new(settings, audience)?, listener))
}
