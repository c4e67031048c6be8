//! A server that announces H.264 and sends H.265, or the other way round.

use std::sync::{Arc, Mutex, PoisonError};

use barrelman_media_protocol::failure::SourceFailure;
use gst::prelude::*;
use gstreamer as gst;

use super::super::failure::temporary;
use super::super::nal_heads::EncodingGuess;
use super::super::play::Play;
use super::super::rtp_times::RtpHead;

/// What [`watch`] looks at; the names have one length.
const ENCODINGS: [&str; 2] = ["H264", "H265"];

/// Fails where the packets of a pad are of another encoding than the server has announced.
pub(super) fn watch(play: &Arc<Play>, pad: &gst::Pad) {
    let caps = pad.current_caps().unwrap_or_else(|| pad.query_caps(None));
    let name = caps.structure(0).and_then(|structure| structure.get::<String>("encoding-name").ok());
    let Some(announced) = name.filter(|name| ENCODINGS.contains(&name.as_str())) else { return };
    let (weak, guess) = (Arc::downgrade(play), Mutex::new(EncodingGuess::default()));
    pad.add_probe(gst::PadProbeType::BUFFER | gst::PadProbeType::BUFFER_LIST, move |pad, info| {
        let mut guess = guess.lock().unwrap_or_else(PoisonError::into_inner);
        let mut look = |buffer: &gst::BufferRef| {
            let packet = buffer.map_readable().ok()?;
            let head = RtpHead::parse(&packet)?;
            guess.on_payload(&packet[head.payload..head.end])
        };
        let sent = match &info.data {
            Some(gst::PadProbeData::Buffer(buffer)) => look(buffer),
            Some(gst::PadProbeData::BufferList(list)) => list.iter().find_map(look),
            _ => None,
        };
        let Some(sent) = sent else { return gst::PadProbeReturn::Ok };
        if sent != announced
            && let (Some(play), Some(element)) = (weak.upgrade(), pad.parent_element())
        {
            let failure = failure(sent);
            play.set_reason(failure.clone());
            gst::element_error!(element, gst::StreamError::WrongType, ("{}", failure.what));
        }
        gst::PadProbeReturn::Remove
    });
}

/// The failure of a stream of another encoding than its server has announced.
fn failure(sent: &str) -> SourceFailure {
    temporary(format!("sends {sent} and announces another encoding"), "Update the camera's firmware")
}

/// The encoding that is sent, where that was the reason of a failure.
pub(super) fn sent(reason: &SourceFailure) -> Option<&'static str> {
    ENCODINGS.into_iter().find(|encoding| failure(encoding) == *reason)
}

/// Writes the encoding that is sent into a description of streams (RFC 8866, 6.6).
pub(super) fn correct(description: &mut [u8], sent: &str) {
    for line in description.split_mut(|byte| *byte == b'\n').filter(|line| line.starts_with(b"a=rtpmap:")) {
        let is_encoding =
            |name: &[u8]| ENCODINGS.iter().any(|known| name.eq_ignore_ascii_case(known.as_bytes()));
        let Some(at) = line.iter().position(|byte| *byte == b' ') else { continue };
        if let Some(name) = line.get_mut(at + 1..at + 1 + sent.len())
            && is_encoding(name)
        {
            name.copy_from_slice(sent.as_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_names_what_is_sent() {
        let mut text =
            *b"m=video 0 RTP/AVP 96\r\na=rtpmap:96 h265/90000\r\na=rtpmap:8 PCMA/8000\r\na=rtpmap:96 H26";
        correct(&mut text, "H264");
        assert_eq!(
            text,
            *b"m=video 0 RTP/AVP 96\r\na=rtpmap:96 H264/90000\r\na=rtpmap:8 PCMA/8000\r\na=rtpmap:96 H26"
        );
    }

    #[test]
    fn the_reason_of_a_failure_is_the_encoding_that_is_sent() {
        assert_eq!(sent(&failure("H265")), Some("H265"));
        assert_eq!(sent(&temporary("does not answer", "")), None);
    }
}
