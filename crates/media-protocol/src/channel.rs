//! Messages over a Unix socket: a header and a payload, both of bounded length.
//!
//! ```text
//! +----------------------+-----------------------+-------------------+---------+
//! | header length, 4 (LE) | payload length, 4 (LE) | header (postcard) | payload |
//! +----------------------+-----------------------+-------------------+---------+
//! ```

use std::io::{self, IoSlice, Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Longest header.
const MAX_HEADER: usize = 64 * 1024;

/// Longest payload: a picture of 4096 x 4096 pixels, 4:2:0, with room for odd sizes.
pub const MAX_PAYLOAD: usize = 26 * 1024 * 1024;

/// Longest time from the first byte of a message to its last, and longest time to send a message.
const MESSAGE_TIMEOUT: Duration = Duration::from_secs(1);

/// Size of the socket's buffers: less would divide the transfer of a picture into many turns of both
/// processes.
const BUFFER_SIZE: usize = 4 * 1024 * 1024;

/// A message cannot be sent or received. The channel cannot be used any more.
#[derive(Debug, thiserror::Error)]
pub enum ChannelError {
    /// The far end has closed the channel, or has ended.
    #[error("the far end has ended")]
    Closed,
    /// The far end stopped in the middle of a message, or does not read.
    #[error("the far end has stopped")]
    Stopped,
    /// The bytes are no message.
    #[error("the far end sent no message: is it of the same build?")]
    Malformed,
    /// The system's error.
    #[error("{0}")]
    Io(io::Error),
}

/// One end of a channel.
#[derive(Debug)]
pub struct Channel {
    stream: UnixStream,
    header: Vec<u8>,
}

impl Channel {
    /// A new channel: this end, and the socket of the far end.
    ///
    /// # Errors
    /// The system has no socket left.
    pub fn pair() -> io::Result<(Self, OwnedFd)> {
        let (near, far) = UnixStream::pair()?;
        Ok((Self::over(near)?, far.into()))
    }

    /// The channel over a socket, at the far end.
    ///
    /// # Errors
    /// The descriptor is no socket.
    pub fn over(stream: UnixStream) -> io::Result<Self> {
        stream.set_read_timeout(Some(MESSAGE_TIMEOUT))?;
        stream.set_write_timeout(Some(MESSAGE_TIMEOUT))?;
        // The system may allow less.
        let _ = rustix::net::sockopt::set_socket_send_buffer_size(&stream, BUFFER_SIZE);
        Ok(Self { stream, header: Vec::new() })
    }

    /// Another end for another thread, which may send while this one receives.
    ///
    /// # Errors
    /// The system has no descriptor left.
    pub fn try_clone(&self) -> io::Result<Self> {
        Ok(Self { stream: self.stream.try_clone()?, header: Vec::new() })
    }

    /// Waits at the far end for room without a limit of time: for a source that is read at the reader's pace.
    ///
    /// # Errors
    /// The system's.
    pub fn wait_for_reader(&self) -> io::Result<()> {
        self.stream.set_write_timeout(None)
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The channel is closed, or the far end does not read.
    pub fn send(&mut self, message: &impl Serialize, payload: &[u8]) -> Result<(), ChannelError> {
        self.send_parts(message, &[payload])
    }

    /// Sends a message whose payload consists of these parts, one after the other.
    ///
    /// # Errors
    /// As [`Self::send`].
    pub fn send_parts(&mut self, message: &impl Serialize, payload: &[&[u8]]) -> Result<(), ChannelError> {
        let header = postcard::to_stdvec(message).map_err(|_| ChannelError::Malformed)?;
        let length: usize = payload.iter().map(|part| part.len()).sum();
        if header.len() > MAX_HEADER || length > MAX_PAYLOAD {
            return Err(ChannelError::Malformed);
        }
        let lengths = [(header.len() as u32).to_le_bytes(), (length as u32).to_le_bytes()].concat();
        let mut slices = vec![IoSlice::new(&lengths), IoSlice::new(&header)];
        slices.extend(payload.iter().map(|part| IoSlice::new(part)));
        let mut slices = &mut slices[..];
        IoSlice::advance_slices(&mut slices, 0);
        while !slices.is_empty() {
            match self.stream.write_vectored(slices) {
                Ok(0) => return Err(ChannelError::Closed),
                Ok(sent) => IoSlice::advance_slices(&mut slices, sent),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Waits for a message until `deadline`. Returns the message and the length of its payload, which must be
    /// read next ([`Self::read_payload`]); `None`: none has come.
    ///
    /// # Errors
    /// The channel is closed, or what comes is no message.
    pub fn receive<M: DeserializeOwned>(
        &mut self,
        deadline: Instant,
    ) -> Result<Option<(M, usize)>, ChannelError> {
        if !self.is_readable(deadline)? {
            return Ok(None);
        }
        let mut lengths = [[0; 4]; 2];
        self.stream.read_exact(lengths.as_flattened_mut())?;
        let [header, payload] = lengths.map(|length| u32::from_le_bytes(length) as usize);
        if header > MAX_HEADER || payload > MAX_PAYLOAD {
            return Err(ChannelError::Malformed);
        }
        self.header.resize(header, 0);
        self.stream.read_exact(&mut self.header)?;
        let message = postcard::from_bytes(&self.header).map_err(|_| ChannelError::Malformed)?;
        Ok(Some((message, payload)))
    }

    /// Fills `into` with the next bytes of a payload.
    ///
    /// # Errors
    /// As [`Self::receive`].
    pub fn read_payload(&mut self, into: &mut [u8]) -> Result<(), ChannelError> {
        Ok(self.stream.read_exact(into)?)
    }

    fn is_readable(&self, deadline: Instant) -> Result<bool, ChannelError> {
        loop {
            let wait = deadline.saturating_duration_since(Instant::now());
            let timeout = Timespec { tv_sec: wait.as_secs() as i64, tv_nsec: i64::from(wait.subsec_nanos()) };
            let mut fds = [PollFd::from_borrowed_fd(self.stream.as_fd(), PollFlags::IN)];
            match poll(&mut fds, Some(&timeout)) {
                Ok(ready) => return Ok(ready > 0),
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(ChannelError::Io(error.into())),
            }
        }
    }
}

impl From<io::Error> for ChannelError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof | io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => {
                Self::Closed
            }
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => Self::Stopped,
            _ => Self::Io(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::ToDecoder;

    fn pair() -> (Channel, Channel) {
        let (near, far) = Channel::pair().unwrap();
        (near, Channel::over(UnixStream::from(far)).unwrap())
    }

    fn soon() -> Instant {
        Instant::now() + Duration::from_secs(5)
    }

    #[test]
    fn a_message_arrives_with_its_payload() {
        let (mut near, mut far) = pair();
        let message = ToDecoder::Decode { pts_ns: 7, key: true };
        near.send_parts(&message, &[b"ab", b"", b"c"]).unwrap();
        near.send(&ToDecoder::Flush, b"").unwrap();
        assert_eq!(far.receive(soon()).unwrap(), Some((message, 3)));
        let mut payload = [0; 3];
        far.read_payload(&mut payload).unwrap();
        assert_eq!(&payload, b"abc");
        assert_eq!(far.receive(soon()).unwrap(), Some((ToDecoder::Flush, 0)));
        assert_eq!(far.receive::<ToDecoder>(Instant::now()).unwrap(), None);
    }

    #[test]
    fn a_far_end_that_has_ended_is_an_error() {
        let (near, mut far) = pair();
        drop(near);
        assert!(matches!(far.receive::<ToDecoder>(soon()), Err(ChannelError::Closed)));
        assert!(matches!(far.send(&ToDecoder::Flush, b""), Err(ChannelError::Closed)));
    }

    #[test]
    fn a_far_end_that_stops_in_a_message_is_an_error() {
        let (mut near, mut far) = pair();
        near.stream.write_all(&[3, 0]).unwrap();
        assert!(matches!(far.receive::<ToDecoder>(soon()), Err(ChannelError::Stopped)));
    }

    #[test]
    fn lengths_beyond_their_bounds_and_bytes_that_are_no_message_are_refused() {
        for bytes in [&[0xff; 8][..], &[0, 0, 0, 0, 0, 0, 0, 0x7f], &[1, 0, 0, 0, 0, 0, 0, 0, 9]] {
            let (mut near, mut far) = pair();
            near.stream.write_all(bytes).unwrap();
            assert!(matches!(far.receive::<ToDecoder>(soon()), Err(ChannelError::Malformed)), "{bytes:?}");
        }
    }
}
