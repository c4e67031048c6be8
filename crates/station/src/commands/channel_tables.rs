//! The CSV of every channel of a recording, with a bounded number of open files.
//!
//! A recording may have thousands of channels, more than a process may have files open. The [`MAX_OPEN`] files that were
//! written to last stay open; others are closed and opened again to append to them.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use barrelman_trial::records::table::TableRow;

use barrelman_host::output::{self, ClosedOutput, OutputFile};

/// Files that are open at the same time. A process may usually have 1024.
const MAX_OPEN: usize = 64;
/// Columns of JSON that a warning names; of more it tells the number.
const NAMED_COLUMNS: usize = 5;

/// The tables of a recording that is being exported.
pub(super) struct ChannelTables<'a> {
    folder: &'a Path,
    force: bool,
    /// By topic; `None` while the file is open.
    files: BTreeMap<String, Option<ClosedOutput>>,
    /// The file written to last comes last.
    open: Vec<(String, BufWriter<OutputFile>)>,
    /// Names of files that are taken, without their extension, and the number that the next file of that name gets.
    taken: BTreeMap<String, u32>,
}

impl<'a> ChannelTables<'a> {
    /// Tables in a folder, besides other CSV files of the export with these names (without their extension).
    pub(super) fn new(folder: &'a Path, force: bool, taken: &[&str]) -> Self {
        Self {
            folder,
            force,
            files: BTreeMap::new(),
            open: Vec::new(),
            taken: taken.iter().map(|name| ((*name).to_owned(), 2)).collect(),
        }
    }

    /// Adds a row to the table of its topic.
    pub(super) fn add(&mut self, row: &TableRow) -> Result<()> {
        let mut file = match self.open.iter().position(|(topic, _)| *topic == row.topic) {
            Some(index) => self.open.remove(index).1,
            None => {
                self.make_room()?;
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

    /// Writes what is still held back.
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
                "{}: messages that nest too deep, too widely or in their own kind are given as JSON, in the column {}{}",
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

    /// A path that no other file of this export has: topics such as /a/b and /a_b differ only in what a name cannot hold.
    fn path_of(&mut self, topic: &str) -> PathBuf {
        let mut name = topic.trim_matches('/').replace('/', "_");
        while let Some(number) = self.taken.get_mut(&name) {
            let numbered = format!("{name}_{number}");
            *number += 1;
            if !self.taken.contains_key(&numbered) {
                name = numbered;
            }
        }
        self.taken.insert(name.clone(), 2);
        self.folder.join(format!("{name}.csv"))
    }

    fn make_room(&mut self) -> Result<()> {
        if self.open.len() < MAX_OPEN {
            return Ok(());
        }
        let (topic, file) = self.open.remove(0);
        let closed = close(file)?;
        self.files.insert(topic, Some(closed));
        Ok(())
    }
}

/// Writes what is held back, and closes the file.
fn close(file: BufWriter<OutputFile>) -> Result<ClosedOutput> {
    let path = file.get_ref().path().to_owned();
    let file = file
        .into_inner()
        .map_err(|error| anyhow!(error.into_error()))
        .with_context(|| format!("{} cannot be written", path.display()))?;
    file.close()
}
