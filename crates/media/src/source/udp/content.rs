//! What the first packets contain.
//!
//! A transport stream has packets of 188 bytes that begin with 0x47 (ITU-T H.222.0, 2.4.3.2). A sender may
//! cut the stream into datagrams anywhere. RTP names fixed payload types only (RFC 3551, table 5); the others
//! are told apart by the heads of their NAL units. H.264 and H.265 without any container begin with a start
//! code (Annex B of both) and a parameter set.

use barrelman_media_protocol::format::CodedFormat;

use super::super::nal_heads::EncodingGuess;
use super::super::rtp_times::RtpHead;

/// Packets after which what is still unknown is forgotten.
pub(super) const MAX_PACKETS: usize = 256;

/// Length of a packet of a transport stream.
const TS_PACKET: usize = 188;

const TS_SYNC: u8 = 0x47;

/// Beginnings of packets that tell a transport stream, in a datagram that begins anywhere.
const TS_PLACES: usize = 3;

/// Bytes of a datagram in which a parameter set begins: an access unit delimiter may stand before it.
const SET_WITHIN: usize = 16;

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
    /// Annex B, from a parameter set on.
    Elementary(CodedFormat),
    /// Something that is not read here.
    Other(String),
}

/// Judges packets until their content is known.
#[derive(Debug)]
pub(super) struct Detector {
    format: Option<CodedFormat>,
    guess: EncodingGuess,
    /// Packets of a dynamic type, of which the format is not known.
    undecided: usize,
}

impl Detector {
    /// `format`: of RTP packets whose payload type says nothing.
    pub(super) fn new(format: Option<CodedFormat>) -> Self {
        Self { format, guess: EncodingGuess::default(), undecided: 0 }
    }

    pub(super) fn judge(&mut self, packet: &[u8]) -> Content {
        let head = RtpHead::parse(packet);
        let is_ts_in_rtp = head.is_some_and(|head| {
            head.payload_type == RTP_MPEG_TS && packet.get(head.payload) == Some(&TS_SYNC)
        });
        if !is_ts_in_rtp && is_transport_stream(packet) {
            return Content::TransportStream;
        }
        if let Some(format) = elementary_format(packet) {
            return Content::Elementary(format);
        }
        let Some(head) = head else { return Content::Unknown };
        let rtp = |encoding| Content::Rtp { encoding, payload_type: head.payload_type };
        match head.payload_type {
            RTP_MPEG_TS => rtp("MP2T"),
            RTP_JPEG => rtp("JPEG"),
            FIRST_DYNAMIC.. => match self.format {
                Some(CodedFormat::H264) => rtp("H264"),
                Some(CodedFormat::H265) => rtp("H265"),
                Some(CodedFormat::Vp9) => rtp("VP9"),
                Some(CodedFormat::Av1) => rtp("AV1"),
                None => {
                    self.undecided += 1;
                    self.guess.on_payload(&packet[head.payload..]).map_or(Content::Unknown, rtp)
                }
            },
            // Reports (RTCP) to the same port have types of 72 to 76 here (RFC 5761, 4).
            72..=76 => Content::Unknown,
            other => Content::Other(format!(
                "sends RTP packets of type {other}, which is no video that is read here"
            )),
        }
    }

    /// What [`MAX_PACKETS`] of unknown content are, and what to do.
    pub(super) const fn doubt(&self) -> &'static str {
        if self.undecided > MAX_PACKETS / 2 {
            "sends RTP packets whose format cannot be told. Add ?codec=h264 or ?codec=h265 to the address"
        } else {
            "sends packets that are neither RTP nor MPEG-TS. Set the sender to one of them; H.264 and H.265 without RTP \
             begin with the next parameter set (SPS), which the sender must repeat"
        }
    }
}

/// Whether a datagram is a part of a transport stream: whole packets, or enough of them behind the rest of
/// one.
fn is_transport_stream(datagram: &[u8]) -> bool {
    if datagram.first() == Some(&TS_SYNC) && datagram.len().is_multiple_of(TS_PACKET) {
        return true;
    }
    (0..TS_PACKET.min(datagram.len())).any(|phase| {
        let mut places = datagram[phase..].iter().step_by(TS_PACKET);
        places.len() >= TS_PLACES && places.all(|byte| *byte == TS_SYNC)
    })
}

