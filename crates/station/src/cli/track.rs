//! The arguments of `track`.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_vocab::PixelBox;
use clap::Args;

use super::values::{parse_box, parse_listen, parse_mp4_path};

/// `track`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman render arena1 --seed 7 --seconds 10 --size 640x360 \\
    --output clip.mp4 --truth truth.csv
  barrelman snapshot clip.mp4 --output first.png
  barrelman track clip.mp4 --select 293,138,48,23 \\
    --output track.csv --overlay seen.mp4

`snapshot` draws a frame with a grid, to read the box from.")]
pub struct TrackArgs {
    /// The recording: an MP4 or MOV with H.264, a Y4M, or a folder of pictures.
    pub video: String,
    /// Track what is in this box of the start frame: left, top, width, height in pixels. Without it, a page
    /// in the browser shows the frame, to draw the box in, where there is a display or --listen.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = parse_box)]
    pub select: Option<PixelBox>,
    /// Address of the page for drawing the box; default: 127.0.0.1:8480, or the next free port.
    #[arg(long, value_name = "ADDR", value_parser = parse_listen, conflicts_with = "select")]
    pub listen: Option<SocketAddr>,
    /// Number of the frame with the selection, from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub start_frame: u64,
    /// Write the track to this file; default: stdout.
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub tracker: TrackerName,
    /// Write the annotated video to this file.
    #[arg(long, value_name = "OUT.mp4", value_parser = parse_mp4_path)]
    pub overlay: Option<PathBuf>,
    /// Draw the tracker's intermediate results into the annotated video.
    #[arg(long, requires = "overlay")]
    pub explain: bool,
    /// Print figures as JSON; the track is then written only with --output.
    #[arg(long)]
    pub json: bool,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}

/// `snapshot`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman snapshot clip.mp4 --frame 100 --output frame.png

The boat's left, top, width and height, read from the grid, are the box for
`track --select` and `run --select`.")]
pub struct SnapshotArgs {
    /// The recording: an MP4 or MOV with H.264, a Y4M, or a folder of pictures.
    pub video: String,
    /// Number of the frame, from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub frame: u64,
    /// Write the picture to this file.
    #[arg(long, value_name = "FILE.png", value_parser = parse_png)]
    pub output: PathBuf,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub force: bool,
}

fn parse_png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    if is_png {
        Ok(path)
    } else {
        Err("the picture is written as PNG: use a name that ends in .png".to_owned())
    }
}
