//! The example of a configuration, from the declarations of its keys.

use std::fmt::Write as _;

use anyhow::Result;

use super::declared::{Node, joined, schema_of};
use super::field_names::{FieldNames, field_names};
use super::file::ConfigFile;
use super::resolve::Configuration;

/// The width to which the comments are wrapped.
const COLUMNS: usize = 100;

/// The example: every section and every key with its words. A key with a value that holds without it shows
/// that value.
///
/// # Errors
/// Never in practice: the defaults are usable.
pub(super) fn example() -> Result<String> {
    let mut file = ConfigFile::default();
    file.vessel.url = Some("udp://boat.example:14550".to_owned());
    let effective = toml::Table::try_from(Configuration::resolve(&file)?.to_file())?;
    let schema = schema_of::<ConfigFile>();
    let mut text = String::new();
    comment(
        &mut text,
        "Barrelman's configuration. Every key is optional. A line that is commented out shows the value that holds \
         without it, those of [vehicle] and [camera] for a Fotokite Pro, or an example where nothing holds. \
         `barrelman config print FILE` prints the effective configuration, `barrelman config schema` the JSON schema \
         for editors. Relative paths start in the current folder.",
    );
    let order = field_names();
    write_keys(&mut text, &Node::root(&schema), &order, Some(&effective), "");
    Ok(text)
}

fn write_keys(
    text: &mut String,
    node: &Node<'_>,
    order: &FieldNames,
    effective: Option<&toml::Table>,
    section: &str,
) {
    let names = node.keys(order.get(node.name).copied().unwrap_or_default());
    let (sections, keys): (Vec<_>, Vec<_>) =
        names.into_iter().partition(|(_, declared)| declared.is_section());
    for (key, declared) in keys {
        let range = declared.range().map_or(String::new(), |(min, max)| format!(" Range: {min} to {max}."));
        comment(text, &format!("{}{range}", declared.words()));
        let value = effective.and_then(|table| table.get(key)).map(ToString::to_string);
        let value = value.or_else(|| declared.example()).unwrap_or_else(|| "0.0".to_owned());
        let _ = writeln!(text, "# {key} = {value}");
    }
    for (key, declared) in sections {
        let path = joined(section, key);
        text.push('\n');
        comment(text, &declared.words());
        // A table whose keys are all needed stands in a comment as a whole.
        let mark = if declared.is_complete() { "# " } else { "" };
        let _ = writeln!(text, "{mark}[{path}]");
        let effective = effective.and_then(|table| table.get(key)?.as_table());
        write_keys(text, &declared, order, effective, &path);
    }
}

/// Adds words as lines of a comment.
fn comment(text: &mut String, words: &str) {
    let mut line = "#".to_owned();
    for word in words.split_whitespace() {
        if line.len() + 1 + word.len() > COLUMNS {
            text.push_str(&line);
            text.push('\n');
            "#".clone_into(&mut line);
        }
        line.push(' ');
        line.push_str(word);
    }
    text.push_str(&line);
    text.push('\n');
}
