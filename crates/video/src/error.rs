//! What can go wrong with a video: each error says what, where, and how to mend it.

use std::io;
use std::path::{Path, PathBuf};

/// A file, a folder or a stream that cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VideoError {
    /// There is nothing of that name.
    #[error("no file or folder `{}`: check the path (relative paths start in the current folder)", .0.display())]
    Missing(PathBuf),
    /// The operating system refused.
    #[error("cannot {doing} `{}`: {cause}", .path.display())]
    Io {
        /// What was tried: "read", "create".
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// The file is of a kind that is not read here.
    #[error("`{}` is {what}, which is not read here. {remedy}", .path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it is: "a Matroska (MKV, WebM) file".
        what: String,
        /// How to make it readable.
        remedy: String,
    },
    /// The file does not hold what it promises.
    #[error("`{}` is damaged after {units} pictures: {what}", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Pictures read before the damage, which were delivered.
        units: u64,
        /// What is wrong.
        what: String,
    },
    /// A picture cannot be decoded.
    #[error("{place}: {cause}")]
    Decode {
        /// The file or the address.
        place: String,
        /// What is wrong with it.
        cause: DecodeError,
    },
    /// A stream that was reached but can never be shown.
    #[error("`{place}` {what}. {remedy}")]
    Stream {
        /// The address, without its password.
        place: String,
        /// What it is.
        what: String,
        /// How to mend it.
        remedy: String,
    },
    /// The thread cannot be started.
    #[error("cannot start the video thread: {0}")]
    Thread(io::Error),
    /// A source that another crate provides, such as a simulated world, cannot start.
    #[error("{reason}")]
    Provided {
        /// What is wrong with the source.
        reason: String,
    },
    /// A picture cannot be encoded.
    #[error("cannot encode a picture of {size}: {reason}")]
    Encode {
        /// Its size.
        size: barrelman_vocab::image::PictureSize,
        /// What the encoder said.
        reason: String,
    },
}

/// A unit that gives no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The stream is of a kind that is not decoded here, however often one tries.
    #[error("the video is {what}, which is not decoded here. {remedy}")]
    Unsupported {
        /// What it is: "interlaced".
        what: String,
        /// How to make it readable.
        remedy: String,
    },
    /// This unit is damaged; decoding goes on with the next key frame.
    #[error("picture {index} is damaged ({reason}): nothing is shown until the next key frame")]
    Damaged {
        /// Which unit.
        index: u64,
        /// What the decoder said.
        reason: String,
    },
    /// The decoder itself cannot be made.
    #[error("the H.264 decoder cannot start: {0}")]
    NoDecoder(String),
}

impl DecodeError {
    /// Whether no later unit of the same stream can be decoded either.
    pub const fn is_final(&self) -> bool {
        !matches!(self, Self::Damaged { .. })
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
