//! What the fuzz targets do with the bytes that they are given.

pub mod recording;
pub mod text;
pub mod tracker;
pub mod vehicle;

/// A fuzz target: its name, and what it does with any bytes.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: [Target; 5] = [
    ("tracker", tracker::session),
    ("session", vehicle::session),
    ("ground_station", vehicle::ground_station),
    ("recording", recording::read),
    ("text", text::parse),
];
