//! What the first packets contain.
//!
//! A transport stream has packets of 188 bytes that begin with 0x47 (ITU-T H.222.0, 2.4.3.2). RTP names fixed
//! payload types only (RFC 3551, table 5); the others are told apart by the heads of their NAL units.

use barrelman_media_protocol::format::CodedFormat;

use super::super::nal_heads::EncodingGuess;
use super::super::rtp_times::RtpHead;

/// Packets after which what is still unknown is forgotten.
pub(super) const MAX_PACKETS: usize = 256;

/// Length of a packet of a transport stream.
const TS_PACKET: usize = 188;

const TS_SYNC: u8 = 0x47;
const RTP_JPEG: u8 = 26;
const RTP_MPEG_TS: u8 = 33;
const FIRST_DYNAMIC: u8 = 96;

/// What packets contain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Content {
    /// It cannot be told yet.
    Unknown,
    TransportStream,
    /// RTP packets with this encoding name.
    Rtp {
        encoding: &'static str,
        payload_type: u8,
    },
    /// Something that is not read here.
    Other(String),
}

/// Judges packets until their content is known.
#[derive(Debug)]
pub(super) struct Detector {
    format: Option<CodedFormat>,
    guess: EncodingGuess,
}

impl Detector {
    /// `format`: of RTP packets whose payload type says nothing.
    pub(super) fn new(format: Option<CodedFormat>) -> Self {
        Self { format, guess: EncodingGuess::default() }
    }

    pub(super) fn judge(&mut self, packet: &[u8]) -> Content {
        if packet.first() == Some(&TS_SYNC) && packet.len().is_multiple_of(TS_PACKET) {
            return Content::TransportStream;
        }
        let Some(head) = RtpHead::parse(packet) else { return Content::Unknown };
        let rtp = |encoding| Content::Rtp { encoding, payload_type: head.payload_type };
        match head.payload_type {
            RTP_MPEG_TS => rtp("MP2T"),
            RTP_JPEG => rtp("JPEG"),
            FIRST_DYNAMIC.. => match self.format {
                Some(CodedFormat::H264) => rtp("H264"),
                Some(CodedFormat::H265) => rtp("H265"),
                Some(CodedFormat::Vp9) => rtp("VP9"),
                Some(CodedFormat::Av1) => rtp("AV1"),
                None => self.guess.on_payload(&packet[head.payload..]).map_or(Content::Unknown, rtp),
            },
            // Reports (RTCP) to the same port have types of 72 to 76 here (RFC 5761, 4).
            72..=76 => Content::Unknown,
            other => Content::Other(format!(
                "sends RTP packets of type {other}, which is no video that is read here"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packet(payload_type: u8, payload: &[u8]) -> Vec<u8> {
        [&[0x80, payload_type, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1], payload].concat()
    }

    fn judge(format: Option<CodedFormat>, packets: &[Vec<u8>]) -> Content {
        let mut detector = Detector::new(format);
        packets
            .iter()
            .map(|packet| detector.judge(packet))
            .find(|content| *content != Content::Unknown)
            .unwrap_or(Content::Unknown)
    }

    #[test]
    fn fixed_types_and_transport_streams_are_known_at_once() {
        assert_eq!(judge(None, &[vec![0x47; 7 * 188]]), Content::TransportStream);
        assert_eq!(judge(None, &[vec![0x47; 187]]), Content::Unknown);
        for (payload_type, encoding) in [(33, "MP2T"), (26, "JPEG")] {
            assert_eq!(judge(None, &[packet(payload_type, b"")]), Content::Rtp { encoding, payload_type });
        }
        assert!(matches!(judge(None, &[packet(0, b"")]), Content::Other(_)));
    }

    #[test]
    fn h264_and_h265_are_told_apart_by_their_nal_units() {
        let h264 =
            [[0x67, 0x42], [0x68, 0xce], [0x06, 5], [0x7c, 0x85], [0x7c, 0x05], [0x41, 0x9a], [0x61, 1]];
        let h265 = [[0x40, 1], [0x42, 1], [0x44, 1], [0x4e, 1], [0x62, 1], [0x02, 1], [0x26, 1]];
        for (heads, encoding) in [(h264, "H264"), (h265, "H265")] {
            let packets = heads.map(|head| packet(96, &head));
            assert_eq!(judge(None, &packets), Content::Rtp { encoding, payload_type: 96 });
            assert_eq!(judge(None, &packets[..4]), Content::Unknown);
        }
        let content = judge(Some(CodedFormat::H265), &[packet(97, &[0x67, 0x42])]);
        assert_eq!(content, Content::Rtp { encoding: "H265", payload_type: 97 });
    }
}
