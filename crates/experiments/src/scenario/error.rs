//! A mistake in a scenario file, with the line of the mistake.

use std::fmt::Write as _;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A mistake in a scenario file.
#[derive(Debug, Clone, PartialEq)]
pub enum ScenarioError {
    /// The text is not TOML, or has an unknown key or a value of the wrong type. The message shows the place.
    Syntax(String),
    /// A value is out of its range, or does not fit the others.
    Value {
        /// The key, with dots between its tables.
        key: String,
        /// What is wrong, and which values are allowed.
        problem: String,
    },
}

/// A mistake with the file and the line of the mistake.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct LocatedScenarioError {
    place: String,
    message: String,
}

impl ScenarioError {
    /// The error of an invalid value.
    pub fn invalid(key: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Value { key: key.into(), problem: problem.into() }
    }

    /// The mistake with its line in `text`, the text of the file `name`.
    pub fn located_in(self, name: &str, text: &str) -> LocatedScenarioError {
        match self {
            Self::Syntax(message) => {
                LocatedScenarioError { place: format!("{name} cannot be read"), message }
            }
            Self::Value { key, problem } => match line_of(text, &key) {
                Some((number, line)) => {
                    let mut message = format!("{key}: {problem}\n");
                    // Writing into a string cannot fail.
                    let _ = write!(message, "{number:>5} | {}", line.trim_end());
                    LocatedScenarioError { place: format!("{name}, line {number}"), message }
                }
                None => LocatedScenarioError { place: name.to_owned(), message: format!("{key}: {problem}") },
            },
        }
    }
}

/// The offset of a key of a table, and its value.
fn find<'t, 'i>(table: &'t DeTable<'i>, key: &str) -> Option<(usize, &'t Spanned<DeValue<'i>>)> {
    table
        .iter()
        .find(|(name, _)| name.get_ref().as_ref() == key)
        .map(|(name, value)| (name.span().start, value))
}

/// The number (from 1) and the text of the line of a key; for a missing key, of the line of its table.
fn line_of<'t>(text: &'t str, key: &str) -> Option<(usize, &'t str)> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = key.split('.');
    let (mut offset, mut value) = find(root.get_ref(), parts.next()?)?;
    for part in parts {
        let found = match value.get_ref() {
            DeValue::Table(table) => find(table, part),
            DeValue::Array(array) => part
                .parse()
                .ok()
                .and_then(|index: usize| array.get(index))
                .map(|item| (item.span().start, item)),
            _ => None,
        };
        let Some((start, inner)) = found else { break };
        (offset, value) = (start, inner);
    }
    let number = text[..offset].matches('\n').count() + 1;
    Some((number, text.lines().nth(number - 1)?))
}
