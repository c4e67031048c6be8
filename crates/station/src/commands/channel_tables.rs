//! Writes one CSV file for each channel of a recording, with a bounded number of open files.
//!
//! A recording may have thousands of channels, more than a process may have open files. The [`MAX_OPEN`]
//! files written to last stay open; other files are closed, and reopened for appending.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use barrelman_trial::records::table::TableRow;

use barrelman_host::output::{self, ClosedOutput, OutputFile};

/// Files open at the same time. The usual limit of a process is 1024.
const MAX_OPEN: usize = 64;
/// Largest number of JSON columns that a warning names; further columns are counted.
const NAMED_COLUMNS: usize = 5;

/// The tables of a recording that is being exported.
pub(super) struct ChannelTables<'a> {
    folder: &'a Path,
    force: bool,
    /// The files by topic; `None` while the file is open.
    files: BTreeMap<String, Option<ClosedOutput>>,
    /// The open files, least recently written first.
    open: Vec<(String, BufWriter<OutputFile>)>,
    /// Names in use, without extension, each with the number that the next file of that name gets.
    used_names: BTreeMap<String, u32>,
}

impl<'a> ChannelTables<'a> {
    /// Tables in a folder. `used_names`: names of the export's other CSV files, without extension.
    pub(super) fn new(folder: &'a Path, force: bool, used_names: &[&str]) -> Self {
        Self {
            folder,
            force,
            files: BTreeMap::new(),
            open: Vec::new(),
            used_names: used_names.iter().map(|name| ((*name).to_owned(), 2)).collect(),
        }
    }

    /// Adds a row to the table of its topic.
    pub(super) fn add(&mut self, row: &TableRow) -> Result<()> {
        let mut file = match self.open.iter().position(|(topic, _)| *topic == row.topic) {
            Some(index) => self.open.remove(index).1,
            None => {
                self.close_oldest()?;
                match self.files.get_mut(&row.topic).and_then(Option::take) {
                    Some(closed) => BufWriter::new(closed.reopen()?),
                    None => self.begin(row)?,
                }
            }
        };
        let written = writeln!(file, "{}", row.cells.join(","))
            .with_context(|| format!("{} cannot be written", file.get_ref().path().display()));
        self.open.push((row.topic.clone(), file));
        written
    }

    /// Writes the buffers and closes all files.
    pub(super) fn finish(mut self) -> Result<()> {
        while let Some((_, file)) = self.open.pop() {
            close(file)?;
        }
        Ok(())
    }

    fn begin(&mut self, row: &TableRow) -> Result<BufWriter<OutputFile>> {
        if !row.json_columns.is_empty() {
            let named = &row.json_columns[..row.json_columns.len().min(NAMED_COLUMNS)];
            let others = row.json_columns.len() - named.len();
            tracing::warn!(
                "{}: messages that nest too deeply, too widely or recursively are written as JSON, in the column {}{}",
                row.topic,
                named.join(", "),
                if others > 0 { format!(" and {others} others") } else { String::new() }
            );
        }
        let path = self.path_of(&row.topic);
        let mut file = BufWriter::new(output::create(&path, self.force)?);
        writeln!(file, "{}", row.columns.join(","))
            .with_context(|| format!("{} cannot be written", path.display()))?;
        self.files.insert(row.topic.clone(), None);
        Ok(file)
    }

    /// A path that no other file of this export has. Topics such as /a/b and /a_b give the same name, so the
    /// second one is numbered.
    fn path_of(&mut self, topic: &str) -> PathBuf {
        let mut name = topic.trim_matches('/').replace('/', "_");
        while let Some(number) = self.used_names.get_mut(&name) {
            let numbered = format!("{name}_{number}");
            *number += 1;
            if !self.used_names.contains_key(&numbered) {
                name = numbered;
            }
        }
        self.used_names.insert(name.clone(), 2);
        self.folder.join(format!("{name}.csv"))
    }

    /// Closes the least recently written file if [`MAX_OPEN`] files are open.
    fn close_oldest(&mut self) -> Result<()> {
        if self.open.len() < MAX_OPEN {
            return Ok(());
        }
        let (topic, file) = self.open.remove(0);
        let closed = close(file)?;
        self.files.insert(topic, Some(closed));
        Ok(())
    }
}

/// Writes the buffer and closes the file.
fn close(file: BufWriter<OutputFile>) -> Result<ClosedOutput> {
    let path = file.get_ref().path().to_owned();
    let file = file
        .into_inner()
        .map_err(|error| anyhow!(error.into_error()))
        .with_context(|| format!("{} cannot be written", path.display()))?;
    file.close()
}
