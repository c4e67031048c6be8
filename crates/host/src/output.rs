//! Output files. An existing file is overwritten only on request.
//!
//! An output file is opened in one step, before the work whose result it holds, and the handle is kept:
//!
//! - Without `--force`, the file is created with `O_CREAT | O_EXCL`. An existing file is refused, also one
//!   that appears at the last moment, and so is a symbolic link, whatever its target.
//! - With `--force`, a new file is created beside an existing one (`.barrelman-*.new`), and takes its name at
//!   the first write. Work that fails before it has a result leaves the old file unchanged. Another name of
//!   the old file (a hard link) keeps the old content. From the first write on a recording can be read while
//!   it grows, and the output of a killed program stays under its name. A device or a pipe is opened as it
//!   is. A symbolic link in the place of the file is refused; links in the folders above it are followed.
//!
//! Secrets and other small files are written as a whole ([`OutputFile::write_whole`]): they are complete
//! before they take the name of the old file.
//!
//! New files can be read by their owner alone (mode 0600): recordings show people in distress.
//!
//! An open file is locked (`flock`), and so is the file that it replaces, so that two programs, or two
//! outputs of one command, cannot write to one file with `--force` or `--resume`.
//!
//! A file that was created and never written is removed when its handle is dropped. Only a killed program
//! leaves an empty file behind.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek, SeekFrom, Write};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;

use crate::random::random_bytes;

/// Attempts to open a file that another program creates and removes at the same time.
const ATTEMPTS: usize = 8;
/// Permissions of a new file: its owner reads and writes.
const OWNER_ALONE: u32 = 0o600;

/// An output file that is open for writing.
#[derive(Debug)]
pub struct OutputFile {
    state: State,
    path: PathBuf,
    file: File,
}

#[derive(Debug)]
enum State {
    /// Created by this program and empty: removed when it is dropped.
    Created,
    /// Created beside an existing file, whose name it takes at the first write; removed when it is dropped
    /// before that.
    Beside {
        /// The name of the new file until then.
        new: PathBuf,
        /// The existing file, which stays locked until then.
        _old: File,
    },
    /// Begun: kept.
    Begun,
}

/// A closed output file that can be opened again to append to it.
#[derive(Debug)]
pub struct ClosedOutput {
    path: PathBuf,
    identity: Identity,
}

