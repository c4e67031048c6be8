//! Single keys of a configuration that are changed on the command line: `--set law.mode=eco`.

use std::str::FromStr;

use anyhow::{Context as _, Result, anyhow};
use barrelman_experiments::toml_message::message_of;
use toml::{Table, Value};

use super::ConfigFile;

/// A key and its new value; without one the default holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedKey {
    /// The key with its tables, joined by dots: `law.horizon_s`.
    key: String,
    value: Option<Value>,
}

impl FromStr for ChangedKey {
    type Err = String;

    /// Parses `KEY=VALUE`. What is no TOML value is a text; `KEY=` takes the key out.
    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .filter(|(key, _)| key.split('.').all(|part| !part.is_empty()))
            .ok_or("use KEY=VALUE, such as law.mode=eco")?;
        let parsed =
            format!("value = {value}").parse::<Table>().ok().and_then(|table| table.get("value").cloned());
        let value = (!value.is_empty()).then(|| parsed.unwrap_or_else(|| Value::String(value.to_owned())));
        Ok(Self { key: key.to_owned(), value })
    }
}

/// Parses a configuration, and changes keys of it.
///
/// # Errors
/// A key that does not exist, a value that does not fit it, or a text that is no configuration.
pub fn parse_changed(text: &str, changes: &[ChangedKey]) -> Result<ConfigFile> {
    let mut root: Table = text.parse().map_err(|error| anyhow!("{}", message_of(&error)))?;
    for ChangedKey { key, value } in changes {
        let (tables, name) = key.rsplit_once('.').map_or(("", key.as_str()), |(tables, name)| (tables, name));
        let mut table = &mut root;
        for part in tables.split('.').filter(|part| !part.is_empty()) {
            let entry = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
            table =
                entry.as_table_mut().with_context(|| format!("{key}: `{part}` is a value, not a table"))?;
        }
        match value {
            Some(value) => table.insert(name.to_owned(), value.clone()),
            None => table.remove(name),
        };
    }
    let names = || changes.iter().map(|change| change.key.as_str()).collect::<Vec<_>>().join(", ");
    root.try_into().map_err(|error| anyhow!("{}: {}", names(), message_of(&error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str, changes: &[&str]) -> Result<ConfigFile> {
        let changes: Vec<ChangedKey> = changes.iter().map(|change| change.parse().unwrap()).collect();
        parse_changed(text, &changes)
    }

    #[test]
    fn one_key_is_changed_and_the_others_stay() {
        let text = "[vehicle]\nregion_half_width = 0.7\nregion_half_height = 0.4\n";
        let config = toml::to_string(
            &changed(text, &["vehicle.region_half_height=0.45", "vehicle.profile=fotokite-sigma"]).unwrap(),
        );
        let config = config.unwrap();
        assert!(config.contains("region_half_width = 0.7\nregion_half_height = 0.45"), "{config}");
        assert!(config.contains("profile = \"fotokite-sigma\""), "{config}");
    }

    #[test]
    fn a_key_without_a_value_is_taken_out() {
        let text = "[vehicle]\nregion_half_width = 0.7\n";
        let config = changed(text, &["vehicle.region_half_width="]).unwrap();
        assert!(!toml::to_string(&config).unwrap().contains("region_half_width"));
    }

    #[test]
    fn an_unknown_key_is_refused_by_its_name() {
        for (change, named) in [
            ("vehicle.height=1", "vehicle.height"),
            ("vehicle.region_half_width=wide", "vehicle.region_half_width"),
            ("vehicle.region_half_width.b=1", "region_half_width"),
        ] {
            let error = changed("[vehicle]\nregion_half_width = 0.7\n", &[change]).unwrap_err().to_string();
            assert!(error.contains(named), "{error}");
        }
        assert!("law.name".parse::<ChangedKey>().is_err());
        assert!("=1".parse::<ChangedKey>().is_err());
    }
}
