//! A campaign's file: reading, resuming, merging.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use barrelman_trial::campaign::{CampaignEntry, CampaignSettings};
use barrelman_trial::metrics::TrialEntry;

use barrelman_host::input;
use barrelman_host::output::{self, OutputFile};

/// A campaign's file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignFile {
    /// The trials, each with its line in the file.
    pub entries: Vec<(CampaignEntry, String)>,
    /// Size of the complete lines, bytes.
    pub whole_bytes: u64,
    /// Whether the last line is incomplete: the program was ended while it wrote.
    pub is_truncated: bool,
}

impl CampaignFile {
    /// The trials.
    pub fn trials(self) -> impl Iterator<Item = TrialEntry> {
        self.entries.into_iter().map(|(entry, _)| entry.trial)
    }

    /// Logs an error if the last line is incomplete. Returns whether it is.
    pub fn report_truncation(&self, path: &Path) -> bool {
        if self.is_truncated {
            let line = self.entries.len() + 1;
            tracing::error!(
                "{}: line {line} has no end, so the file was cut there: the trials before it were used",
                path.display()
            );
        }
        self.is_truncated
    }
}

/// Whether a file that starts with these bytes is a campaign's file.
pub fn is_campaign_file(bytes: &[u8]) -> bool {
    bytes.first() == Some(&b'{')
}

/// Reads a campaign's file.
///
/// # Errors
/// The file cannot be read, or a line is not a trial; the message names the line.
pub fn read(path: &Path) -> Result<CampaignFile> {
    let bytes = input::read(path)?;
    parse(&bytes).with_context(|| format!("{} is no campaign's file", path.display()))
}

/// Reads a campaign's file from its bytes.
///
/// # Errors
/// A line is not a trial; the message names the line.
pub fn parse(bytes: &[u8]) -> Result<CampaignFile> {
    ensure!(
        bytes.is_empty() || is_campaign_file(bytes),
        "it does not begin with a JSON object, as what `barrelman trials --output FILE.jsonl` writes does"
    );
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let text = std::str::from_utf8(&bytes[..whole]).context("it is not text")?;
    let mut entries = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let entry: CampaignEntry =
            serde_json::from_str(line).with_context(|| format!("line {}", index + 1))?;
        entries.push((entry, line.to_owned()));
    }
    Ok(CampaignFile { entries, whole_bytes: whole as u64, is_truncated: whole < bytes.len() })
}

/// Writes a campaign's file, trial by trial.
#[derive(Debug)]
pub struct CampaignWriter {
    file: OutputFile,
}

impl CampaignWriter {
    /// Creates a file. An existing file is overwritten only with `force`.
    ///
    /// # Errors
    /// The file exists, or cannot be written.
    pub fn create(path: &Path, force: bool) -> Result<Self> {
        Ok(Self { file: output::create(path, force)? })
    }

    /// Opens a file to append the trials of these settings and seeds, and returns the trials that it holds. A
    /// missing file is created.
    ///
    /// # Errors
    /// The file is not a campaign's file, belongs to another campaign, or is a symbolic link.
    pub fn resume(
        path: &Path,
        settings: &CampaignSettings,
        seeds: &[u64],
    ) -> Result<(Self, Vec<CampaignEntry>)> {
        // The file is read through the handle that appends to it, so that both are the same file.
        let (mut file, bytes) = OutputFile::resume(path)?;
        let read = parse(&bytes).with_context(|| format!("{} is no campaign's file", path.display()))?;
        for (index, (entry, _)) in read.entries.iter().enumerate() {
            if entry.campaign.program != settings.program {
                bail!(
                    "{} is of another campaign: its line {} was run with barrelman {}, this program is {}; run all its \
                     trials again into another --output",
                    path.display(),
                    index + 1,
                    entry.campaign.program,
                    settings.program,
                );
            }
            if entry.campaign != *settings {
                bail!(
                    "{} is of another campaign: its line {} has the settings {}, asked for are {}; give the same \
                     options as then, or another --output",
                    path.display(),
                    index + 1,
                    as_json(&entry.campaign),
                    as_json(settings),
                );
            }
            if seeds.get(index) != Some(&entry.seed) {
                bail!(
                    "{}: line {} has the seed {} where these options come to {}; give the same --seed, --trials and \
                     --shard as then (--trials may be larger), or another --output",
                    path.display(),
                    index + 1,
                    entry.seed,
                    seeds.get(index).map_or_else(|| "the end".to_owned(), u64::to_string),
                );
            }
        }
        // An incomplete line is removed: its trial is run again.
        file.truncate_at(read.whole_bytes)?;
        let entries = read.entries.into_iter().map(|(entry, _)| entry).collect();
        Ok((Self { file }, entries))
    }

    /// Adds a trial.
    ///
    /// # Errors
    /// The file cannot be written; the trials before this one stay in it.
    pub fn add(&mut self, entry: &CampaignEntry) -> Result<()> {
        let line = serde_json::to_string(entry)? + "\n";
        self.add_line(&line)
    }

    fn add_line(&mut self, line: &str) -> Result<()> {
        // One write for each line: a program that ends in between leaves an incomplete line, which is
        // recognised.
        self.file.write_all(line.as_bytes()).with_context(|| {
            format!("{} cannot be written: the trials before this one are in it", self.file.path().display())
        })
    }
}

/// Merges the files of one campaign's shards in the order of their seeds.
///
/// # Errors
/// The files are of different campaigns, two files hold different results for one seed, or a file is
/// incomplete.
pub fn merge(files: &[(PathBuf, CampaignFile)]) -> Result<Vec<(CampaignEntry, String)>> {
    let mut by_seed: BTreeMap<u64, (&PathBuf, &CampaignEntry, &String)> = BTreeMap::new();
    let mut first: Option<(&PathBuf, &CampaignSettings)> = None;
    for (path, file) in files {
        if file.is_truncated {
            bail!(
                "{} ends within a line: its shard was not finished; go on with it by --resume first",
                path.display()
            );
        }
        for (entry, line) in &file.entries {
            let (first_path, settings) = *first.get_or_insert((path, &entry.campaign));
            if entry.campaign.program != settings.program {
                bail!(
                    "{} and {} are of different campaigns: the first was run with barrelman {}, the second with {}; run \
                     the trials of both with one program",
                    first_path.display(),
                    path.display(),
                    settings.program,
                    entry.campaign.program,
                );
            }
            if entry.campaign != *settings {
                bail!(
                    "{} and {} are of different campaigns: {} and {}",
                    first_path.display(),
                    path.display(),
                    as_json(settings),
                    as_json(&entry.campaign)
                );
            }
            if let Some((other, known, _)) = by_seed.insert(entry.seed, (path, entry, line))
                && known.trial != entry.trial
            {
                bail!(
                    "{} and {} have different results for seed {}: the same seed gives the same trial, so one of \
                     them is not what it says",
                    other.display(),
                    path.display(),
                    entry.seed
                );
            }
        }
    }
    Ok(by_seed.into_values().map(|(_, entry, line)| (entry.clone(), line.clone())).collect())
}

/// The settings as in the file.
fn as_json(settings: &CampaignSettings) -> String {
    serde_json::to_string(settings).unwrap_or_else(|_| format!("{settings:?}"))
}
