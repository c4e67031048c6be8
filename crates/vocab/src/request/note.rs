//! A request that marks a moment of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

/// A request about the recording, of which the pilot knows nothing: refused where nothing is recorded.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema, VariantNames)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[strum(serialize_all = "kebab-case")]
pub enum NoteRequest {
    /// Mark this moment in the recording. Anyone who has the token for control can, also without the control.
    Note(Note),
}

/// A marked moment.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Note {
    /// What there is to say of the moment; may be empty.
    #[serde(default)]
    pub text: NoteText,
}

/// The text of a note: one line of at most 200 characters.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
pub struct NoteText(#[schemars(length(max = 200))] String);

impl NoteText {
    /// Longest text, characters.
    pub const MAX_CHARACTERS: usize = 200;

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<String> for NoteText {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let characters = text.chars().count();
        if characters > Self::MAX_CHARACTERS {
            let most = Self::MAX_CHARACTERS;
            return Err(format!("the text of a note has {characters} characters: at most {most} are taken"));
        }
        if text.chars().any(char::is_control) {
            return Err("the text of a note is one line, without control characters".to_owned());
        }
        Ok(Self(text))
    }
}

impl From<NoteText> for String {
    fn from(text: NoteText) -> Self {
        text.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_one_line_of_at_most_200_characters() {
        assert!(NoteText::try_from("ü".repeat(200)).is_ok());
        assert!(NoteText::try_from("ü".repeat(201)).unwrap_err().contains("has 201 characters"));
        assert!(NoteText::try_from("two\nlines".to_owned()).unwrap_err().contains("one line"));
        assert_eq!(NoteText::try_from(String::new()), Ok(NoteText::default()));
    }
}
