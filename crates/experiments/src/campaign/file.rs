//! A campaign's file: read, gone on with, merged.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use barrelman_trial::behaviour::VersionDifference;
use barrelman_trial::campaign::{CampaignEntry, CampaignSettings};
use barrelman_trial::metrics::TrialEntry;

use barrelman_host::input;
use barrelman_host::output::{self, OutputFile};

/// A campaign's file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignFile {
    /// Its trials, and each as it stands in the file.
    pub entries: Vec<(CampaignEntry, String)>,
    /// Bytes of whole lines.
    pub whole_bytes: u64,
    /// Whether its last line has no end: the program was ended while it wrote.
    pub cut: bool,
}

impl CampaignFile {
    /// Its trials.
    pub fn trials(self) -> impl Iterator<Item = TrialEntry> {
        self.entries.into_iter().map(|(entry, _)| entry.trial)
    }

    /// Says where its last line is cut, and whether it is.
    pub fn report_cut(&self, path: &Path) -> bool {
        if self.cut {
            let line = self.entries.len() + 1;
            tracing::error!(
                "{}: line {line} has no end, so the file was cut there: the trials before it were used",
                path.display()
            );
        }
        self.cut
    }
}

/// Whether a file's beginning is that of a campaign's.
pub fn is_campaign_file(bytes: &[u8]) -> bool {
    bytes.first() == Some(&b'{')
}

/// Reads a campaign's file.
///
/// # Errors
/// If it cannot be read, or a line of it is no trial; the message names the line.
pub fn read(path: &Path) -> Result<CampaignFile> {
    let bytes = input::read(path)?;
    parse(&bytes).with_context(|| format!("{} is no campaign's file", path.display()))
}

/// Reads a campaign's file from its bytes.
///
/// # Errors
/// If a line of it is no trial; the message names the line.
pub fn parse(bytes: &[u8]) -> Result<CampaignFile> {
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let text = std::str::from_utf8(&bytes[..whole]).context("it is not text")?;
    let mut entries = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let entry: CampaignEntry =
            serde_json::from_str(line).with_context(|| format!("line {}", index + 1))?;
        let entry = CampaignEntry { campaign: entry.campaign.completed(), ..entry };
        entries.push((entry, line.to_owned()));
    }
    Ok(CampaignFile { entries, whole_bytes: whole as u64, cut: whole < bytes.len() })
}

/// A campaign's file that is being written, trial by trial.
#[derive(Debug)]
pub struct CampaignWriter {
    file: OutputFile,
}

impl CampaignWriter {
    /// Begins a file. One that exists is overwritten with `force` only.
    ///
    /// # Errors
    /// If it exists or cannot be written.
    pub fn create(path: &Path, force: bool) -> Result<Self> {
        Ok(Self { file: output::create(path, force)? })
    }

    /// Goes on with a file that was begun, for these settings and seeds, and says which trials it has already. A
    /// file that is not there is begun.
    ///
    /// # Errors
    /// If it is no campaign's file, another campaign's, or a symbolic link.
    pub fn resume(
        path: &Path,
        settings: &CampaignSettings,
        seeds: &[u64],
    ) -> Result<(Self, Vec<CampaignEntry>)> {
        // The file is read through the handle that goes on with it: it is the same file.
        let (mut file, bytes) = OutputFile::resume(path)?;
        let read = parse(&bytes).with_context(|| format!("{} is no campaign's file", path.display()))?;
        for (index, (entry, _)) in read.entries.iter().enumerate() {
            if let Some(VersionDifference { first, second }) = entry.campaign.version_difference(settings) {
                bail!(
                    "{} is of another campaign: its line {} was run with {first}, this program has {second}; run all its \
                     trials again into another --output",
                    path.display(),
                    index + 1,
                );
            }
            if entry.campaign != *settings {
                bail!(
                    "{} is of another campaign: its line {} has the settings {}, asked for are {}; give the same \
                     options as then, or another --output",
                    path.display(),
                    index + 1,
                    in_words(&entry.campaign),
                    in_words(settings),
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
        // A line without its end was being written when the program ended: that trial is run again.
        file.cut_after(read.whole_bytes)?;
        let entries = read.entries.into_iter().map(|(entry, _)| entry).collect();
        Ok((Self { file }, entries))
    }

    /// Adds a trial.
    ///
    /// # Errors
    /// If it cannot be written; the trials before it stay.
    pub fn add(&mut self, entry: &CampaignEntry) -> Result<()> {
        let line = serde_json::to_string(entry)? + "\n";
        self.add_line(&line)
    }

    fn add_line(&mut self, line: &str) -> Result<()> {
        // One write for each line: what ends the program in between leaves a cut line, which is known as such.
        self.file.write_all(line.as_bytes()).with_context(|| {
            format!("{} cannot be written: the trials before this one are in it", self.file.path().display())
        })
    }
}

/// Merges the files of one campaign's shards in the order of their seeds.
///
/// # Errors
/// If they are not of one campaign, a trial is in two of them with different results, or one is cut.
pub fn merge(files: &[(PathBuf, CampaignFile)]) -> Result<Vec<(CampaignEntry, String)>> {
    let mut by_seed: BTreeMap<u64, (&PathBuf, &CampaignEntry, &String)> = BTreeMap::new();
    let mut first: Option<(&PathBuf, &CampaignSettings)> = None;
    for (path, file) in files {
        if file.cut {
            bail!(
                "{} ends within a line: its shard was not finished; go on with it by --resume first",
                path.display()
            );
        }
        for (entry, line) in &file.entries {
            let (first_path, settings) = *first.get_or_insert((path, &entry.campaign));
            if let Some(VersionDifference { first, second }) = settings.version_difference(&entry.campaign) {
                bail!(
                    "{} and {} are of different campaigns: the first was run with {first}, the second with {second}; run \
                     the trials of both with one program",
                    first_path.display(),
                    path.display(),
                );
            }
            if entry.campaign != *settings {
                bail!(
                    "{} and {} are of different campaigns: {} and {}",
                    first_path.display(),
                    path.display(),
                    in_words(settings),
                    in_words(&entry.campaign)
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

/// Settings as they stand in the file.
fn in_words(settings: &CampaignSettings) -> String {
    serde_json::to_string(settings).unwrap_or_else(|_| format!("{settings:?}"))
}
