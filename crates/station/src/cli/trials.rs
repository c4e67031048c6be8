//! The arguments of the commands of campaigns: `trials`, `merge`, `compare`.

use std::path::PathBuf;

use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_simd::SimdLevel;
use barrelman_vocab::PictureSize;
use clap::{Args, ValueEnum};

use super::law_options::LawOptions;
use super::values::{
    Shard, parse_count, parse_not_negative, parse_positive, parse_rate, parse_sea_state, parse_shard,
    parse_size,
};

/// `trials`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman trials lab1 --perception truth --trials 200 --seed 10000 --output lab1.jsonl
  barrelman trials arena1 --trials 20 --record recordings
  barrelman trials lab1 --perception truth --trials 1000 --shard 3/10 --output shard-3.jsonl
  barrelman trials --drive drive.jsonl --law optimal --record recordings

Nothing is written without --output or --record.")]
pub struct TrialsArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file.
    #[arg(required_unless_present = "drive")]
    pub scenario: Option<String>,
    /// One trial in which the boat is steered as in this drive, which `demo --store` wrote: its scenario, its seed, the
    /// size of its pictures, its tracker and its camera law, where no other is asked for.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "trials", "seed", "shard", "boat_speed"])]
    pub drive: Option<PathBuf>,
    /// How many trials.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Seed of the first trial; each further one has the next.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Rate of the schema on both axes, rad/s; without it the vehicle's. The simulated vehicle is able to turn so fast.
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true, value_parser = parse_rate)]
    pub rate: Option<f64>,
    /// Where localisations come from.
    #[arg(long, value_enum, default_value_t)]
    pub perception: PerceptionName,
    /// The tracker, in pixels; without it `fused`.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// How the kite moves by itself: a setting of the scenario (of `lab1` still, indoor or windy, of `arena1` calm or
    /// tether); without it the scenario's own.
    #[arg(long, value_name = "NAME")]
    pub setting: Option<String>,
    /// The plant: as the scenario has it, or drawn for each trial from the scenario's intervals.
    #[arg(long, value_enum, default_value_t)]
    pub plant: PlantName,
    /// The target's speed; without it the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub boat_speed: Option<f64>,
    /// Sea state, 0 (glassy) to 4 (moderate); without it the scenario's.
    #[arg(long, value_name = "0..4", allow_negative_numbers = true, value_parser = parse_sea_state)]
    pub sea_state: Option<u8>,
    /// Mean wind; without it the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_not_negative)]
    pub wind: Option<f64>,
    /// Size of the picture; the view stays the same. Without it the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// Trials at the same time; without it as many as there are cores. The results are the same for any number.
    #[arg(long, value_name = "N", value_parser = parse_count)]
    pub threads: Option<usize>,
    /// Only every Nth trial, from the Ith on: one of N parts that `merge` joins.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// The widest vector instructions that pictures are drawn with: scalar, sse2, avx2 or avx512. The results are the
    /// same with all.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Record every trial here: SCENARIO-SEED.mcap, and in pixels the annotated video SCENARIO-SEED.mp4.
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Go on with the file that --output names: trials that are in it are not run again.
    #[arg(long)]
    pub resume: bool,
    /// Where results go, one trial per line (JSON).
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an output file that exists.
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
}

/// Where localisations of simulated trials come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PerceptionName {
    /// Pictures are drawn, and the tracker looks at them.
    #[default]
    Pixels,
    /// The truth, with noise.
    Truth,
}

/// `merge`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman merge shard-*.jsonl --output campaign.jsonl")]
pub struct MergeArgs {
    /// The files of the shards.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Where the whole goes.
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an output file that exists.
    #[arg(long)]
    pub force: bool,
}

/// `compare`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman trials lab1 --perception truth --trials 200 --law schema --output schema.jsonl
  barrelman trials lab1 --perception truth --trials 200 --law centre --output centre.jsonl
  barrelman compare schema.jsonl centre.jsonl")]
pub struct CompareArgs {
    /// A campaign's file.
    pub first: PathBuf,
    /// Another's, on the same scenario and seeds.
    pub second: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
