//! Names that the glossary retires: the table "Retired names" of docs/glossary.md against the identifiers of all Rust
//! code.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail};
use syn::Ident;
use syn::visit::Visit;

use crate::tracked_files::tracked_files;

/// The heading of the table.
const HEADING: &str = "## Retired names";

/// One finding for each retired name in a file, with the name to use instead.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let glossary = std::fs::read_to_string(root.join("docs/glossary.md")).context("docs/glossary.md")?;
    let retired = table(&glossary)?;
    let mut findings = Vec::new();
    for file in tracked_files(root)? {
        if file.extension().is_none_or(|extension| extension != "rs") {
            continue;
        }
        // A file that is deleted and not yet committed is still listed.
        let Ok(text) = std::fs::read_to_string(root.join(&file)) else { continue };
        let parsed = syn::parse_file(&text).with_context(|| file.display().to_string())?;
        for name in retired_in(&parsed, &retired) {
            let instead = &retired[&name];
            findings.push(format!("{}: the name {name} is retired, use {instead}", file.display()));
        }
    }
    Ok(findings)
}

/// The retired names, each with what is used instead.
fn table(glossary: &str) -> Result<BTreeMap<String, String>> {
    let Some((_, section)) = glossary.split_once(HEADING) else {
        bail!("docs/glossary.md has no section \"{HEADING}\"");
    };
    let mut retired = BTreeMap::new();
    for line in section.lines().take_while(|line| !line.starts_with("## ")) {
        let cells: Vec<&str> = line.trim().trim_matches('|').split(" | ").map(str::trim).collect();
        let [names, instead] = cells[..] else { continue };
        for name in names.split(',').filter_map(|name| name.trim().strip_prefix('`')?.strip_suffix('`')) {
            retired.insert(name.to_owned(), instead.to_owned());
        }
    }
    if retired.is_empty() {
        bail!("the section \"{HEADING}\" of docs/glossary.md has no table of names");
    }
    Ok(retired)
}

/// The retired names of a file, each once.
fn retired_in(file: &syn::File, retired: &BTreeMap<String, String>) -> Vec<String> {
    struct Found<'a> {
        retired: &'a BTreeMap<String, String>,
        names: Vec<String>,
    }
    impl Visit<'_> for Found<'_> {
        fn visit_ident(&mut self, ident: &Ident) {
            let name = ident.to_string();
            if self.retired.contains_key(&name) && !self.names.contains(&name) {
                self.names.push(name);
            }
        }
    }
    let mut found = Found { retired, names: Vec::new() };
    found.visit_file(file);
    found.names
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLOSSARY: &str = "# Words\n| `Kept` | here |\n## Retired names\ntext\n| retired | use |\n|---|---|\n\
                            | `Eye`, `look` | `Camera`, `capture` |\n## Next\n| `Other` | no |\n";

    #[test]
    fn the_table_ends_with_its_section() {
        let retired = table(GLOSSARY).unwrap();
        assert_eq!(retired.keys().collect::<Vec<_>>(), ["Eye", "look"]);
        assert!(table("# Words").is_err());
    }

    #[test]
    fn types_functions_fields_and_uses_are_found_once_each() {
        let retired = table(GLOSSARY).unwrap();
        let found = |text: &str| retired_in(&syn::parse_file(text).unwrap(), &retired);
        assert_eq!(found("struct Eye; fn f(eye: Eye) { eye.look(); }"), ["Eye", "look"]);
        assert_eq!(found("// Eye\nstruct Eyelid; const S: &str = \"Eye\";"), Vec::<String>::new());
    }
}