/// Brings an output file to the disk: a file system may keep written content in memory for half a minute.
#[derive(Debug)]
pub struct OutputSync {
    file: File,
    path: PathBuf,
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
            match create_new(path) {
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
                    let old = Self { state: State::Begun, path: path.to_owned(), file }.lock()?;
                    // Otherwise another program removed the file before it was locked.
                    if old.is_at_its_path() {
                        return old.replaced();
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

    /// What brings the file to the disk, from any thread; `None`: a device or a pipe. The file stays locked
    /// until both are dropped.
    ///
    /// # Errors
    /// The process has no more file descriptors.
    pub fn sync(&self) -> Result<Option<OutputSync>> {
        let context = || cannot_be_written(&self.path);
        if !self.file.metadata().with_context(context)?.is_file() {
            return Ok(None);
        }
        Ok(Some(OutputSync { file: self.file.try_clone().with_context(context)?, path: self.path.clone() }))
    }

    /// Takes the place of an existing file now, and keeps the file even if nothing is written to it.
    ///
    /// # Errors
    /// The existing file cannot be replaced.
    pub fn begin(&mut self) -> Result<()> {
        self.take_place().with_context(|| cannot_be_written(&self.path))
    }

    /// Writes the whole content of a small file. Whatever ends the program or the machine meanwhile, an
    /// existing file keeps its old content, or has the new one; a new file may be empty.
    ///
    /// # Errors
    /// The file cannot be written: an existing one keeps its old content.
    pub fn write_whole(mut self, content: &[u8]) -> Result<()> {
        let written = self.file.write_all(content).and_then(|()| self.file.sync_all());
        if written.is_err() {
            // A new file is removed when it is empty.
            let _ = self.file.set_len(0);
        }
        written.and_then(|()| self.take_place()).with_context(|| cannot_be_written(&self.path))?;
        sync_folder_of(&self.path);
        Ok(())
    }

    /// Truncates the file to `bytes` bytes and continues at its end.
    ///
    /// # Errors
    /// The file cannot be truncated.
    pub fn truncate_at(&mut self, bytes: u64) -> Result<()> {
        self.take_place()
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

    /// A new file that replaces this existing one at the first write. A device or a pipe is written as it is.
    fn replaced(mut self) -> Result<Self> {
        let context = || cannot_be_written(&self.path);
        if !self.file.metadata().with_context(context)?.is_file() {
            return Ok(self);
        }
        let mut random = [0; 8];
        random_bytes(&mut random).with_context(context)?;
        let new = self.path.with_file_name(format!(".barrelman-{:016x}.new", u64::from_ne_bytes(random)));
        let file = create_new(&new)
            .with_context(|| format!("no file can be created beside it: {}", new.display()))
            .with_context(context)?;
        let old = std::mem::replace(&mut self.file, file);
        self.state = State::Beside { new, _old: old };
        self.lock()
    }

    /// Gives a new file the name of the existing one that it replaces.
    fn take_place(&mut self) -> io::Result<()> {
        if let State::Beside { new, .. } = &self.state {
            std::fs::rename(new, &self.path)?;
        }
        self.state = State::Begun;
        Ok(())
    }
}

impl OutputSync {
    /// Waits until what was written so far is on the disk. A file system that cannot be asked is left to the
    /// system.
    ///
    /// # Errors
    /// The disk's.
    pub fn content(&self) -> io::Result<()> {
        where_possible(self.file.sync_data())
    }

    /// Waits until content and name are on the disk. A file system that cannot be asked, and a folder that
    /// cannot be read, are left to the system.
    ///
    /// # Errors
    /// The disk's.
    pub fn content_and_name(&self) -> io::Result<()> {
        where_possible(self.file.sync_all())?;
        sync_folder_of(&self.path);
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
        if !bytes.is_empty() {
            self.take_place()?;
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
        match &self.state {
            State::Created => {
                // A file that another program has put in its place is kept.
                let is_empty = self.file.metadata().is_ok_and(|metadata| metadata.len() == 0);
                if is_empty && self.is_at_its_path() {
                    let _ = std::fs::remove_file(&self.path);
                }
            }
            State::Beside { new, .. } => drop(std::fs::remove_file(new)),
            State::Begun => {}
        }
    }
}

/// Locks an open file, and returns whether another open file has the lock already.
fn is_locked_elsewhere(file: &File) -> bool {
    flock(file, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK)
}

/// Whether the file at a path is an output that is being written now, by this program or another one. What
/// cannot be asked is not.
pub fn is_being_written(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| is_locked_elsewhere(&file))
}

/// Creates an output file that is kept even if nothing is written to it. An existing file is replaced only
/// with `force`.
///
/// # Errors
/// As [`OutputFile::open`].
pub fn create(path: &Path, force: bool) -> Result<OutputFile> {
    let mut file = OutputFile::open(path, force)?;
    file.begin()?;
    Ok(file)
}

/// Creates a file that its owner alone can read.
fn create_new(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).mode(OWNER_ALONE).open(path)
}

/// What a wait for the disk has said, unless the file system knows no such wait.
fn where_possible(waited: io::Result<()>) -> io::Result<()> {
    let is_unknown = |error: &io::Error| {
        [Errno::INVAL, Errno::NOSYS, Errno::OPNOTSUPP]
            .iter()
            .any(|errno| Errno::from_io_error(error) == Some(*errno))
    };
    waited.or_else(|error| if is_unknown(&error) { Ok(()) } else { Err(error) })
}

/// Keeps the names of a folder over a power cut. Where the file system refuses this, the old content may come
/// back.
fn sync_folder_of(path: &Path) {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Ok(folder) = File::open(folder.unwrap_or(Path::new("."))) {
        let _ = folder.sync_all();
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_written_as_a_whole_is_never_seen_without_its_content() {
        const BYTES: usize = 1 << 20;
        let folder = std::env::temp_dir().join(format!("barrelman-whole-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("secret");
        let write = |content: u8| OutputFile::open(&path, true).unwrap().write_whole(&vec![content; BYTES]);
        write(0).unwrap();
        std::thread::scope(|scope| {
            let writer = scope.spawn(|| (1..30).try_for_each(write));
            while !writer.is_finished() {
                let seen = std::fs::read(&path).unwrap();
                assert!(seen.len() == BYTES && seen.iter().all(|byte| *byte == seen[0]), "{}", seen.len());
            }
            writer.join().unwrap().unwrap();
        });
        assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, OWNER_ALONE);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "nothing is left beside it");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
