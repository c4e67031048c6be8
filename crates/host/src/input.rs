//! Input files. An error names the file and says what to check.

use std::fs::File;
use std::io::{self, Read as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use anyhow::{Context, Result, anyhow};

/// Permission bits that let the file's group or everybody read the file.
const READABLE_BY_OTHERS: u32 = 0o044;

/// Opens an input file.
///
/// # Errors
/// The file does not exist or may not be read; the message names it.
pub fn open(path: &Path) -> Result<File> {
    File::open(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => anyhow!(
            "there is no file {}: check the path (relative paths start in the current folder)",
            path.display()
        ),
        io::ErrorKind::PermissionDenied => anyhow!(
            "{} may not be read by this user: change its owner or its rights (`ls -l {}` shows them)",
            path.display(),
            path.display()
        ),
        _ => anyhow!("{} cannot be read: {error}", path.display()),
    })
}

/// Reads a whole input file.
///
/// # Errors
/// As [`open`], and a file that cannot be read to its end.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).with_context(|| format!("{} cannot be read", path.display()))?;
    Ok(bytes)
}

/// Whether the group or everybody may read a file; `false` for a file that does not exist.
pub fn is_readable_by_others(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| found.permissions().mode() & READABLE_BY_OTHERS != 0)
}
