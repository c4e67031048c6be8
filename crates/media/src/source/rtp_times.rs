//! RTP packets in their order to what is known of a picture: its time stamp, its arrival, and whether a part
//! is lost.
//!
//! A time stamp has 32 bits and wraps. Here it is extended: the first one has 2^32 added, so that an older
//! one stays positive, and the low 32 bits are always those of the packet. The packets of a picture have one
//! time stamp, and the last of them has the marker (RFC 6184, 5.1; RFC 7798, 4.1).

use std::collections::VecDeque;

/// Pictures whose arrival is remembered: those between the jitter buffer and the end of the line.
const REMEMBERED: usize = 64;

/// Largest picture, bytes: a key frame of 4K video has less than 2 MiB.
pub(super) const MAX_PICTURE_BYTES: usize = 8 << 20;

/// Largest number of packets that are missing in one place. More: the sender has begun anew.
const MAX_GAP: u16 = 3000;

const WRAP: u64 = 1 << 32;

/// The head of an RTP packet (RFC 3550, 5.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RtpHead {
    pub marker: bool,
    pub payload_type: u8,
    pub sequence: u16,
    pub ticks: u32,
    pub ssrc: u32,
    /// Where the payload begins.
    pub payload: usize,
    /// Where the payload ends, and padding begins.
    pub end: usize,
}

impl RtpHead {
    /// The head of a packet; `None`: the bytes are no RTP packet.
    pub(super) fn parse(packet: &[u8]) -> Option<Self> {
        let head: &[u8; 12] = packet.first_chunk()?;
        if head[0] >> 6 != 2 {
            return None;
        }
        let word = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let mut payload = 12 + 4 * usize::from(head[0] & 0x0f);
        if head[0] & 0x10 != 0 {
            let extension = packet.get(payload..payload + 4)?;
            payload += 4 + 4 * usize::from(u16::from_be_bytes([extension[2], extension[3]]));
        }
        let padding = if head[0] & 0x20 == 0 { 0 } else { usize::from(*packet.last()?).max(1) };
        let end = packet.len().checked_sub(padding)?;
        (payload <= end).then_some(Self {
            marker: head[1] & 0x80 != 0,
            payload_type: head[1] & 0x7f,
            sequence: u16::from_be_bytes([head[2], head[3]]),
            ticks: word(4),
            ssrc: word(8),
            payload,
            end,
        })
    }
}

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrived {
    /// It is whole.
    Whole {
        /// Arrival of its first packet; `None`: not known.
        arrival_ns: Option<u64>,
        /// Whether packets directly before it are lost.
        follows_loss: bool,
    },
    /// Packets of it are lost.
    Incomplete,
}

/// Follows the packets of one stream.
#[derive(Debug, Default)]
pub(super) struct RtpTimes {
    last: Option<Last>,
    ssrc: Option<u32>,
    /// Extended time stamp and arrival of the last pictures.
    pictures: VecDeque<Picture>,
    /// Extended time stamp of the first packet after a loss.
    loss: Option<u64>,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    extended: u64,
    sequence: u16,
    marker: bool,
}

#[derive(Debug, Clone, Copy)]
struct Picture {
    extended: u64,
    arrival_ns: u64,
    bytes: usize,
    is_incomplete: bool,
}

impl RtpTimes {
    /// Takes the next packet, in the order of the sequence numbers. Returns its extended time stamp; `None`:
    /// its picture is larger than [`MAX_PICTURE_BYTES`].
    pub(super) fn on_packet(&mut self, head: RtpHead, bytes: usize, arrival_ns: u64) -> Option<u64> {
        self.ssrc = Some(head.ssrc);
        let extended =
            self.last.map_or(WRAP + u64::from(head.ticks), |last| extend(last.extended, head.ticks));
        let gap = self.last.map_or(0, |last| head.sequence.wrapping_sub(last.sequence).wrapping_sub(1));
        if let Some(last) = self.last
            && gap != 0
        {
            self.on_loss(last, extended, gap);
        }
        match self.pictures.iter_mut().rev().find(|picture| picture.extended == extended) {
            Some(picture) => picture.bytes += bytes,
            None => {
                if self.pictures.len() == REMEMBERED {
                    self.pictures.pop_front();
                }
                self.pictures.push_back(Picture { extended, arrival_ns, bytes, is_incomplete: false });
            }
        }
        if self.last.is_some_and(|last| gap != 0 && gap <= MAX_GAP && last.extended == extended) {
            self.mark_incomplete(extended);
        }
        self.last = Some(Last { extended, sequence: head.sequence, marker: head.marker });
        let picture = self.pictures.iter().rev().find(|picture| picture.extended == extended)?;
        (picture.bytes <= MAX_PICTURE_BYTES).then_some(extended)
    }

    /// The synchronisation source of the packets.
    pub(super) fn ssrc(&self) -> Option<u32> {
        self.ssrc
    }

    fn on_loss(&mut self, last: Last, extended: u64, gap: u16) {
        self.loss = Some(extended);
        if !last.marker && gap <= MAX_GAP {
            self.mark_incomplete(last.extended);
        }
    }

    fn mark_incomplete(&mut self, extended: u64) {
        if let Some(picture) = self.pictures.iter_mut().rev().find(|picture| picture.extended == extended) {
            picture.is_incomplete = true;
        }
    }

