//! The parser and the decoder of a format.

use barrelman_media_protocol::decoder::DecoderElement;
use barrelman_media_protocol::format::CodedFormat;
use gst::prelude::*;
use gstreamer as gst;
use gstreamer_video::VideoDecoder;

/// Why no decoder can start.
#[derive(Debug)]
pub(super) struct NoDecoder {
    pub(super) reason: String,
    pub(super) remedy: String,
}

/// The caps of a format's units.
pub(super) fn unit_caps(format: CodedFormat) -> gst::Caps {
    match format {
        CodedFormat::H264 => byte_stream("video/x-h264"),
        CodedFormat::H265 => byte_stream("video/x-h265"),
        CodedFormat::Vp9 => gst::Caps::builder("video/x-vp9").build(),
        CodedFormat::Av1 => gst::Caps::builder("video/x-av1")
            .field("stream-format", "obu-stream")
            .field("alignment", "tu")
            .build(),
    }
}

fn byte_stream(name: &str) -> gst::Caps {
    gst::Caps::builder(name).field("stream-format", "byte-stream").field("alignment", "au").build()
}

/// The name of a format's parser.
pub(super) const fn parser(format: CodedFormat) -> &'static str {
    match format {
        CodedFormat::H264 => "h264parse",
        CodedFormat::H265 => "h265parse",
        CodedFormat::Vp9 => "vp9parse",
        CodedFormat::Av1 => "av1parse",
    }
}

/// The Debian package of a format's decoder in software.
pub(super) const fn package(format: CodedFormat) -> &'static str {
    match format {
        CodedFormat::H264 | CodedFormat::H265 => "gstreamer1.0-libav",
        CodedFormat::Vp9 => "gstreamer1.0-plugins-good",
        CodedFormat::Av1 => "gstreamer1.0-plugins-bad",
    }
}

/// The decoder of a format that GStreamer ranks highest among those that can be opened, opened. A decoder in
/// hardware whose device is absent or in use is passed over.
pub(super) fn decoder(format: CodedFormat) -> Option<(gst::Element, DecoderElement)> {
    let kinds = gst::ElementFactoryType::DECODER
        | gst::ElementFactoryType::MEDIA_VIDEO
        | gst::ElementFactoryType::MEDIA_IMAGE;
    let mut factories: Vec<gst::ElementFactory> =
        gst::ElementFactory::factories_with_type(kinds, gst::Rank::MARGINAL).into_iter().collect();
    let caps = unit_caps(format);
    factories.retain(|factory| factory.can_sink_any_caps(&caps));
    factories.sort_by(|a, b| b.rank().cmp(&a.rank()).then_with(|| a.name().cmp(&b.name())));
    factories.into_iter().find_map(|factory| {
        let element = factory.create().build().ok()?;
        // Not a bin for streams of a special kind, such as those with transparency.
        element.is::<VideoDecoder>().then_some(())?;
        if element.set_state(gst::State::Ready).is_err() {
            let _ = element.set_state(gst::State::Null);
            return None;
        }
        let is_hardware = factory.klass().split('/').any(|word| word == "Hardware");
        let name = factory.name().to_string();
        Some((element, DecoderElement { name, is_hardware }))
    })
}
