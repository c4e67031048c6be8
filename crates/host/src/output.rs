//! Output files. An existing file is overwritten only on request.
//!
//! An output file is opened in one step, before the work whose result it holds, and the handle is kept:
//!
//! - Without `--force`, the file is created with `O_CREAT | O_EXCL`. An existing file is refused, also one that
//!   appears at the last moment, and so is a symbolic link, whatever its target.
//! - With `--force`, an existing file is opened with `O_NOFOLLOW` and emptied at the first write, so that work that fails
//!   before it has a result leaves the old file unchanged. The file is overwritten in place and not replaced by a
//!   temporary file: a recording can be read while it grows, and the output of a killed program stays under its name. A
//!   symbolic link in the place of the file is refused; links in the folders above it are followed.
//!
//! An open file is locked (`flock`), so that two programs, or two outputs of one command, cannot write to one file with
//! `--force` or `--resume`.
//!
//! A file that was created and never written is removed when its handle is dropped. Only a killed program leaves an empty
//! file behind.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek, SeekFrom, Write};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;

/// Attempts to open a file that another program creates and removes at the same time.
const ATTEMPTS: usize = 8;

/// An output file that is open for writing.
#[derive(Debug)]
pub struct OutputFile {
    state: State,
    path: PathBuf,
    file: File,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Created by this program and empty: removed when it is dropped.
    Created,
    /// Existed before: emptied at the first write.
    Existing,
    /// Emptied or written: kept.
    Begun,
}

/// A closed output file that can be opened again to append to it.
#[derive(Debug)]
pub struct ClosedOutput {
    path: PathBuf,
    identity: Identity,
}

/// The device and the inode of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Identity {
    device: u64,
    inode: u64,
}

impl From<&std::fs::Metadata> for Identity {
    fn from(metadata: &std::fs::Metadata) -> Self {
        Self { device: metadata.dev(), inode: metadata.ino() }
    }
}

impl OutputFile {
    /// Opens an output file. An existing file is overwritten only with `force`, from the first write on.
    ///
    /// # Errors
    /// The file exists and `force` is false, is a symbolic link, or cannot be created; the message names it.
    pub fn open(path: &Path, force: bool) -> Result<Self> {
        for _ in 0..ATTEMPTS {
            match OpenOptions::new().write(true).create_new(true).open(path) {
                Ok(file) => return Self { state: State::Created, path: path.to_owned(), file }.lock(),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(open_error(path, error)),
            }
            if is_link(path) {
                bail!("{} exists already, as a symbolic link: choose another name", path.display());
            }
            if !force {
                bail!("{} exists already: choose another name, or overwrite it with --force", path.display());
            }
            match without_following().write(true).open(path) {
                Ok(file) => {
                    let file = Self { state: State::Existing, path: path.to_owned(), file }.lock()?;
                    // Otherwise another program removed the file before it was locked.
                    if file.is_at_its_path() {
                        return Ok(file);
                    }
                }
                // Another program removed the file.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(open_error(path, error)),
            }
        }
        bail!("{} cannot be opened: another program creates and removes it", path.display())
    }

