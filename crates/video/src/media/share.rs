//! Serves encoded video to programs of others by RTSP, in a process `barrelman-media`.
//!
//! The program keeps the listening socket: where the process ends, readers wait at the same port for the next
//! one.

use std::io;
use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::process::Stdio;
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::ChannelError;
use barrelman_media_protocol::role::Role;
use barrelman_media_protocol::share::{FromShare, ShareSettings, ToShare};

use super::process::{MediaProcess, MediaProgram, START_TIMEOUT};
use crate::encoder::EncodedPicture;

pub use barrelman_media_protocol::share::{Demand, MAX_READERS, SHARE_USER};

/// What is served, and where.
#[derive(Debug)]
pub struct ShareSocket {
    listener: TcpListener,
    path: String,
}

impl ShareSocket {
    /// Serves at `path`, with its first slash.
    pub const fn new(listener: TcpListener, path: String) -> Self {
        Self { listener, path }
    }
}

/// A process that serves. Ends when this is dropped.
#[derive(Debug)]
pub struct Share {
    process: MediaProcess,
}

impl Share {
    /// Starts a process, and waits until it serves those who know the password; `None`: everybody who reaches
    /// the socket.
    ///
    /// # Errors
    /// Why it does not serve, with what to do.
    pub fn start(
        program: &MediaProgram,
        socket: &ShareSocket,
        password: Option<String>,
    ) -> Result<Self, String> {
        let listener = socket.listener.try_clone().map_err(|error: io::Error| error.to_string())?;
        let role = Role::Share(ShareSettings { path: socket.path.clone(), password });
        let process = MediaProcess::start_with(program, role, Stdio::from(OwnedFd::from(listener)));
        let mut process = process.map_err(|error| error.to_string())?;
        match process.channel().receive::<FromShare>(Instant::now() + START_TIMEOUT) {
            Ok(Some((FromShare::Ready, 0))) => Ok(Self { process }),
            Ok(Some((FromShare::Failed { reason, remedy }, 0))) => Err(format!("{reason}. {remedy}")),
            Ok(Some(_)) => Err(process.end(&ChannelError::Malformed)),
            Ok(None) => Err("barrelman-media does not start".to_owned()),
            Err(error) => Err(process.end(&error)),
        }
    }

    /// Waits at most so long for a change of what the readers need. `None`: nothing has changed.
    ///
    /// # Errors
    /// The process has ended, or sends nonsense.
    pub fn next_demand(&mut self, wait: Duration) -> Result<Option<Demand>, String> {
        match self.process.channel().receive::<FromShare>(Instant::now() + wait) {
            Ok(Some((FromShare::Demand(demand), 0))) => Ok(Some(demand)),
            Ok(None) => Ok(None),
            Ok(Some(_)) => Err(self.process.end(&ChannelError::Malformed)),
            Err(error) => Err(self.process.end(&error)),
        }
    }

    /// Sends a picture to the readers.
    ///
    /// # Errors
    /// The process has ended, or does not read.
    pub fn send(&mut self, picture: &EncodedPicture) -> Result<(), String> {
        let message = ToShare::Unit { key: picture.key };
        self.process.send(&message, &picture.bytes).map_err(|error| self.process.end(&error))
    }
}
