//! One end of the socket pair between program and guard: whole messages, no waiting.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::io::Errno;
use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType};

use super::message::MAX_MESSAGE_BYTES;

/// One end of the pipe.
#[derive(Debug)]
pub struct Pipe(OwnedFd);

/// What a pipe holds.
#[derive(Debug, PartialEq, Eq)]
pub enum PipeRead {
    /// A message.
    Message(Vec<u8>),
    /// No message now.
    Nothing,
    /// The other end is gone.
    End,
}

impl Pipe {
    /// A pair of connected ends: the program's, and the one that becomes the guard's standard input.
    ///
    /// # Errors
    /// If the system has no more file descriptors.
    pub fn pair() -> io::Result<(Self, OwnedFd)> {
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let (program, guard) =
            rustix::net::socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)?;
        Ok((Self(program), guard))
    }

    /// An end that this process was started with.
    pub const fn from_fd(fd: OwnedFd) -> Self {
        Self(fd)
    }

    /// Sends a message. Returns whether there was room for it, and another end.
    pub fn send(&self, message: &[u8]) -> bool {
        rustix::net::send(&self.0, message, SendFlags::DONTWAIT | SendFlags::NOSIGNAL).is_ok()
    }

    /// The next message.
    pub fn read(&self) -> PipeRead {
        let mut buffer = [0; MAX_MESSAGE_BYTES + 1];
        let mut receive = || rustix::net::recv(&self.0, &mut buffer, RecvFlags::DONTWAIT);
        let received = match receive() {
            // The other end was closed with messages that it had not read. The system says so once, before
            // the messages that the other end had sent.
            Err(Errno::CONNRESET) => receive(),
            received => received,
        };
        match received {
            // No message is empty.
            Ok((_, 0)) => PipeRead::End,
            Ok((_, length)) => PipeRead::Message(buffer[..length.min(buffer.len())].to_vec()),
            Err(Errno::AGAIN | Errno::INTR) => PipeRead::Nothing,
            Err(_) => PipeRead::End,
        }
    }
}

impl AsFd for Pipe {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_end_said_is_read_after_it_was_closed_with_messages_unread() {
        let (program, guard) = Pipe::pair().unwrap();
        let guard = Pipe::from_fd(guard);
        assert!(guard.send(b"panicked") && guard.send(b"ended"));
        assert!(program.send(b"a request that is not read"));
        drop(guard);
        let read = [program.read(), program.read(), program.read(), program.read()];
        let message = |text: &[u8]| PipeRead::Message(text.to_vec());
        assert_eq!(read, [message(b"panicked"), message(b"ended"), PipeRead::End, PipeRead::End]);
    }
}
