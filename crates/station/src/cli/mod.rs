//! The command line: every command, its options, and an example of each.
//!
//! Values are checked while they are parsed; what is wrong with one is said in clap's words and ends with exit
//! code 2. What a command does lives in `commands`.

mod check;
mod config;
mod demo;
mod emulate;
mod law_options;
mod log_options;
mod logs;
mod recordings;
mod region_options;
mod run;
mod scenarios;
mod track;
mod trials;
mod values;
mod wrong_use;

use clap::{Parser, Subcommand};

pub use check::CheckArgs;
pub use config::{ConfigArgs, ConfigWhat};
pub use demo::DemoArgs;
pub use emulate::{EmulateArgs, EmulateFotokiteProArgs, StationName};
pub use law_options::LawOptions;
pub use log_options::{LogFormat, LogLevel};
pub use logs::{LawArgs, MetricsArgs, ReportArgs};
pub use recordings::{ExportArgs, ReplayArgs};
pub use region_options::RegionArgs;
pub use run::RunArgs;
pub use scenarios::{RenderArgs, ScenariosArgs};
pub use track::TrackArgs;
pub use trials::{CompareArgs, MergeArgs, PerceptionName, TrialsArgs};
pub use values::Shard;
pub use wrong_use::WrongUse;

/// Keeps an unmanned surface vehicle in a small tethered UAV's view, moving the camera as little as possible.
#[derive(Debug, Parser)]
#[command(
    name = "barrelman",
    version,
    max_term_width = 100,
    after_help = "Examples:
  barrelman
  barrelman check --video rtsp://192.168.2.100/live
  barrelman run --video sim:arena1 --link sim: --engage

Without a command it does what demo does."
)]
pub struct Cli {
    /// What to do; without a command: demo.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// How much is logged on stderr.
    #[arg(long, global = true, value_enum, default_value_t = LogLevel::Info, help_heading = "Logging")]
    pub log_level: LogLevel,
    /// How log lines look.
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, help_heading = "Logging")]
    pub log_format: LogFormat,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Drive a simulated boat in the browser, while the camera follows it.
    Demo(DemoArgs),
    /// Track the boat in live video and move the vehicle's camera.
    Run(RunArgs),
    /// Run the tracker alone on a recording.
    Track(TrackArgs),
    /// Put recorded positions through a camera law.
    Law(LawArgs),
    /// Measure trials: sensitivity, excursions, movement, energy.
    Metrics(MetricsArgs),
    /// Make an HTML page of trials, with figures.
    Report(ReportArgs),
    /// Run simulated trials, one for each seed.
    Trials(TrialsArgs),
    /// Join the shards of a campaign of trials.
    Merge(MergeArgs),
    /// Compare two campaigns of trials, paired by seed.
    Compare(CompareArgs),
    /// List the scenarios that can be simulated, or print one scenario's file, documented.
    Scenarios(ScenariosArgs),
    /// Draw a clip of a scenario, with its exact truth.
    Render(RenderArgs),
    /// Run a recording through the pilot again.
    Replay(ReplayArgs),
    /// Turn a recording into CSV files and an MP4.
    Export(ExportArgs),
    /// Emulate a ground station to test against.
    Emulate(EmulateArgs),
    /// Say what is reachable, what is missing, and how to mend it.
    Check(CheckArgs),
    /// Print the configuration, documented.
    Config(ConfigArgs),
}
