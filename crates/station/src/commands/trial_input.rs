//! Reads trial logs of all kinds, and campaign files.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use barrelman_trial::logs::recorded::LogBuilder;
use barrelman_trial::logs::{self, TrialLog};
use barrelman_trial::records::{Entry, ReadError, RecordingReader, RecordingStart};

use barrelman_experiments::campaign::file::{self as campaign_file, CampaignFile};
use barrelman_host::input;

/// The first bytes of an MCAP file.
const MCAP_MAGIC: [u8; 5] = [0x89, b'M', b'C', b'A', b'P'];

/// The content of a file.
#[derive(Debug)]
pub(super) enum InputFile {
    /// One trial.
    Trial(Box<TrialInput>),
    /// The metrics of a campaign's trials.
    Campaign(CampaignFile),
}

/// The kind of a log.
#[derive(Debug)]
pub(super) enum LogKind {
    /// A CSV of the paper's laboratory.
    Laboratory,
    /// A CSV that this program exported.
    Exported,
    /// A recording, with its start message; `None` where that is missing.
    Recording(Option<Box<RecordingStart>>),
}

/// A trial and its file.
#[derive(Debug)]
pub(super) struct TrialInput {
    /// The file's name without folder and extension.
    pub(super) name: String,
    /// The trial.
    pub(super) log: TrialLog,
    /// The message for the user if the file is truncated.
    pub(super) cut: Option<String>,
    /// The kind of the log.
    pub(super) kind: LogKind,
}

/// Reads a trial log or a campaign file.
///
/// # Errors
/// If the file cannot be read or has an unknown format; the message names the file.
pub(super) fn read_any(path: &Path) -> Result<InputFile> {
    let mut first = Vec::new();
    input::open(path)?.take(1).read_to_end(&mut first)?;
    if campaign_file::is_campaign_file(&first) {
        return campaign_file::read(path).map(InputFile::Campaign);
    }
    read(path).map(|trial| InputFile::Trial(Box::new(trial)))
}

/// Reads a trial log.
///
/// # Errors
/// If the file cannot be read or has an unknown format; the message names the file.
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
    let mut builder = LogBuilder::default();
    let (mut cut, mut start) = (None, None);
    for entry in RecordingReader::new(BufReader::new(file)) {
        match entry {
            Ok(Entry::Outcome(outcome)) => builder.add_outcome(&outcome),
            Ok(Entry::Input { input, .. }) => builder.add_input(&input),
            Ok(Entry::Truth(truth)) => builder.add_truth(truth),
            Ok(Entry::Start(found)) => start = Some(Box::new(found)),
            Ok(Entry::Unit(..) | Entry::Note { .. }) => {}
            Err(ReadError::Truncated) => {
                cut = Some(format!("{name}: the recording is cut off: everything before the cut was used"));
            }
            Err(error) => return Err(error.into()),
        }
    }
    match builder.finish() {
        Some(log) => Ok(TrialInput { name, log, cut, kind: LogKind::Recording(start) }),
        None => bail!("the recording has no localisation"),
    }
}
