//! A stored drive run again, as fast as the computer allows.

use std::path::Path;

use anyhow::{Result, bail};
use barrelman_experiments::drive::{Drive, StoredDrive};
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_host::output::OutputFile;
use barrelman_sim::tick::TICKS_PER_SECOND;

use super::observers::DriveObservers;
use super::recording;
use crate::progress::Progress;

/// The result of a replay.
#[derive(Debug)]
pub struct ReplayedDrive {
    /// The scenario.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// The last tick of the stored drive.
    pub last_tick: u64,
    /// The hash of the replayed drive.
    pub hash: String,
    /// The stored hash; `None` where the file is cut off.
    pub stored_hash: Option<String>,
    /// The program that stored the drive: version and hash of the executable.
    pub program: String,
}

/// Replays a stored drive, and records it if a file is given.
///
/// # Errors
/// If the stored drive cannot be read, its world not be made, or the recording not be written.
pub fn replay(record: Option<OutputFile>, path: &Path) -> Result<ReplayedDrive> {
    let stored = StoredDrive::read(path)?;
    let last_tick = stored.last_tick();
    let StoredDrive { setup, program, requests, end } = stored;
    if record.is_some() && !setup.encoded {
        bail!(
            "{} was driven without --record, on pictures that were not encoded: a recording would show another drive",
            path.display()
        );
    }
    let threads = RenderThreads::new()?;
    let mut drive = Drive::new(&setup, &threads)?;
    let mut observers =
        DriveObservers { recorder: recording::begin(record, &setup)?, ..DriveObservers::default() };
    let progress = Progress::new("ticks", last_tick);
    let mut requests = requests.into_iter().peekable();
    loop {
        let tick = drive.world().tick();
        while let Some((_, request)) = requests.next_if(|(at, _)| *at <= tick) {
            drive.request(request, &mut observers);
        }
        if tick >= last_tick {
            break;
        }
        if tick.is_multiple_of(u64::from(TICKS_PER_SECOND)) {
            progress.set(tick);
        }
        drive.tick(&mut observers);
    }
    progress.finish();
    let hash = observers.hash.hex();
    if let Some(recorder) = observers.recorder {
        recorder.finish()?;
    }
    Ok(ReplayedDrive {
        scenario: setup.url.scenario.clone(),
        seed: setup.url.seed,
        last_tick,
        hash,
        stored_hash: end.map(|(_, hash)| hash),
        program,
    })
}
