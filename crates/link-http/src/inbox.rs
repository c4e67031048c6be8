//! What has come from the vehicle, until the link's thread takes it: bounded, with a descriptor that tells of
//! it.

use std::collections::VecDeque;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::{Mutex, MutexGuard, PoisonError};

use barrelman_link::Waker;
use barrelman_wire::http::Received;

/// Capacity. Each lane has one answer at most; the rest are messages, of which the newest tells all.
const CAPACITY: usize = 64;

/// Received packets.
#[derive(Debug)]
pub(crate) struct Inbox {
    packets: Mutex<VecDeque<Received>>,
    ready: Waker,
}

impl Inbox {
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self { packets: Mutex::default(), ready: Waker::new()? })
    }

    /// Puts a packet in. Where the inbox is full, the oldest message makes room, or the oldest packet.
    pub(crate) fn put(&self, packet: Received) {
        let mut packets = self.packets();
        if packets.len() >= CAPACITY {
            let oldest = packets.iter().position(|one| matches!(one, Received::Message(_)));
            packets.remove(oldest.unwrap_or(0));
        }
        packets.push_back(packet);
        drop(packets);
        self.ready.wake();
    }

    /// Takes everything out.
    pub(crate) fn take(&self) -> VecDeque<Received> {
        self.ready.clear();
        std::mem::take(&mut *self.packets())
    }

    fn packets(&self) -> MutexGuard<'_, VecDeque<Received>> {
        // Plain data, whole at any time.
        self.packets.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl AsFd for Inbox {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.ready.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_inbox_drops_messages_and_keeps_answers() {
        let inbox = Inbox::new().unwrap();
        inbox.put(Received::NoAnswer { id: 1 });
        for number in 0..200_u8 {
            inbox.put(Received::Message(vec![number]));
        }
        let taken = inbox.take();
        assert_eq!((taken.len(), taken.front()), (CAPACITY, Some(&Received::NoAnswer { id: 1 })));
        assert_eq!(taken.back(), Some(&Received::Message(vec![199])));
        assert!(inbox.take().is_empty());
    }
}
