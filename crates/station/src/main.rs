//! The program `barrelman`: parses the command line, runs a command, and converts errors to exit codes.

use std::process::ExitCode;

use barrelman_host::clock::Clock;
use barrelman_station::cli::{Cli, Command, UsageError};
use barrelman_station::config::UnusableConfiguration;
use barrelman_station::live::supervision::is_a_service;
use barrelman_station::{commands, logging};
use clap::Parser as _;

/// The exit status of sysexits.h for a configuration that cannot be used.
const EX_CONFIG: u8 = 78;

fn main() -> ExitCode {
    // The clock comes first: all timestamps of the run count from here.
    let clock = Clock::start();
    let cli = Cli::parse();
    // Dropped last, so that all log lines are written before the program ends.
    let _logging = logging::start(cli.log_level, cli.log_format);
    let result = match cli.command.unwrap_or_else(|| Command::Demo(Default::default())) {
        Command::Demo(args) => commands::demo::run(&args, clock),
        Command::Run(args) => commands::run::run(&args, clock),
        Command::Track(args) => commands::track::run(&args),
        Command::Snapshot(args) => commands::snapshot::run(&args),
        Command::Law(args) => commands::law::run(&args),
        Command::Metrics(args) => commands::metrics::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Trials(args) => commands::trials::run(&args),
        Command::Merge(args) => commands::merge::run(&args),
        Command::Compare(args) => commands::compare::run(&args),
        Command::Scenarios(args) => commands::scenarios::run(&args),
        Command::Render(args) => commands::render::run(&args),
        Command::Library(args) => commands::library::run(&args),
        Command::Replay(args) => commands::replay::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Emulate(args) => commands::emulate::run(&args, clock),
        Command::Calibrate(args) => commands::calibrate::run(&args, clock),
        Command::Doctor(args) => commands::doctor::run(&args),
        Command::Check(args) => commands::check::run(&args, clock),
        Command::Links(args) => commands::links::run(&args),
        Command::Config(args) => commands::config::run(&args),
    };
    result.unwrap_or_else(|error| {
        if !is_broken_pipe(&error) {
            tracing::error!("{error:#}");
        }
        if error.is::<UsageError>() {
            ExitCode::from(2)
        } else if error.is::<UnusableConfiguration>() && is_a_service() {
            // A service with this configuration is not started again: see config/systemd/barrelman.service.
            ExitCode::from(EX_CONFIG)
        } else {
            ExitCode::FAILURE
        }
    })
}

/// Whether the error is that the reader of the output has closed it, as `head` does.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}
