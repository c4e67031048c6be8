//! The licences of the libraries that are part of a program: `cargo run -p xtask -- licences PACKAGE...`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::dependencies::cargo_metadata;

/// The licence of the font, which is no package of its own.
const FONT: &str = "docs/licences/LICENSE-DejaVu.txt";
/// How deep a package keeps the licences of what it contains.
const DEPTH: usize = 2;

/// The text of all licences, each once, under the names of its libraries.
///
/// # Errors
/// If a package is not known, or a library has neither a licence file nor the name of a licence.
pub(crate) fn text(root: &Path, packages: &[String]) -> Result<String> {
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let metadata = cargo_metadata(root, &["--locked", "--filter-platform", &platform])?;
    let linked = linked(&metadata, packages)?;
    let mut libraries_of: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in metadata["packages"].as_array().context("packages")? {
        // A package without a source is one of this workspace.
        if package["source"].is_null() || !linked.contains(as_text(&package["id"])) {
            continue;
        }
        let name = format!("{} {}", as_text(&package["name"]), as_text(&package["version"]));
        let folder =
            Path::new(as_text(&package["manifest_path"])).parent().context("a manifest lies in a folder")?;
        let mut files = Vec::new();
        licence_files(folder, DEPTH, &mut files)?;
        let mut texts = files.iter().map(std::fs::read_to_string).collect::<std::io::Result<Vec<_>>>()?;
        if texts.is_empty() {
            let named = package["license"].as_str().with_context(|| format!("{name} states no licence"))?;
            texts.push(format!("The package states its licence by name: {named}"));
        }
        for text in texts {
            libraries_of.entry(text).or_default().insert(name.clone());
        }
    }
    if libraries_of.values().flatten().any(|library| library.starts_with("dejavu ")) {
        let font = std::fs::read_to_string(root.join(FONT)).context(FONT)?;
        libraries_of.entry(font).or_default().insert("the font DejaVu".to_owned());
    }
    let mut all = String::new();
    for (text, libraries) in libraries_of {
        let names: Vec<_> = libraries.into_iter().collect();
        write!(all, "{}\n\n{}\n\n{}\n\n", names.join(", "), text.trim_end(), "-".repeat(72))?;
    }
    Ok(all)
}

fn as_text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// The ids of the packages that are part of the programs: dependencies of builds and tests are not.
fn linked(metadata: &Value, packages: &[String]) -> Result<BTreeSet<String>> {
    let nodes = metadata["resolve"]["nodes"].as_array().context("nodes")?;
    let edges: BTreeMap<&str, Vec<&str>> = nodes
        .iter()
        .map(|node| {
            let next = node["deps"].as_array().into_iter().flatten();
            let normal = next.filter(|to| {
                to["dep_kinds"]
                    .as_array()
                    .is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
            });
            (as_text(&node["id"]), normal.map(|to| as_text(&to["pkg"])).collect())
        })
        .collect();
    let all = metadata["packages"].as_array().context("packages")?;
    let first = all.iter().filter(|one| packages.iter().any(|name| one["name"] == name.as_str()));
    let mut waiting: Vec<&str> = first.map(|one| as_text(&one["id"])).collect();
    if waiting.len() != packages.len() {
        bail!("{packages:?} are not packages of this workspace");
    }
    let mut seen = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if seen.insert(id.to_owned()) {
            waiting.extend(edges.get(id).into_iter().flatten());
        }
    }
    Ok(seen)
}

/// The files of a folder, and of folders in it, that have the name of a licence.
fn licence_files(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) -> Result<()> {
    let mut entries: Vec<_> = std::fs::read_dir(folder)?.collect::<std::io::Result<_>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        if path.is_dir() && depth > 0 {
            licence_files(&path, depth - 1, found)?;
        }
        let name = entry.file_name().to_string_lossy().to_uppercase();
        let is_text = path
            .extension()
            .is_none_or(|ending| !["rs", "toml", "py", "html"].iter().any(|code| ending == *code));
        if path.is_file()
            && is_text
            && ["LICENSE", "LICENCE", "COPYING", "NOTICE", "COPYRIGHT"]
                .iter()
                .any(|start| name.starts_with(start))
        {
            found.push(path);
        }
    }
    Ok(())
}
