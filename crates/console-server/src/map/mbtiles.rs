//! Tiles in an MBTiles file (version 1.3): an SQLite database with a table, or view, `tiles`, whose rows
//! count from the south, and a table `metadata`.

use std::io;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::{Context as _, Result};
use rusqlite::{Connection, OpenFlags, OptionalExtension as _};

use super::tile::{About, TileAt};

const TILE: &str = "SELECT tile_data FROM tiles WHERE zoom_level = ?1 AND tile_column = ?2 AND tile_row = ?3";
/// The longest statement of whom the map names, characters.
const MAX_ATTRIBUTION: usize = 200;

/// A file, opened for reading alone.
#[derive(Debug)]
pub(super) struct MbTiles(Mutex<Connection>);

impl MbTiles {
    pub(super) fn open(path: &Path) -> Result<(Self, About)> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let file = Connection::open_with_flags(path, flags)?;
        let range = "SELECT min(zoom_level), max(zoom_level) FROM tiles";
        let zooms = file.query_row(range, (), |row| Ok((row.get(0)?, row.get(1)?)))?;
        let (Some(min_zoom), Some(max_zoom)): (Option<u8>, Option<u8>) = zooms else {
            anyhow::bail!("it has no tile");
        };
        let attribution = "SELECT value FROM metadata WHERE name = 'attribution'";
        let attribution: Option<String> =
            file.query_row(attribution, (), |row| row.get(0)).optional().unwrap_or_default();
        let attribution = attribution.map(|text| text.chars().take(MAX_ATTRIBUTION).collect());
        Ok((Self(Mutex::new(file)), About { min_zoom, max_zoom, attribution }))
    }

    /// Any tile.
    pub(super) fn first(&self) -> Result<Vec<u8>> {
        let file = self.file();
        file.query_row("SELECT tile_data FROM tiles LIMIT 1", (), |row| row.get(0)).context("it has no tile")
    }

    pub(super) fn tile(&self, TileAt { zoom, x, y }: TileAt) -> io::Result<Option<Vec<u8>>> {
        let row = (1_u32 << zoom) - 1 - y;
        let file = self.file();
        let found = file
            .prepare(TILE)
            .and_then(|mut tile| tile.query_row((zoom, x, row), |row| row.get(0)).optional());
        found.map_err(io::Error::other)
    }

    fn file(&self) -> MutexGuard<'_, Connection> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
