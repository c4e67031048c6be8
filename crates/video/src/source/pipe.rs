//! Pipes that another program writes to: Y4M, or what GStreamer recognises.

use std::fs::File;
use std::io::Read as _;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

use rustix::pipe::{SpliceFlags, pipe, tee};

use super::demux::kind::{FileKind, HEAD_BYTES};
use super::demux::y4m::Y4mReader;
use crate::error::{VideoError, cannot_read};
use crate::media::MediaProgram;
use crate::url::VideoUrl;

/// An open pipe, of which nothing has been read.
pub(super) enum Pipe {
    /// Y4M, whose header has been read.
    Y4m(Y4mReader),
    /// Anything else.
    Other(OtherPipe),
}

/// A pipe whose content GStreamer must recognise.
pub(super) struct OtherPipe {
    /// Stays open as long as `path` is used.
    _file: File,
    /// A name of the open pipe for another process.
    pub(super) path: PathBuf,
    /// The kind of the content.
    kind: FileKind,
}

impl Pipe {
    /// Opens a pipe and waits for its first bytes.
    ///
    /// # Errors
    /// A pipe that cannot be read, what is no pipe, or a Y4M header that is not supported.
    pub(super) fn open(path: &Path) -> Result<Self, VideoError> {
        let file = File::open(path).map_err(|error| cannot_read(path, error))?;
        if !file.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo()) {
            return Err(VideoError::NoPipe(path.to_owned()));
        }
        let head = peek(&file).map_err(|error| cannot_read(path, error.into()))?;
        Ok(match FileKind::detect(&head) {
            FileKind::Y4m => Self::Y4m(Y4mReader::open(path, file)?),
            kind => {
                let name = format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd());
                Self::Other(OtherPipe { _file: file, path: name.into(), kind })
            }
        })
    }
}

impl OtherPipe {
    /// The program that reads the pipe.
    ///
    /// # Errors
    /// A content that is no video, or a program that is missing or must not be used.
    pub(super) fn reading_program(&self, url: &VideoUrl, path: &Path) -> Result<MediaProgram, VideoError> {
        if let FileKind::NotVideo { what } = self.kind {
            return Err(VideoError::not_video(path, what));
        }
        url.engine.media_program().ok_or_else(|| VideoError::NoMedia { address: url.to_string() })
    }
}

/// The bytes at the head of a pipe, which stay in it.
fn peek(file: &File) -> Result<Vec<u8>, rustix::io::Errno> {
    let (copy, to) = pipe()?;
    tee(file, &to, HEAD_BYTES as usize, SpliceFlags::empty())?;
    drop(to);
    let mut head = Vec::new();
    // A pipe of this process, which is closed at its end.
    let _ = File::from(copy).read_to_end(&mut head);
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_given_as_a_pipe_is_told() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
        let Err(error) = Pipe::open(path) else { panic!("it is a file") };
        assert!(error.to_string().contains("is no pipe: give the path of the file"), "{error}");
    }
}
