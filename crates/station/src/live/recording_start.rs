//! The first record of a recording: the program, its clocks, and the effective configuration.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_trial::records::RecordingStart;

use super::source::Source;
use crate::config::Configuration;
use crate::link::{LinkUrl, command_path};

/// The first record of a recording of this run. It contains no passwords: recordings are handed on.
///
/// # Errors
/// If the configuration cannot be written as TOML.
pub(super) fn recording_start(
    configuration: &Configuration,
    source: &Source,
    link: Option<&LinkUrl>,
    clock: Clock,
) -> Result<RecordingStart> {
    let since_start = Duration::from_nanos(clock.now().as_nanos());
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().saturating_sub(since_start);
    let video = source.address();
    let stored = Configuration { video: Some(video.clone()), ..configuration.clone() };
    Ok(RecordingStart {
        program: barrelman_host::program::identity().to_owned(),
        monotonic_ns: clock.start_on_monotonic_ns(),
        unix_ns: u64::try_from(unix.as_nanos()).unwrap_or(u64::MAX),
        configuration: stored.to_toml()?,
        video,
        link: link.map(ToString::to_string).unwrap_or_default(),
        live_video: source.is_live(),
        command_path: command_path(link),
        trial: None,
    })
}
