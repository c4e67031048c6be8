//! `barrelman replay`: runs a recording through the pilot again.
//!
//! The recording is read once and not held in memory. Queued at a time are at most [`MAX_QUEUED_BYTES`] of
//! encoded video, a few decoded frames (see [`StoredVideo`]), and [`MAX_QUEUED_OUTCOMES`] outcomes.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write as _, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use barrelman_trial::records::{Entry, ReadError, RecordedOutcome, RecordingReader};
use barrelman_trial::replay::{Replay, ReplayComparison};

use super::replayed_video::ReplayedVideo;
use super::run::build_pilot;
use crate::cli::ReplayArgs;
use crate::config::changed_keys::{ChangedKey, parse_changed};
use crate::config::{self, Configuration};
use barrelman_host::input;
use barrelman_host::program::identity;

/// Limit of the encoded video that waits for its step. In this program's recordings about ten units wait,
/// because the pilot takes the newest frame. A gigabyte is three seconds of raw video at 3840 x 2160 and 30
/// frames per second.
pub const MAX_QUEUED_BYTES: usize = 1 << 30;
/// Limit of the outcomes that wait for the recorded outcome of the same step. In this program's recordings
/// that outcome comes next. Beyond the limit the oldest outcome is dropped.
pub const MAX_QUEUED_OUTCOMES: usize = 2048;

/// Runs the command.
///
/// # Errors
/// If the recording or the configuration cannot be used.
pub fn run(args: &ReplayArgs) -> Result<ExitCode> {
    let changed = args.config.as_deref().map(config::read).transpose()?;
    let changed = changed.as_ref().map(Configuration::resolve).transpose()?;
    let recording = input::open(&args.recording)?;
    let replayed = replay(recording, changed, &args.changed)
        .with_context(|| format!("{} cannot be replayed", args.recording.display()))?;
    let mut out = stdout().lock();
    writeln!(
        out,
        "{} steps, {} video frames{}, {} outcomes{}",
        replayed.steps,
        replayed.frames,
        if replayed.is_rendered { " (rendered again from scenario and seed)" } else { "" },
        replayed.comparison.outcomes,
        if replayed.is_truncated {
            "; the recording is cut off, everything before the cut was replayed"
        } else {
            ""
        }
    )?;
    let program = identity();
    if replayed.recorded_by != program {
        writeln!(
            out,
            "recorded by barrelman {}, this program is {program}: outcomes may differ",
            replayed.recorded_by
        )?;
    }
    if !args.compare {
        return Ok(ExitCode::SUCCESS);
    }
    let comparison = &replayed.comparison;
    if comparison.outcomes == 0 {
        bail!("the recording has no outcome to compare with");
    }
    if comparison.commands_differ == 0 {
        writeln!(out, "every command is the same, bit for bit")?;
    } else {
        writeln!(out, "{} of {} commands differ", comparison.commands_differ, comparison.outcomes)?;
    }
    if comparison.outcomes_differ > 0 {
        writeln!(out, "{} outcomes differ", comparison.outcomes_differ)?;
    }
    if let Some(first) = &comparison.first_difference {
        writeln!(
            out,
            "first difference, step {}:\n  recorded {:?}\n  replayed {:?}",
            first.0.step, first.0, first.1
        )?;
    }
    Ok(if comparison.commands_differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

struct Replayed {
    steps: u64,
    frames: u64,
    comparison: ReplayComparison,
    is_truncated: bool,
    /// Whether the frames were rendered again: a recording of a trial in pixels holds none.
    is_rendered: bool,
    /// The program that made the recording: version and hash of the executable.
    recorded_by: String,
}

fn replay(recording: File, changed: Option<Configuration>, keys: &[ChangedKey]) -> Result<Replayed> {
    let mut entries = RecordingReader::new(BufReader::new(recording));
    let start = match entries.next().transpose()? {
        Some(Entry::Start(start)) => start,
        _ => bail!("it does not begin with a start message: it is not a recording of this program"),
    };
    let configuration = match changed {
        Some(configuration) => configuration,
        None => parse_changed(&start.configuration, keys)
            .and_then(|file| Configuration::resolve_recorded(&file))
            .context("the recorded configuration")?,
    };
    let mut video = ReplayedVideo::new(&start, MAX_QUEUED_BYTES);
    let pilot = build_pilot(&configuration, start.command_path)?;
    let mut replay = Replay::new(pilot, configuration.profile.clone());
    let mut replayed = Replayed {
        steps: 0,
        frames: 0,
        comparison: ReplayComparison::default(),
        is_truncated: false,
        is_rendered: false,
        recorded_by: start.program,
    };
    // Outcomes by step, until the recorded outcome of the same step is read.
    let mut outcomes: BTreeMap<u64, RecordedOutcome> = BTreeMap::new();
    for entry in entries {
        match entry {
            Ok(Entry::Unit(number, unit)) => video.add(number, unit)?,
            Ok(Entry::Input { step, now, input }) => {
                let (mut frame, frames) = (None, &mut replayed.frames);
                let input = input.to_input(|fingerprint| {
                    *frames += 1;
                    video.frame(fingerprint).map(|found| &*frame.insert(found))
                })?;
                let outcome = replay.step(step, now, input);
                replayed.steps += 1;
                outcomes.insert(step, outcome);
                if outcomes.len() > MAX_QUEUED_OUTCOMES {
                    outcomes.pop_first();
                }
            }
            Ok(Entry::Outcome(recorded)) => {
                video.command(&recorded);
                if let Some(outcome) = outcomes.remove(&recorded.step) {
                    replayed.comparison.add(&recorded, &outcome);
                }
            }
            // Neither is an input of the pilot.
            Ok(Entry::Truth(_) | Entry::Note { .. }) => {}
            Ok(Entry::Start(_)) => bail!("it has two start messages"),
            Err(ReadError::Truncated) => replayed.is_truncated = true,
            Err(error) => return Err(error.into()),
        }
    }
    replayed.is_rendered = video.is_rendered();
    Ok(replayed)
}
