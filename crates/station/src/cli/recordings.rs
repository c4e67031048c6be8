//! The arguments of the commands that read recordings: `library`, `replay`, `export`.

use std::path::PathBuf;

use clap::Args;

use crate::config::changed_keys::ChangedKey;

/// `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman demo open --seconds 5 --record sortie.mcap
  barrelman replay sortie.mcap --compare
  barrelman replay sortie.mcap --compare --set law.mode=eco

A recording of a simulated trial in pixels (`trials --record`) holds no
pictures: they are rendered again, to the same bits. Its film is the .mp4
beside it.")]
pub struct ReplayArgs {
    /// The recording.
    pub recording: PathBuf,
    /// Replay with this configuration instead of the recorded one.
    #[arg(long, value_name = "CHANGED.toml")]
    pub config: Option<PathBuf>,
    /// Change this key of the recorded configuration, such as law.mode=eco; KEY= takes the key out. May be
    /// given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "config")]
    pub changed: Vec<ChangedKey>,
    /// Compare every command with the recorded one; exit 1 if any differs.
    #[arg(long)]
    pub compare: bool,
}

/// `library`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman library
  barrelman library sortie.mcap

Without a path, the folder of `recording.folder` is listed.")]
pub struct LibraryArgs {
    /// A folder of recordings, or a recording.
    pub path: Option<PathBuf>,
    /// The configuration that names the folder.
    #[arg(long, value_name = "CONFIG.toml", conflicts_with = "path")]
    pub config: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `export`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman export sortie.mcap --output sortie
  barrelman export sortie.mcap --output film --annotated

The folder gets one CSV file a channel, trial.csv with the rows of the trial,
and video.mp4. A recording of a simulated trial (`trials --record`) holds no
video; with pixels its film is the .mp4 beside it.")]
pub struct ExportArgs {
    /// The recording.
    pub recording: PathBuf,
    /// Folder of the output files.
    #[arg(long, value_name = "DIR")]
    pub output: PathBuf,
    /// Write annotated.mp4, too: the video with box, region, mode and time of day drawn into it.
    #[arg(long)]
    pub annotated: bool,
    /// Write report.html, too: the page of `barrelman report`.
    #[arg(long)]
    pub report: bool,
    /// Write the tracks of boat and marks on Earth, too, as tracks.geojson.
    #[arg(long)]
    pub geojson: bool,
    /// The same as tracks.kml.
    #[arg(long)]
    pub kml: bool,
    /// The same as tracks.gpx.
    #[arg(long)]
    pub gpx: bool,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}
