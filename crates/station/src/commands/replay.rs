//! `barrelman replay`: a recording through the pilot again.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Write as _, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, bail};
use barrelman_trial::records::{
    Entry, FrameFingerprint, ReadError, RecordedOutcome, RecordingReader, RecordingStart,
};
use barrelman_trial::replay::{Replay, ReplayComparison};
use barrelman_vocab::VideoFrame;

use super::run::pilot_for;
use crate::cli::ReplayArgs;
use crate::config::{self, Configuration};
use crate::input;
use crate::video::decoder::{DecodeMode, UnitDecoder};

/// Runs the command.
///
/// # Errors
/// If the recording or the configuration cannot be used.
pub fn run(args: &ReplayArgs) -> Result<ExitCode> {
    let changed = args.config.as_deref().map(config::read).transpose()?;
    let changed = changed.as_ref().map(Configuration::resolve).transpose()?;
    let recording = input::open(&args.recording)?;
    let replayed = replay(recording, changed)
        .with_context(|| format!("{} cannot be replayed", args.recording.display()))?;
    let mut out = stdout().lock();
    writeln!(
        out,
        "{} steps, {} video frames, {} outcomes{}",
        replayed.steps,
        replayed.frames,
        replayed.comparison.outcomes,
        if replayed.cut { "; the recording is cut off, everything before the cut was replayed" } else { "" }
    )?;
    if !args.compare {
        return Ok(ExitCode::SUCCESS);
    }
    let comparison = &replayed.comparison;
    if comparison.outcomes == 0 {
        bail!("the recording holds no outcome to compare with");
    }
    if comparison.commands_differ == 0 {
        writeln!(out, "every command is the same, bit for bit")?;
    } else {
        writeln!(out, "{} of {} commands differ", comparison.commands_differ, comparison.outcomes)?;
    }
    if comparison.outcomes_differ > 0 {
        writeln!(out, "{} outcomes differ in something", comparison.outcomes_differ)?;
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
    cut: bool,
}

fn replay(recording: File, changed: Option<Configuration>) -> Result<Replayed> {
    let mut entries = RecordingReader::new(BufReader::new(recording));
    let start = match entries.next().transpose()? {
        Some(Entry::Start(start)) => start,
        _ => bail!("it does not begin with what ran and how: this is no recording of this program"),
    };
    let configuration = match changed {
        Some(configuration) => configuration,
        None => Configuration::resolve(&config::parse_recorded(&start.configuration)?)
            .context("the recorded configuration")?,
    };
    let mut film = StoredVideo::new(&start);
    let mut replay = Replay::new(pilot_for(&configuration)?, configuration.profile.clone());
    let mut replayed = Replayed { steps: 0, frames: 0, comparison: ReplayComparison::default(), cut: false };
    // Outcomes are held against those of the same step; a queue bounds how many wait.
    let mut waiting: BTreeMap<u64, RecordedOutcome> = BTreeMap::new();
    for entry in entries {
        match entry {
            Ok(Entry::Unit(unit)) => film.take(&unit),
            Ok(Entry::Input { step, now, input }) => {
                let (mut frame, frames) = (None, &mut replayed.frames);
                let input = input.to_input(|fingerprint| {
                    *frames += 1;
                    film.frame(fingerprint).map(|found| &*frame.insert(found))
                })?;
                let outcome = replay.step(step, now, input);
                replayed.steps += 1;
                waiting.insert(step, outcome);
            }
            Ok(Entry::Outcome(recorded)) => {
                if let Some(outcome) = waiting.remove(&recorded.step) {
                    replayed.comparison.add(&recorded, &outcome);
                }
            }
            Ok(Entry::Truth(_)) => {}
            Ok(Entry::Start(_)) => bail!("it begins twice"),
            Err(ReadError::Truncated) => replayed.cut = true,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(replayed)
}

/// The video of a recording, decoded again.
struct StoredVideo {
    decoder: UnitDecoder,
    decoded: VecDeque<VideoFrame>,
    ended: bool,
}

impl StoredVideo {
    fn new(start: &RecordingStart) -> Self {
        let mode = if start.live_video { DecodeMode::Live } else { DecodeMode::File };
        Self { decoder: UnitDecoder::new(mode), decoded: VecDeque::new(), ended: false }
    }

    fn take(&mut self, unit: &barrelman_vocab::EncodedUnit) {
        // What was damaged then is damaged now: the frames that came of it are the same.
        let _ = self.decoder.decode(unit, &mut |frame| self.decoded.push_back(frame));
    }

    /// The frame of a stamp, with the time of capture that it had then.
    fn frame(&mut self, stamp: &FrameFingerprint) -> Result<VideoFrame> {
        while self.decoded.front().is_some_and(|frame| frame.sequence < stamp.sequence) {
            self.decoded.pop_front();
        }
        if self.decoded.is_empty() && !std::mem::replace(&mut self.ended, true) {
            // The last pictures of a file come out when nothing more goes in.
            self.decoder.finish(&mut |frame| self.decoded.push_back(frame));
            return self.frame(stamp);
        }
        let mut frame = self
            .decoded
            .pop_front()
            .filter(|frame| frame.sequence == stamp.sequence)
            .ok_or_else(|| anyhow!("video frame {} is not in the recording", stamp.sequence))?;
        if FrameFingerprint::from_frame(&frame).luma_hash != stamp.luma_hash {
            bail!("video frame {} decodes to another picture than it did then", stamp.sequence);
        }
        frame.capture = stamp.capture;
        Ok(frame)
    }
}
