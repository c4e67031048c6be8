//! The arguments of `calibrate`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::connection_options::ConnectionOptions;

/// `calibrate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman calibrate axes --video sim:arena1 --link sim: --turn-the-camera"
)]
pub struct CalibrateArgs {
    /// What is calibrated.
    #[command(subcommand)]
    pub what: CalibrateCommand,
}

/// What is calibrated.
#[derive(Debug, Subcommand)]
pub enum CalibrateCommand {
    /// Measure sign, gain, dead times and lag of each camera axis, and the convention of the reported tilt,
    /// from slow test motions.
    Axes(CalibrateAxesArgs),
}

/// `calibrate axes`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:
  barrelman calibrate axes --video sim:arena1 --link sim: --turn-the-camera
  barrelman calibrate axes barrelman.toml --turn-the-camera --output new.toml

The camera turns by itself, at most 0.1 rad/s, to 15 degrees to each side,
for a minute and a half. Point it at something with structure that does not
move. Space stops it, and so does every signal. A camera whose speeds are not
known (ONVIF) turns at one after the other before, up to 80 degrees, for eight
minutes.",
    mut_arg("config", |arg| arg.help("Configuration file (TOML); it is not changed")),
    mut_arg("link", |arg| arg.help("The link of the vehicle whose camera is measured"))
)]
pub struct CalibrateAxesArgs {
    /// Configuration, video and link.
    #[command(flatten)]
    pub connection: ConnectionOptions,
    /// The vehicle's profile; default: the configuration's, or fotokite-pro.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Consent: the camera turns by itself. A question on the terminal follows.
    #[arg(long)]
    pub turn_the_camera: bool,
    /// Answer the question with yes.
    #[arg(long, requires = "turn_the_camera")]
    pub yes: bool,
    /// Write the complete configuration with the measured values to this file.
    #[arg(long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Record to this file.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}
