//! Every frame of a recording, one after the other, for offline use: nothing is dropped and nothing waits for a
//! clock.

use std::collections::VecDeque;

use barrelman_vocab::video::VideoFrame;

use super::demux::FileReader;
use super::url::VideoUrl;
use crate::codec::decoder::{DecodeMode, UnitDecoder};
use crate::error::{DecodeError, VideoError};

/// The frames of a file or a folder, in the order of display.
pub struct FileFrames {
    place: String,
    reader: FileReader,
    decoder: UnitDecoder,
    ready: VecDeque<VideoFrame>,
    failed: Option<VideoError>,
    ended: bool,
}

impl FileFrames {
    /// Opens a file or a folder.
    ///
    /// # Errors
    /// Whatever [`FileReader::open`] finds.
    pub fn open(url: &VideoUrl) -> Result<Self, VideoError> {
        Ok(Self {
            place: url.to_string(),
            reader: FileReader::open(url)?,
            decoder: UnitDecoder::new(DecodeMode::File),
            ready: VecDeque::new(),
            failed: None,
            ended: false,
        })
    }

    /// How many frames there are at most, where the file says so.
    pub fn frame_count(&self) -> Option<u64> {
        self.reader.unit_count()
    }

    /// The next frame, or `None` at the end. All of reading and decoding happens in here, on the calling
    /// thread, so that its time can be measured apart from what is done with the frame.
    ///
    /// # Errors
    /// Damage in the file. All whole frames before it come first. After a single damaged picture
    /// ([`DecodeError::Damaged`]) the caller may go on, with the next key frame; after any other error there
    /// is nothing more.
    pub fn next_frame(&mut self) -> Result<Option<VideoFrame>, VideoError> {
        loop {
            if let Some(frame) = self.ready.pop_front() {
                return Ok(Some(frame));
            }
            if let Some(error) = self.failed.take() {
                return Err(error);
            }
            if self.ended {
                return Ok(None);
            }
            self.read_on();
        }
    }

    fn read_on(&mut self) {
        let mut out = |frame| self.ready.push_back(frame);
        let result = match self.reader.next_unit() {
            Ok(Some(unit)) => self
                .decoder
                .decode(&unit, &mut out)
                .map_err(|cause| VideoError::Decode { place: self.place.clone(), cause }),
            Ok(None) => {
                self.ended = true;
                Ok(())
            }
            Err(error) => Err(error),
        };
        if let Err(error) = result {
            let may_go_on = matches!(error, VideoError::Decode { cause: DecodeError::Damaged { .. }, .. });
            self.failed = Some(error);
            self.ended |= !may_go_on;
        }
        if self.ended {
            self.decoder.finish(&mut out);
        }
    }
}
