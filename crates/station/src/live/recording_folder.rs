//! The folder of the recordings that `run` makes without being asked: names, quota, and the reserve of the
//! disk.
//!
//! The folder of a recording's film and tables, `NAME.export`, counts as part of the recording and is removed
//! with it. An export whose recording is gone was kept on purpose, and stays.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::{Context, Result, bail};
use barrelman_console_server::Library;
use barrelman_host::output::{OutputFile, is_being_written};
use jiff::Timestamp;

use crate::config::RecordingConfig;

/// Recordings of this program in the folder: `run-20261123T021500.250Z.mcap`. Other files are never removed.
const PREFIX: &str = "run-";
const ENDING: &str = ".mcap";
const BYTES_PER_GB: f64 = 1e9;

/// The disk of a recording, and how much of it must stay free.
#[derive(Debug, Clone)]
pub struct DiskReserve {
    folder: PathBuf,
    bytes: u64,
}

impl DiskReserve {
    /// A reserve on the disk of `folder`.
    pub fn new(folder: &Path, gigabytes: f64) -> Self {
        Self { folder: folder.to_owned(), bytes: (gigabytes * BYTES_PER_GB) as u64 }
    }

    /// Fails where less than the reserve is free. A disk that cannot be asked is taken to be free.
    ///
    /// # Errors
    /// The free space and the reserve, in words.
    pub fn check(&self) -> Result<()> {
        let Some(free) = self.free().filter(|free| *free < self.bytes) else { return Ok(()) };
        bail!(
            "only {:.1} GB of the disk of {} are free, and recording.reserve_gb keeps {:.1} GB",
            free as f64 / BYTES_PER_GB,
            self.folder.display(),
            self.bytes as f64 / BYTES_PER_GB
        )
    }

    /// The free space, bytes; `None`: the disk cannot be asked.
    fn free(&self) -> Option<u64> {
        let disk = rustix::fs::statvfs(&self.folder).ok()?;
        Some(disk.f_bavail.saturating_mul(disk.f_frsize))
    }

    /// How much must be removed so that a run can be recorded: as far as `removable` bytes allow it, half of
    /// the reserve is free beyond the reserve, or else the reserve alone. 0 where neither can be reached:
    /// nothing is removed in vain.
    fn missing(&self, free: u64, removable: u64) -> u64 {
        let with_room = self.bytes.saturating_add(self.bytes / 2);
        let missing = [with_room, self.bytes].map(|wanted| wanted.saturating_sub(free));
        missing.into_iter().find(|missing| *missing <= removable).unwrap_or(0)
    }
}

/// The recordings of the folder, for the console; `None`: the system does not say where this program is.
pub fn library(config: &RecordingConfig) -> Option<Library> {
    Some(Library::new(config.folder.clone(), std::env::current_exe().ok()?))
}

/// Opens the next recording in the folder. The oldest recordings make room where the quota is used up or
/// the reserve is not free; one that another program writes, and has locked, stays.
///
/// # Errors
/// If the folder cannot be used, or the disk is full.
pub fn open_next(config: &RecordingConfig) -> Result<OutputFile> {
    let folder = &config.folder;
    let context = || format!("the recordings' folder {} cannot be used", folder.display());
    std::fs::create_dir_all(folder).with_context(context)?;
    let reserve = DiskReserve::new(folder, config.reserve_gb);
    make_room(config, &reserve).with_context(context)?;
    reserve.check()?;
    let name = Timestamp::now().strftime("%Y%m%dT%H%M%S%.3fZ").to_string();
    OutputFile::open(&folder.join(format!("{PREFIX}{name}{ENDING}")), false)
}

/// Removes the oldest recordings, for the quota and for the reserve.
fn make_room(config: &RecordingConfig, reserve: &DiskReserve) -> Result<()> {
    let quota = (config.quota_gb * BYTES_PER_GB) as u64;
    let (written, others): (Vec<_>, Vec<_>) =
        own_recordings(&config.folder)?.into_iter().partition(OwnRecording::is_being_written);
    let beyond_quota = sum(&written).saturating_add(sum(&others)).saturating_sub(quota);
    let for_reserve = reserve.free().map_or(0, |free| reserve.missing(free, sum(&others)));
    for recording in oldest(others, beyond_quota.max(for_reserve)) {
        recording.remove();
    }
    Ok(())
}

/// A recording of this program and the folder of its film and tables, if there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
struct OwnRecording {
    /// The last change: the clock may have been wrong at the start, which the name tells.
    changed: SystemTime,
    path: PathBuf,
    bytes: u64,
}

