//! What arrives from a sender: pictures and sender reports.

use barrelman_vocab::time::Timestamp;

/// A picture as it arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArrivedPicture {
    /// RTP time.
    pub rtp: u32,
    /// Size of the encoded picture, bytes.
    pub bytes: usize,
    /// Arrival of its first packet.
    pub arrival: Timestamp,
}

/// A sender report (RFC 3550, 6.4.1) as it arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SenderReport {
    /// RTP time of the moment of the report.
    pub rtp: u32,
    /// Wall-clock time of the same moment by the sender's clock, nanoseconds since 1900; `None`: not told.
    pub sender_wall_ns: Option<i128>,
    /// Arrival.
    pub arrival: Timestamp,
    /// Wall-clock time of the arrival by this machine's clock, nanoseconds since 1900.
    pub wall_ns: i128,
}
