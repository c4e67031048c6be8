//! The video source of a live run: a stream or file, or a simulated world.

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_host::redaction::without_logins;
use barrelman_link_http::Trust;
use barrelman_video::sender_clock::TimingSettings;
use barrelman_video::url::VideoSource;
use barrelman_video::{VideoHandle, VideoUrl};
use barrelman_vocab::VehicleProfile;

use super::video_sink::LiveVideoSink;
use crate::config::Configuration;
use crate::encrypted_video;
use crate::simulated_source::{self, LiveWorld};
use crate::source_url::{SimulatedUrl, SourceUrl};

/// A video source that has not started.
pub enum Source {
    /// A stream, a file, or a folder of pictures.
    Video(Box<VideoUrl>, Trust),
    /// A simulated world.
    Simulated(SimulatedUrl, Box<LiveWorld>),
}

impl Source {
    /// Loads a source. A stream or file is opened later, by [`Self::start`]. `trust`: which certificate of a
    /// stream in TLS is accepted.
    ///
    /// # Errors
    /// If the scenario of a simulated world does not exist or has a mistake.
    pub fn load(url: SourceUrl, trust: Trust) -> Result<Self> {
        Ok(match url {
            SourceUrl::Video(url) => Self::Video(Box::new(url), trust),
            SourceUrl::Simulated(url) => {
                let world = Box::new(LiveWorld::load(&url.world)?);
                Self::Simulated(url, world)
            }
        })
    }

    /// The simulated world, where the source is one.
    pub fn world(&self) -> Option<&LiveWorld> {
        match self {
            Self::Video(..) => None,
            Self::Simulated(_, world) => Some(world),
        }
    }

    /// The address without a password.
    pub fn address(&self) -> String {
        match self {
            Self::Video(url, _) => url.to_string(),
            Self::Simulated(url, _) => url.to_string(),
        }
    }

    /// The address of a stream that others can open, too, without a login; `None`: the source is no stream,
    /// or its address holds a secret.
    pub fn stream_address(&self) -> Option<&str> {
        match self {
            Self::Video(url, _) => match &url.source {
                VideoSource::Rtsp { address, .. } => {
                    Some(address.as_str()).filter(|address| without_logins(address) == *address)
                }
                VideoSource::File(_) | VideoSource::Pipe(_) | VideoSource::Media(_) => None,
            },
            Self::Simulated(..) => None,
        }
    }

    /// Whether the video frames come at the speed of the scene, not of a file.
    pub fn is_live(&self) -> bool {
        match self {
            Self::Video(url, _) => url.is_live(),
            Self::Simulated(..) => true,
        }
    }

    /// Starts the source. `is_recorded`: a simulated world encodes its pictures, so that a replay decodes
    /// what the pilot saw.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub(super) fn start(
        self,
        configuration: &Configuration,
        is_recorded: bool,
        clock: Clock,
        sink: LiveVideoSink,
    ) -> Result<VideoHandle> {
        Ok(match self {
            Self::Simulated(url, world) => {
                let world = world.with_profile(&configuration.profile).with_encoding(is_recorded);
                simulated_source::spawn_world(world, &url, clock, sink)?
            }
            Self::Video(mut url, trust) => {
                let VehicleProfile { video_latency, stale_after, .. } = configuration.profile;
                let late_after = video_latency.saturating_add(stale_after);
                url.engine = configuration.video_engine;
                url.timing = TimingSettings { clock: configuration.video_clock, late_after };
                encrypted_video::spawn(*url, &trust, clock, sink)?
            }
        })
    }
}