    /// Opens an output file to append to it, and returns its content. A missing file is created.
    ///
    /// # Errors
    /// The file is a symbolic link, or cannot be read or written; the message names it.
    pub fn resume(path: &Path) -> Result<(Self, Vec<u8>)> {
        let mut file = match without_following().read(true).write(true).open(path) {
            Ok(file) => Self { state: State::Begun, path: path.to_owned(), file }.lock()?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok((Self::open(path, false)?, Vec::new()));
            }
            Err(error) => return Err(open_error(path, error)),
        };
        let mut bytes = Vec::new();
        file.file.read_to_end(&mut bytes).with_context(|| format!("{} cannot be read", path.display()))?;
        Ok((file, bytes))
    }

    /// The path that the file was opened with.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Empties the file now, and keeps it even if nothing is written to it.
    ///
    /// # Errors
    /// The file cannot be emptied.
    pub fn begin(&mut self) -> Result<()> {
        self.empty_once().with_context(|| cannot_be_written(&self.path))
    }

    /// Truncates the file to `bytes` bytes and continues at its end.
    ///
    /// # Errors
    /// The file cannot be truncated.
    pub fn truncate_at(&mut self, bytes: u64) -> Result<()> {
        self.empty_once()
            .and_then(|()| self.file.set_len(bytes))
            .and_then(|()| self.file.seek(SeekFrom::Start(bytes)).map(drop))
            .with_context(|| cannot_be_written(&self.path))
    }

    /// Closes the file so that it can be opened again.
    ///
    /// # Errors
    /// The device and the inode of the file cannot be read.
    pub fn close(mut self) -> Result<ClosedOutput> {
        self.begin()?;
        let metadata = self.file.metadata().with_context(|| cannot_be_written(&self.path))?;
        Ok(ClosedOutput { path: self.path.clone(), identity: Identity::from(&metadata) })
    }

    fn lock(mut self) -> Result<Self> {
        let is_file = self.file.metadata().is_ok_and(|metadata| metadata.is_file());
        // Some file systems have no locks. Devices and pipes may be shared.
        if is_file && is_locked_elsewhere(&self.file) {
            // The file belongs to the program that locked it, even if this program created it.
            self.state = State::Begun;
            bail!("{} is being written already: choose another name, or wait", self.path.display());
        }
        Ok(self)
    }

    /// Whether the path still names this file.
    fn is_at_its_path(&self) -> bool {
        match (self.file.metadata(), std::fs::symlink_metadata(&self.path)) {
            (Ok(ours), Ok(there)) => Identity::from(&ours) == Identity::from(&there),
            _ => false,
        }
    }

    fn empty_once(&mut self) -> io::Result<()> {
        // Devices and pipes have no length.
        if self.state == State::Existing && self.file.metadata()?.is_file() {
            self.file.set_len(0)?;
        }
        self.state = State::Begun;
        Ok(())
    }
}

impl ClosedOutput {
    /// Opens the file again to append to it.
    ///
    /// # Errors
    /// The path names another file now, or the file cannot be opened.
    pub fn reopen(self) -> Result<OutputFile> {
        let Self { path, identity } = self;
        let file = without_following().append(true).open(&path).map_err(|error| open_error(&path, error))?;
        let metadata = file.metadata().with_context(|| cannot_be_written(&path))?;
        if Identity::from(&metadata) != identity {
            bail!("{} was replaced while it was being written", path.display());
        }
        Ok(OutputFile { state: State::Begun, path, file })
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.state != State::Begun && !bytes.is_empty() {
            self.empty_once()?;
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.seek(position)
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        // A file that another program has put in its place is kept.
        let is_empty = || self.file.metadata().is_ok_and(|metadata| metadata.len() == 0);
        if self.state == State::Created && is_empty() && self.is_at_its_path() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Locks an open file, and returns whether another open file has the lock already.
fn is_locked_elsewhere(file: &File) -> bool {
    flock(file, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK)
}

/// Whether the file at a path is an output that is being written now, by this program or another one. What cannot be asked is
/// not.
pub fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| is_locked_elsewhere(&file))
}

/// Creates an output file that is kept even if nothing is written to it. An existing file is emptied only with `force`.
///
/// # Errors
/// As [`OutputFile::open`].
pub fn create(path: &Path, force: bool) -> Result<OutputFile> {
    let mut file = OutputFile::open(path, force)?;
    file.begin()?;
    Ok(file)
}

fn without_following() -> OpenOptions {
    let mut options = OpenOptions::new();
    // The flags of open(2) are a C int: the bits are kept.
    options.custom_flags(OFlags::NOFOLLOW.bits() as i32);
    options
}

fn is_link(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|found| found.file_type().is_symlink())
}

fn open_error(path: &Path, error: io::Error) -> anyhow::Error {
    if error.kind() == io::ErrorKind::NotFound {
        return anyhow!("{} cannot be written: its folder does not exist, make it first", path.display());
    }
    if is_link(path) {
        return anyhow!("{} is a symbolic link, which is not followed: choose another name", path.display());
    }
    anyhow::Error::new(error).context(cannot_be_written(path))
}

fn cannot_be_written(path: &Path) -> String {
    format!("{} cannot be written", path.display())
}
