//! The messages of a source.
//!
//! The program sends the settings once. The source then sends [`FromSource`], and ends.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use serde::{Deserialize, Serialize};

use crate::failure::SourceFailure;
use crate::format::CodedFormat;

/// Longest silence of a source that runs: [`FromSource::Alive`] comes at least this often.
pub const ALIVE_INTERVAL_MS: u64 = 100;

/// What a source plays, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceSettings {
    /// What is played.
    pub address: SourceAddress,
    /// Whether units are sent as they arrive. Otherwise the source is read at the pace at which the socket is
    /// read.
    pub is_live: bool,
}

impl SourceSettings {
    /// A file or a pipe.
    pub const fn file(path: PathBuf, is_live: bool) -> Self {
        Self { address: SourceAddress::File(path), is_live }
    }
}

/// What a source plays. Holds passwords: never print this.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
pub enum SourceAddress {
    /// An RTSP server.
    Rtsp {
        /// The address without login: `rtsp://` or `rtsps://`.
        url: String,
        /// The way of the packets.
        transport: RtspTransport,
        /// The login.
        login: Option<SourceLogin>,
    },
    /// A UDP port that packets are sent to: RTP, MPEG-TS, or H.264 and H.265 without either, found by their
    /// content.
    Udp {
        /// The port, and the local address or the multicast group.
        bind: SocketAddr,
        /// The format of RTP packets whose payload type says nothing; `None`: guessed from the first packets.
        format: Option<CodedFormat>,
    },
    /// An SDP file, which describes RTP streams.
    Sdp(PathBuf),
    /// A video capture device.
    Device(DeviceSettings),
    /// A stream that GStreamer has a source element for: `srt://`, `rtmp://`, `http(s)://`.
    Network {
        /// The address without login.
        url: String,
        /// The login, where the protocol has one.
        login: Option<SourceLogin>,
    },
    /// A file, or a pipe.
    File(PathBuf),
    /// A pipeline in the notation of `gst-launch-1.0`, whose last element puts out video.
    Pipeline(String),
}

impl SourceAddress {
    /// Whether [`FromSource::Ended`] is the end of the video: of a file, an address that may be one (HTTP),
    /// or a pipeline of the operator. A camera's stream that ends is lost.
    pub fn may_end(&self) -> bool {
        match self {
            Self::Rtsp { .. } | Self::Udp { .. } | Self::Sdp(_) | Self::Device(_) => false,
            Self::Network { url, .. } => url.starts_with("http"),
            Self::File(_) | Self::Pipeline(_) => true,
        }
    }
}

/// A login. Not printed.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceLogin {
    /// The user.
    pub user: String,
    /// The password.
    pub password: String,
    /// Whether the password may be sent without encryption (Basic).
    pub permits_basic: bool,
}

/// The way of an RTSP server's packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RtspTransport {
    /// In the TCP connection; where the server refuses this, over UDP.
    Auto,
    /// In the TCP connection.
    Tcp,
    /// Over UDP.
    Udp,
    /// Over UDP to a multicast group.
    Multicast,
}

/// A video capture device and what is asked of it; `None`: what the device prefers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceSettings {
    /// `/dev/video0`.
    pub path: PathBuf,
    /// Size of the pictures.
    pub size: Option<PictureSize>,
    /// Pictures per second.
    pub fps: Option<f64>,
    /// Format of the pictures.
    pub format: Option<DeviceFormat>,
}

/// A format of a capture device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum DeviceFormat {
    /// JPEG pictures.
    Mjpeg,
    /// H.264.
    H264,
    /// H.265.
    H265,
    /// Uncompressed pictures.
    Raw,
}

/// A message of a source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FromSource {
    /// The source runs. Sent at least every [`ALIVE_INTERVAL_MS`].
    Alive,
    /// The source is connected: "H.265 by RTP over UDP".
    Opened(String),
    /// One encoded picture, which is the payload.
    Unit(SourceUnit),
    /// An RTCP sender report.
    SenderReport(SourceReport),
    /// Something odd that does not stop the source, in one line.
    Note(String),
    /// The end of a file or of a stream.
    Ended,
    /// The source cannot go on.
    Failed(SourceFailure),
}

/// An encoded picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceUnit {
    /// Format of the payload.
    pub codec: UnitCodec,
    /// Whether decoding can start here.
    pub key: bool,
    /// Whether something was lost directly before: the units up to the next key cannot be decoded.
    pub follows_loss: bool,
    /// Rotation that displays the picture upright.
    pub rotation: Rotation,
    /// The time that the source gives.
    pub time: UnitTime,
    /// Arrival of the picture's first byte: nanoseconds of `CLOCK_MONOTONIC`.
    pub arrival_ns: u64,
}

/// The time that a source gives to a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum UnitTime {
    /// The RTP time stamp, in ticks of 1/90000 s, or an MPEG-TS time stamp, which has the same ticks.
    Ticks(u32),
    /// Nanoseconds since the start of the file.
    SinceStart(u64),
    /// Time of capture: nanoseconds of `CLOCK_MONOTONIC`.
    Captured(u64),
    /// None.
    Unknown,
}

/// An RTCP sender report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceReport {
    /// The RTP time stamp.
    pub rtp: u32,
    /// The sender's wall clock: NTP time, seconds in the upper 32 bits. 0: the sender has none.
    pub ntp: u64,
    /// Arrival: nanoseconds of `CLOCK_MONOTONIC`.
    pub arrival_ns: u64,
}

impl std::fmt::Debug for SourceAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SourceAddress(***)")
    }
}

impl std::fmt::Debug for SourceLogin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SourceLogin(***)")
    }
}
