//! The arguments of the commands that read trial logs: `law`, `metrics`, `report`.

use std::path::PathBuf;

use barrelman_vocab::PictureSize;
use clap::Args;

use super::columns::{COLUMNS, COLUMNS_IN_PIXELS};
use super::law_options::LawOptions;
use super::region_options::RegionArgs;
use super::values::{parse_rate, parse_size};

/// `law`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:
  barrelman law arena1_01.csv --output commands.csv
  barrelman law arena1_01.csv --law optimal --mode eco --output eco.csv

The rates are those that the vehicle would be sent, in its own signs.",
    mut_arg("law", |arg| arg.help("The camera law; default: schema"))
)]
pub struct LawArgs {
    /// The log: a CSV of the laboratory, an exported CSV, or a recording.
    pub log: PathBuf,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Rate of the schema on both axes, rad/s; default: the vehicle's.
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true, value_parser = parse_rate)]
    pub rate: Option<f64>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// The vehicle's profile: the printed rates have this vehicle's signs.
    #[arg(long, value_name = "NAME", default_value = "fotokite-pro")]
    pub profile: String,
    /// Write the rows to this file; default: stdout.
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
    /// Overwrite an existing output file.
    #[arg(long)]
    pub force: bool,
}

/// The examples of `metrics`.
const METRICS_EXAMPLES: &str = "Examples:
  barrelman metrics lab1.jsonl
  barrelman metrics arena1_*.csv arena2_*.csv";

/// `metrics`.
#[derive(Debug, Args)]
#[command(
    after_help = METRICS_EXAMPLES,
    after_long_help = format!("{METRICS_EXAMPLES}\n\n{COLUMNS}\n\n{COLUMNS_IN_PIXELS}")
)]
pub struct MetricsArgs {
    /// The logs: CSV of the laboratory, exported CSV, recordings, or campaign files.
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The arena, for files whose name does not tell.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub arena: Option<u8>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// Size of the picture within the frame, for the time at the picture's border; default: the log's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub picture: Option<PictureSize>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman trials lab1 --perception truth --trials 5 --record recordings
  barrelman trials lab1 --perception truth --law optimal --output optimal.jsonl
  barrelman report recordings/*.mcap optimal.jsonl --output report.html
  barrelman report arena1_*.csv arena2_*.csv --output paper.html --svg figures")]
pub struct ReportArgs {
    /// The logs: CSV of the laboratory, exported CSV, recordings, or campaign files of `trials --output`
    /// (their metrics; a campaign file has no figures over time).
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// Write the page to this file.
    #[arg(long, value_name = "REPORT.html")]
    pub output: PathBuf,
    /// Also write each figure as SVG into this folder.
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// The arena, for files that do not tell.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub arena: Option<u8>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}
