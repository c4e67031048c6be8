//! Checks that the guard links neither decoder nor renderer: its source names one crate of ours, and that
//! crate reaches none of the heavy ones.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;
use syn::visit::Visit;

use crate::dependencies::cargo_metadata;

/// The source of the program `barrelman-guard`.
const SOURCE: &str = "crates/station/src/guard.rs";
/// The crate that the guard consists of.
const CRATE: &str = "barrelman-link";
/// What the guard must not link: decoders, renderers, the network of the console, the crates around them.
const HEAVY: [&str; 14] = [
    "openh264",
    "openh264-sys2",
    "retina",
    "tiny-skia",
    "tokio",
    "axum",
    "hyper",
    "ring",
    "rustls",
    "tungstenite",
    "webpki-roots",
    "barrelman-link-http",
    "barrelman-video",
    "barrelman-vision",
];

/// The findings.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    let text = std::fs::read_to_string(root.join(SOURCE)).context(SOURCE)?;
    let mut named = Crates::default();
    named.visit_file(&syn::parse_file(&text).context(SOURCE)?);
    for name in named.0.iter().filter(|name| name.starts_with("barrelman") && *name != "barrelman_link") {
        findings.push(format!("{SOURCE}: names {name}; the guard consists of {CRATE} alone"));
    }
    let reached = reached_from(root, CRATE)?;
    for name in HEAVY.iter().filter(|name| reached.contains(**name)) {
        findings.push(format!("{CRATE}: reaches {name}, which the guard must not link"));
    }
    Ok(findings)
}

/// The first segments of all paths.
#[derive(Default)]
struct Crates(BTreeSet<String>);

impl<'ast> Visit<'ast> for Crates {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.0.extend(path.segments.first().map(|segment| segment.ident.to_string()));
    }

    fn visit_use_path(&mut self, path: &'ast syn::UsePath) {
        self.0.insert(path.ident.to_string());
    }
}

/// The names of all packages that a package depends on, directly or through others.
fn reached_from(root: &Path, package: &str) -> Result<BTreeSet<String>> {
    // The packages of other platforms may not have been downloaded.
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let metadata = cargo_metadata(root, &["--locked", "--offline", "--filter-platform", &platform])?;
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let packages = metadata["packages"].as_array().context("packages")?;
    let names: BTreeMap<String, String> =
        packages.iter().map(|package| (text(&package["id"]), text(&package["name"]))).collect();
    let nodes = metadata["resolve"]["nodes"].as_array().context("nodes")?;
    let edges: BTreeMap<String, Vec<String>> = nodes
        .iter()
        .map(|node| {
            let next = node["dependencies"].as_array().map(|next| next.iter().map(text).collect());
            (text(&node["id"]), next.unwrap_or_default())
        })
        .collect();
    let first = names.iter().find(|(_, name)| *name == package).context("the guard's crate")?.0;
    let mut waiting = vec![first.clone()];
    let mut seen = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if seen.insert(id.clone()) {
            waiting.extend(edges.get(&id).into_iter().flatten().cloned());
        }
    }
    Ok(seen.iter().filter_map(|id| names.get(id).cloned()).collect())
}