/// The format of a datagram that begins with a start code, and with a parameter set behind it.
fn elementary_format(datagram: &[u8]) -> Option<CodedFormat> {
    if !(datagram.starts_with(&[0, 0, 1]) || datagram.starts_with(&[0, 0, 0, 1])) {
        return None;
    }
    datagram[..datagram.len().min(SET_WITHIN)].windows(5).find_map(|window| {
        let [0, 0, 1, first, second] = *window else { return None };
        // H.264, 7.3.1: a sequence parameter set (7), which others refer to.
        let is_h264 = first & 0x9f == 7 && first & 0x60 != 0;
        // H.265, 7.3.1.2: a video or a sequence parameter set (32, 33) of layer 0.
        let is_h265 = matches!(first, 0x40 | 0x42) && second == 1;
        match (is_h264, is_h265) {
            (true, _) => Some(CodedFormat::H264),
            (_, true) => Some(CodedFormat::H265),
            _ => None,
        }
    })
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

    /// A part of a transport stream with this many bytes before the first whole packet.
    fn transport_stream(phase: usize, length: usize) -> Vec<u8> {
        let byte =
            |at: usize| if (at + TS_PACKET - phase).is_multiple_of(TS_PACKET) { TS_SYNC } else { 0x80 };
        (0..length).map(byte).collect()
    }

    #[test]
    fn a_transport_stream_may_be_cut_anywhere() {
        for phase in [0, 1, 96, 187] {
            let content = judge(None, &[transport_stream(phase, 1472)]);
            assert_eq!(content, Content::TransportStream, "{phase}");
        }
        assert_eq!(judge(None, &[transport_stream(5, 6 + 2 * 188)]), Content::TransportStream);
        assert!(judge(None, &[transport_stream(5, 5 + 2 * 188)]) != Content::TransportStream);
        let mut torn = transport_stream(5, 1472);
        torn[5 + 4 * 188] = 0;
        assert!(judge(None, &[torn]) != Content::TransportStream);
    }

    #[test]
    fn a_transport_stream_in_rtp_stays_rtp() {
        let content = judge(None, &[packet(RTP_MPEG_TS, &transport_stream(0, 7 * 188))]);
        assert_eq!(content, Content::Rtp { encoding: "MP2T", payload_type: RTP_MPEG_TS });
    }

    #[test]
    fn annex_b_is_known_by_its_parameter_sets() {
        let h264 = Content::Elementary(CodedFormat::H264);
        let h265 = Content::Elementary(CodedFormat::H265);
        for (datagram, content) in [
            (&[0, 0, 0, 1, 0x67, 0x42, 0, 0x1f][..], &h264),
            (&[0, 0, 1, 0x27, 0x4d], &h264),
            (&[0, 0, 0, 1, 9, 0xf0, 0, 0, 0, 1, 0x67, 0x42], &h264),
            (&[0, 0, 0, 1, 0x40, 1, 0x0c, 1], &h265),
            (&[0, 0, 0, 1, 0x42, 1, 1, 1], &h265),
            (&[0, 0, 0, 1, 0x46, 1, 0x10, 0, 0, 0, 1, 0x40, 1], &h265),
            (&[0, 0, 0, 1, 0x41, 0x9a, 0, 1], &Content::Unknown),
            (&[0, 0, 0, 1, 0x68, 0xce], &Content::Unknown),
            (&[9, 0, 0, 0, 1, 0x67, 0x42], &Content::Unknown),
            (&[0, 0, 0, 1, 0x67], &Content::Unknown),
            (&[0, 0, 1], &Content::Unknown),
        ] {
            assert_eq!(judge(None, &[datagram.to_vec()]), *content, "{datagram:x?}");
        }
    }

    #[test]
    fn what_stays_unknown_is_told_with_what_to_do() {
        let mut detector = Detector::new(None);
        (0..MAX_PACKETS).for_each(|_| assert_eq!(detector.judge(b"telemetry"), Content::Unknown));
        assert!(detector.doubt().contains("neither RTP nor MPEG-TS"));
        let mut detector = Detector::new(None);
        let unclear = packet(96, &[0xff, 0xff]);
        (0..MAX_PACKETS).for_each(|_| assert_eq!(detector.judge(&unclear), Content::Unknown));
        assert!(detector.doubt().contains("?codec=h264"));
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
