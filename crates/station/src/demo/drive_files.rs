//! The files of the drives of a session: the first drive has the files that were named, each further one has
//! files with its number.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::Result;
use barrelman_host::output::OutputFile;

/// The files that were named for the recording and for the stored drive.
#[derive(Debug, Clone, Default)]
pub struct DriveFiles {
    /// The recording.
    pub record: Option<PathBuf>,
    /// The stored drive.
    pub store: Option<PathBuf>,
    /// Whether existing files are overwritten.
    pub force: bool,
}

/// The open files of one drive.
#[derive(Debug, Default)]
pub struct OpenFiles {
    /// The recording.
    pub record: Option<OutputFile>,
    /// The stored drive.
    pub store: Option<OutputFile>,
}

impl DriveFiles {
    /// Opens the files of the drive with this number, from 1.
    ///
    /// # Errors
    /// A file cannot be opened, or exists already.
    pub fn open(&self, number: u32) -> Result<OpenFiles> {
        let open = |path: &Option<PathBuf>| {
            path.as_deref().map(|path| OutputFile::open(&numbered(path, number), self.force)).transpose()
        };
        Ok(OpenFiles { record: open(&self.record)?, store: open(&self.store)? })
    }

    /// The recordings of so many drives.
    pub fn recordings(&self, drives: u32) -> impl Iterator<Item = PathBuf> {
        paths(self.record.as_deref(), drives)
    }

    /// The stored drives of so many drives.
    pub fn stored(&self, drives: u32) -> impl Iterator<Item = PathBuf> {
        paths(self.store.as_deref(), drives)
    }
}

fn paths(path: Option<&Path>, drives: u32) -> impl Iterator<Item = PathBuf> {
    path.into_iter().flat_map(move |path| (1..=drives).map(move |number| numbered(path, number)))
}

/// The file of the drive with this number: `drive.mcap`, `drive-2.mcap`, ...
fn numbered(path: &Path, number: u32) -> PathBuf {
    if number <= 1 {
        return path.to_owned();
    }
    let mut name: OsString = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_further_drive_has_a_file_with_its_number() {
        let files =
            DriveFiles { record: Some("runs/drive.mcap".into()), store: Some("drive".into()), force: false };
        let text = |paths: Vec<PathBuf>| {
            paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(
            text(files.recordings(3).collect()),
            "runs/drive.mcap runs/drive-2.mcap runs/drive-3.mcap"
        );
        assert_eq!(text(files.stored(2).collect()), "drive drive-2");
        assert_eq!(DriveFiles::default().recordings(3).count(), 0);
    }
}
