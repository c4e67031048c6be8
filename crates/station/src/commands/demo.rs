//! `barrelman demo`: a simulated boat that a person steers in the browser, and the camera that follows it.
//!
//! World and pilot run in lock step, tick by tick, as in a trial; the clock only decides when the next tick runs. So a
//! stored drive replays bit for bit.

use std::io::{Write as _, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use barrelman_console_server::ConsoleSettings;
use barrelman_vocab::PictureSize;

use super::practice;
use crate::cli::DemoArgs;
use crate::demo::live_drive::DriveEnd;
use crate::demo::replay;
use crate::demo::session::DriveSession;
use barrelman_experiments::drive::DriveSetup;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_host::program::identity;

/// Default limit of the picture's width, pixels: pictures are rendered on the CPU.
const MAX_WIDTH: u32 = 960;

/// Runs the command.
///
/// # Errors
/// If the scenario cannot be used, the page cannot be served, or an output cannot be written.
pub fn run(args: &DemoArgs, clock: Clock) -> Result<ExitCode> {
    if args.clip || args.draw_only {
        return practice::run(args, clock);
    }
    let open =
        |path: &Option<PathBuf>| path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose();
    let (record, store) = (open(&args.record)?, open(&args.store)?);
    match &args.replay {
        Some(path) => replay_drive(record, path),
        None => drive(args, record, store, clock),
    }
}

/// Runs drives in the browser until the session is ended.
fn drive(
    args: &DemoArgs,
    record: Option<OutputFile>,
    store: Option<OutputFile>,
    clock: Clock,
) -> Result<ExitCode> {
    let mut url = WorldUrl {
        scenario: args.scenario.clone().unwrap_or_else(|| "open".to_owned()),
        seed: args.seed,
        size: args.size,
    };
    url.size = Some(picture_size(&url)?);
    let setup =
        DriveSetup::new(url, args.tracker, args.law.resolve(LawChoice::OPTIMAL)?, args.record.is_some())?;
    let setup = DriveSetup { hands_on: args.hands_on, ..setup };
    let options = &args.console;
    let console =
        ConsoleSettings::without_tokens_on_loopback(options.listen, options.console_token_file.as_deref())?;
    let console = ConsoleSettings { on_lost: options.on_console_lost.unwrap_or_default(), ..console };
    let max_duration = args.seconds.map(Duration::from_secs_f64);
    let end = DriveSession { setup, console, record, store, max_duration, clock }.run()?;
    print_outputs(args)?;
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

/// The size of the pictures: the given size, else the scenario's, limited to `MAX_WIDTH`.
fn picture_size(url: &WorldUrl) -> Result<PictureSize> {
    if let Some(size) = url.size {
        return Ok(size);
    }
    let own = scenario::load(&url.scenario, &ScenarioOverrides::default())?.scenario.camera.optics.picture;
    let height = (own.height * MAX_WIDTH / own.width.max(1)) & !1;
    Ok(if own.width > MAX_WIDTH { PictureSize::new(MAX_WIDTH, height) } else { own })
}

/// Prints what was written, and the commands that use it.
fn print_outputs(args: &DemoArgs) -> Result<()> {
    let mut out = stdout();
    for path in args.record.iter() {
        writeln!(
            out,
            "{}: the recording; try\n  barrelman replay {} --compare",
            path.display(),
            path.display()
        )?;
    }
    for path in args.store.iter() {
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
