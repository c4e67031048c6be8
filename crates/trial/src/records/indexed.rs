//! Reads a recording from any time on, by the index at the end of its file.
//!
//! The times of messages: a unit's is its capture's, an input's and an outcome's that of the step.

use std::io::{self, Read, Seek, SeekFrom};

use barrelman_vocab::{Timestamp, VideoNumber};
use mcap::sans_io::indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions, ReadOrder};
use mcap::{McapError, Summary};
use prost::Message as _;

use super::convert::Malformed;
use super::entry::{Entry, RecordingStart};
use super::reader::{ReadError, decode};
use super::record_lengths::MAX_RECORD_BYTES;
use super::stored;
use super::stored_sortie::{sortie_of, summary_of};
use super::topics::Topic;
use crate::sortie::Sortie;

/// The topics of videos and steps; the others repeat them for other programs.
const TOPICS: [Topic; 14] = [
    Topic::VideoUnit,
    Topic::Video,
    Topic::VideoPicture,
    Topic::VideoRaw,
    Topic::SecondVideo,
    Topic::SecondPicture,
    Topic::SecondRaw,
    Topic::InputFrame,
    Topic::InputLocalisation,
    Topic::InputTelemetry,
    Topic::InputDetections,
    Topic::InputRequest,
    Topic::InputTick,
    Topic::Outcome,
];

/// A recording that was ended in order, and so has an index.
pub struct IndexedRecording<R> {
    input: R,
    summary: Summary,
    start: RecordingStart,
}

impl<R: Read + Seek> IndexedRecording<R> {
    /// Reads index and start of a recording. `None`: it has no index, as it was cut off.
    ///
    /// # Errors
    /// If the input cannot be read, or is no recording.
    pub fn open(mut input: R) -> Result<Option<Self>, ReadError> {
        let bytes = input.seek(SeekFrom::End(0)).map_err(io_error)?;
        input.rewind().map_err(io_error)?;
        let Ok(Some(summary)) = summary_of(&mut input, bytes) else { return Ok(None) };
        let mut start = None;
        let options = IndexedReaderOptions::new().include_topics([Topic::Start.name()]);
        read(&mut input, &summary, options, |_, data| {
            start = Some(RecordingStart::try_from(stored::RecordingStart::decode(data)?)?);
            Ok(false)
        })?;
        Ok(start.map(|start| Self { input, summary, start }))
    }

    /// Program, configuration and clocks of the run.
    pub const fn start(&self) -> &RecordingStart {
        &self.start
    }

    /// The time of the newest unit of a video, at or before `at`, with which decoding can start.
    ///
    /// # Errors
    /// If the input cannot be read, or is damaged.
    pub fn key_unit_before(
        &mut self,
        video: VideoNumber,
        at: Timestamp,
    ) -> Result<Option<Timestamp>, ReadError> {
        let options = IndexedReaderOptions::new()
            .include_topics([Topic::VideoUnit.name()])
            .with_order(ReadOrder::ReverseLogTime)
            .ending_at(self.log_time(at));
        let mut found = None;
        read(&mut self.input, &self.summary, options, |_, data| {
            let unit = stored::VideoUnit::decode(data)?;
            if unit.key && unit.second == (video == VideoNumber::Second) {
                found = Some(Timestamp::from_nanos(unit.captured_ns));
            }
            Ok(found.is_none())
        })?;
        Ok(found)
    }

    /// Gives the entries of the videos and the steps from a time on, in the order of their times, until
    /// `each` returns false.
    ///
    /// # Errors
    /// If the input cannot be read, or is damaged.
    pub fn entries_from(
        &mut self,
        at: Timestamp,
        mut each: impl FnMut(Entry) -> bool,
    ) -> Result<(), ReadError> {
        let options = IndexedReaderOptions::new()
            .include_topics(TOPICS.map(Topic::name))
            .starting_at(self.log_time(at));
        let mut pending = None;
        read(&mut self.input, &self.summary, options, |topic, data| {
            let entry = decode(topic, data, &mut pending)?;
            Ok(entry.is_none_or(&mut each))
        })
    }

    /// The first thing from a time on that `wanted` takes from an entry.
    ///
    /// # Errors
    /// As [`Self::entries_from`].
    pub fn find_from<T>(
        &mut self,
        at: Timestamp,
        mut wanted: impl FnMut(Entry) -> Option<T>,
    ) -> Result<Option<T>, ReadError> {
        let mut found = None;
        self.entries_from(at, |entry| {
            found = wanted(entry);
            found.is_none()
        })?;
        Ok(found)
    }

    /// The summary of the sortie, where the recording holds one.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub fn sortie(&mut self) -> io::Result<Option<Sortie>> {
        sortie_of(&mut self.input, &self.summary)
    }

    const fn log_time(&self, at: Timestamp) -> u64 {
        self.start.unix_ns.saturating_add(at.as_nanos())
    }
}

fn io_error(error: io::Error) -> ReadError {
    ReadError::Container(McapError::Io(error))
}

/// Reads messages until `each` returns false.
fn read<R: Read + Seek>(
    input: &mut R,
    summary: &Summary,
    options: IndexedReaderOptions,
    mut each: impl FnMut(Topic, &[u8]) -> Result<bool, Malformed>,
) -> Result<(), ReadError> {
    let mut reader =
        IndexedReader::new_with_options(summary, options.with_record_length_limit(MAX_RECORD_BYTES))
            .map_err(ReadError::Container)?;
    let mut buffer = Vec::new();
    while let Some(event) = reader.next_event() {
        match event.map_err(ReadError::Container)? {
            IndexedReadEvent::ReadChunkRequest { offset, length } => {
                if length > MAX_RECORD_BYTES {
                    return Err(ReadError::Container(McapError::ChunkTooLarge(length as u64)));
                }
                buffer.resize(length, 0);
                input.seek(SeekFrom::Start(offset)).map_err(io_error)?;
                input.read_exact(&mut buffer).map_err(io_error)?;
                reader.insert_chunk_record_data(offset, &buffer).map_err(ReadError::Container)?;
            }
            IndexedReadEvent::Message { header, data } => {
                let Some(channel) = summary.channels.get(&header.channel_id) else { continue };
                let Some(topic) = Topic::from_name(&channel.topic) else { continue };
                let goes_on = each(topic, data).map_err(|malformed| ReadError::Message {
                    topic: channel.topic.clone(),
                    reason: malformed.0,
                })?;
                if !goes_on {
                    break;
                }
            }
        }
    }
    Ok(())
}
