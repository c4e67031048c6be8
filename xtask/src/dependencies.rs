//! Checks the dependencies of the crates against the table in ARCHITECTURE.md.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// The dependencies that the table allows a crate; `others: None` allows all.
struct Allowed {
    ours: BTreeSet<String>,
    others: Option<BTreeSet<String>>,
}

/// A package of the workspace, with the names of its dependencies.
struct Package {
    name: String,
    dependencies: BTreeSet<String>,
    dev_dependencies: BTreeSet<String>,
}

/// The folder of what measures the product and is no part of it.
const RESEARCH: &str = "research/";

/// The findings: each dependency that the table does not allow (dev-dependencies excepted), each allowed
/// dependency that is not used, each crate that is missing in the table or in the workspace, and each
/// dependency of the product on research, dev-dependencies included.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let allowed = table(root)?;
    let packages = packages(root)?;
    let mut findings = Vec::new();
    for (folder, Package { dependencies, .. }) in &packages {
        let Some(allowed) = allowed.get(folder) else {
            findings.push(format!("ARCHITECTURE.md: its table of crates does not name {folder}"));
            continue;
        };
        for dependency in dependencies {
            let is_allowed = match (ours(dependency), &allowed.others) {
                (Some(ours), _) => allowed.ours.contains(ours),
                (None, Some(others)) => others.contains(dependency),
                (None, None) => true,
            };
            if !is_allowed {
                findings
                    .push(format!("{folder}: may not use {dependency} (table of crates in ARCHITECTURE.md)"));
            }
        }
        let used: BTreeSet<&str> =
            dependencies.iter().map(|dependency| ours(dependency).unwrap_or(dependency)).collect();
        let named = allowed.ours.iter().chain(allowed.others.iter().flatten());
        for name in named.filter(|name| !used.contains(name.as_str())) {
            findings.push(format!("ARCHITECTURE.md: {folder} may use {name} and does not"));
        }
    }
    for folder in allowed.keys().filter(|folder| !packages.contains_key(*folder)) {
        findings.push(format!("ARCHITECTURE.md: its table of crates names {folder}, which is not there"));
    }
    findings.extend(uses_of_research(&packages));
    Ok(findings)
}

/// The findings: each crate outside of [`RESEARCH`] that depends on one inside.
fn uses_of_research(packages: &BTreeMap<String, Package>) -> Vec<String> {
    let (research, product): (Vec<_>, Vec<_>) =
        packages.iter().partition(|(folder, _)| folder.starts_with(RESEARCH));
    let uses = |package: &Package, name: &String| {
        package.dependencies.contains(name) || package.dev_dependencies.contains(name)
    };
    product
        .iter()
        .flat_map(|(folder, package)| {
            let used = research.iter().map(|(_, used)| &used.name).filter(|name| uses(package, name));
            used.map(move |name| format!("{folder}: may not use {name}, which is in {RESEARCH}"))
        })
        .collect()
}

/// The name of a workspace package in the table, which is the name of its folder; `None` for other packages.
fn ours(package: &str) -> Option<&str> {
    if package == "barrelman" { Some("station") } else { package.strip_prefix("barrelman-") }
}

/// The table of crates by folder.
fn table(root: &Path) -> Result<BTreeMap<String, Allowed>> {
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?;
    let names = |cell: &str| -> BTreeSet<String> {
        cell.split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty() && *name != "none")
            .map(str::to_owned)
            .collect()
    };
    let rows = text.lines().filter_map(|line| {
        let cells: Vec<&str> = line.trim().trim_matches('|').split(" | ").map(str::trim).collect();
        let [folder, _, ours, others] = cells[..] else { return None };
        let folder = folder.strip_prefix('`')?.strip_suffix('`')?.to_owned();
        let others = (others != "any").then(|| names(others));
        Some((folder, Allowed { ours: names(ours), others }))
    });
    let table: BTreeMap<_, _> = rows.collect();
    if table.is_empty() {
        bail!("ARCHITECTURE.md has no table of crates with the columns folder, what, ours, others");
    }
    Ok(table)
}

/// What `cargo metadata` says about the workspace.
pub(crate) fn cargo_metadata(root: &Path, options: &[&str]) -> Result<Value> {
    let output = Command::new("cargo")
        .args(["metadata", "--format-version", "1"])
        .args(options)
        .current_dir(root)
        .output()
        .context("cargo metadata")?;
    if !output.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// Each package of the workspace by its folder.
fn packages(root: &Path) -> Result<BTreeMap<String, Package>> {
    let metadata = cargo_metadata(root, &["--no-deps"])?;
    let mut packages = BTreeMap::new();
    for package in metadata["packages"].as_array().context("packages")? {
        let manifest = Path::new(package["manifest_path"].as_str().context("manifest_path")?);
        let folder = manifest.parent().context("a manifest lies in a folder")?.strip_prefix(root)?;
        let all = package["dependencies"].as_array().context("dependencies")?;
        let named = |is_dev: bool| {
            all.iter()
                .filter(|dependency| (dependency["kind"] == "dev") == is_dev)
                .filter_map(|dependency| dependency["name"].as_str().map(str::to_owned))
                .collect()
        };
        let name = package["name"].as_str().context("name")?.to_owned();
        let package = Package { name, dependencies: named(false), dev_dependencies: named(true) };
        packages.insert(folder.to_string_lossy().into_owned(), package);
    }
    Ok(packages)
}
