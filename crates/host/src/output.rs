//! Output files: none that exists is overwritten without being asked to.
//!
//! An output file is opened in one step, before the work begins whose result it takes, and the handle is kept:
//!
//! - Without `--force`, the file is created with `O_CREAT | O_EXCL`. A file that exists is refused, also one that appears
//!   at the last moment. A symbolic link is refused as well, wherever it leads.
//! - With `--force`, a file that exists is opened with `O_NOFOLLOW` and emptied at the first write, so that work that
//!   fails before it has a result leaves the old file as it was. The file is overwritten in place instead of replaced by
//!   a temporary file: a recording can be read while it grows, and what a killed program has written stays under its
//!   name. A symbolic link in the place of the file is refused; links in the folders above it are followed.
//!
//! While a file is open it is locked (`flock`), so that two programs, or two outputs of one command, do not write into each
//! other with `--force` or `--resume`.
//!
//! A file that was created and never written is removed again when its handle is dropped. Only a killed program leaves
//! an empty file behind.

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
    /// Created here, and empty: removed when it is dropped.
    Created,
    /// It existed before: emptied at the first write.
    Existing,
    /// Emptied or written; it stays.
    Begun,
}

/// An output file that was closed, and may be opened again to append to it.
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
    /// Opens an output file. A file that exists is overwritten with `force` only, from the first write on.
    ///
    /// # Errors
    /// If the file exists and `force` is not given, if it is a symbolic link, or if it cannot be created; the message
    /// names it.
    pub fn open(path: &Path, force: bool) -> Result<Self> {
        for _ in 0..ATTEMPTS {
            match OpenOptions::new().write(true).create_new(true).open(path) {
                Ok(file) => return Self { state: State::Created, path: path.to_owned(), file }.locked(),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(explained(path, error)),
            }
            if is_link(path) {
                bail!("{} exists already, as a symbolic link: choose another name", path.display());
            }
            if !force {
                bail!("{} exists already: choose another name, or overwrite it with --force", path.display());
            }
            match without_following().write(true).open(path) {
                Ok(file) => {
                    let file = Self { state: State::Existing, path: path.to_owned(), file }.locked()?;
                    // Else it was removed before it was locked.
                    if file.is_at_its_path() {
                        return Ok(file);
                    }
                }
                // Removed meanwhile.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(explained(path, error)),
            }
        }
        bail!("{} cannot be opened: another program creates and removes it", path.display())
    }

    /// Opens an output file that may have been begun before, and reads what it holds. What is written comes behind. A
    /// file that does not exist is created, and holds nothing.
    ///
    /// # Errors
    /// If the file is a symbolic link, or cannot be read or written; the message names it.
    pub fn resume(path: &Path) -> Result<(Self, Vec<u8>)> {
        let mut file = match without_following().read(true).write(true).open(path) {
            Ok(file) => Self { state: State::Begun, path: path.to_owned(), file }.locked()?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok((Self::open(path, false)?, Vec::new()));
            }
            Err(error) => return Err(explained(path, error)),
        };
        let mut bytes = Vec::new();
        file.file.read_to_end(&mut bytes).with_context(|| format!("{} cannot be read", path.display()))?;
        Ok((file, bytes))
    }

    /// The path that the file was opened with.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Empties the file now, and keeps it even if nothing is ever written to it.
    ///
    /// # Errors
    /// If the file cannot be emptied.
    pub fn begin(&mut self) -> Result<()> {
        self.begun().with_context(|| cannot_be_written(&self.path))
    }

    /// Cuts the file after so many bytes, and goes on there.
    ///
    /// # Errors
    /// If the file cannot be cut.
    pub fn cut_after(&mut self, bytes: u64) -> Result<()> {
        self.begun()
            .and_then(|()| self.file.set_len(bytes))
            .and_then(|()| self.file.seek(SeekFrom::Start(bytes)).map(drop))
            .with_context(|| cannot_be_written(&self.path))
    }

    /// Closes the file, to be opened again later.
    ///
    /// # Errors
    /// If the system does not tell which file it is.
    pub fn close(mut self) -> Result<ClosedOutput> {
        self.begin()?;
        let metadata = self.file.metadata().with_context(|| cannot_be_written(&self.path))?;
        Ok(ClosedOutput { path: self.path.clone(), identity: Identity::from(&metadata) })
    }

    fn locked(mut self) -> Result<Self> {
        let is_file = self.file.metadata().is_ok_and(|metadata| metadata.is_file());
        // Some file systems have no locks; devices and pipes may be shared.
        if is_file && flock(&self.file, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK) {
            // Whoever was faster has the file now, even if it was created here.
            self.state = State::Begun;
            bail!("{} is being written already: choose another name, or wait", self.path.display());
        }
        Ok(self)
    }

    /// Whether the path still leads to this file.
    fn is_at_its_path(&self) -> bool {
        match (self.file.metadata(), std::fs::symlink_metadata(&self.path)) {
            (Ok(ours), Ok(there)) => Identity::from(&ours) == Identity::from(&there),
            _ => false,
        }
    }

    fn begun(&mut self) -> io::Result<()> {
        // Devices and pipes have no length.
        if self.state == State::Existing && self.file.metadata()?.is_file() {
            self.file.set_len(0)?;
        }
        self.state = State::Begun;
        Ok(())
    }
}

impl ClosedOutput {
    /// Opens the file again, to append to it.
    ///
    /// # Errors
    /// If the file at this path is another one now, or cannot be opened.
    pub fn reopen(self) -> Result<OutputFile> {
        let Self { path, identity } = self;
        let file = without_following().append(true).open(&path).map_err(|error| explained(&path, error))?;
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
            self.begun()?;
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
        // What another program has put there since is not ours to remove.
        let is_empty = || self.file.metadata().is_ok_and(|metadata| metadata.len() == 0);
        if self.state == State::Created && is_empty() && self.is_at_its_path() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Creates an output file that stays even if nothing is written to it; one that exists is emptied, with `force` only.
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

fn explained(path: &Path, error: io::Error) -> anyhow::Error {
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
