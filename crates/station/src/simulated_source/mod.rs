//! A simulated world as a live video source and a camera to move.
//!
//! | thread | does |
//! |---|---|
//! | `world` | runs one tick every 1/120 s of the clock, and skips none; reads the camera's rates from the link at each tick |
//! | `render` | renders (with the render threads) and encodes the newest picture that was taken |
//! | `video` | delivers each picture when it arrives: the scenario's latency after the picture was taken |
//!
//! If rendering is slower than the scenario's picture rate, the newest moment is rendered and the others are
//! counted; the world never waits. Pictures are stamped with the program's time of the tick at which they
//! were taken. Pictures travel as encoded units like any other video: as H.264 where they are recorded or
//! served, so that a replay sees what the pilot saw, and otherwise as plain samples.
//!
//! Another world can take the place of the running one ([`WorldSwitch`]): its video is a new epoch of the
//! same stream, and link and boat stay the same.

mod live_world;
mod loaded_world;
mod next_world;

mod playback;

mod delivery;
mod moments;
mod rendering;

use barrelman_host::clock::Clock;
use barrelman_video::engine::VideoEngine;
use barrelman_video::feed::{Feed, FeedSettings};
use barrelman_video::mode::DecodeMode;
use barrelman_video::sender_clock::TimingSettings;
use barrelman_video::{VideoError, VideoHandle, VideoSink};

pub use live_world::LiveWorld;
pub use loaded_world::LoadedWorld;
pub use next_world::WorldSwitch;

use crate::source_url::SimulatedUrl;

/// Starts a world whose camera is not moved. The sink receives an unusable scenario as a failure.
///
/// # Errors
/// If the system has no more threads.
pub fn spawn(
    url: &SimulatedUrl,
    clock: Clock,
    sink: impl VideoSink + 'static,
) -> Result<VideoHandle, VideoError> {
    let (url, settings) = (url.clone(), feed_settings(url));
    VideoHandle::start(move |stop| {
        let mut feed = Feed::new(settings, clock, sink);
        match LiveWorld::load(&url.world) {
            Ok(world) => playback::play(world, feed, stop),
            Err(error) => feed.fail(VideoError::Provided { reason: format!("{error:#}") }),
        }
    })
}

/// Starts a world that is already loaded, so that a link can move its camera.
///
/// # Errors
/// If the system has no more threads.
pub fn spawn_world(
    world: LiveWorld,
    url: &SimulatedUrl,
    clock: Clock,
    sink: impl VideoSink + 'static,
) -> Result<VideoHandle, VideoError> {
    let settings = feed_settings(url);
    VideoHandle::start(move |stop| playback::play(world, Feed::new(settings, clock, sink), stop))
}

fn feed_settings(url: &SimulatedUrl) -> FeedSettings {
    FeedSettings {
        address: url.to_string(),
        faults: url.faults.clone(),
        mode: DecodeMode::Live,
        engine: VideoEngine::Auto,
        timing: TimingSettings::default(),
    }
}
