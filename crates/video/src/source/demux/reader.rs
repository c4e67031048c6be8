//! Reads a video file of any supported kind.

use std::fs::{self, File};
use std::io::{Read as _, Seek as _};
use std::path::Path;

use barrelman_media_protocol::source::SourceSettings;
use barrelman_vocab::unit::EncodedUnit;

use super::kind::{self, FileKind};
use super::media::MediaReader;
use super::{folder, mp4, y4m};
use crate::engine::VideoEngine;
use crate::error::{VideoError, cannot_read};
use crate::media::MediaProgram;
use crate::source::pipe::{OtherPipe, Pipe};
use crate::source::url::{VideoSource, VideoUrl};

/// Reads the units of a file or a folder in decoding order.
pub struct FileReader {
    reader: Reader,
    /// A pipe that the reader of another process has a name of.
    _pipe: Option<OtherPipe>,
}

enum Reader {
    Mp4(mp4::Mp4Reader),
    Y4m(y4m::Y4mReader),
    Folder(folder::FolderReader),
    Media(Box<MediaReader>),
}

impl FileReader {
    /// Opens a file, a folder or a pipe, and reads its index. A file that the built-in engine does not read
    /// is read by GStreamer, if that is installed and `url.engine` permits it.
    ///
    /// # Errors
    /// A file that is missing, unreadable, empty, or of an unsupported kind, or a damaged index. An address
    /// that is not a file counts as missing.
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        match &url.source {
            VideoSource::File(path) => Self::open_file(url, path),
            VideoSource::Pipe(path) => match Pipe::open(path)? {
                Pipe::Y4m(reader) => Ok(Reader::Y4m(reader).into()),
                Pipe::Other(pipe) => Self::open_pipe(url, path, pipe),
            },
            VideoSource::Rtsp { .. } | VideoSource::Media(_) => {
                Err(VideoError::Missing(url.to_string().into()))
            }
        }
    }

    fn open_file(url: &VideoUrl, path: &Path) -> Result<Self, VideoError> {
        let metadata = fs::metadata(path).map_err(|error| cannot_read(path, error))?;
        if metadata.is_dir() {
            return Ok(Reader::Folder(folder::FolderReader::open(path, url.fps)?).into());
        }
        let error = match open_built_in(path, url.fps) {
            Ok(reader) if url.engine == VideoEngine::Gstreamer && reader.is_video_file() => None,
            Ok(reader) => return Ok(reader.into()),
            Err(error @ VideoError::Unsupported { .. }) if url.engine != VideoEngine::BuiltIn => Some(error),
            Err(error) => return Err(error),
        };
        match (url.engine.media_program(), error) {
            (Some(program), _) => {
                let settings = SourceSettings::file(path.to_owned(), false);
                let reader = MediaReader::open(&program, settings, url.to_string())?;
                Ok(Reader::Media(Box::new(reader)).into())
            }
            (None, Some(VideoError::Unsupported { path, what, remedy })) => {
                let installation = MediaProgram::INSTALLATION;
                let remedy = format!("{remedy}; barrelman-media reads it, too: {installation}");
                Err(VideoError::Unsupported { path, what, remedy })
            }
            (None, _) => Err(VideoError::NoMedia { address: url.to_string() }),
        }
    }

    fn open_pipe(url: &VideoUrl, path: &Path, pipe: OtherPipe) -> Result<Self, VideoError> {
        let program = pipe.reading_program(url, path)?;
        let settings = SourceSettings::file(pipe.path.clone(), false);
        let reader = MediaReader::open(&program, settings, url.to_string())?;
        Ok(Self { reader: Reader::Media(Box::new(reader)), _pipe: Some(pipe) })
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
            Reader::Media(reader) => reader.next_unit(),
        }
    }

    /// Number of units, if the file states it.
    pub fn unit_count(&self) -> Option<u64> {
        match &self.reader {
            Reader::Mp4(reader) => Some(reader.unit_count()),
            Reader::Folder(reader) => Some(reader.unit_count()),
            Reader::Y4m(_) | Reader::Media(_) => None,
        }
    }
}

fn open_built_in(path: &Path, fps: Option<f64>) -> Result<Reader, VideoError> {
    let mut file = File::open(path).map_err(|error| cannot_read(path, error))?;
    let mut head = Vec::new();
    let read = file.by_ref().take(kind::HEAD_BYTES).read_to_end(&mut head);
    read.and_then(|_| file.rewind()).map_err(|error| cannot_read(path, error))?;
    Ok(match FileKind::detect(&head) {
        FileKind::Mp4 => Reader::Mp4(mp4::Mp4Reader::open(path, file)?),
        FileKind::Y4m => Reader::Y4m(y4m::Y4mReader::open(path, file)?),
        FileKind::Png | FileKind::Jpeg | FileKind::Webp | FileKind::Tiff => {
            Reader::Folder(folder::FolderReader::from_picture(path, fps))
        }
        FileKind::NotVideo { what } => return Err(VideoError::not_video(path, what)),
        FileKind::Other { what, remedy } => {
            let path = path.to_owned();
            return Err(VideoError::Unsupported { path, what: what.to_owned(), remedy: remedy.to_owned() });
        }
    })
}

impl Reader {
    /// Whether GStreamer may read the same file.
    const fn is_video_file(&self) -> bool {
        matches!(self, Self::Mp4(_))
    }
}

impl From<Reader> for FileReader {
    fn from(reader: Reader) -> Self {
        Self { reader, _pipe: None }
    }
}
