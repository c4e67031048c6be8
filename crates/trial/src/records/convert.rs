//! Conversion of entries to stored messages and back.
//!
//! A stored message that lacks a required field, or has a number that stands for no known variant, is [`Malformed`].

mod malformed;

mod enums;
mod input;
mod outcome;
mod request;
mod telemetry;
mod track;
mod truth;
mod video;

pub(super) use malformed::Malformed;

use super::entry::RecordingStart;
use super::stored;

impl From<&RecordingStart> for stored::RecordingStart {
    fn from(start: &RecordingStart) -> Self {
        Self {
            program_version: start.program_version.clone(),
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration.clone(),
            video: start.video.clone(),
            link: start.link.clone(),
            live_video: start.live_video,
        }
    }
}

impl From<stored::RecordingStart> for RecordingStart {
    fn from(start: stored::RecordingStart) -> Self {
        Self {
            program_version: start.program_version,
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration,
            video: start.video,
            link: start.link,
            live_video: start.live_video,
        }
    }
}
