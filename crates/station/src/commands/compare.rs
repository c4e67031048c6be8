//! `barrelman compare`: compares two campaigns, paired by seed.

use std::fmt::Write as _;
use std::io::{Write as _, stdout};
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Result, bail};
use barrelman_trial::campaign::CampaignComparison;
use barrelman_trial::campaign::statistics::{Bootstrap, Interval};
use barrelman_trial::metrics::TrialEntry;

use crate::cli::CompareArgs;
use barrelman_experiments::campaign::file;

/// Runs the command.
///
/// # Errors
/// If a file cannot be read, or the campaigns have no trial in common.
pub fn run(args: &CompareArgs) -> Result<ExitCode> {
    let (first, second) = (trials(&args.first)?, trials(&args.second)?);
    let comparison = CampaignComparison::new(&first, &second, &Bootstrap::DEFAULT);
    if comparison.pairs == 0 {
        bail!(
            "{} and {} have no trial in common: run both campaigns on the same scenario with the same --seed",
            args.first.display(),
            args.second.display()
        );
    }
    for (path, alone) in [(&args.first, &comparison.only_first), (&args.second, &comparison.only_second)] {
        if let Some(name) = alone.first() {
            tracing::warn!(
                "{} trials of {} have no partner and are left out, the first is {name}",
                alone.len(),
                path.display()
            );
        }
    }
    let text =
        if args.json { serde_json::to_string_pretty(&comparison)? + "\n" } else { table(&comparison, args)? };
    stdout().write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

fn trials(path: &Path) -> Result<Vec<TrialEntry>> {
    let read = file::read(path)?;
    if read.cut {
        tracing::warn!("{} ends within a line: the trials before it are used", path.display());
    }
    Ok(read.entries.into_iter().map(|(entry, _)| entry.trial).collect())
}

fn table(comparison: &CampaignComparison, args: &CompareArgs) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(
        text,
        "A: {}\nB: {}\n{} trials in both; intervals: 95 %, pairs resampled\n",
        args.first.display(),
        args.second.display(),
        comparison.pairs
    )?;
    writeln!(text, "{:32}  {:>10}  {:>10}  {:>26}  {:>28}", "mean of", "A", "B", "B / A", "B - A")?;
    let interval = |interval: &Option<Interval>, decimals: usize| {
        interval.map_or_else(
            || "-".to_owned(),
            |i| format!("{:.decimals$} ({:.decimals$} to {:.decimals$})", i.value, i.low, i.high),
        )
    };
    for figure in &comparison.metrics {
        let name = if figure.unit.is_empty() {
            figure.metric.to_owned()
        } else {
            format!("{}, {}", figure.metric, figure.unit)
        };
        writeln!(
            text,
            "{name:32}  {:>10.3}  {:>10.3}  {:>26}  {:>28}",
            figure.first,
            figure.second,
            interval(&figure.ratio, 3),
            interval(&figure.difference, 3)
        )?;
    }
    Ok(text)
}
