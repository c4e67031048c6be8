//! The summary of a recording: the one that it holds, or the one of what is there where it was cut off.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context as _, Result};
use barrelman_host::input;
use barrelman_trial::records::{Entry, ReadError, RecordingReader, read_sortie};
use barrelman_trial::sortie::{Sortie, SortieObserver};

use crate::config::{self, Configuration};

/// The summary of a recording, and whether the recording was cut off, as when the program was killed.
///
/// # Errors
/// If the file cannot be read, or holds no run of this program.
pub(super) fn of_recording(path: &Path) -> Result<(Sortie, bool)> {
    match read_sortie(&mut input::open(path)?)? {
        Some(sortie) => Ok((sortie, false)),
        None => observe(path),
    }
}

/// The summary of a recording that holds none.
fn observe(path: &Path) -> Result<(Sortie, bool)> {
    let mut observer: Option<SortieObserver> = None;
    let mut is_cut = false;
    for entry in RecordingReader::new(BufReader::new(File::open(path)?)) {
        match entry {
            Ok(entry) => {
                if let Entry::Start(start) = &entry {
                    let configuration =
                        Configuration::resolve_recorded(&config::parse(&start.configuration)?)
                            .context("the recorded configuration")?;
                    observer = Some(SortieObserver::new(configuration.profile));
                }
                let Some(observer) = &mut observer else { break };
                observer.add(&entry);
            }
            Err(ReadError::Truncated) => is_cut = true,
            Err(error) => return Err(error.into()),
        }
    }
    let observer = observer.context("it holds no run of this program")?;
    Ok((observer.finish(), is_cut))
}
