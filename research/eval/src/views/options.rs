//! Options of `barrelman-eval views`.

use std::path::PathBuf;

/// Options of `views`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Folder for the pictures; created if it does not exist
    #[arg(long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Render only views whose name contains this
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(crate) only: String,
    /// Width of the pictures in pixels; the height is 9/16 of it
    #[arg(long, value_name = "PIXELS", default_value_t = 1280)]
    pub(crate) width: u32,
}
