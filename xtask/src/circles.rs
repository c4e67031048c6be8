//! Finds circles (dependency cycles) of files: file A uses file B, and file B uses file A, directly or
//! through others.
//!
//! The edges of the graph are the paths in the code of a crate (`use` declarations, calls, types; not the
//! paths in macros), resolved to the file of the module that they name. A re-export (`pub use`) resolves to
//! the file that it re-exports and is not an edge of its own file: a folder's `mod.rs` may name its parts.
//! Unit tests do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, UseTree, Visibility};

/// The path of a module below its crate; empty for the root of the crate.
type ModulePath = Vec<String>;

/// The findings: one for each circle in the source folder of a crate.
pub(crate) fn check(root: &Path) -> Result<Vec<String>> {
    let mut findings = Vec::new();
    for folder in source_folders(root)? {
        let modules = Modules::read(&folder)?;
        for circle in circles(&modules.edges()) {
            let names: Vec<String> = circle
                .iter()
                .map(|file| file.strip_prefix(root).unwrap_or(file).display().to_string())
                .collect();
            findings.push(format!("a circle of files: {}", names.join(", ")));
        }
    }
    Ok(findings)
}

fn source_folders(root: &Path) -> Result<Vec<PathBuf>> {
    let mut folders = vec![root.join("xtask/src")];
    for parent in ["crates", "research"] {
        for entry in std::fs::read_dir(root.join(parent)).context(parent)? {
            folders.push(entry?.path().join("src"));
        }
    }
    folders.retain(|folder| folder.is_dir());
    folders.sort();
    Ok(folders)
}

/// The modules of a crate.
struct Modules {
    by_path: BTreeMap<ModulePath, Module>,
}

/// A module: its file and the names in the file.
struct Module {
    file: PathBuf,
    /// The names that the module re-exports, each with its path.
    reexports: BTreeMap<String, Vec<String>>,
    /// The paths in the module's code, with `crate`, `self` and `super` unresolved.
    paths: BTreeSet<Vec<String>>,
}

impl Modules {
    fn read(folder: &Path) -> Result<Self> {
        let mut by_path = BTreeMap::new();
        let mut pending = vec![folder.to_path_buf()];
        while let Some(current) = pending.pop() {
            for entry in std::fs::read_dir(&current).with_context(|| current.display().to_string())? {
                let path = entry?.path();
                if path.is_dir() {
                    pending.push(path);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    let text = std::fs::read_to_string(&path)?;
                    let parsed = syn::parse_file(&text).with_context(|| path.display().to_string())?;
                    let mut names = Names::default();
                    names.visit_file(&parsed);
                    let Names { reexports, paths } = names;
                    by_path.insert(module_path(folder, &path), Module { file: path, reexports, paths });
                }
            }
        }
        Ok(Self { by_path })
    }

    /// The files that each file uses.
    fn edges(&self) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
        let mut edges: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
        for (module_path, module) in &self.by_path {
            let used = edges.entry(module.file.clone()).or_default();
            for path in &module.paths {
                if let Some(target) = self.resolve(module_path, path, 0)
                    && target.file != module.file
                {
                    used.insert(target.file.clone());
                }
            }
        }
        edges
    }

    /// The module that defines the last name of a path; `None` for a path into another crate.
    fn resolve(&self, from: &ModulePath, path: &[String], depth: usize) -> Option<&Module> {
        // Limit for re-exports of re-exports.
        const MAX_DEPTH: usize = 16;
        let mut rest = path;
        let mut at = from.clone();
        match rest.first()?.as_str() {
            "crate" => {
                at.clear();
                rest = &rest[1..];
            }
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    at.pop()?;
                    rest = &rest[1..];
                }
            }
            first => {
                let child = [at.as_slice(), &[first.to_owned()]].concat();
                if !self.by_path.contains_key(&child) {
                    return None;
                }
            }
        }
        while let Some(segment) = rest.first() {
            let child = [at.as_slice(), std::slice::from_ref(segment)].concat();
            if !self.by_path.contains_key(&child) {
                break;
            }
            at = child;
            rest = &rest[1..];
        }
        let module = self.by_path.get(&at)?;
        match rest.first().and_then(|name| module.reexports.get(name)) {
            Some(target) if depth < MAX_DEPTH => self.resolve(&at, target, depth + 1).or(Some(module)),
            _ => Some(module),
        }
    }
}

fn module_path(folder: &Path, file: &Path) -> ModulePath {
    let relative = file.strip_prefix(folder).unwrap_or(file).with_extension("");
    let mut path: ModulePath =
        relative.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    if path.last().is_some_and(|last| last == "mod")
        || (path.len() == 1 && (path[0] == "lib" || path[0] == "main"))
    {
        path.pop();
    }
    path
}

