//! Checks documents: broken links, and absolute paths of a machine.

use std::path::Path;

use anyhow::Result;

use crate::tracked_files::tracked_files;

/// The findings: each relative link in a tracked Markdown file whose target does not exist, and each line of
/// a tracked text file with an absolute path of a machine.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    for file in tracked_files(root)? {
        // Files that are not text are skipped.
        let Ok(text) = std::fs::read_to_string(root.join(&file)) else { continue };
        let shown = file.display();
        if file.extension().is_some_and(|extension| extension == "md") {
            for target in links(&text).filter(|target| is_broken(root, &file, target)) {
                findings.push(format!("{shown}: the link {target} leads nowhere"));
            }
        }
        for (index, line) in text.lines().enumerate() {
            if has_machine_path(line) {
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

fn is_broken(root: &Path, file: &Path, target: &str) -> bool {
    let path = target.split('#').next().unwrap_or_default();
    if path.is_empty() || target.contains("://") || target.starts_with("mailto:") {
        return false;
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    !root.join(folder).join(path).exists()
}

fn has_machine_path(line: &str) -> bool {
    // Joined at run time, so that this file is not a finding.
    [["/home", "/"], ["/root", "/"], ["/wor", "k/"]].iter().any(|parts| line.contains(&parts.concat()))
}
