//! The first record of a recording: the program, its clocks, and the effective configuration.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_trial::records::{RecordedVideo, RecordingStart};
use barrelman_vocab::Videos;

use super::source::Source;
use crate::config::Configuration;
use crate::link::{LinkUrl, command_path};

/// The first record of a recording of this run. It contains no passwords: recordings are handed on.
///
/// # Errors
/// If the configuration cannot be written as TOML.
pub(super) fn recording_start(
    configuration: &Configuration,
    sources: &Videos<Source>,
    link: Option<&LinkUrl>,
    clock: Clock,
) -> Result<RecordingStart> {
    let since_start = Duration::from_nanos(clock.now().as_nanos());
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().saturating_sub(since_start);
    let recorded = |source: &Source| RecordedVideo { address: source.address(), is_live: source.is_live() };
    let videos = sources.as_ref().map(|_, source| recorded(source));
    let mut stored = Configuration { video: Some(videos.first.address.clone()), ..configuration.clone() };
    if let (Some(second), Some(video)) = (&mut stored.second_video, &videos.second) {
        second.url.clone_from(&video.address);
    }
    Ok(RecordingStart {
        program: barrelman_host::program::identity().to_owned(),
        monotonic_ns: clock.start_on_monotonic_ns(),
        unix_ns: u64::try_from(unix.as_nanos()).unwrap_or(u64::MAX),
        configuration: stored.to_toml()?,
        videos,
        link: link.map(ToString::to_string).unwrap_or_default(),
        command_path: command_path(link),
        trial: None,
    })
}
