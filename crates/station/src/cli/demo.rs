//! The arguments of `demo`.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_vocab::PictureSize;
use clap::Args;

use super::law_options::LawOptions;
use super::values::{parse_seconds, parse_size};

/// `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman demo
  barrelman demo arena1 --store drive.jsonl
  barrelman demo --replay drive.jsonl
  barrelman demo --clip --output demo-output

The page takes keys: arrows steer the boat, p pauses, space stops the camera, e engages it, h leaves the boat to
the scenario's helmsman again. A terminal takes keys, too: e engages, space and d stop the camera, q quits. --clip is the loop on a practice clip that the program draws, against an emulated
ground station.")]
pub struct DemoArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file; without it: open.
    pub scenario: Option<String>,
    /// Where the page is served; without it: 127.0.0.1:8480, or the next port that is free.
    #[arg(long, value_name = "ADDR")]
    pub listen: Option<SocketAddr>,
    /// Size of the picture; the view stays the same. Without it the scenario's, at most 960 wide.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// Everything that is left to chance comes from this.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// End after so many seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_seconds)]
    pub seconds: Option<f64>,
    /// Record everything here; the pilot then sees the pictures as they are recorded, in H.264.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Store the drive here: the scenario, and each input with its tick.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with = "replay")]
    pub store: Option<PathBuf>,
    /// Drive a stored drive again, without a page and as fast as it goes; exit 1 unless it
    /// is the same, bit for bit.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "listen", "size", "seed", "seconds", "law", "mode", "horizon"])]
    pub replay: Option<PathBuf>,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t, conflicts_with = "replay")]
    pub tracker: TrackerName,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// The loop on a practice clip instead, against an emulated ground station.
    #[arg(long, conflicts_with_all = ["scenario", "listen", "size", "seed", "seconds", "record", "store", "replay"])]
    pub clip: bool,
    /// With --clip: where the clip, the annotated video and the recording go.
    #[arg(long, default_value = "demo-output", requires = "clip")]
    pub output: PathBuf,
    /// With --clip: draw the practice clip and its truth, and run nothing.
    #[arg(long, requires = "clip")]
    pub draw_only: bool,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

impl Default for DemoArgs {
    fn default() -> Self {
        Self {
            scenario: None,
            listen: None,
            size: None,
            seed: 1,
            seconds: None,
            record: None,
            store: None,
            replay: None,
            tracker: TrackerName::default(),
            law: LawOptions::default(),
            clip: false,
            output: PathBuf::from("demo-output"),
            draw_only: false,
            force: false,
        }
    }
}
