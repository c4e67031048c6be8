//! Reads a video file of any supported kind.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use barrelman_vocab::unit::EncodedUnit;

use super::kind::{self, FileKind};
use super::{folder, mp4, y4m};
use crate::error::{VideoError, cannot_read};
use crate::source::url::{VideoSource, VideoUrl};

/// Reads the units of a file or a folder in decoding order.
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
    /// A file that is missing, unreadable, empty, or of an unsupported kind, or a damaged index. An address that is not a
    /// file counts as missing.
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        let path = match &url.source {
            VideoSource::File(path) => path,
            VideoSource::Rtsp { .. } => return Err(VideoError::Missing(url.to_string().into())),
        };
        let metadata = fs::metadata(path).map_err(|error| cannot_read(path, error))?;
        let reader = if metadata.is_dir() {
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
        Ok(match FileKind::detect(&head) {
            FileKind::Mp4 => Reader::Mp4(mp4::Mp4Reader::open(path, file)?),
            FileKind::Y4m => Reader::Y4m(y4m::Y4mReader::open(path, file)?),
            FileKind::Png | FileKind::Jpeg => Reader::Folder(folder::FolderReader::from_picture(path, fps)),
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

    /// The next unit, or `None` at the end. No unit follows an error.
    ///
    /// # Errors
    /// Damage; the message states the number of units before it.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        match &mut self.reader {
            Reader::Mp4(reader) => reader.next_unit(),
            Reader::Y4m(reader) => reader.next_unit(),
            Reader::Folder(reader) => reader.next_unit(),
        }
    }

    /// Number of units, if the file states it.
    pub fn unit_count(&self) -> Option<u64> {
        match &self.reader {
            Reader::Mp4(reader) => Some(reader.unit_count()),
            Reader::Y4m(_) => None,
            Reader::Folder(reader) => Some(reader.unit_count()),
        }
    }
}
