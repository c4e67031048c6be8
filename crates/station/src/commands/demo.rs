//! `barrelman demo`: a simulated boat that a person steers in the browser, and the camera that follows it.
//!
//! World and pilot run in lock step, tick by tick, as in a trial; the clock only decides when the next tick
//! runs. So a stored drive replays bit for bit.

use std::io::{Write as _, stdout};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, Result};
use barrelman_console_server::{ConsoleAddress, ConsoleSettings, KeptTokens};
use barrelman_vocab::{NewDrill, NewDrive};

use super::practice;
use crate::cli::DemoArgs;
use crate::demo::drive_files::{DriveFiles, OpenFiles};
use crate::demo::drive_plan::{DrivePlan, Purpose};
use crate::demo::live_drive::DriveEnd;
use crate::demo::replay;
use crate::demo::session::{DriveSession, SessionEnd};
use crate::share::{ShareAddress, ShareSetup};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_host::program::identity;

/// Runs the command.
///
/// # Errors
/// If the scenario cannot be used, the page cannot be served, or an output cannot be written.
pub fn run(args: &DemoArgs, clock: Clock) -> Result<ExitCode> {
    if args.clip || args.draw_only {
        return practice::run(args, clock);
    }
    let files = DriveFiles { record: args.record.clone(), store: args.store.clone(), force: args.force };
    let first_files = files.open(1)?;
    match &args.replay {
        Some(path) => replay_drive(first_files.record, path),
        None => drive(args, files, first_files, clock),
    }
}

/// Runs drives in the browser until the session is ended.
fn drive(args: &DemoArgs, files: DriveFiles, first_files: OpenFiles, clock: Clock) -> Result<ExitCode> {
    let usual = if args.hands_on { "first-drive" } else { "open" };
    let scenario = args.scenario.clone().unwrap_or_else(|| usual.to_owned());
    let first = match args.drill {
        Some(drill) => Purpose::Drill(NewDrill { drill, seed: args.seed }),
        None => Purpose::Drive(NewDrive { scenario, seed: args.seed }),
    };
    let plan = DrivePlan {
        first,
        size: args.size,
        tracker: args.tracker,
        law: args.law.resolve(LawChoice::OPTIMAL)?,
        encoded: args.record.is_some(),
        hands_on: args.hands_on,
    };
    let options = &args.console;
    let address = options.address(ConsoleAddress::default());
    let tokens = options.kept_tokens(KeptTokens::default());
    let mut console = ConsoleSettings::without_tokens_on_loopback(address, tokens)?;
    console.map = options.open_map(None)?;
    console.on_lost = options.on_console_lost.unwrap_or_default();
    let share = args.share.as_deref().map(|address| share(address, &console)).transpose()?;
    let max_duration = args.seconds.map(Duration::from_secs_f64);
    let session =
        DriveSession { plan, files: files.clone(), first_files, console, share, max_duration, clock };
    let SessionEnd { end, drives } = session.run()?;
    print_outputs(&files, drives)?;
    Ok(match end {
        DriveEnd::Quit(cause) => {
            tracing::info!("stopped: {cause}");
            ExitCode::SUCCESS
        }
        DriveEnd::TimeIsUp => ExitCode::SUCCESS,
        DriveEnd::Failed(why) => {
            tracing::error!("{why}");
            ExitCode::FAILURE
        }
    })
}

/// The socket of the annotated video. Readers know the console's watch token, where the console has tokens.
fn share(address: &str, console: &ConsoleSettings) -> Result<ShareSetup> {
    let open = |address| ShareSetup::open(address, console.tokens.clone());
    ShareAddress::parse(address).and_then(open).context("--share")
}

/// Prints what was written, and the commands that use it.
fn print_outputs(files: &DriveFiles, drives: u32) -> Result<()> {
    let mut out = stdout();
    for path in files.recordings(drives) {
        writeln!(
            out,
            "{}: the recording; try\n  barrelman replay {} --compare",
            path.display(),
            path.display()
        )?;
    }
    for path in files.stored(drives) {
        let path = path.display();
        writeln!(
            out,
            "{path}: the drive; try\n  barrelman demo --replay {path}\n  barrelman trials --drive {path} --record recordings"
        )?;
    }
    Ok(())
}

/// Replays a stored drive. Fails unless it is the same, bit for bit.
fn replay_drive(record: Option<OutputFile>, path: &Path) -> Result<ExitCode> {
    let replayed = replay::replay(record, path)?;
    let mut out = stdout();
    let hash = &replayed.hash;
    writeln!(out, "{} ticks of {}, seed {}: {hash}", replayed.last_tick, replayed.scenario, replayed.seed)?;
    match replayed.stored_hash {
        None => {
            writeln!(out, "the file is cut off: everything before the cut was replayed")?;
            Ok(ExitCode::SUCCESS)
        }
        Some(stored) if stored == *hash => {
            writeln!(out, "the drive is the same, bit for bit")?;
            Ok(ExitCode::SUCCESS)
        }
        Some(stored) => {
            let (stored_by, program) = (replayed.program, identity());
            if stored_by == program {
                tracing::error!("the drive differs: the stored hash is {stored}");
            } else {
                tracing::error!(
                    "the drive differs: the stored hash is {stored}; barrelman {stored_by} stored the drive, this \
                     program is {program}, so a difference may be expected"
                );
            }
            Ok(ExitCode::FAILURE)
        }
    }
}
