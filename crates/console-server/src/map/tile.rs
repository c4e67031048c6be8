//! The places of tiles, and what a map says of itself.

use schemars::JsonSchema;
use serde::Serialize;

/// The largest zoom: 0.15 m a tile at the equator.
pub(super) const MAX_ZOOM: u8 = 28;

/// What a map has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "Map")]
pub struct About {
    /// The smallest zoom that has tiles.
    pub min_zoom: u8,
    /// The largest zoom that has tiles.
    pub max_zoom: u8,
    /// Whom the map is to name; `null`: nobody is stated.
    pub attribution: Option<String>,
}

/// The place of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TileAt {
    pub(super) zoom: u8,
    pub(super) x: u32,
    pub(super) y: u32,
}

impl TileAt {
    /// `None`: the map of the world has no such tile.
    pub(super) fn new(zoom: u8, x: u32, y: u32) -> Option<Self> {
        let side = 1_u32.checked_shl(u32::from(zoom)).filter(|_| zoom <= MAX_ZOOM)?;
        (x < side && y < side).then_some(Self { zoom, x, y })
    }
}
