//! A map of the operator's own under boat and marks: raster tiles of a folder, or of an MBTiles file. No tile
//! is fetched from anywhere.
//!
//! Tiles are those of Web Mercator, 2^zoom by 2^zoom of them; x counts from 180 degrees west eastwards, y
//! from the north.

mod folder;
mod mbtiles;
mod tile;

pub(super) mod routes;

use std::io;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use folder::Folder;
use mbtiles::MbTiles;
pub(crate) use tile::About;
use tile::TileAt;

/// The largest tile, bytes.
const MAX_TILE_BYTES: usize = 1 << 20;

/// A map.
#[derive(Debug)]
pub struct Map {
    about: About,
    tiles: Tiles,
}

#[derive(Debug)]
enum Tiles {
    Folder(Folder),
    MbTiles(MbTiles),
}

impl Map {
    /// Opens a folder with tiles at `ZOOM/X/Y.png` (or `.jpg`, `.webp`), or an MBTiles file.
    ///
    /// # Errors
    /// If there is nothing, or nothing of this form; the message says what is.
    pub fn open(path: &Path) -> Result<Self> {
        let shown = path.display();
        let is_folder = std::fs::metadata(path).with_context(|| format!("there is no map {shown}"))?.is_dir();
        let (about, tiles, first) = if is_folder {
            let (folder, about) =
                Folder::open(path).with_context(|| format!("the map {shown} cannot be read"))?.with_context(
                    || format!("the map {shown} has no tile: it needs files such as 17/69000/42000.png"),
                )?;
            let first = folder.first();
            (about, Tiles::Folder(folder), first)
        } else {
            let (file, about) = MbTiles::open(path)
                .with_context(|| format!("the map {shown} is no MBTiles file that can be read"))?;
            let first = file.first()?;
            (about, Tiles::MbTiles(file), first)
        };
        if kind_of(&first).is_none() {
            bail!(
                "the tiles of the map {shown} are no PNG, JPEG or WebP pictures: vector tiles cannot be shown"
            );
        }
        Ok(Self { about, tiles })
    }

    /// What the map has.
    pub(super) const fn about(&self) -> &About {
        &self.about
    }

    /// A tile and its media type; `None`: the map has none there.
    fn tile(&self, at: TileAt) -> io::Result<Option<(&'static str, Vec<u8>)>> {
        let bytes = match &self.tiles {
            Tiles::Folder(folder) => folder.tile(at)?,
            Tiles::MbTiles(file) => file.tile(at)?,
        };
        Ok(bytes
            .filter(|bytes| bytes.len() <= MAX_TILE_BYTES)
            .and_then(|bytes| Some((kind_of(&bytes)?, bytes))))
    }
}

/// The media type of a picture that browsers show.
fn kind_of(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
