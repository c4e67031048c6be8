//! `barrelman merge`: joins the shards of a campaign.

use std::io::{BufWriter, Write as _};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use barrelman_trial::metrics::summarise;

use super::summary_table;
use crate::cli::MergeArgs;
use barrelman_experiments::campaign::file;
use barrelman_host::output;

/// Runs the command.
///
/// # Errors
/// If the files do not belong to one campaign, or the result cannot be written.
pub fn run(args: &MergeArgs) -> Result<ExitCode> {
    let mut files = Vec::with_capacity(args.files.len());
    for path in &args.files {
        files.push((path.clone(), file::read(path)?));
    }
    let merged = file::merge(&files)?;
    if merged.is_empty() {
        bail!("there are no trials in these files");
    }
    if let Some(path) = &args.output {
        let mut file = BufWriter::new(output::create(path, args.force)?);
        for (_, line) in &merged {
            writeln!(file, "{line}").with_context(|| format!("{} cannot be written", path.display()))?;
        }
        file.flush().with_context(|| format!("{} cannot be written", path.display()))?;
    }
    let summary = summarise(merged.into_iter().map(|(entry, _)| entry.trial).collect());
    summary_table::print(&summary, args.json)?;
    Ok(ExitCode::SUCCESS)
}