impl OwnRecording {
    fn export(&self) -> PathBuf {
        self.path.with_extension("export")
    }

    /// Whether a program writes the recording or a file of its export.
    fn is_being_written(&self) -> bool {
        is_being_written(&self.path) || content_of(&self.export()).iter().any(|path| is_being_written(path))
    }

    fn remove(&self) {
        let export = self.export();
        let of_export = if export.is_dir() { std::fs::remove_dir_all(&export) } else { Ok(()) };
        match of_export.and_then(|()| std::fs::remove_file(&self.path)) {
            Ok(()) => {
                tracing::info!(
                    "{} is removed, for the quota or the reserve of recordings",
                    self.path.display()
                );
            }
            Err(error) => tracing::warn!("{} cannot be removed: {error}", self.path.display()),
        }
    }
}

/// The recordings of this program in a folder, oldest first.
fn own_recordings(folder: &Path) -> Result<Vec<OwnRecording>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let about = match entry.metadata() {
            Ok(about) => about,
            // Removed meanwhile, by another program that makes room.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(error.into()),
        };
        if about.is_file() && entry.file_name().to_str().is_some_and(is_own_name) {
            let (changed, path) = (about.modified()?, entry.path());
            let mut recording = OwnRecording { changed, path, bytes: about.len() };
            recording.bytes += content_of(&recording.export()).iter().map(|path| bytes_of(path)).sum::<u64>();
            found.push(recording);
        }
    }
    found.sort_by_key(|recording| recording.changed);
    Ok(found)
}

/// Whether this program gives a recording such a name.
fn is_own_name(name: &str) -> bool {
    let time = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_suffix(ENDING));
    time.is_some_and(|time| time.get(..8).is_some_and(|day| day.bytes().all(|byte| byte.is_ascii_digit())))
}

/// What a folder contains. One that cannot be read is empty.
fn content_of(folder: &Path) -> Vec<PathBuf> {
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

/// The size of a file; 0 of a folder, and where there is none.
fn bytes_of(path: &Path) -> u64 {
    path.symlink_metadata().ok().filter(std::fs::Metadata::is_file).map_or(0, |about| about.len())
}

/// The size of all recordings together.
fn sum(recordings: &[OwnRecording]) -> u64 {
    recordings.iter().map(|recording| recording.bytes).sum()
}

/// The oldest recordings that have at least `bytes` bytes together, or all of them.
fn oldest(recordings: Vec<OwnRecording>, mut bytes: u64) -> Vec<OwnRecording> {
    recordings
        .into_iter()
        .take_while(|recording| {
            let goes = bytes > 0;
            bytes = bytes.saturating_sub(recording.bytes);
            goes
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_recordings_make_room() {
        let removed = |sizes: &[u64], bytes: u64| {
            let changed = SystemTime::UNIX_EPOCH;
            let all = sizes.iter().map(|bytes| OwnRecording { changed, path: PathBuf::new(), bytes: *bytes });
            oldest(all.collect(), bytes).iter().map(|recording| recording.bytes).collect::<Vec<_>>()
        };
        assert!(removed(&[5, 5], 0).is_empty());
        assert_eq!(removed(&[5, 5, 1], 1), [5]);
        assert_eq!(removed(&[5, 5, 1], 5), [5]);
        assert_eq!(removed(&[5, 5, 1], 6), [5, 5]);
        assert_eq!(removed(&[5], 6), [5]);
    }

    #[test]
    fn room_is_made_for_the_reserve_and_never_in_vain() {
        let reserve = DiskReserve { folder: PathBuf::new(), bytes: 20 };
        assert_eq!(reserve.missing(30, 100), 0);
        assert_eq!(reserve.missing(18, 100), 12, "the reserve, and half of it for the run");
        assert_eq!(reserve.missing(18, 11), 2, "the reserve alone");
        assert_eq!(reserve.missing(25, 4), 0, "the reserve is free");
        assert_eq!(reserve.missing(18, 1), 0, "the reserve cannot be reached");
    }

    #[test]
    fn a_reserve_beyond_any_disk_is_refused_with_its_size() {
        let error = DiskReserve::new(Path::new("."), 1e9).check().unwrap_err().to_string();
        assert!(error.contains("recording.reserve_gb keeps 1000000000.0 GB"), "{error}");
        assert!(DiskReserve::new(Path::new("."), 0.0).check().is_ok());
    }
}
