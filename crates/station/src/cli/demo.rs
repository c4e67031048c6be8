//! The arguments of `demo`.

use std::path::PathBuf;

use barrelman_experiments::law_choice::named_values;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_vocab::{DrillName, Named as _, PictureSize};
use clap::Args;

use super::console_options::ConsoleOptions;
use super::law_options::LawOptions;
use super::values::{parse_seconds, parse_world_size};

/// Options that have no effect with `--clip`. (A requirement of `--clip` alone is not checked beside an
/// option that excludes it.)
const WITHOUT_CLIP: [&str; 11] = [
    "scenario",
    "drill",
    "ConsoleOptions",
    "size",
    "seed",
    "seconds",
    "record",
    "store",
    "replay",
    "hands_on",
    "share",
];

/// `demo`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:
  barrelman demo
  barrelman demo --hands-on
  barrelman demo --drill find-the-boat
  barrelman demo arena1 --store drive.jsonl
  barrelman demo --replay drive.jsonl
  barrelman demo --clip --output demo-output

Keys on the console: arrows steer the boat, space stops camera and boat, e
engages the camera; ? shows all keys.
Keys on a terminal: e engages, d disengages, s searches for a lost boat, space
stops camera and boat, q quits.
--clip runs the live loop on a rendered practice clip, with an emulated ground
station.",
    mut_arg("law", |arg| arg.help("The camera law; default: optimal, and schema with --clip"))
)]
pub struct DemoArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of a .toml file; default: open, and
    /// first-drive with --hands-on.
    pub scenario: Option<String>,
    /// The console.
    #[command(flatten)]
    pub console: ConsoleOptions,
    /// Begin unselected and disengaged, and wait: the operator draws the box around the boat, and engages.
    #[arg(long, conflicts_with = "replay")]
    pub hands_on: bool,
    /// Begin with a drill: a short task with a result. Without a name: keep-in-view. More of them on the
    /// page.
    #[arg(
        long,
        value_name = "NAME",
        num_args = 0..=1,
        default_missing_value = DrillName::KeepInView.key(),
        value_parser = named_values::<DrillName>(),
        conflicts_with_all = ["scenario", "hands_on", "replay"],
    )]
    pub drill: Option<DrillName>,
    /// Serve the annotated video to other programs there, as in rtsp://127.0.0.1:8554/boat. Off loopback they
    /// give the user watch and the console's watch token. Needs barrelman-media.
    #[arg(long, value_name = "URL", conflicts_with = "replay")]
    pub share: Option<String>,
    /// Size of the picture; the field of view stays the same. Default: the scenario's, at most 960 wide.
    #[arg(long, value_name = "WxH", value_parser = parse_world_size)]
    pub size: Option<PictureSize>,
    /// Seed of all random numbers.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// Duration of the session, seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_seconds)]
    pub seconds: Option<f64>,
    /// Record to this file; the pilot then sees the pictures as recorded, in H.264.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Store the drive in this file: the scenario, and each input with its tick.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with = "replay")]
    pub store: Option<PathBuf>,
    /// Replay a stored drive, without a page and at full speed; exit 1 unless it is the same,
    /// bit for bit.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "ConsoleOptions", "size", "seed", "seconds", "law", "mode", "horizon"])]
    pub replay: Option<PathBuf>,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t, conflicts_with = "replay")]
    pub tracker: TrackerName,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Run the live loop on a practice clip instead, with an emulated ground station.
    #[arg(long, conflicts_with_all = WITHOUT_CLIP)]
    pub clip: bool,
    /// With --clip: folder of the clip, the annotated video and the recording.
    #[arg(long, default_value = "demo-output", requires = "clip", conflicts_with_all = WITHOUT_CLIP)]
    pub output: PathBuf,
    /// With --clip: only render the practice clip and its truth.
    #[arg(long, requires = "clip", conflicts_with_all = WITHOUT_CLIP)]
    pub draw_only: bool,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}

impl Default for DemoArgs {
    fn default() -> Self {
        Self {
            scenario: None,
            console: ConsoleOptions::default(),
            hands_on: false,
            drill: None,
            share: None,
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
