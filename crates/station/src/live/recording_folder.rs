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
        let Ok(disk) = rustix::fs::statvfs(&self.folder) else { return Ok(()) };
        let free = disk.f_bavail.saturating_mul(disk.f_frsize);
        if free >= self.bytes {
            return Ok(());
        }
        bail!(
            "only {:.1} GB of the disk of {} are free, and recording.reserve_gb keeps {:.1} GB",
            free as f64 / BYTES_PER_GB,
            self.folder.display(),
            self.bytes as f64 / BYTES_PER_GB
        )
    }
}

/// The recordings of the folder, for the console; `None`: the system does not say where this program is.
pub fn library(config: &RecordingConfig) -> Option<Library> {
    Some(Library::new(config.folder.clone(), std::env::current_exe().ok()?))
}

/// Opens the next recording in the folder. The oldest recordings make room where the quota is used up; one
/// that another program writes, and has locked, stays.
///
/// # Errors
/// If the folder cannot be used, or the disk is full.
pub fn open_next(config: &RecordingConfig) -> Result<OutputFile> {
    let folder = &config.folder;
    let context = || format!("the recordings' folder {} cannot be used", folder.display());
    std::fs::create_dir_all(folder).with_context(context)?;
    DiskReserve::new(folder, config.reserve_gb).check()?;
    let quota = (config.quota_gb * BYTES_PER_GB) as u64;
    for (path, bytes) in surplus(own_recordings(folder).with_context(context)?, quota) {
        if is_being_written(&path) {
            tracing::warn!("{} is not removed, for another program writes it", path.display());
            continue;
        }
        match std::fs::remove_file(&path) {
            Ok(()) => tracing::info!("{} is removed, for recording.quota_gb ({bytes} bytes)", path.display()),
            Err(error) => tracing::warn!("{} cannot be removed: {error}", path.display()),
        }
    }
    let name = Timestamp::now().strftime("%Y%m%dT%H%M%S%.3fZ").to_string();
    OutputFile::open(&folder.join(format!("{PREFIX}{name}{ENDING}")), false)
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

/// The oldest files that must go so that the others fit into `quota` bytes.
fn surplus(files: Vec<(PathBuf, u64)>, quota: u64) -> Vec<(PathBuf, u64)> {
    let mut used: u64 = files.iter().map(|(_, bytes)| bytes).sum();
    files
        .into_iter()
        .take_while(|(_, bytes)| {
            let goes = used > quota;
            used -= bytes;
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
        assert!(surplus(files(&[5, 5]), 10).is_empty());
        assert_eq!(surplus(files(&[5, 5, 1]), 10), files(&[5]));
        assert_eq!(surplus(files(&[5, 5, 1]), 5), files(&[5, 5]));
        assert_eq!(surplus(files(&[5]), 0), files(&[5]));
    }

    #[test]
    fn a_reserve_beyond_any_disk_is_refused_with_its_size() {
        let error = DiskReserve::new(Path::new("."), 1e9).check().unwrap_err().to_string();
        assert!(error.contains("recording.reserve_gb keeps 1000000000.0 GB"), "{error}");
        assert!(DiskReserve::new(Path::new("."), 0.0).check().is_ok());
    }
}
