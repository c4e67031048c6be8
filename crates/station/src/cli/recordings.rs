//! The arguments of the commands that read recordings: `replay`, `export`.

use std::path::PathBuf;

use clap::Args;

/// `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman replay sortie.mcap --compare")]
pub struct ReplayArgs {
    /// The recording.
    pub recording: PathBuf,
    /// Replay with this configuration instead of the recorded one.
    #[arg(long, value_name = "CHANGED.toml")]
    pub config: Option<PathBuf>,
    /// Compare every command with the recorded one; exit 1 if any differs.
    #[arg(long)]
    pub compare: bool,
}

/// `export`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman export sortie.mcap --output sortie")]
pub struct ExportArgs {
    /// The recording.
    pub recording: PathBuf,
    /// Folder of the output files.
    #[arg(long, value_name = "DIR")]
    pub output: PathBuf,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}
