//! The reader of a recording, whatever kind of file it is.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use barrelman_vocab::unit::EncodedUnit;

use super::kind::{self, FileKind};
use super::{folder, mp4, y4m};
use crate::error::{VideoError, cannot_read};
use crate::source::url::{VideoSource, VideoUrl};

/// Reads the units of a recording, in the order in which they are decoded.
pub struct FileReader {
    reader: Reader,
}

enum Reader {
    Mp4(mp4::Mp4Reader),
    Y4m(y4m::Y4mReader),
    Folder(folder::FolderReader),
}

impl FileReader {
    /// Opens a file or a folder and reads its index.
    ///
    /// # Errors
    /// A file that is missing, unreadable, empty, of another kind, or whose index is damaged. An address that
    /// is not a file counts as a file that is missing.
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        let path = match &url.source {
            VideoSource::File(path) => path,
            VideoSource::Rtsp { .. } => return Err(VideoError::Missing(url.to_string().into())),
        };
        let about = fs::metadata(path).map_err(|error| cannot_read(path, error))?;
        let reader = if about.is_dir() {
            Reader::Folder(folder::FolderReader::open(path, url.fps)?)
        } else {
            Self::open_file(path, url.fps)?
        };
        Ok(Self { reader })
    }

    fn open_file(path: &Path, fps: Option<f64>) -> Result<Reader, VideoError> {
        let mut file = fs::File::open(path).map_err(|error| cannot_read(path, error))?;
        let mut head = Vec::new();
        file.by_ref()
            .take(kind::HEAD_BYTES)
            .read_to_end(&mut head)
            .map_err(|error| cannot_read(path, error))?;
        Ok(match FileKind::of(&head) {
            FileKind::Mp4 => Reader::Mp4(mp4::Mp4Reader::open(path, file)?),
            FileKind::Y4m => Reader::Y4m(y4m::Y4mReader::open(path, file)?),
            FileKind::Png | FileKind::Jpeg => Reader::Folder(folder::FolderReader::of_one(path, fps)),
            FileKind::Other { what, remedy } => {
                let path = path.to_owned();
                return Err(VideoError::Unsupported {
                    path,
                    what: what.to_owned(),
                    remedy: remedy.to_owned(),
                });
            }
        })
    }

    /// The next unit, or `None` at the end. After an error there is nothing more.
    ///
    /// # Errors
    /// Damage, named together with the number of units before it.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        match &mut self.reader {
            Reader::Mp4(reader) => reader.next_unit(),
            Reader::Y4m(reader) => reader.next_unit(),
            Reader::Folder(reader) => reader.next_unit(),
        }
    }

    /// How many units there are, where the file says so.
    pub fn unit_count(&self) -> Option<u64> {
        match &self.reader {
            Reader::Mp4(reader) => Some(reader.unit_count()),
            Reader::Y4m(_) => None,
            Reader::Folder(reader) => Some(reader.unit_count()),
        }
    }
}
