//! Takes connections: as many as there is room for, each with a bounded socket.

use std::net::{TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use gio::Socket;
use gstreamer_rtsp_server::RTSPServer;
use gstreamer_rtsp_server::gio;
use gstreamer_rtsp_server::prelude::*;
use rustix::net::sockopt;

use super::audience::Audience;

/// Pause before the next look for room, or after a connection that failed.
const PAUSE: Duration = Duration::from_millis(20);

/// Size of a connection's buffer, of which the kernel makes twice as much.
const SEND_BUFFER: usize = 208 * 1024;

/// Bytes that wait unsent in a connection's buffer before it counts as full. A reader is hardly further
/// behind than this and what its own buffer holds.
const MAX_UNSENT: i32 = 32 * 1024;

/// A connection whose far end answers nothing for so long has gone, ms.
const MAX_SILENCE_MS: u32 = 30_000;

/// Takes connections without end, on a thread of its own.
pub(super) fn take_connections(listener: TcpListener, server: RTSPServer, audience: Arc<Audience>) {
    std::thread::spawn(move || {
        loop {
            let is_taken = audience.has_room()
                && listener.accept().is_ok_and(|(stream, from)| {
                    hand_over(stream, &server, &audience, (&from.ip().to_string(), from.port())).is_ok()
                });
            if !is_taken {
                std::thread::sleep(PAUSE);
            }
        }
    });
}

fn hand_over(
    stream: TcpStream,
    server: &RTSPServer,
    audience: &Audience,
    (address, port): (&str, u16),
) -> Result<(), Box<dyn std::error::Error>> {
    stream.set_nodelay(true)?;
    sockopt::set_socket_send_buffer_size(&stream, SEND_BUFFER)?;
    sockopt::set_socket_keepalive(&stream, true)?;
    sockopt::set_tcp_user_timeout(&stream, MAX_SILENCE_MS)?;
    audience.await_client(stream.try_clone()?);
    let socket = Socket::from_fd(OwnedFd::from(stream))?;
    socket.set_option(libc::IPPROTO_TCP, libc::TCP_NOTSENT_LOWAT, MAX_UNSENT)?;
    Ok(server.transfer_connection(socket, address, i32::from(port), None)?)
}
