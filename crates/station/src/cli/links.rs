//! The arguments of `links`.

use std::path::PathBuf;

use clap::Args;

/// `links`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman links

The links of the service are root's to read: put sudo before it.
The links hold the console's tokens: who has the first one may control.")]
pub struct LinksArgs {
    /// The file that a run writes with --links-file; default: that of the service.
    #[arg(long, value_name = "FILE", default_value = "/run/barrelman/links", hide_default_value = true)]
    pub file: PathBuf,
}
