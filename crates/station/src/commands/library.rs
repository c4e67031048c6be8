//! `barrelman library`: lists the recordings of a folder, or says what one of them holds.
//!
//! A recording that was ended in order has its summary in itself. One that was cut off is read as a whole.

use std::io::{Write as _, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, Result};
use barrelman_host::input;
use barrelman_trial::sortie::Sortie;
use serde::Serialize;

use super::recorded_sortie;
use crate::cli::LibraryArgs;
use crate::config::{self, Configuration};
use crate::live::sortie_text::{MomentLines, SortieLine, SortieText};

/// A recording and its summary.
#[derive(Debug, Serialize)]
struct Listed {
    path: PathBuf,
    bytes: u64,
    /// Whether the recording was cut off, as when the program was killed.
    is_cut: bool,
    sortie: Sortie,
}

/// Runs the command.
///
/// # Errors
/// If the path cannot be read, or a recording that was named is none.
pub fn run(args: &LibraryArgs) -> Result<ExitCode> {
    let path = match &args.path {
        Some(path) => path.clone(),
        None => recordings_folder(args)?,
    };
    let mut out = stdout().lock();
    // `run` makes its folder with the first recording.
    let is_to_come = args.path.is_none() && !path.exists();
    if !path.is_dir() && !is_to_come {
        let listed =
            read(&path).with_context(|| format!("{} is no recording that can be read", path.display()))?;
        if args.json {
            writeln!(out, "{}", serde_json::to_string_pretty(&listed)?)?;
        } else {
            let text = SortieText { sortie: &listed.sortie, path: &listed.path, is_cut: listed.is_cut };
            write!(out, "{text}{}", MomentLines(&listed.sortie))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let recordings = if is_to_come { Vec::new() } else { recordings_in(&path)? };
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&recordings)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    for Listed { path, bytes, is_cut, sortie } in &recordings {
        writeln!(out, "{}", SortieLine { sortie, path, bytes: *bytes, is_cut: *is_cut })?;
    }
    writeln!(out, "{}: {} recordings", path.display(), recordings.len())?;
    Ok(ExitCode::SUCCESS)
}

fn recordings_folder(args: &LibraryArgs) -> Result<PathBuf> {
    let file = args.config.as_deref().map(config::read).transpose()?.unwrap_or_default();
    Ok(Configuration::resolve(&file)?.recording.folder)
}

/// The recordings of a folder, the newest first. Files of other programs are left out.
fn recordings_in(folder: &Path) -> Result<Vec<Listed>> {
    let context = || format!("the folder {} cannot be read", folder.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(context)? {
        let path = entry.with_context(context)?.path();
        if path.extension().is_none_or(|extension| extension != "mcap") {
            continue;
        }
        match read(&path) {
            Ok(listed) => found.push(listed),
            Err(error) => tracing::warn!("{} is left out: {error:#}", path.display()),
        }
    }
    found.sort_by_key(|listed| std::cmp::Reverse(listed.sortie.began_unix_ns));
    Ok(found)
}

fn read(path: &Path) -> Result<Listed> {
    let bytes = input::open(path)?.metadata()?.len();
    let (sortie, is_cut) = recorded_sortie::of_recording(path)?;
    Ok(Listed { path: path.to_owned(), bytes, is_cut, sortie })
}
