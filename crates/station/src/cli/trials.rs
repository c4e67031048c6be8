//! The arguments of the commands of campaigns: `trials`, `merge`, `compare`.

use std::path::PathBuf;

use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_simd::SimdLevel;
use barrelman_vocab::PictureSize;
use clap::{Args, ValueEnum};

use super::columns::{COLUMNS, COLUMNS_IN_PIXELS, COLUMNS_OF_GUIDANCE};
use super::law_options::LawOptions;
use super::values::{
    Shard, parse_count, parse_not_negative, parse_positive, parse_rate, parse_sea_state, parse_shard,
    parse_world_size,
};

/// The examples of `trials`.
const TRIALS_EXAMPLES: &str = "Examples:
  barrelman trials lab1 --perception truth --trials 200 --output lab1.jsonl
  barrelman trials lab1 --perception truth --law optimal --record recordings
  barrelman trials lab2 --trials 1 --size 320x180 --record pictures
  barrelman trials lab1 --perception truth --trials 100 --shard 3/10 \\
    --output shard-3.jsonl
  barrelman trials rescue --perception truth --guidance los --current 0.35
  barrelman trials --drive drive.jsonl --law optimal --record driven

Nothing is written without --output or --record.
With --perception truth a trial takes less than a second; with pixels (the
default) pictures are rendered and tracked, at about real time.";

/// `trials`.
#[derive(Debug, Args)]
#[command(
    after_help = TRIALS_EXAMPLES,
    after_long_help = format!("{TRIALS_EXAMPLES}\n\n{COLUMNS}\n\n{COLUMNS_IN_PIXELS}\n\n{COLUMNS_OF_GUIDANCE}"),
    mut_arg("law", |arg| arg.help("The camera law; default: schema, or with --drive the drive's"))
)]
pub struct TrialsArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of a .toml file.
    #[arg(required_unless_present = "drive")]
    pub scenario: Option<String>,
    /// Run one trial with the steering of this drive, which `demo --store` wrote. Scenario and seed are the
    /// drive's; so are picture size, tracker and camera law, unless given.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "trials", "seed", "shard", "boat_speed"])]
    pub drive: Option<PathBuf>,
    /// Number of trials.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Seed of the first trial; each further trial has the next seed.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Rate of the schema on both axes, rad/s; default: the vehicle's. The simulated vehicle's limits are
    /// raised to it.
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true, value_parser = parse_rate)]
    pub rate: Option<f64>,
    /// The source of localisations.
    #[arg(long, value_enum, default_value_t)]
    pub perception: PerceptionName,
    /// The tracker, with `--perception pixels`; default: `fused`.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// How the kite moves: a setting of the scenario (`lab1`: still, indoor or windy; `arena1`: calm or
    /// tether); default: the scenario's.
    #[arg(long, value_name = "NAME")]
    pub setting: Option<String>,
    /// The plant: the scenario's, or sampled for each trial from the scenario's intervals.
    #[arg(long, value_enum, default_value_t)]
    pub plant: PlantName,
    /// The target's speed; default: the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub boat_speed: Option<f64>,
    /// Sea state, 0 (glassy) to 4 (moderate); default: the scenario's.
    #[arg(long, value_name = "0..4", allow_negative_numbers = true, value_parser = parse_sea_state)]
    pub sea_state: Option<u8>,
    /// Mean wind; default: the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_not_negative)]
    pub wind: Option<f64>,
    /// Water current across the first view, positive to the right; default: the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true)]
    pub current: Option<f64>,
    /// Let the boat go to the scenario's first person by this law, instead of along its path by the helmsman.
    #[arg(long, value_enum, value_name = "NAME", conflicts_with_all = ["drive", "boat_speed"])]
    pub guidance: Option<GuidedBy>,
    /// Size of the picture; the field of view stays the same. Default: the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_world_size)]
    pub size: Option<PictureSize>,
    /// Number of trials at the same time; default: the number of cores. The results are the same for any
    /// number.
    #[arg(long, value_name = "N", value_parser = parse_count)]
    pub threads: Option<usize>,
    /// Run only every Nth trial, from the Ith on: one of N parts that `merge` joins.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Widest vector instructions of the renderer: scalar, sse2, avx2 or avx512. The results are the same
    /// with each.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Record every trial into this folder: SCENARIO-SEED.mcap, and with pixels its film, the annotated video
    /// SCENARIO-SEED.mp4. The .mcap of a trial in pixels holds no pictures: `replay` renders them again from
    /// scenario, seed and commands.
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Continue the file of --output: trials in the file are not run again.
    #[arg(long)]
    pub resume: bool,
    /// Write the results to this file, one trial per line (JSON).
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an existing output file.
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
}

/// The laws that guide the boat in trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum GuidedBy {
    /// Along a line over the water.
    Los,
    /// The law of the paper's laboratory, in the picture.
    Lab,
}

/// The source of localisations of simulated trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PerceptionName {
    /// The tracker, on rendered pictures.
    #[default]
    Pixels,
    /// The truth, with noise.
    Truth,
}

/// The examples of `merge`.
const MERGE_EXAMPLES: &str = "Example:\n  barrelman merge shard-*.jsonl --output campaign.jsonl";

/// `merge`.
#[derive(Debug, Args)]
#[command(
    after_help = MERGE_EXAMPLES,
    after_long_help = format!("{MERGE_EXAMPLES}\n\n{COLUMNS}\n\n{COLUMNS_IN_PIXELS}")
)]
pub struct MergeArgs {
    /// The files of the shards.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Write the joined campaign to this file.
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub force: bool,
}

/// `compare`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman trials lab1 --perception truth --output schema.jsonl
  barrelman trials lab1 --perception truth --law optimal --output optimal.jsonl
  barrelman compare schema.jsonl optimal.jsonl")]
pub struct CompareArgs {
    /// A campaign file.
    pub first: PathBuf,
    /// A second campaign file, with the same scenario, seeds and settings of the world; law and tracker may
    /// differ.
    pub second: PathBuf,
    /// Compare campaigns of different worlds, too: of other settings, plants, picture sizes, or of truth and
    /// pixels.
    #[arg(long)]
    pub anyway: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
