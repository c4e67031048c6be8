//! The two engines that read and decode video.

use serde::{Deserialize, Serialize};

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
