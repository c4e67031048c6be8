//! The program `barrelman-ros2`.

use std::process::ExitCode;

use barrelman_ros2::cli::Cli;
use barrelman_ros2::notice::say;
use barrelman_ros2::program;
use clap::Parser as _;

fn main() -> ExitCode {
    match program::run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}
