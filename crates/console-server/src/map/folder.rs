//! Tiles as files `ZOOM/X/Y.png`, as most programs export them.

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::tile::{About, MAX_ZOOM, TileAt};

/// Endings of tiles.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// A folder of tiles of one ending.
#[derive(Debug)]
pub(super) struct Folder {
    folder: PathBuf,
    ending: &'static str,
    first: PathBuf,
}

impl Folder {
    /// `None`: it has no tile.
    pub(super) fn open(folder: &Path) -> io::Result<Option<(Self, About)>> {
        let mut zooms: Vec<u8> = numbered(folder)?.into_iter().filter(|zoom| *zoom <= MAX_ZOOM).collect();
        zooms.sort_unstable();
        let mut first = None;
        zooms.retain(|zoom| match first_tile(&folder.join(zoom.to_string())) {
            Ok(Some(found)) => {
                first.get_or_insert(found);
                true
            }
            Ok(None) | Err(_) => false,
        });
        let (Some((first, ending)), [min_zoom, ..]) = (first, zooms.as_slice()) else { return Ok(None) };
        let about = About { min_zoom: *min_zoom, max_zoom: zooms[zooms.len() - 1], attribution: None };
        Ok(Some((Self { folder: folder.to_owned(), ending, first }, about)))
    }

    /// Any tile.
    pub(super) fn first(&self) -> Vec<u8> {
        fs::read(&self.first).unwrap_or_default()
    }

    pub(super) fn tile(&self, TileAt { zoom, x, y }: TileAt) -> io::Result<Option<Vec<u8>>> {
        let path = self.folder.join(format!("{zoom}/{x}/{y}.{}", self.ending));
        match fs::read(path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// The entries of a folder whose names are numbers.
fn numbered(folder: &Path) -> io::Result<Vec<u8>> {
    let entries = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    Ok(entries.iter().filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect())
}

/// A tile of a zoom, with its ending.
fn first_tile(zoom: &Path) -> io::Result<Option<(PathBuf, &'static str)>> {
    for column in fs::read_dir(zoom)? {
        let column = column?.path();
        if !column.is_dir() {
            continue;
        }
        for file in fs::read_dir(column)? {
            let path = file?.path();
            let ending = path.extension().and_then(OsStr::to_str);
            if let Some(ending) = ENDINGS.into_iter().find(|known| Some(*known) == ending) {
                return Ok(Some((path, ending)));
            }
        }
    }
    Ok(None)
}
