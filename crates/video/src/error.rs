//! The errors of this crate. Each says what happened, where, and what to do.

use std::io;
use std::path::{Path, PathBuf};

use crate::media::{MediaError, MediaProgram};

/// A file, a folder or a stream that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VideoError {
    /// The file or the folder does not exist.
    #[error("no file or folder `{}`: check the path (relative paths start in the current folder)", .0.display())]
    Missing(PathBuf),
    /// The operating system returned an error.
    #[error("cannot {doing} `{}`: {cause}", .path.display())]
    Io {
        /// The operation: "read", "create", "write".
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// The kind of the file is not supported.
    #[error("`{}` is {what}, which is not read here. {remedy}", .path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The kind, with its article: "a Matroska (MKV, WebM) file".
        what: String,
        /// How to convert it.
        remedy: String,
    },
    /// The file holds no video.
    #[error(
        "`{}` is {what}. Give a video file (MP4, Matroska, MPEG-TS, AVI, Y4M) or a folder of PNG or JPEG pictures",
        .path.display()
    )]
    NotVideo {
        /// The file.
        path: PathBuf,
        /// What it is, with its article.
        what: &'static str,
    },
    /// The path, or the standard input, is not a pipe.
    #[error("`{}` is no pipe: give the path of the file", .0.display())]
    NoPipe(PathBuf),
    /// The file is damaged.
    #[error("`{}` is damaged after {units} pictures: {what}", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Number of pictures before the damage, all of which were delivered.
        units: u64,
        /// What is wrong.
        what: String,
    },
    /// A picture cannot be decoded.
    #[error("{address}: {cause}")]
    Decode {
        /// The path or the address of the source.
        address: String,
        /// The decoder's error.
        cause: DecodeError,
    },
    /// A stream that was reached and cannot be used.
    #[error("`{address}` {what}. {remedy}")]
    Stream {
        /// The address, without its password.
        address: String,
        /// What is wrong with it, with a verb.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// The thread cannot be started.
    #[error("cannot start the video thread: {0}")]
    Thread(io::Error),
    /// The program of the second engine cannot be used.
    #[error(transparent)]
    Media(#[from] MediaError),
    /// A source that only the second engine reads, which is not installed.
    #[error(
        "`{address}` is read by barrelman-media, which is not beside this program: {}",
        MediaProgram::INSTALLATION
    )]
    NoMedia {
        /// The address, without its password.
        address: String,
    },
    /// A source of another crate, such as a simulated world, cannot start.
    #[error("{reason}")]
    Provided {
        /// What is wrong with the source.
        reason: String,
    },
    /// A picture cannot be encoded.
    #[error("cannot encode a picture of {size}: {reason}")]
    Encode {
        /// The size of the picture.
        size: barrelman_vocab::image::PictureSize,
        /// The encoder's error.
        reason: String,
    },
}

/// A unit that cannot be decoded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The kind of the stream is not supported.
    #[error("the video is {what}, which is not decoded here. {remedy}")]
    Unsupported {
        /// The kind: "interlaced H.264".
        what: String,
        /// How to convert it.
        remedy: String,
    },
    /// The unit is damaged. Decoding continues with the next key frame.
    #[error("picture {index} is damaged ({reason}): nothing is shown until the next key frame")]
    Damaged {
        /// The number of the unit.
        index: u64,
        /// The decoder's error.
        reason: String,
    },
    /// The decoder cannot be created.
    #[error("the {format} decoder cannot start: {reason}")]
    NoDecoder {
        /// The format.
        format: &'static str,
        /// Why.
        reason: String,
    },
}

impl DecodeError {
    /// Whether no later unit of the stream can be decoded.
    pub const fn is_final(&self) -> bool {
        !matches!(self, Self::Damaged { .. })
    }
}

impl VideoError {
    pub(crate) fn not_video(path: &Path, what: &'static str) -> Self {
        Self::NotVideo { path: path.to_owned(), what }
    }
}

/// The error of a file that cannot be opened or read.
pub(crate) fn cannot_read(path: &Path, source: io::Error) -> VideoError {
    let path = path.to_owned();
    match source.kind() {
        io::ErrorKind::NotFound => VideoError::Missing(path),
        _ => VideoError::Io { doing: "read", path, cause: source },
    }
}
