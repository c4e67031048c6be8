//! The name of a recording.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::Serialize;

const ENDING: &str = ".mcap";
/// Longest name, bytes.
const MAX_BYTES: usize = 128;

/// The name of a recording within its folder: letters, digits, `-`, `_`, `.`, blanks, and `.mcap` at the end.
/// A name does not begin with a dot, so it leads nowhere else.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(transparent)]
pub(super) struct RecordingName(String);

impl RecordingName {
    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    /// The name without its ending.
    pub(super) fn stem(&self) -> &str {
        self.0.strip_suffix(ENDING).unwrap_or(&self.0)
    }
}

impl FromStr for RecordingName {
    type Err = &'static str;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let is_plain = |c: char| c.is_alphanumeric() || "-_. ".contains(c);
        let stem = name.strip_suffix(ENDING).unwrap_or_default();
        if stem.is_empty()
            || stem.starts_with(['.', ' '])
            || name.len() > MAX_BYTES
            || !stem.chars().all(is_plain)
        {
            return Err("use up to 120 letters, digits, blanks, - _ . and .mcap at the end");
        }
        Ok(Self(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_leads_nowhere_else() {
        for name in ["run-20261129T041200.123Z.mcap", "Übung 3.mcap", "a.mcap"] {
            assert_eq!(name.parse::<RecordingName>().unwrap().as_str(), name);
        }
        let long = format!("{}.mcap", "a".repeat(MAX_BYTES));
        for name in [
            "",
            ".mcap",
            "..mcap",
            "../a.mcap",
            "a/b.mcap",
            "a\\b.mcap",
            "a.mp4",
            " a.mcap",
            "a\n.mcap",
            &long,
        ] {
            assert!(name.parse::<RecordingName>().is_err(), "{name:?}");
        }
    }
}
