//! This program's own options in an address: `?fps=30&fault=stall@12`.

use barrelman_host::fault::FaultPlan;
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::source::{DeviceFormat, RtspTransport};
use barrelman_vocab::PictureSize;

use super::error::VideoUrlError;

/// The options. `None`: not given.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Options {
    /// Pictures per second of a folder, or of a device.
    pub(super) fps: Option<f64>,
    pub(super) faults: FaultPlan,
    pub(super) transport: Option<RtspTransport>,
    pub(super) codec: Option<CodedFormat>,
    pub(super) size: Option<PictureSize>,
    pub(super) format: Option<DeviceFormat>,
}

/// Which options a kind of address has. A camera's address has options of its own, which are left to the
/// camera.
pub(super) const FILE: &[&str] = &["fps", "fault"];
pub(super) const RTSP: &[&str] = &["fault", "transport"];
pub(super) const UDP: &[&str] = &["fault", "codec"];
pub(super) const DEVICE: &[&str] = &["fault", "size", "fps", "format"];
pub(super) const NETWORK: &[&str] = &["fault"];

impl Options {
    /// Takes the options of this program out of a query. Returns the rest.
    ///
    /// # Errors
    /// A value that an option cannot have.
    pub(super) fn take_from(&mut self, query: &str, known: &[&'static str]) -> Result<String, VideoUrlError> {
        let mut rest = Vec::new();
        for option in query.split('&').filter(|option| !option.is_empty()) {
            let (name, value) = option.split_once('=').unwrap_or((option, ""));
            match known.iter().find(|known| **known == name) {
                Some(name) => self.set(name, value)?,
                None => rest.push(option),
            }
        }
        Ok(rest.join("&"))
    }

    /// Whether every option of a query is known.
    pub(super) fn are_all_known(query: &str, known: &[&str]) -> bool {
        query.split('&').all(|option| option.split_once('=').is_some_and(|(name, _)| known.contains(&name)))
    }

    fn set(&mut self, name: &'static str, value: &str) -> Result<(), VideoUrlError> {
        let value = percent_decoded(value);
        let invalid = |example| VideoUrlError::InvalidOption { name, value: value.clone(), example };
        match name {
            "fps" => {
                let fps = value.parse().ok().filter(|fps| *fps > 0.0 && *fps <= 1000.0);
                self.fps = Some(fps.ok_or_else(|| invalid("fps=30 (more than 0, at most 1000)"))?);
            }
            "fault" => self.faults = FaultPlan::parse(&value)?,
            "transport" => {
                self.transport = Some(match value.as_str() {
                    "tcp" => RtspTransport::Tcp,
                    "udp" => RtspTransport::Udp,
                    "multicast" => RtspTransport::Multicast,
                    _ => return Err(invalid("transport=udp (or tcp, multicast)")),
                });
            }
            "codec" => {
                self.codec = Some(match value.to_ascii_lowercase().as_str() {
                    "h264" => CodedFormat::H264,
                    "h265" | "hevc" => CodedFormat::H265,
                    _ => return Err(invalid("codec=h265 (or h264)")),
                });
            }
            "size" => {
                let size = value.split_once('x').and_then(|(width, height)| {
                    Some(PictureSize::new(width.parse().ok()?, height.parse().ok()?))
                });
                let is_possible = |size: &PictureSize| (16..=8192).contains(&size.width.min(size.height));
                self.size = Some(size.filter(is_possible).ok_or_else(|| invalid("size=1280x720"))?);
            }
            "format" => {
                self.format = Some(match value.as_str() {
                    "mjpeg" => DeviceFormat::Mjpeg,
                    "h264" => DeviceFormat::H264,
                    "h265" => DeviceFormat::H265,
                    "raw" => DeviceFormat::Raw,
                    _ => return Err(invalid("format=mjpeg (or h264, h265, raw)")),
                });
            }
            _ => {}
        }
        Ok(())
    }
}

pub(super) fn percent_decoded(text: &str) -> String {
    percent_encoding::percent_decode_str(text).decode_utf8_lossy().into_owned()
}
