//! Starts and ends a process `barrelman-media`.

use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::decoder::DecoderList;
use barrelman_media_protocol::role::{BUILD, MEDIA_NAME, Role, Start};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Longest start of a process. The first start after an installation reads all of GStreamer's plugins.
pub(crate) const START_TIMEOUT: Duration = Duration::from_secs(20);

/// A process whose channel is closed, or that was killed, has ended within this time.
const ENDS_WITHIN: Duration = Duration::from_secs(1);

/// Bytes of one process's error output that reach the log.
const MAX_LOGGED_BYTES: u64 = 16 * 1024;

/// The program `barrelman-media`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MediaProgram(PathBuf);

impl MediaProgram {
    /// How the program is installed, for messages of where it is missing.
    pub const INSTALLATION: &'static str = "install its package (barrelman-media), or build it: \
         scripts/setup.sh media && cargo build --release -p barrelman-media";

    /// The program beside the running one; `None`: there is no such file.
    pub fn installed() -> Option<Self> {
        let path = std::env::current_exe().ok()?.with_file_name(MEDIA_NAME);
        path.is_file().then_some(Self(path))
    }

    /// The program in this file.
    pub const fn at(path: PathBuf) -> Self {
        Self(path)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// The program cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MediaError {
    /// The program cannot be started.
    #[error("{} cannot be started: {cause}", .program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// The process cannot be spoken to.
    #[error("{}: {cause}", .program.display())]
    Channel {
        /// The program.
        program: PathBuf,
        /// The channel's error.
        cause: ChannelError,
    },
}

/// A running process. Ends when this is dropped.
#[derive(Debug)]
pub(crate) struct MediaProcess {
    channel: Channel,
    child: Child,
}

impl MediaProcess {
    /// Starts a process and tells it what it is for.
    ///
    /// # Errors
    /// The program cannot be started.
    pub(crate) fn start(program: &MediaProgram, role: Role) -> Result<Self, MediaError> {
        Self::start_with(program, role, Stdio::null())
    }

    /// The same, with a standard output.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub(crate) fn start_with(program: &MediaProgram, role: Role, output: Stdio) -> Result<Self, MediaError> {
        let not_started = |cause| MediaError::Start { program: program.0.clone(), cause };
        let (channel, far) = Channel::pair().map_err(not_started)?;
        let mut command = Command::new(&program.0);
        command.stdin(Stdio::from(far)).stdout(output).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(not_started)?;
        // The far end's socket must not stay open here: its end is how the death of the process is seen.
        drop(command);
        if let Some(output) = child.stderr.take() {
            log_output(output).map_err(not_started)?;
        }
        let mut process = Self { channel, child };
        let start = Start { build: BUILD.to_owned(), role };
        let sent = process.channel.send(&start, &[]);
        sent.map_err(|cause| MediaError::Channel { program: program.0.clone(), cause })?;
        Ok(process)
    }

    /// Sends a message. Errors as [`Channel::send`].
    pub(crate) fn send(&mut self, message: &impl Serialize, payload: &[u8]) -> Result<(), ChannelError> {
        self.channel.send(message, payload)
    }

    /// Waits for a message with its payload. Errors as [`Channel::receive`].
    pub(crate) fn receive<M: DeserializeOwned>(
        &mut self,
        until: Instant,
    ) -> Result<Option<(M, Vec<u8>)>, ChannelError> {
        let Some((message, length)) = self.channel.receive(until)? else { return Ok(None) };
        let mut payload = vec![0; length];
        self.channel.read_payload(&mut payload)?;
        Ok(Some((message, payload)))
    }

    /// The channel, for messages whose payload goes into memory that is there already.
    pub(crate) const fn channel(&mut self) -> &mut Channel {
        &mut self.channel
    }

    /// How the process ended: "ended by signal 11", or why the channel cannot be used.
    pub(crate) fn end(&mut self, error: &ChannelError) -> String {
        // The end of the channel is seen a moment before the process can be waited for.
        let is_closed = matches!(error, ChannelError::Closed);
        match self.ended().filter(|_| is_closed) {
            Some(status) => format!("{MEDIA_NAME} ended ({status})"),
            None => format!("{MEDIA_NAME}: {error}"),
        }
    }

    /// The status of the process once it has ended; `None`: it has not within [`ENDS_WITHIN`], as a process
    /// that waits in the kernel for a device that hangs.
    fn ended(&mut self) -> Option<ExitStatus> {
        let until = Instant::now() + ENDS_WITHIN;
        loop {
            match self.child.try_wait() {
                Ok(None) if Instant::now() < until => std::thread::sleep(Duration::from_millis(2)),
                status => return status.ok().flatten(),
            }
        }
    }
}

impl Drop for MediaProcess {
    fn drop(&mut self) {
        // A process that has ended already is only waited for.
        let _ = self.child.kill();
        if self.ended().is_none() {
            tracing::warn!("{MEDIA_NAME} ({}) does not end: it waits for a device", self.child.id());
        }
    }
}

/// What an installed `barrelman-media` decodes.
///
/// # Errors
/// The program cannot be started, or does not answer.
pub fn decoders(program: &MediaProgram) -> Result<DecoderList, MediaError> {
    let mut process = MediaProcess::start(program, Role::ListDecoders)?;
    let answer = process.receive(Instant::now() + START_TIMEOUT);
    let failed = |cause| MediaError::Channel { program: program.0.clone(), cause };
    let (list, _) = answer.map_err(failed)?.ok_or_else(|| failed(ChannelError::Stopped))?;
    Ok(list)
}

/// Logs what a process prints, up to a bound; the rest is read and dropped, so that the process never blocks.
fn log_output(output: ChildStderr) -> io::Result<()> {
    std::thread::Builder::new().name("media-log".to_owned()).spawn(move || {
        let mut lines = BufReader::new(output.take(MAX_LOGGED_BYTES));
        let mut line = Vec::new();
        while lines.read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
            tracing::warn!("{MEDIA_NAME}: {}", String::from_utf8_lossy(line.trim_ascii_end()));
            line.clear();
        }
        let _ = io::copy(&mut lines.into_inner().into_inner(), &mut io::sink());
    })?;
    Ok(())
}
