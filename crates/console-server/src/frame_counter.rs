//! Counts the frames of a WebSocket in the bytes that a client sends: each message, each part of a message,
//! each ping, pong and close (RFC 6455, section 5.2). The library that reads the messages tells neither of
//! empty parts nor of their number.

use super::limited_stream::Counter;

/// Counts frames by their heads. What is no frame is for the library to refuse.
#[derive(Debug, Default)]
pub(super) struct FrameCounter {
    /// The head of the frame that begins, as far as it has come.
    head: [u8; MAX_HEAD_BYTES],
    head_bytes: usize,
    /// Bytes of the frame's content that are still to come.
    content_bytes: u64,
}

/// Longest head: two bytes, a length of eight, a mask of four.
const MAX_HEAD_BYTES: usize = 14;

impl FrameCounter {
    /// Length of the head, as far as the bytes so far say it.
    const fn head_length(&self) -> usize {
        if self.head_bytes < 2 {
            return 2;
        }
        let length = match self.head[1] & 0x7f {
            126 => 2,
            127 => 8,
            _ => 0,
        };
        let mask = if self.head[1] & 0x80 == 0 { 0 } else { 4 };
        2 + length + mask
    }

    /// Length of the content, by a complete head.
    const fn content_length(&self) -> u64 {
        let head = &self.head;
        match head[1] & 0x7f {
            126 => u16::from_be_bytes([head[2], head[3]]) as u64,
            127 => {
                u64::from_be_bytes([head[2], head[3], head[4], head[5], head[6], head[7], head[8], head[9]])
            }
            length => length as u64,
        }
    }
}

impl Counter for FrameCounter {
    fn count(&mut self, bytes: &[u8]) -> usize {
        let (mut frames, mut rest) = (0, bytes);
        loop {
            let skipped = rest.len().min(usize::try_from(self.content_bytes).unwrap_or(usize::MAX));
            self.content_bytes -= skipped as u64;
            rest = &rest[skipped..];
            let [byte, after @ ..] = rest else { return frames };
            rest = after;
            self.head[self.head_bytes] = *byte;
            self.head_bytes += 1;
            if self.head_bytes == self.head_length() {
                (self.content_bytes, self.head_bytes) = (self.content_length(), 0);
                frames += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A masked frame with a content of this length.
    fn frame(kind: u8, length: usize) -> Vec<u8> {
        let mut frame = vec![kind];
        match length {
            0..126 => frame.push(0x80 | length as u8),
            126..65_536 => {
                frame.push(0x80 | 126);
                frame.extend((length as u16).to_be_bytes());
            }
            _ => {
                frame.push(0x80 | 127);
                frame.extend((length as u64).to_be_bytes());
            }
        }
        frame.extend([0; 4]);
        frame.extend(vec![0x81; length]);
        frame
    }

    #[test]
    fn each_frame_is_one_however_the_bytes_are_cut() {
        let (text, part, more, ping, pong) = (0x81, 0x01, 0x00, 0x89, 0x8a);
        let kinds = [(text, 5), (ping, 0), (part, 125), (more, 0), (more, 0), (pong, 126), (text, 70_000)];
        let bytes: Vec<u8> = kinds.iter().flat_map(|&(kind, length)| frame(kind, length)).collect();
        for cut in [1, 2, 3, 7, 130, 4096, bytes.len()] {
            let mut counter = FrameCounter::default();
            let counted: usize = bytes.chunks(cut).map(|piece| counter.count(piece)).sum();
            assert_eq!(counted, kinds.len(), "in pieces of {cut} bytes");
        }
    }

    #[test]
    fn a_head_that_promises_more_than_there_can_be_counts_once() {
        let mut counter = FrameCounter::default();
        let mut head = vec![0x82, 0xff];
        head.extend([0xff; 8]);
        head.extend([0; 4]);
        assert_eq!(counter.count(&head), 1);
        assert_eq!(counter.count(&[0x89; 4096]), 0);
    }
}