    /// What became of the picture with this extended time stamp, which has left the line.
    pub(super) fn on_picture(&mut self, extended: u64) -> Arrived {
        let picture = self.pictures.iter().rev().find(|picture| picture.extended == extended);
        if picture.is_some_and(|picture| picture.is_incomplete) {
            return Arrived::Incomplete;
        }
        let follows_loss = self.loss.is_some();
        if self.loss.is_some_and(|loss| extended >= loss) {
            self.loss = None;
        }
        Arrived::Whole { arrival_ns: picture.map(|picture| picture.arrival_ns), follows_loss }
    }
}

/// The extended time stamp nearest to `last` with these low 32 bits.
fn extend(last: u64, ticks: u32) -> u64 {
    let difference = ticks.wrapping_sub(last as u32).cast_signed();
    last.saturating_add_signed(i64::from(difference))
}

/// Nanoseconds of an extended time stamp. [`to_extended`] is its exact inverse.
pub(super) fn to_ns(extended: u64) -> u64 {
    (u128::from(extended) * 100_000 / 9) as u64
}

/// The extended time stamp of these nanoseconds.
pub(super) fn to_extended(ns: u64) -> u64 {
    ((u128::from(ns) * 9 + 50_000) / 100_000) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(sequence: u16, ticks: u32, marker: bool) -> RtpHead {
        RtpHead { marker, payload_type: 96, sequence, ticks, ssrc: 1, payload: 12, end: 12 }
    }

    fn whole(arrival_ns: u64, follows_loss: bool) -> Arrived {
        Arrived::Whole { arrival_ns: Some(arrival_ns), follows_loss }
    }

    #[test]
    fn time_stamps_survive_the_way_through_nanoseconds() {
        for extended in (0..100_000).chain(WRAP - 50_000..WRAP + 50_000).chain([WRAP * 2000 + 12_345]) {
            assert_eq!(to_extended(to_ns(extended)), extended);
        }
    }

    #[test]
    fn time_stamps_wrap_in_both_directions() {
        let mut times = RtpTimes::default();
        let first = times.on_packet(head(0, u32::MAX - 10, true), 1, 0).unwrap();
        assert_eq!(first as u32, u32::MAX - 10);
        assert_eq!(times.on_packet(head(1, 89, true), 1, 0), Some(first + 100));
        assert_eq!(times.on_packet(head(2, u32::MAX - 20, true), 1, 0), Some(first - 10));
    }

    #[test]
    fn a_picture_arrives_with_its_first_packet() {
        let mut times = RtpTimes::default();
        let first = times.on_packet(head(65_535, 3000, false), 1, 10).unwrap();
        times.on_packet(head(0, 3000, true), 1, 20);
        let second = times.on_packet(head(1, 6000, true), 1, 30).unwrap();
        assert_eq!(times.on_picture(first), whole(10, false));
        assert_eq!(times.on_picture(second), whole(30, false));
        assert_eq!(times.on_picture(7), Arrived::Whole { arrival_ns: None, follows_loss: false });
    }

    #[test]
    fn a_picture_with_a_gap_is_incomplete_and_the_next_follows_a_loss() {
        let mut times = RtpTimes::default();
        let first = times.on_packet(head(10, 3000, false), 1, 1).unwrap();
        times.on_packet(head(12, 3000, true), 1, 2);
        assert_eq!(times.on_picture(first), Arrived::Incomplete);
        let second = times.on_packet(head(13, 6000, true), 1, 3).unwrap();
        assert_eq!(times.on_picture(second), whole(3, true));
        let third = times.on_packet(head(14, 9000, true), 1, 4).unwrap();
        assert_eq!(times.on_picture(third), whole(4, false));
    }

    #[test]
    fn a_picture_without_its_end_is_incomplete() {
        let mut times = RtpTimes::default();
        let first = times.on_packet(head(10, 3000, false), 1, 1).unwrap();
        let second = times.on_packet(head(12, 6000, true), 1, 2).unwrap();
        assert_eq!(times.on_picture(first), Arrived::Incomplete);
        assert_eq!(times.on_picture(second), whole(2, true));
    }

    #[test]
    fn lost_pictures_leave_those_around_them_whole() {
        let mut times = RtpTimes::default();
        let first = times.on_packet(head(10, 3000, true), 1, 1).unwrap();
        assert_eq!(times.on_picture(first), whole(1, false));
        let third = times.on_packet(head(15, 9000, true), 1, 2).unwrap();
        assert_eq!(times.on_picture(third), whole(2, true));
    }

    #[test]
    fn a_picture_has_a_bound() {
        let mut times = RtpTimes::default();
        assert!(times.on_packet(head(0, 1, false), MAX_PICTURE_BYTES, 0).is_some());
        assert_eq!(times.on_packet(head(1, 1, false), 1, 0), None);
        assert!(times.on_packet(head(2, 2, false), 1, 0).is_some());
    }

    #[test]
    fn heads_are_read_with_their_extensions() {
        let mut packet = vec![0x91, 0x80 | 96, 0, 7, 0, 0, 0x0b, 0xb8, 1, 2, 3, 4, 9, 9, 9, 9, 0, 0, 0, 1];
        assert_eq!(RtpHead::parse(&packet), None);
        packet.extend([5, 5, 5, 5]);
        let head = RtpHead::parse(&packet).unwrap();
        assert_eq!((head.marker, head.payload_type, head.sequence), (true, 96, 7));
        assert_eq!((head.ticks, head.ssrc, head.payload), (3000, 0x0102_0304, 24));
        assert_eq!(RtpHead::parse(&[0x47; 188]), None);
    }
}
