//! Where the workspace and the data beside it lie.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// The root folder of the workspace.
///
/// # Errors
/// If this crate does not lie two folders below it.
pub(crate) fn workspace_root() -> Result<PathBuf> {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    crates
        .and_then(Path::parent)
        .map(Path::to_path_buf)
        .context("the workspace lies two folders above this crate")
}

/// The folder that was given, or else the default: a path relative to the workspace.
///
/// # Errors
/// As [`workspace_root`].
pub(crate) fn path_or_default(given: Option<&PathBuf>, default: &str) -> Result<PathBuf> {
    Ok(match given {
        Some(path) => path.clone(),
        None => workspace_root()?.join(default),
    })
}
