//! Reads all frames of a file one after the other, for offline use: no frame is dropped, and nothing waits for a clock.

use std::collections::VecDeque;

use barrelman_vocab::video::VideoFrame;

use super::demux::FileReader;
use super::url::VideoUrl;
use crate::codec::decoder::{DecodeMode, UnitDecoder};
use crate::error::{DecodeError, VideoError};

/// The frames of a file or a folder, in the order of display.
pub struct FileFrames {
    address: String,
    reader: FileReader,
    decoder: UnitDecoder,
    ready: VecDeque<VideoFrame>,
    error: Option<VideoError>,
    ended: bool,
}

impl FileFrames {
    /// Opens a file or a folder.
    ///
    /// # Errors
    /// As [`FileReader::open`].
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        Ok(Self {
            address: url.to_string(),
            reader: FileReader::open(url)?,
            decoder: UnitDecoder::new(DecodeMode::File),
            ready: VecDeque::new(),
            error: None,
            ended: false,
        })
    }

    /// Upper bound of the number of frames, if the file states one.
    pub fn frame_count(&self) -> Option<u64> {
        self.reader.unit_count()
    }

    /// The next frame, or `None` at the end. Reads and decodes on the calling thread.
    ///
    /// # Errors
    /// Damage in the file. All intact frames before it are returned first. After a damaged picture
    /// ([`DecodeError::Damaged`]) the next call continues with the next key frame; after any other error no frame
    /// follows.
    pub fn next_frame(&mut self) -> Result<Option<VideoFrame>, VideoError> {
        loop {
            if let Some(frame) = self.ready.pop_front() {
                return Ok(Some(frame));
            }
            if let Some(error) = self.error.take() {
                return Err(error);
            }
            if self.ended {
                return Ok(None);
            }
            self.decode_next_unit();
        }
    }

    fn decode_next_unit(&mut self) {
        let mut out = |frame| self.ready.push_back(frame);
        let result = match self.reader.next_unit() {
            Ok(Some(unit)) => self
                .decoder
                .decode(&unit, &mut out)
                .map_err(|cause| VideoError::Decode { address: self.address.clone(), cause }),
            Ok(None) => {
                self.ended = true;
                Ok(())
            }
            Err(error) => Err(error),
        };
        if let Err(error) = result {
            let may_continue = matches!(error, VideoError::Decode { cause: DecodeError::Damaged { .. }, .. });
            self.error = Some(error);
            self.ended |= !may_continue;
        }
        if self.ended {
            self.decoder.finish(&mut out);
        }
    }
}
