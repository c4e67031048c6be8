//! Documents: links that lead nowhere, and paths of somebody's machine.

use std::path::Path;

use anyhow::Result;

use crate::tracked_files::tracked_files;

/// Every relative link in a tracked Markdown file whose target is not there, and every line of a tracked text
/// file with a path of a machine in it.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    for file in tracked_files(root)? {
        // Pictures and clips are no text.
        let Ok(text) = std::fs::read_to_string(root.join(&file)) else { continue };
        let shown = file.display();
        if file.extension().is_some_and(|extension| extension == "md") {
            for target in links(&text).filter(|target| leads_nowhere(root, &file, target)) {
                findings.push(format!("{shown}: the link {target} leads nowhere"));
            }
        }
        for (index, line) in text.lines().enumerate() {
            if machine_path(line) {
                findings.push(format!("{shown}:{}: a path of a machine", index + 1));
            }
        }
    }
    Ok(findings)
}

/// Targets of `[text](target)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("](").filter_map(|(at, _)| {
        let rest = &text[at + 2..];
        let target = &rest[..rest.find(')')?];
        (!target.contains(['\n', ' '])).then_some(target)
    })
}

fn leads_nowhere(root: &Path, file: &Path, target: &str) -> bool {
    let path = target.split('#').next().unwrap_or_default();
    if path.is_empty() || target.contains("://") || target.starts_with("mailto:") {
        return false;
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    !root.join(folder).join(path).exists()
}

fn machine_path(line: &str) -> bool {
    // Put together here, so that this file does not find itself.
    [["/home", "/"], ["/root", "/"], ["/wor", "k/"]].iter().any(|parts| line.contains(&parts.concat()))
}
