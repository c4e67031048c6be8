//! Reads trial logs of every kind from files.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use barrelman_trial::logs::recorded::LogBuilder;
use barrelman_trial::logs::{self, TrialLog};
use barrelman_trial::records::{Entry, ReadError, RecordingReader, RecordingStart};

use barrelman_experiments::campaign::file::{self as campaign_file, CampaignFile};
use barrelman_host::input;

/// How an MCAP file begins.
const MCAP_MAGIC: [u8; 5] = [0x89, b'M', b'C', b'A', b'P'];

/// What was read from a file.
#[derive(Debug)]
pub(super) enum Input {
    /// One trial.
    Trial(Box<TrialInput>),
    /// The trials of a campaign, by their metrics.
    Campaign(CampaignFile),
}

/// What kind of log a trial was read from.
#[derive(Debug)]
pub(super) enum LogKind {
    /// The authors' laboratory's.
    Laboratory,
    /// A CSV that this program wrote.
    Exported,
    /// A recording, with what ran; `None` where that is missing.
    Recording(Option<Box<RecordingStart>>),
}

/// A trial that was read from a file.
#[derive(Debug)]
pub(super) struct TrialInput {
    /// The file's name without its folder and ending.
    pub(super) name: String,
    /// The trial.
    pub(super) log: TrialLog,
    /// Where the file was cut, if it was, in words.
    pub(super) cut: Option<String>,
    /// What it was read from.
    pub(super) kind: LogKind,
}

/// Reads a trial, or a campaign's file.
///
/// # Errors
/// If the file cannot be read or is none that is known; the message names it.
pub(super) fn read_any(path: &Path) -> Result<Input> {
    let mut first = Vec::new();
    input::open(path)?.take(1).read_to_end(&mut first)?;
    if campaign_file::is_campaign_file(&first) {
        return campaign_file::read(path).map(Input::Campaign);
    }
    read(path).map(|trial| Input::Trial(Box::new(trial)))
}

/// Reads a trial.
///
/// # Errors
/// If the file cannot be read or is none that is known; the message names it.
pub(super) fn read(path: &Path) -> Result<TrialInput> {
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let file = input::open(path)?;
    read_named(file, path, name).with_context(|| format!("{} cannot be used as a trial log", path.display()))
}

fn read_named(mut file: File, path: &Path, name: String) -> Result<TrialInput> {
    let mut magic = Vec::new();
    file.by_ref().take(MCAP_MAGIC.len() as u64).read_to_end(&mut magic)?;
    file.seek(SeekFrom::Start(0))?;
    if magic == MCAP_MAGIC {
        return read_recording(file, name);
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let text = String::from_utf8(bytes).map_err(|_| anyhow!("it is neither text nor an MCAP recording"))?;
    let read = logs::read_text(&text)?;
    let cut = read.truncated_at_line.map(|line| {
        format!(
            "{}: line {line} has no end, so the file was cut there: the rows before it were used",
            path.display()
        )
    });
    let is_laboratory = text.starts_with(logs::laboratory::HEADER);
    let kind = if is_laboratory { LogKind::Laboratory } else { LogKind::Exported };
    Ok(TrialInput { name, log: read.log, cut, kind })
}

fn read_recording(file: File, name: String) -> Result<TrialInput> {
    let mut collector = LogBuilder::default();
    let (mut cut, mut start) = (None, None);
    for entry in RecordingReader::new(BufReader::new(file)) {
        match entry {
            Ok(Entry::Outcome(outcome)) => collector.add_outcome(&outcome),
            Ok(Entry::Truth(truth)) => collector.add_truth(truth),
            Ok(Entry::Start(found)) => start = Some(Box::new(found)),
            Ok(_) => {}
            Err(ReadError::Truncated) => {
                cut = Some(format!("{name}: the recording is cut off: everything before the cut was used"));
            }
            Err(error) => return Err(error.into()),
        }
    }
    match collector.finish() {
        Some(log) => Ok(TrialInput { name, log, cut, kind: LogKind::Recording(start) }),
        None => bail!("nothing was ever localised in this recording"),
    }
}
