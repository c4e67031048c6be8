//! Messages about mistakes in TOML files, in words for people who know the file and not the program.
//!
//! The parser shows the line of a mistake, and says what it expected in the types of the program
//! (`expected f64`). This module keeps the line and puts the rest into words (`expected a number`).

/// Types as the parser names them, and the words for what is to be written in the file.
const TYPES: [(&str, &str); 14] = [
    ("f64", "a number"),
    ("f32", "a number"),
    ("u8", "a whole number, 0 or more"),
    ("u16", "a whole number, 0 or more"),
    ("u32", "a whole number, 0 or more"),
    ("u64", "a whole number, 0 or more"),
    ("usize", "a whole number, 0 or more"),
    ("i32", "a whole number"),
    ("i64", "a whole number"),
    ("a boolean", "true or false"),
    ("a string", "text in quotes"),
    ("a sequence", "a list in [ ]"),
    ("a map", "a section"),
    ("string or map", "text in quotes"),
];

/// Kinds of values as the parser names them, and their words.
const VALUES: [(&str, &str); 6] = [
    ("floating point ", "the number "),
    ("integer ", "the number "),
    ("boolean ", ""),
    ("string ", "the text "),
    ("sequence", "a list"),
    ("map", "a section"),
];

/// The message of a mistake in words, with its line.
pub fn message_of(error: &toml::de::Error) -> String {
    let shown = error.to_string();
    let said = error.message();
    let place = shown.trim_end().strip_suffix(said.trim_end()).unwrap_or_default();
    let place = place.replace("TOML parse error at line", "mistake at line");
    format!("{place}{}", in_words(said))
}

/// What the parser says, in words; unchanged where it is no message about a type or a key.
fn in_words(said: &str) -> String {
    for (start, verb) in
        [("invalid type: ", "found"), ("invalid value: ", "found"), ("invalid length ", "found a list of")]
    {
        if let Some((found, expected)) =
            said.strip_prefix(start).and_then(|rest| rest.split_once(", expected "))
        {
            return format!("expected {}, {verb} {}", type_in_words(expected), value_in_words(found));
        }
    }
    for (parsed, words) in [
        ("unknown field `", "there is no key `"),
        ("unknown variant `", "there is no choice `"),
        ("missing field `", "a key is missing: `"),
        ("duplicate key", "a key stands there twice"),
        ("wanted string or table", "expected one of the choices, in quotes"),
    ] {
        if let Some(rest) = said.strip_prefix(parsed) {
            return format!(
                "{words}{}",
                rest.replacen(", expected one of ", "; use one of ", 1).replacen(", expected ", "; use ", 1)
            );
        }
    }
    said.to_owned()
}

fn type_in_words(expected: &str) -> String {
    if let Some((_, words)) = TYPES.iter().find(|(name, _)| *name == expected) {
        return (*words).to_owned();
    }
    if let Some(length) = expected.strip_prefix("an array of length ") {
        return format!("a list of {length} values");
    }
    if expected.starts_with("struct ") {
        return "a section of keys ([name] on a line of its own)".to_owned();
    }
    expected
        .strip_prefix("enum ")
        .map_or_else(|| expected.to_owned(), |_| "one of the choices, in quotes".to_owned())
}

fn value_in_words(found: &str) -> String {
    let plain = |value: &str| value.replace('`', "");
    VALUES
        .iter()
        .find_map(|(kind, words)| Some(format!("{words}{}", plain(found.strip_prefix(kind)?))))
        .unwrap_or_else(|| plain(found))
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn types_of_the_program_do_not_reach_the_user() {
        for (said, expected) in [
            ("invalid type: string \"a\", expected f64", "expected a number, found the text \"a\""),
            (
                "invalid type: floating point `7.5`, expected u32",
                "expected a whole number, 0 or more, found the number 7.5",
            ),
            (
                "invalid value: integer `-1`, expected u8",
                "expected a whole number, 0 or more, found the number -1",
            ),
            ("invalid type: boolean `true`, expected a string", "expected text in quotes, found true"),
            (
                "invalid type: integer `3`, expected struct VideoSection",
                "expected a section of keys ([name] on a line of its own), found the number 3",
            ),
            (
                "invalid length 1, expected an array of length 2",
                "expected a list of 2 values, found a list of 1",
            ),
            (
                "unknown field `colour`, expected one of `a`, `b`",
                "there is no key `colour`; use one of `a`, `b`",
            ),
            ("unknown variant `fast`, expected `a` or `b`", "there is no choice `fast`; use `a` or `b`"),
            ("missing field `name`", "a key is missing: `name`"),
            ("wanted string or table", "expected one of the choices, in quotes"),
            ("invalid string", "invalid string"),
        ] {
            assert_eq!(in_words(said), expected);
        }
    }
}
