//! What a share needs from the start of a run: its socket, the password of its readers, and
//! `barrelman-media`.

use std::net::TcpListener;

use anyhow::{Context as _, Result, bail};
use barrelman_console_server::TokensInForce;
use barrelman_video::media::MediaProgram;
use barrelman_video::media::share::ShareSocket;

use super::ShareAddress;

/// What the thread needs to know from the start.
#[derive(Debug)]
pub struct ShareSetup {
    /// Where the video is served, as it was given.
    pub(super) address: ShareAddress,
    /// The socket, open.
    pub(super) socket: ShareSocket,
    /// The program that serves.
    pub(super) program: MediaProgram,
    /// The console's tokens; that for watching is the password.
    tokens: TokensInForce,
}

impl ShareSetup {
    /// Opens the socket. `tokens`: the console's.
    ///
    /// # Errors
    /// If there is no password off loopback, if the socket cannot be opened, or if `barrelman-media` is
    /// missing.
    pub fn open(address: ShareAddress, tokens: TokensInForce) -> Result<Self> {
        if !tokens.are_asked_for() && !address.is_loopback() {
            bail!(
                "{address}: other devices read the video with the console's watch token, and there is none: leave out \
                 --headless, name a file of tokens (--console-token-file, console.token_file), or share at 127.0.0.1"
            );
        }
        let (listener, program) = listen(&address)?;
        let socket = ShareSocket::new(listener, address.path.clone());
        Ok(Self { socket, address, program, tokens })
    }

    /// The password in force; `None`: none is asked for.
    pub(super) fn password(&self) -> Option<String> {
        self.tokens.get().map(|tokens| tokens.watch)
    }

    /// Whether this is the password in force.
    pub(super) fn is_password(&self, password: Option<&str>) -> bool {
        self.tokens.is_watch(password)
    }
}

/// Opens the socket, and finds the program that serves it.
///
/// # Errors
/// If `barrelman-media` is missing, or the address is not this machine's, or is in use.
pub fn listen(address: &ShareAddress) -> Result<(TcpListener, MediaProgram)> {
    let program = MediaProgram::installed().with_context(|| {
        format!(
            "the video is shared by barrelman-media, which is not installed: {}",
            MediaProgram::INSTALLATION
        )
    })?;
    let listener = TcpListener::bind(address.listen).with_context(|| {
        format!("{address} cannot be listened on: give an address of this machine, and a port that no other program uses")
    })?;
    Ok((listener, program))
}
