//! The command line: the commands, their options, and examples.
//!
//! Values are checked while they are parsed; a wrong value ends the program with clap's message and exit
//! code 2. The module [`crate::commands`] runs the commands.

mod demo;

mod run;

mod track;

mod logs;

mod columns;
mod trials;

mod scenarios;

mod recordings;

mod emulate;

mod calibrate;
mod check;
mod config;
mod links;

mod connection_options;
mod console_options;
mod law_options;
mod log_options;
mod region_options;

mod usage_error;
mod values;

use clap::{Parser, Subcommand};

pub use calibrate::{CalibrateArgs, CalibrateAxesArgs, CalibrateCommand};
pub use check::{CheckArgs, DoctorArgs};
pub use config::{ConfigArgs, ConfigCommand};
pub use connection_options::ConnectionOptions;
pub use console_options::ConsoleOptions;
pub use demo::DemoArgs;
pub use emulate::{
    BoatName, CameraKindName, EmulateArgs, EmulateFotokiteProArgs, EmulateFotokiteSigmaArgs,
    EmulateGimbalArgs, EmulateOnvifArgs, EmulateVesselArgs, HabitsName, StationName, WorldArgs,
};
pub use law_options::LawOptions;
pub use links::LinksArgs;
pub use log_options::{LogFormat, LogLevel};
pub use logs::{LawArgs, MetricsArgs, ReportArgs};
pub use recordings::{ExportArgs, LibraryArgs, ReplayArgs};
pub use region_options::RegionArgs;
pub use run::RunArgs;
pub use scenarios::{RenderArgs, ScenariosArgs};
pub use track::{SnapshotArgs, TrackArgs};
pub use trials::{CompareArgs, GuidedBy, MergeArgs, PerceptionName, TrialsArgs};
pub use usage_error::UsageError;
pub use values::Shard;

/// Keeps an unmanned surface vehicle in the view of a small tethered UAV, with gentle movements of the
/// camera.
#[derive(Debug, Parser)]
#[command(
    name = "barrelman",
    version,
    max_term_width = 100,
    after_help = "Examples:
  barrelman
  barrelman trials lab1 --perception truth
  barrelman run --video sim:arena1 --link sim: --hands-on
  barrelman check --video rtsp://camera.example/live

Without a command, barrelman runs demo."
)]
pub struct Cli {
    /// The command; default: demo.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Least severe level that is logged on stderr.
    #[arg(long, global = true, value_enum, default_value_t = LogLevel::Info, help_heading = "Logging")]
    pub log_level: LogLevel,
    /// Format of log lines.
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, help_heading = "Logging")]
    pub log_format: LogFormat,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Steer a simulated boat in the browser while the camera follows it.
    Demo(DemoArgs),
    /// Track the boat in live video and move the vehicle's camera.
    Run(Box<RunArgs>),
    /// Run the tracker alone on a recording.
    Track(TrackArgs),
    /// Draw a frame of a video with a grid of coordinates, to select a boat.
    Snapshot(SnapshotArgs),
    /// Run a camera law on recorded positions.
    Law(LawArgs),
    /// Measure trials: sensitivity, excursions, movement, energy.
    Metrics(MetricsArgs),
    /// Make an HTML page of trials, logs and campaigns, with figures.
    Report(ReportArgs),
    /// Run simulated trials, one for each seed.
    Trials(TrialsArgs),
    /// Join the shards of a campaign of trials.
    Merge(MergeArgs),
    /// Compare two campaigns of trials, paired by seed.
    Compare(CompareArgs),
    /// List the built-in scenarios, or print the documented file of one.
    Scenarios(ScenariosArgs),
    /// Render a clip of a scenario, with the exact truth.
    Render(RenderArgs),
    /// List recordings, or say what one of them holds
    Library(LibraryArgs),
    /// Run a recording through the pilot again.
    Replay(ReplayArgs),
    /// Convert a recording to CSV files and an MP4.
    Export(ExportArgs),
    /// Emulate a vehicle or a boat for tests.
    Emulate(EmulateArgs),
    /// Measure the camera's axes by slow test motions.
    Calibrate(CalibrateArgs),
    /// Check the configuration, the video and the link, and suggest remedies.
    Check(CheckArgs),
    /// Look at this machine: ports, cameras, decoders, clock, disk, sleep; each lack with its remedy.
    Doctor(DoctorArgs),
    /// Print the links of the running service, with a QR code.
    Links(LinksArgs),
    /// Print an example, the JSON schema, or the effective configuration.
    Config(ConfigArgs),
}
