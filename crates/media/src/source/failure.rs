//! Why a source cannot go on, in plain words, with what to do.

use barrelman_media_protocol::failure::SourceFailure;
pub(super) use barrelman_media_protocol::failure::{from_status, permanent, temporary};
use gstreamer as gst;

/// An element of GStreamer is not installed.
pub(super) fn missing_element(name: &str) -> SourceFailure {
    let what = format!("needs GStreamer's element {name}, which is not installed");
    permanent(what, format!("Install {}", package(name)))
}

/// The Debian package of an element.
fn package(element: &str) -> &'static str {
    match element {
        "rtspsrc" | "rtpjitterbuffer" | "rtph264depay" | "rtph265depay" | "rtpjpegdepay" | "rtpmp2tdepay"
        | "v4l2src" | "souphttpsrc" | "jpegenc" => "gstreamer1.0-plugins-good",
        "h264parse" | "h265parse" | "av1parse" | "vp9parse" | "tsdemux" | "srtsrc" | "rtmp2src"
        | "sdpdemux" => "gstreamer1.0-plugins-bad",
        _ => "gstreamer1.0-plugins-base",
    }
}

/// Elements do not fit together, which is no fault of the stream.
pub(super) fn unlinked(error: impl std::fmt::Display) -> SourceFailure {
    permanent(
        format!("cannot be played: GStreamer's elements do not fit together ({error})"),
        "Install GStreamer's packages anew, all of one version",
    )
}

/// What GStreamer reports.
pub(super) fn from_gst(error: &gst::glib::Error, debug: &str) -> SourceFailure {
    if let Some(failure) = status_in(debug).and_then(from_status) {
        return failure;
    }
    let said = error.message().trim_end_matches('.').to_owned();
    if let Some(kind) = error.kind::<gst::ResourceError>() {
        return from_resource(kind, &said, debug);
    }
    match error.kind::<gst::StreamError>() {
        Some(gst::StreamError::CodecNotFound) => missing_codec(&said),
        Some(gst::StreamError::TypeNotFound | gst::StreamError::WrongType) => {
            permanent("is no video that is read here", "Check that the address leads to a video")
        }
        Some(gst::StreamError::Decrypt | gst::StreamError::DecryptNokey) => {
            permanent("is encrypted", "Set the camera to a stream without encryption of its own")
        }
        _ => temporary(format!("cannot be played: {said}"), ""),
    }
}

/// A codec whose plug-in is not installed.
pub(super) fn missing_codec(name: &str) -> SourceFailure {
    permanent(
        format!("needs a plug-in of GStreamer that is not installed ({name})"),
        "Install gstreamer1.0-plugins-good, gstreamer1.0-plugins-bad and gstreamer1.0-libav",
    )
}

fn from_resource(kind: gst::ResourceError, said: &str, debug: &str) -> SourceFailure {
    match kind {
        gst::ResourceError::NotAuthorized => from_status(401),
        gst::ResourceError::NotFound => from_status(404),
        gst::ResourceError::Busy => Some(temporary("is in use", "Close the other program that uses it")),
        _ => from_words(debug),
    }
    .unwrap_or_else(|| temporary(format!("cannot be reached: {said}"), NOT_REACHED))
}

const NOT_REACHED: &str = "Check that the device is on and in this network";

/// What the system's words say that GStreamer passes on.
pub(super) fn from_words(debug: &str) -> Option<SourceFailure> {
    let debug = debug.to_ascii_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| debug.contains(word));
    if has(&["certificate", "tls"]) {
        return Some(permanent(
            "shows a certificate that is not trusted",
            "Install the camera's certificate on this machine, or use the address without TLS",
        ));
    }
    if has(&["connection refused"]) {
        return Some(temporary(
            "refuses the connection: nothing listens at this port",
            "Check the port in the address, and that the stream is switched on",
        ));
    }
    if has(&["no route", "unreachable"]) {
        return Some(temporary("cannot be reached: there is no way to it", NOT_REACHED));
    }
    if has(&["resolv", "name or service not known", "unknown host"]) {
        return Some(temporary("cannot be found: its name is not known", "Check the name in the address"));
    }
    if has(&["udp packets"]) {
        return Some(temporary(
            "sends no packets over UDP, or a firewall holds them back",
            "Choose TCP as the transport",
        ));
    }
    has(&["timeout", "timed out", "time out"]).then(|| temporary("does not answer", NOT_REACHED))
}

/// The status in GStreamer's words, such as "Unauthorized (401)" and "Error (503): busy".
fn status_in(debug: &str) -> Option<u16> {
    debug.split('(').skip(1).find_map(|rest| {
        let (number, _) = rest.split_once(')')?;
        let is_status = number.len() == 3 && number.starts_with(['3', '4', '5']);
        is_status.then(|| number.parse().ok()).flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resource(kind: gst::ResourceError, debug: &str) -> SourceFailure {
        from_gst(&gst::glib::Error::new(kind, "It failed."), debug)
    }

    #[test]
    fn words_of_gstreamer_become_plain_ones() {
        gst::init().unwrap();
        let read = gst::ResourceError::Read;
        let cases = [
            (gst::ResourceError::NotAuthorized, "", "does not let us in", true),
            (read, "x.c(12): f (): Unauthorized (401)", "does not let us in", true),
            (read, "Error (453): no", "has not enough bandwidth for one more viewer", false),
            (
                read,
                "Failed: Connection refused",
                "refuses the connection: nothing listens at this port",
                false,
            ),
            (read, "No route to host", "cannot be reached: there is no way to it", false),
            (read, "Could not connect: Socket I/O timed out", "does not answer", false),
            (read, "what else", "cannot be reached: It failed", false),
        ];
        for (kind, debug, what, is_final) in cases {
            let failure = resource(kind, debug);
            assert_eq!((failure.what.as_str(), failure.is_final), (what, is_final), "{debug}");
        }
    }

    #[test]
    fn numbers_that_are_no_status_are_not_taken_for_one() {
        assert_eq!(status_in("gstrtspsrc.c(8133): gst_rtspsrc_open (): Not Found (404)"), Some(404));
        assert_eq!(status_in("file.c(404x): f ()"), None);
        assert_eq!(status_in("(12) (4040)"), None);
    }
}
