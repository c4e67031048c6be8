//! What follows from the declarations of the keys in the section types: the JSON schema, the check of ranges, and the
//! example. A key is declared once: its type, its words, its range and an example of what has no default.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::{Context, Result, ensure};
use barrelman_vision::FusedConfig;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use super::field_names::field_names;
use super::file::ConfigFile;
use super::resolve::Configuration;

/// The width to which the example's comments are wrapped.
const COLUMNS: usize = 100;

/// The JSON schema of a type of the configuration. The fused tracker's ranges are those of its own settings.
pub(super) fn schema_of<T: JsonSchema>() -> Value {
    let mut schema = schemars::schema_for!(T).to_value();
    if let Some(keys) = schema.pointer_mut("/$defs/FusedSection/properties") {
        for setting in FusedConfig::SETTINGS {
            keys[setting.name]["minimum"] = json!(setting.min);
            keys[setting.name]["maximum"] = json!(setting.max);
        }
    }
    schema
}

/// Checks the numbers of a section against the ranges of their keys. `section` is put before the keys in an error.
///
/// # Errors
/// If a number is out of its range; the message names the key, the unit and the range.
pub(super) fn check<T: JsonSchema + Serialize>(value: &T, section: &str) -> Result<()> {
    let table = toml::Table::try_from(value).context("the configuration is not plain data")?;
    let schema = schema_of::<T>();
    check_table(&table, &Node::root(&schema), section)
}

fn check_table(table: &toml::Table, node: &Node<'_>, section: &str) -> Result<()> {
    for (key, value) in table {
        let Some(declared) = node.key(key) else { continue };
        let path = joined(section, key);
        let number = match value {
            toml::Value::Table(table) => {
                check_table(table, &declared, &path)?;
                continue;
            }
            toml::Value::Float(number) => *number,
            #[expect(clippy::cast_precision_loss, reason = "ranges are small numbers")]
            toml::Value::Integer(number) => *number as f64,
            _ => continue,
        };
        if let Some((min, max)) = declared.range() {
            let unit = unit_of(key).map_or(String::new(), |unit| format!("{unit} from "));
            ensure!((min..=max).contains(&number), "{path} = {number}: use {unit}{min} to {max}");
        }
    }
    Ok(())
}

/// The unit that a key's name ends in.
fn unit_of(key: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 8] = [
        ("_rad_per_s", "rad/s"),
        ("_m_per_s", "m/s"),
        ("_per_s", "1/s"),
        ("_rad", "radians"),
        ("_s", "seconds"),
        ("_m", "metres"),
        ("_gb", "gigabytes"),
        ("_share", "a share"),
    ];
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit)
}

/// The example: every section and every key with its words. A key with a value that holds without it shows that value.
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
    write_keys(&mut text, &Node::root(&schema), Some(&effective), "");
    Ok(text)
}

fn write_keys(text: &mut String, node: &Node<'_>, effective: Option<&toml::Table>, section: &str) {
    let order = field_names();
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
        write_keys(text, &declared, effective, &path);
    }
}

fn joined(section: &str, key: &str) -> String {
    if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") }
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

/// A place in the JSON schema: a section, or a key.
struct Node<'a> {
    definitions: Option<&'a Value>,
    /// The name of the type, where it has one.
    name: &'a str,
    /// What stands at the key itself.
    own: &'a Value,
    /// What stands at its type.
    of_type: &'a Value,
}

impl<'a> Node<'a> {
    fn root(schema: &'a Value) -> Self {
        let name = schema["title"].as_str().unwrap_or_default();
        Self { definitions: schema.get("$defs"), name, own: schema, of_type: schema }
    }

    fn key(&self, key: &str) -> Option<Self> {
        let own = self.of_type.get("properties")?.get(key)?;
        let optional = own.get("anyOf").and_then(|kinds| kinds.get(0)).unwrap_or(own);
        let name =
            optional["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/")).unwrap_or_default();
        let of_type = self.definitions.and_then(|all| all.get(name)).unwrap_or(own);
        Some(Self { definitions: self.definitions, name, own, of_type })
    }

    /// The keys, in this order.
    fn keys(&self, order: &'static [&'static str]) -> Vec<(&'static str, Self)> {
        order.iter().filter_map(|key| Some((*key, self.key(key)?))).collect()
    }

    fn is_section(&self) -> bool {
        self.of_type.get("properties").is_some()
    }

    /// Whether some of its keys have to be given.
    fn is_complete(&self) -> bool {
        self.of_type["required"].as_array().is_some_and(|keys| !keys.is_empty())
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some((self.own["minimum"].as_f64()?, self.own["maximum"].as_f64()?))
    }

    /// The words of the key, and those of the names that it can have.
    fn words(&self) -> String {
        let words = self.own["description"].as_str().or(self.of_type["description"].as_str());
        let mut words = words.unwrap_or_default().replace('\n', " ");
        let names: BTreeMap<_, _> = (self.of_type["oneOf"].as_array().into_iter().flatten().enumerate())
            .filter_map(|(index, name)| {
                Some((index, (name["const"].as_str()?, name["description"].as_str()?)))
            })
            .collect();
        for (name, meaning) in names.values() {
            let meaning = meaning.trim_end_matches('.').replace('\n', " ");
            let _ = write!(words, " {name:?}: {meaning}.");
        }
        words
    }

    /// An example of its value, in TOML.
    fn example(&self) -> Option<String> {
        let example = self.own["examples"].get(0)?;
        Some(match example {
            Value::String(text) => format!("{text:?}"),
            other => other.to_string(),
        })
    }
}
