//! The two engines that read and decode video.

use serde::{Deserialize, Serialize};

use crate::media::MediaProgram;

/// Which engine reads and decodes a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VideoEngine {
    /// The built-in engine where it reads the source, otherwise GStreamer.
    #[default]
    Auto,
    /// The built-in engine: H.264 over RTSP in the TCP connection, MP4, Y4M, pictures.
    BuiltIn,
    /// GStreamer, in the program `barrelman-media`.
    Gstreamer,
}

impl VideoEngine {
    /// The program of the second engine, where the engine may be used and is installed.
    pub(crate) fn media_program(self) -> Option<MediaProgram> {
        match self {
            Self::BuiltIn => None,
            Self::Auto | Self::Gstreamer => MediaProgram::installed(),
        }
    }
}
