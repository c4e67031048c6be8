//! The video that a vehicle names.

/// A video of a vehicle: the one that the operator has chosen, or the main one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VehicleVideo {
    /// The stream's name.
    pub name: String,
    /// Its address: without encryption where there is one, otherwise in TLS (`rtsps://`); `None`: it has
    /// neither.
    pub address: Option<String>,
    /// The names of all streams that may be chosen, this one among them.
    pub choices: Vec<String>,
}

impl VehicleVideo {
    /// Its name, with those of the others where there are some.
    pub fn among_choices(&self) -> String {
        let Self { name, choices, .. } = self;
        match &choices[..] {
            [] | [_] => name.clone(),
            several => format!("{name} (of {}: video.stream chooses)", several.join(", ")),
        }
    }
}
