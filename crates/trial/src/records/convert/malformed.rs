//! The error of a stored message that cannot be converted.

/// What is wrong with a stored message, for the reader's error.
#[derive(Debug)]
pub struct Malformed(pub(in crate::records) String);

impl From<prost::DecodeError> for Malformed {
    fn from(error: prost::DecodeError) -> Self {
        Self(error.to_string())
    }
}

/// The error of a field that another format stands in.
pub(super) fn unreadable(field: &str, error: &dyn core::fmt::Display) -> Malformed {
    Malformed(format!("{field} is unreadable: {error}"))
}

/// The error of a field that is absent, or whose number stands for no known variant.
pub(super) fn missing(field: &str) -> Malformed {
    Malformed(format!("{field} is missing, or has a value that this version does not know"))
}
