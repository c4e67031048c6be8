//! A mistake in a scenario's file, shown where it stands.

use std::fmt::Write as _;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What is wrong, and at which key.
#[derive(Debug, Clone, PartialEq)]
pub enum ScenarioError {
    /// It is not TOML, or has a key or a value that no scenario has. The words point at it.
    Form(String),
    /// A value cannot be.
    Value {
        /// The key, with dots between its tables.
        key: String,
        /// What is wrong with it, and what would be right.
        wrong: String,
    },
}

/// A mistake, with the place where it stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {words}")]
pub struct LocatedScenarioError {
    place: String,
    words: String,
}

impl ScenarioError {
    /// A value that cannot be.
    pub fn value(key: impl Into<String>, wrong: impl Into<String>) -> Self {
        Self::Value { key: key.into(), wrong: wrong.into() }
    }

    /// The mistake with its line, for the text that it was found in.
    pub fn located_in(self, name: &str, text: &str) -> LocatedScenarioError {
        match self {
            Self::Form(words) => LocatedScenarioError { place: format!("{name} cannot be read"), words },
            Self::Value { key, wrong } => match line_of(text, &key) {
                Some((number, line)) => {
                    let mut words = format!("{key}: {wrong}\n");
                    // Nothing can go wrong when writing into a string.
                    let _ = write!(words, "{number:>5} | {}", line.trim_end());
                    LocatedScenarioError { place: format!("{name}, line {number}"), words }
                }
                None => LocatedScenarioError { place: name.to_owned(), words: format!("{key}: {wrong}") },
            },
        }
    }
}

/// Where a key of a table stands, and its value.
fn find<'t, 'i>(table: &'t DeTable<'i>, key: &str) -> Option<(usize, &'t Spanned<DeValue<'i>>)> {
    table
        .iter()
        .find(|(name, _)| name.get_ref().as_ref() == key)
        .map(|(name, value)| (name.span().start, value))
}

/// The line of a key, from 1, and what stands there. Of a key that is left out: the line of its table.
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
