//! What follows from the declarations of the keys in the section types: the JSON schema and the check of
//! ranges. A key is declared once: its type, its words, its range and an example of what has no default.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::{Context, Result, ensure};
use barrelman_vision::FusedConfig;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

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

/// Checks the numbers of a section against the ranges of their keys. `section` is put before the keys in an
/// error.
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
            let unit = declared.unit().or(unit_of(key)).map_or(String::new(), |unit| format!("{unit} from "));
            ensure!((min..=max).contains(&number), "{path} = {number}: use {unit}{min} to {max}");
        }
    }
    Ok(())
}

/// The unit that a key's name ends in.
fn unit_of(key: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 7] = [
        ("_rad_per_s", "rad/s"),
        ("_m_per_s", "m/s"),
        ("_per_s", "1/s"),
        ("_rad", "radians"),
        ("_s", "seconds"),
        ("_m", "metres"),
        ("_gb", "gigabytes"),
    ];
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map(|(_, unit)| *unit)
}

/// The name of a key in a section.
pub(super) fn joined(section: &str, key: &str) -> String {
    if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") }
}

/// A place in the JSON schema: a section, or a key.
pub(super) struct Node<'a> {
    definitions: Option<&'a Value>,
    /// The name of the type, where it has one.
    pub(super) name: &'a str,
    /// What stands at the key itself.
    own: &'a Value,
    /// What stands at its type.
    of_type: &'a Value,
}

impl<'a> Node<'a> {
    pub(super) fn root(schema: &'a Value) -> Self {
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
    pub(super) fn keys(&self, order: &'static [&'static str]) -> Vec<(&'static str, Self)> {
        order.iter().filter_map(|key| Some((*key, self.key(key)?))).collect()
    }

    pub(super) fn is_section(&self) -> bool {
        self.of_type.get("properties").is_some()
    }

    /// Whether some of its keys have to be given.
    pub(super) fn is_complete(&self) -> bool {
        self.of_type["required"].as_array().is_some_and(|keys| !keys.is_empty())
    }

    pub(super) fn range(&self) -> Option<(f64, f64)> {
        Some((self.own["minimum"].as_f64()?, self.own["maximum"].as_f64()?))
    }

    /// The unit of a key whose name does not end in it.
    fn unit(&self) -> Option<&'a str> {
        self.own["unit"].as_str()
    }

    /// The words of the key, and those of the names that it can have.
    pub(super) fn words(&self) -> String {
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
    pub(super) fn example(&self) -> Option<String> {
        let example = self.own["examples"].get(0)?;
        Some(match example {
            Value::String(text) => format!("{text:?}"),
            other => other.to_string(),
        })
    }
}
