//! A connection of which everything that is read is counted, and that gives the others their turn.
//!
//! All connections share one thread. Each read takes [`READ_BYTES`] at most, and the next one lets the tasks
//! that are ready run first: a client that sends without end delays a Stop by the work for one such piece.
//! What comes beyond a limit ends the connection at the next read, so that a Stop in the last piece is still
//! taken.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};

use barrelman_host::clock::Clock;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::limits::{READ_BYTES, Rate, RateLimit};

/// What a limit is about.
pub(super) trait Counter {
    /// How many end in these bytes, which follow those before.
    fn count(&mut self, bytes: &[u8]) -> usize;
}

/// Counts bytes.
#[derive(Debug)]
pub(super) struct Bytes;

impl Counter for Bytes {
    fn count(&mut self, bytes: &[u8]) -> usize {
        bytes.len()
    }
}

/// A connection with a limit of what it may send.
#[derive(Debug)]
pub(super) struct LimitedStream<S, C> {
    stream: S,
    counter: C,
    limit: RateLimit,
    clock: Clock,
    /// Whether the others have their turn before the next read.
    gives_turn: bool,
    is_over: Arc<AtomicBool>,
}

impl<S, C: Counter> LimitedStream<S, C> {
    /// A connection of which `counter` counts no more than `rate`.
    pub(super) fn new(stream: S, counter: C, rate: Rate, clock: Clock) -> Self {
        let limit = RateLimit::new(rate, clock.now());
        Self { stream, counter, limit, clock, gives_turn: false, is_over: Arc::default() }
    }

    /// Whether the limit is exceeded, for the code that handles what was read.
    pub(super) fn is_over(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.is_over)
    }
}

impl<S: AsyncRead + Unpin, C: Counter + Unpin> AsyncRead for LimitedStream<S, C> {
    fn poll_read(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        if this.is_over.load(Ordering::Relaxed) {
            return Poll::Ready(Err(io::Error::other("the connection sends more than it may")));
        }
        if std::mem::take(&mut this.gives_turn) {
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        let room = buffer.remaining().min(READ_BYTES);
        let mut piece = ReadBuf::new(buffer.initialize_unfilled_to(room));
        ready!(Pin::new(&mut this.stream).poll_read(context, &mut piece))?;
        let counted = this.counter.count(piece.filled());
        let read = piece.filled().len();
        buffer.advance(read);
        this.gives_turn = read > 0;
        if !this.limit.takes(counted as f64, this.clock.now()) {
            this.is_over.store(true, Ordering::Relaxed);
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin, C: Unpin> AsyncWrite for LimitedStream<S, C> {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.get_mut().stream).poll_write(context, bytes)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.get_mut().stream).poll_write_vectored(context, pieces)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_flush(context)
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use std::task::Waker;

    use tokio::io::AsyncWriteExt as _;

    use super::super::in_memory::block_on;
    use super::*;

    /// Polls a read of up to 64 KiB once: the bytes that were read, `None` where the task has to wait.
    fn poll(stream: &mut (impl AsyncRead + Unpin)) -> Option<io::Result<usize>> {
        let mut room = vec![0; 65_536];
        let mut buffer = ReadBuf::new(&mut room);
        match Pin::new(stream).poll_read(&mut Context::from_waker(Waker::noop()), &mut buffer) {
            Poll::Ready(read) => Some(read.map(|()| buffer.filled().len())),
            Poll::Pending => None,
        }
    }

    #[test]
    fn each_read_is_short_and_the_others_have_their_turn_before_the_next() {
        block_on(async {
            let (mut client, program) = tokio::io::duplex(1 << 20);
            client.write_all(&vec![7; 2 * READ_BYTES + 1]).await.unwrap();
            let rate = Rate { per_second: 0.0, burst: 1e9 };
            let mut stream = LimitedStream::new(program, Bytes, rate, Clock::start());
            for expected in [READ_BYTES, READ_BYTES, 1] {
                assert_eq!(poll(&mut stream).unwrap().unwrap(), expected);
                assert!(poll(&mut stream).is_none(), "a turn of the others");
            }
            assert!(poll(&mut stream).is_none(), "nothing more came");
        });
    }

    #[test]
    fn what_exceeds_the_limit_is_read_and_ends_the_connection() {
        block_on(async {
            let (mut client, program) = tokio::io::duplex(1 << 20);
            let rate = Rate { per_second: 0.0, burst: 10.0 };
            let mut stream = LimitedStream::new(program, Bytes, rate, Clock::start());
            client.write_all(&[7; 10]).await.unwrap();
            assert_eq!(poll(&mut stream).unwrap().unwrap(), 10);
            assert!(!stream.is_over().load(Ordering::Relaxed), "just what is permitted");
            client.write_all(&[7; 3]).await.unwrap();
            assert!(poll(&mut stream).is_none());
            assert_eq!(poll(&mut stream).unwrap().unwrap(), 3, "a Stop may be among them");
            assert!(stream.is_over().load(Ordering::Relaxed));
            client.write_all(&[7; 3]).await.unwrap();
            assert!(poll(&mut stream).unwrap().is_err());
        });
    }
}
