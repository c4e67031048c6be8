//! The folder of the recordings that `run` makes without being asked: names, quota, and the reserve of the
//! disk.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

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
    let (written, files): (Vec<_>, Vec<_>) =
        own_recordings(&config.folder)?.into_iter().partition(|(path, _)| is_being_written(path));
    let beyond_quota = sum(&written).saturating_add(sum(&files)).saturating_sub(quota);
    let for_reserve = reserve.free().map_or(0, |free| reserve.missing(free, sum(&files)));
    for (path, bytes) in oldest(files, beyond_quota.max(for_reserve)) {
        match std::fs::remove_file(&path) {
            Ok(()) => {
                let why = "for recording.quota_gb and recording.reserve_gb";
                tracing::info!("{} is removed, {why} ({bytes} bytes)", path.display());
            }
            Err(error) => tracing::warn!("{} cannot be removed: {error}", path.display()),
        }
    }
    Ok(())
}

/// The recordings of this program in a folder with their sizes, oldest first.
fn own_recordings(folder: &Path) -> Result<Vec<(PathBuf, u64)>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let is_own = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(ENDING));
        let about = match entry.metadata() {
            Ok(about) => about,
            // Removed meanwhile, by another program that makes room.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(error.into()),
        };
        if is_own && about.is_file() {
            found.push((entry.path(), about.len()));
        }
    }
    // The names sort by time.
    found.sort();
    Ok(found)
}

/// The size of all files together.
fn sum(files: &[(PathBuf, u64)]) -> u64 {
    files.iter().map(|(_, bytes)| bytes).sum()
}

/// The oldest files that have at least `bytes` bytes together, or all of them.
fn oldest(files: Vec<(PathBuf, u64)>, mut bytes: u64) -> Vec<(PathBuf, u64)> {
    files
        .into_iter()
        .take_while(|(_, size)| {
            let goes = bytes > 0;
            bytes = bytes.saturating_sub(*size);
            goes
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_recordings_make_room() {
        let files = |sizes: &[u64]| -> Vec<(PathBuf, u64)> {
            sizes
                .iter()
                .enumerate()
                .map(|(index, bytes)| (PathBuf::from(index.to_string()), *bytes))
                .collect()
        };
        assert!(oldest(files(&[5, 5]), 0).is_empty());
        assert_eq!(oldest(files(&[5, 5, 1]), 1), files(&[5]));
        assert_eq!(oldest(files(&[5, 5, 1]), 5), files(&[5]));
        assert_eq!(oldest(files(&[5, 5, 1]), 6), files(&[5, 5]));
        assert_eq!(oldest(files(&[5]), 6), files(&[5]));
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
