//! The symbolic link to a pseudo-terminal.
//!
//! Creating the link never removes what belongs to others. Whatever lies at the path is kept and causes an
//! error, with two exceptions: a link to a pseudo-terminal that no longer exists, as a killed emulator leaves
//! it, and with `--force` any symbolic link. A file, a folder or a device is never replaced.

use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;

/// The folder of pseudo-terminals, which are named by their numbers.
const TERMINALS: &str = "/dev/pts";
/// Attempts to create the link while other programs change the same path.
const ATTEMPTS: u32 = 8;

/// A link to a pseudo-terminal. Dropping it removes the link.
#[derive(Debug)]
pub(super) struct PortLink {
    path: PathBuf,
    device: PathBuf,
}

impl PortLink {
    /// Creates a link at `path` to `device`. With `force`, another symbolic link at `path` is replaced.
    ///
    /// # Errors
    /// If something else lies at `path`, or the link cannot be created; the message names the path.
    pub(super) fn create(path: &Path, device: &Path, force: bool) -> Result<Self> {
        let link = Self { path: path.to_owned(), device: device.to_owned() };
        let context = || format!("the port's link {} cannot be created", path.display());
        for attempt in 0..ATTEMPTS {
            match symlink(device, path) {
                Ok(()) => return Ok(link),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error).with_context(context),
            }
            let target = match std::fs::read_link(path) {
                Ok(target) => target,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) if error.kind() == io::ErrorKind::InvalidInput => {
                    bail!(
                        "{} exists and is no symbolic link: choose another path for the port",
                        path.display()
                    )
                }
                Err(error) => return Err(error).with_context(context),
            };
            // Left by a killed emulator, whose terminal's number the new terminal has got.
            if target == device {
                return Ok(link);
            }
            if !force && !is_stale(&target) {
                bail!(
                    "{} exists already, as a symbolic link to {}: choose another path for the port, or replace the link \
                     with --force",
                    path.display(),
                    target.display()
                );
            }
            if link.replace(&target, attempt).with_context(context)? {
                return Ok(link);
            }
        }
        bail!("{} cannot be linked: other programs keep changing it", path.display())
    }

    /// The path of the link.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the link, if it still points to this terminal.
    pub(super) fn remove(&self) {
        if std::fs::read_link(&self.path).is_ok_and(|target| target == self.device) {
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// Replaces the link to `target` by this one, atomically. Returns whether the link to `target` was
    /// replaced: anything else that appeared in the meantime is put back.
    fn replace(&self, target: &Path, attempt: u32) -> io::Result<bool> {
        let mut name = self.path.as_os_str().to_owned();
        name.push(format!(".{}-{attempt}", std::process::id()));
        let beside = PathBuf::from(name);
        symlink(&self.device, &beside)?;
        let exchange = || renameat_with(CWD, &beside, CWD, &self.path, RenameFlags::EXCHANGE);
        let replaced = match exchange() {
            Ok(()) if std::fs::read_link(&beside).is_ok_and(|found| found == target) => Ok(true),
            Ok(()) => exchange().map(|()| false).map_err(io::Error::from),
            Err(Errno::NOENT) => Ok(false),
            Err(error) => Err(io::Error::from(error)),
        };
        // The path now holds this link or the replaced one.
        let is_removable =
            std::fs::read_link(&beside).is_ok_and(|found| found == self.device || found == target);
        if is_removable {
            std::fs::remove_file(&beside)?;
        }
        replaced
    }
}

impl Drop for PortLink {
    fn drop(&mut self) {
        self.remove();
    }
}

/// Whether a link's target is a pseudo-terminal that no longer exists.
fn is_stale(target: &Path) -> bool {
    let number = target.strip_prefix(TERMINALS).ok().and_then(Path::to_str);
    let is_terminal = number.is_some_and(|text| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit()));
    let is_missing =
        std::fs::symlink_metadata(target).is_err_and(|error| error.kind() == io::ErrorKind::NotFound);
    is_terminal && is_missing
}
