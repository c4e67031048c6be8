//! Reads MP4 and QuickTime files with H.264: the index at the start, each picture on request.
//!
//! Other tracks are ignored. A truncated file gives its complete pictures and then an error.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use bytes::Bytes;

use super::mp4_boxes::{TopLevelBox, top_level};
use super::mp4_index::{Index, IndexError};
use super::stamp::capture_at;
use crate::error::{VideoError, cannot_read};
use barrelman_vocab::unit::{EncodedUnit, UnitCodec};

/// Maximum size of the index, bytes. 20 hours take about 40 MB.
const MAX_INDEX_BYTES: u64 = 512 << 20;

/// Maximum size of one picture, bytes.
const MAX_SAMPLE_BYTES: u32 = 64 << 20;

/// Reads the pictures of an MP4 file one by one.
pub struct Mp4Reader {
    path: PathBuf,
    file: File,
    file_size: u64,
    index: Index,
    next: usize,
    units: u64,
    ended: bool,
}

impl Mp4Reader {
    /// Reads the index.
    ///
    /// # Errors
    /// A missing or damaged index, or another codec.
    pub fn open(path: &Path, file: File) -> Result<Self, VideoError> {
        let failed = |error| cannot_read(path, error);
        let damaged =
            |what: &str| VideoError::Damaged { path: path.to_owned(), units: 0, what: what.to_owned() };
        let file_size = file.metadata().map_err(failed)?.len();
        let boxes = top_level(&file, file_size).map_err(failed)?;
        let moov = boxes.iter().find(|found| found.kind == *b"moov" && found.end <= file_size);
        let moov = moov.ok_or_else(|| {
            damaged(
                "its index (moov) is missing, because the file was cut off or never finished. Copy it again, \
                 or repair it with `untrunc` and a whole recording of the same camera",
            )
        })?;
        let content = |found: &TopLevelBox| {
            if found.end - found.content > MAX_INDEX_BYTES {
                return Err(io::Error::other("its index is larger than 512 MiB"));
            }
            let mut content = vec![0; (found.end - found.content) as usize];
            file.read_exact_at(&mut content, found.content)?;
            Ok(content)
        };
        let mut fragments = Vec::new();
        for moof in boxes.iter().filter(|found| found.kind == *b"moof" && found.end <= file_size) {
            fragments.push((moof.start, content(moof).map_err(failed)?));
        }
        let moov = content(moov).map_err(failed)?;
        let index = Index::parse(&moov, &fragments).map_err(|error| match error {
            IndexError::Malformed(what) => damaged(what),
            IndexError::Unsupported { what, remedy } => {
                VideoError::Unsupported { path: path.to_owned(), what, remedy: remedy.to_owned() }
            }
        })?;
        if index.samples.is_empty() {
            return Err(damaged("its video track holds no picture"));
        }
        Ok(Self { path: path.to_owned(), file, file_size, index, next: 0, units: 0, ended: false })
    }

    /// Number of pictures in the index.
    pub fn unit_count(&self) -> u64 {
        self.index.samples.len() as u64
    }

    /// The next picture in decoding order.
    ///
    /// # Errors
    /// A picture beyond the end of the file, or data that is not H.264.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        if self.ended {
            return Ok(None);
        }
        // An empty sample is a pause in the video, not a picture.
        while self.index.samples.get(self.next).is_some_and(|sample| sample.size == 0) {
            self.next += 1;
        }
        let Some(sample) = self.index.samples.get(self.next).copied() else { return Ok(None) };
        self.ended = true;
        if sample.offset.saturating_add(u64::from(sample.size)) > self.file_size {
            return Err(self.damaged("the rest of the file is missing. Copy it again"));
        }
        if sample.size > MAX_SAMPLE_BYTES {
            return Err(self.damaged("the next one is larger than 64 MiB"));
        }
        let mut bytes = vec![0; sample.size as usize];
        self.file.read_exact_at(&mut bytes, sample.offset).map_err(|error| cannot_read(&self.path, error))?;
        let configuration = &self.index.configurations[usize::from(sample.configuration)];
        let unit = configuration
            .to_annex_b(&bytes)
            .map_err(|_| self.damaged("the next one is not H.264, or is overwritten"))?;
        let index = self.units;
        self.units += 1;
        self.next += 1;
        self.ended = false;
        Ok(Some(EncodedUnit {
            epoch: 0,
            index,
            capture: capture_at(sample.time, u64::from(self.index.ticks_per_second)),
            key: unit.key,
            shown: sample.shown,
            rotation: self.index.rotation,
            codec: UnitCodec::H264AnnexB,
            payload: Bytes::from(unit.bytes),
        }))
    }

    fn damaged(&self, what: &str) -> VideoError {
        VideoError::Damaged { path: self.path.clone(), units: self.units, what: what.to_owned() }
    }
}
