//! Reads the entries of an MCAP file, up to its end or to where it is truncated.

use std::io::Read;

use bytes::Bytes;
use foxglove::messages::{CompressedImage, CompressedVideo};
use prost::Message as _;

use super::convert::Malformed;
use super::entry::Entry;
use super::record_lengths::{CheckedLengths, MAX_RECORD_BYTES};
use super::stored;
use super::topics::Topic;

/// A recording cannot be read further.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file is truncated (a killed process). Every entry before the end was returned.
    #[error("the recording is cut off: everything before the cut was read")]
    Truncated,
    /// The file is not MCAP, or damaged.
    #[error("this is not an MCAP recording, or a damaged one")]
    Container(#[source] mcap::McapError),
    /// A message does not conform to the schema of its topic.
    #[error("the message on {topic} cannot be understood: {reason}")]
    Message {
        /// The topic.
        topic: String,
        /// What is wrong with the message.
        reason: String,
    },
}

/// The entries of a recording, in order. Ignores topics of other programs.
pub struct RecordingReader<R: Read> {
    messages: mcap::io::MessageReader<CheckedLengths<R>>,
    /// A unit whose payload is the next video message.
    pending_unit: Option<stored::VideoUnit>,
    started: bool,
    ended: bool,
}

impl<R: Read> RecordingReader<R> {
    /// Reads from the beginning of a recording.
    pub fn new(input: R) -> Self {
        Self { messages: messages(input), pending_unit: None, started: false, ended: false }
    }

    fn next_entry(&mut self) -> Result<Option<Entry>, ReadError> {
        for message in self.messages.by_ref() {
            let message = match message {
                Ok(message) => message,
                Err(error) if self.started && is_truncation(&error) => return Err(ReadError::Truncated),
                Err(error) => return Err(ReadError::Container(error)),
            };
            let name = &message.channel.topic;
            let Some(topic) = Topic::from_name(name) else { continue };
            let entry = decode(topic, &message.data, &mut self.pending_unit)
                .map_err(|malformed| ReadError::Message { topic: name.clone(), reason: malformed.0 })?;
            if let Some(entry) = entry {
                self.started = true;
                return Ok(Some(entry));
            }
        }
        Ok(None)
    }
}

impl<R: Read> Iterator for RecordingReader<R> {
    type Item = Result<Entry, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let item = self.next_entry().transpose();
        self.ended = !matches!(item, Some(Ok(_)));
        item
    }
}

/// Reads the messages of an MCAP file.
pub(super) fn messages<R: Read>(input: R) -> mcap::io::MessageReader<CheckedLengths<R>> {
    let options = mcap::sans_io::LinearReaderOptions::default().with_record_length_limit(MAX_RECORD_BYTES);
    mcap::io::MessageReader::new_with_options(CheckedLengths::new(input), options)
}

pub(super) fn is_truncation(error: &mcap::McapError) -> bool {
    matches!(error, mcap::McapError::UnexpectedEof | mcap::McapError::BadFooter)
}

/// The entry of a message; `None` where the message only announces the next.
pub(super) fn decode(
    topic: Topic,
    data: &[u8],
    pending_unit: &mut Option<stored::VideoUnit>,
) -> Result<Option<Entry>, Malformed> {
    let mut unit = |payload: Bytes| match pending_unit.take() {
        Some(unit) => unit.with_payload(payload).map(|(video, unit)| Some(Entry::Unit(video, unit))),
        None => Err(Malformed("a picture that no unit announced".to_owned())),
    };
    Ok(Some(match topic {
        Topic::Start => Entry::Start(stored::RecordingStart::decode(data)?.try_into()?),
        Topic::VideoUnit => {
            *pending_unit = Some(stored::VideoUnit::decode(data)?);
            return Ok(None);
        }
        Topic::Video | Topic::SecondVideo => return unit(CompressedVideo::decode(data)?.data),
        Topic::VideoPicture | Topic::SecondPicture => return unit(CompressedImage::decode(data)?.data),
        Topic::VideoRaw | Topic::SecondRaw => return unit(stored::RawPicture::decode(data)?.samples.into()),
        Topic::InputFrame => stored::FrameInput::decode(data)?.try_into()?,
        Topic::InputLocalisation => stored::LocalisationInput::decode(data)?.try_into()?,
        Topic::InputTelemetry => stored::TelemetryInput::decode(data)?.try_into()?,
        Topic::InputDetections => stored::DetectionsInput::decode(data)?.try_into()?,
        Topic::InputRequest => stored::RequestInput::decode(data)?.try_into()?,
        Topic::InputTick => stored::TickInput::decode(data)?.into(),
        Topic::Outcome => Entry::Outcome(stored::Outcome::decode(data)?.try_into()?),
        // These repeat the outcomes.
        Topic::Annotations | Topic::Log | Topic::Location => return Ok(None),
        Topic::Truth => Entry::Truth(stored::WorldTruth::decode(data)?.into()),
        Topic::Note => stored::Note::decode(data)?.try_into()?,
    }))
}
