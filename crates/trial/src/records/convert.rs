//! Conversion of entries to stored messages and back.
//!
//! A stored message that lacks a required field, or has a number that stands for no known variant, is
//! [`Malformed`].

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

use super::entry::{RecordedVideo, RecordingStart, SimulatedTrial};
use super::stored;
use barrelman_vocab::Videos;

impl From<&RecordedVideo> for stored::VideoSource {
    fn from(video: &RecordedVideo) -> Self {
        Self { address: video.address.clone(), live: video.is_live }
    }
}

impl From<stored::VideoSource> for RecordedVideo {
    fn from(video: stored::VideoSource) -> Self {
        Self { address: video.address, is_live: video.live }
    }
}

impl From<&RecordingStart> for stored::RecordingStart {
    fn from(start: &RecordingStart) -> Self {
        Self {
            program: start.program.clone(),
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration.clone(),
            video: Some((&start.videos.first).into()),
            second_video: start.videos.second.as_ref().map(Into::into),
            link: start.link.clone(),
            command_path: stored::CommandPath::from(start.command_path) as i32,
            trial: start.trial.clone().map(|SimulatedTrial { seed, settings, scenario }| {
                stored::SimulatedTrial { seed, settings, scenario }
            }),
        }
    }
}

impl TryFrom<stored::RecordingStart> for RecordingStart {
    type Error = Malformed;

    fn try_from(start: stored::RecordingStart) -> Result<Self, Malformed> {
        let command_path = stored::CommandPath::try_from(start.command_path)
            .map_err(|_| malformed::missing("command_path"))?
            .try_into()?;
        Ok(Self {
            program: start.program,
            monotonic_ns: start.monotonic_ns,
            unix_ns: start.unix_ns,
            configuration: start.configuration,
            videos: Videos {
                first: start.video.ok_or_else(|| malformed::missing("video"))?.into(),
                second: start.second_video.map(Into::into),
            },
            link: start.link,
            command_path,
            trial: start.trial.map(|stored::SimulatedTrial { seed, settings, scenario }| SimulatedTrial {
                seed,
                settings,
                scenario,
            }),
        })
    }
}
