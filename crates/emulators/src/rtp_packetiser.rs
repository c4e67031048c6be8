//! H.264 in RTP packets (RFC 6184), interleaved into an RTSP connection.

use barrelman_video::annexb;
use barrelman_vocab::EncodedUnit;

/// Longest payload of an RTP packet, bytes.
const MAX_PAYLOAD_BYTES: usize = 1400;
/// Rate of the video's RTP clock, Hz.
pub(super) const RTP_HZ: u64 = 90_000;
/// RTP payload type of the video.
pub(super) const RTP_TYPE: u8 = 96;

/// Splits pictures into RTP packets.
#[derive(Default)]
pub(super) struct RtpPacketiser {
    sequence: u16,
}

impl RtpPacketiser {
    /// The packets of a picture, each in RTSP's interleaved framing.
    pub(super) fn packets(&mut self, unit: &EncodedUnit, channel: u8) -> Vec<u8> {
        let time = (u128::from(unit.capture.at.as_nanos()) * u128::from(RTP_HZ) / 1_000_000_000) as u32;
        let mut bytes = Vec::with_capacity(unit.payload.len() + unit.payload.len() / 32 + 64);
        let mut nals = annexb::nals(&unit.payload).peekable();
        while let Some(nal) = nals.next() {
            let ends_picture = nals.peek().is_none();
            if nal.len() <= MAX_PAYLOAD_BYTES {
                self.append(&mut bytes, channel, time, ends_picture, &[nal]);
                continue;
            }
            // Fragments (FU-A): two bytes in front of each carry the NAL unit's header.
            let (header, content) = (nal[0], &nal[1..]);
            let mut pieces = content.chunks(MAX_PAYLOAD_BYTES - 2).enumerate().peekable();
            while let Some((index, piece)) = pieces.next() {
                let is_last = pieces.peek().is_none();
                let flags = u8::from(index == 0) << 7 | u8::from(is_last) << 6;
                let fragment_header = [header & 0xe0 | 28, flags | header & 0x1f];
                let marker = is_last && ends_picture;
                self.append(&mut bytes, channel, time, marker, &[&fragment_header, piece]);
            }
        }
        bytes
    }

    /// Appends one packet. `marker`: the packet ends its picture.
    fn append(&mut self, bytes: &mut Vec<u8>, channel: u8, time: u32, marker: bool, payload: &[&[u8]]) {
        let length = 12 + payload.iter().map(|part| part.len()).sum::<usize>();
        bytes.extend([b'$', channel]);
        bytes.extend((length as u16).to_be_bytes());
        bytes.extend([0x80, u8::from(marker) << 7 | RTP_TYPE]);
        bytes.extend(self.sequence.to_be_bytes());
        bytes.extend(time.to_be_bytes());
        bytes.extend(*b"boat");
        payload.iter().for_each(|part| bytes.extend(*part));
        self.sequence = self.sequence.wrapping_add(1);
    }
}