/// Collects the names of a file.
#[derive(Default)]
struct Names {
    reexports: BTreeMap<String, Vec<String>>,
    paths: BTreeSet<Vec<String>>,
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes_of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let mut found = Vec::new();
        expand(&item.tree, &mut Vec::new(), &mut found);
        for (name, path) in found {
            if matches!(item.vis, Visibility::Inherited) {
                self.paths.insert(path);
            } else {
                self.reexports.insert(name, path);
            }
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if segments.len() > 1 {
            self.paths.insert(segments);
        }
        visit::visit_path(self, path);
    }
}

fn attributes_of(item: &Item) -> &[Attribute] {
    match item {
        Item::Mod(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        _ => &[],
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|argument| argument == "test")
    })
}

/// Collects each name that a `use` imports, with its path.
fn expand(tree: &UseTree, prefix: &mut Vec<String>, found: &mut Vec<(String, Vec<String>)>) {
    match tree {
        UseTree::Path(path) => {
            prefix.push(path.ident.to_string());
            expand(&path.tree, prefix, found);
            prefix.pop();
        }
        UseTree::Name(name) if name.ident == "self" => {
            found.push((prefix.last().cloned().unwrap_or_default(), prefix.clone()));
        }
        UseTree::Name(name) => {
            let name = name.ident.to_string();
            found.push((name.clone(), [prefix.as_slice(), &[name]].concat()));
        }
        UseTree::Rename(rename) => {
            let path = [prefix.as_slice(), &[rename.ident.to_string()]].concat();
            found.push((rename.rename.to_string(), path));
        }
        UseTree::Glob(_) => found.push(("*".to_owned(), prefix.clone())),
        UseTree::Group(group) => group.items.iter().for_each(|tree| expand(tree, prefix, found)),
    }
}

/// The groups of two or more files that reach each other.
fn circles(edges: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> Vec<BTreeSet<PathBuf>> {
    let reach: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> =
        edges.keys().map(|file| (file, reachable(edges, file))).collect();
    let mut circles: Vec<BTreeSet<PathBuf>> = Vec::new();
    for (file, reached) in &reach {
        let circle: BTreeSet<PathBuf> = reached
            .iter()
            .filter(|other| reach.get(**other).is_some_and(|back| back.contains(*file)))
            .map(|other| (*other).clone())
            .collect();
        if circle.len() > 1 && !circles.contains(&circle) {
            circles.push(circle);
        }
    }
    circles
}

fn reachable<'a>(
    edges: &'a BTreeMap<PathBuf, BTreeSet<PathBuf>>,
    from: &'a PathBuf,
) -> BTreeSet<&'a PathBuf> {
    let mut reached = BTreeSet::new();
    let mut pending = vec![from];
    while let Some(file) = pending.pop() {
        for next in edges.get(file).into_iter().flatten() {
            if reached.insert(next) {
                pending.push(next);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modules(files: &[(&str, &str)]) -> Modules {
        let folder = Path::new("src");
        let by_path = files.iter().map(|(name, text)| {
            let file = folder.join(name);
            let mut names = Names::default();
            names.visit_file(&syn::parse_file(text).unwrap());
            let Names { reexports, paths } = names;
            (module_path(folder, &file), Module { file, reexports, paths })
        });
        Modules { by_path: by_path.collect() }
    }

    #[track_caller]
    fn check(files: &[(&str, &str)], expected: &[&[&str]]) {
        let found = circles(&modules(files).edges());
        let expected: Vec<BTreeSet<PathBuf>> = expected
            .iter()
            .map(|circle| circle.iter().map(|name| Path::new("src").join(name)).collect())
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn two_files_that_use_each_other_are_a_circle() {
        check(&[("a.rs", "use crate::b::B;"), ("b.rs", "use super::a::A;")], &[&["a.rs", "b.rs"]]);
        check(&[("a.rs", "use crate::b::B;"), ("b.rs", "fn f() { crate::a::g() }")], &[&["a.rs", "b.rs"]]);
    }

    #[test]
    fn a_circle_may_go_through_others() {
        check(
            &[("a.rs", "use crate::b::B;"), ("b.rs", "use crate::c;"), ("c.rs", "use crate::a::A;")],
            &[&["a.rs", "b.rs", "c.rs"]],
        );
    }

    #[test]
    fn a_folder_that_only_names_its_parts_is_no_part_of_a_circle() {
        check(
            &[
                ("folder/mod.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
                ("folder/a.rs", "use super::B;"),
                ("folder/b.rs", ""),
            ],
            &[],
        );
        check(
            &[("folder/mod.rs", "mod a; use a::A; pub struct B;"), ("folder/a.rs", "use super::B;")],
            &[&["folder/a.rs", "folder/mod.rs"]],
        );
    }

    #[test]
    fn tests_do_not_count() {
        check(&[("a.rs", "use crate::b::B;"), ("b.rs", "#[cfg(test)] mod tests { use crate::a::A; }")], &[]);
    }
}
