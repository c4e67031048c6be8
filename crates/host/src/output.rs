//! Output files: none that exists is overwritten without being asked to.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Creates an output file; one that exists is overwritten with `force` only.
///
/// # Errors
/// If it exists and `force` is not given, or cannot be created; the message names it.
pub fn create(path: &Path, force: bool) -> Result<File> {
    let mut options = OpenOptions::new();
    options.write(true);
    if force {
        options.create(true).truncate(true);
    } else {
        options.create_new(true);
    }
    match options.open(path) {
        Ok(file) => Ok(file),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            bail!("{} exists already: choose another name, or overwrite it with --force", path.display())
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            bail!("{} cannot be written: its folder does not exist, make it first", path.display())
        }
        Err(error) => Err(error).with_context(|| format!("{} cannot be written", path.display())),
    }
}

/// Checks that an output file may be created, before work begins that would be lost otherwise.
///
/// # Errors
/// If it exists and `force` is not given.
pub fn check_free(path: &Path, force: bool) -> Result<()> {
    if !force && path.exists() {
        bail!("{} exists already: choose another name, or overwrite it with --force", path.display());
    }
    Ok(())
}
