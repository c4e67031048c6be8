//! The built-in scenarios and paths.

/// A built-in scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// The name.
    pub name: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        [$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../../../config/scenarios/", $name, ".toml")),
        }),*]
    };
}

/// The built-in scenarios, in the order of the list.
pub const BUILT_IN: [BuiltIn; 21] = built_in![
    "lab1",
    "lab2",
    "arena1",
    "arena2",
    "field1",
    "field2",
    "steep1",
    "steep2",
    "first-drive",
    "open",
    "glint",
    "sea3",
    "distractors",
    "pier",
    "exit",
    "gusts",
    "rescue",
    "rescue-current",
    "rescue-surf",
    "rescue-four",
    "two-boats",
];

/// The built-in paths by their names, each with the text of its file.
pub const BUILT_IN_PATHS: [(&str, &str); 2] = [
    ("arena1", include_str!("../../../../config/scenarios/paths/arena1.toml")),
    ("arena2", include_str!("../../../../config/scenarios/paths/arena2.toml")),
];
