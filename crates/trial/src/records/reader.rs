//! Reads the entries of an MCAP file, up to its end or its cut.

use std::io::Read;

use bytes::Bytes;
use foxglove::messages::{CompressedImage, CompressedVideo};
use prost::Message as _;

use super::convert::Malformed;
use super::entry::Entry;
use super::framing::Framed;
use super::stored;
use super::topics::Topic;

/// A recording could not be read on.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It ends in the middle, as that of a killed process does. Everything before was read.
    #[error("the recording is cut off: everything before the cut was read")]
    CutOff,
    /// It is no MCAP file, or a damaged one.
    #[error("this is not an MCAP recording, or a damaged one")]
    Container(#[source] mcap::McapError),
    /// A message does not have the form that its topic promises.
    #[error("the message on {topic} cannot be understood: {reason}")]
    Message {
        /// The topic.
        topic: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// The entries of a recording, in order. Topics that are not ours are passed over.
pub struct RecordingReader<R: Read> {
    messages: mcap::io::MessageReader<Framed<R>>,
    /// A unit whose payload comes with the next video message.
    announced: Option<stored::VideoUnit>,
    started: bool,
    ended: bool,
}

impl<R: Read> RecordingReader<R> {
    /// Reads from the beginning of a recording.
    pub fn new(input: R) -> Self {
        Self { messages: messages(input), announced: None, started: false, ended: false }
    }

    fn next_entry(&mut self) -> Result<Option<Entry>, ReadError> {
        for message in self.messages.by_ref() {
            let message = match message {
                Ok(message) => message,
                Err(error) if self.started && is_cut(&error) => return Err(ReadError::CutOff),
                Err(error) => return Err(ReadError::Container(error)),
            };
            let name = &message.channel.topic;
            let Some(topic) = Topic::named(name) else { continue };
            let entry = read(topic, &message.data, &mut self.announced)
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

/// The longest record that is read, bytes: more than a raw picture of 7680 x 4320 needs. A damaged length must not
/// make the reader ask for more memory than there is.
const LONGEST_RECORD: usize = 64 << 20;

/// The messages of an MCAP file.
pub(super) fn messages<R: Read>(input: R) -> mcap::io::MessageReader<Framed<R>> {
    let options = mcap::sans_io::LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    mcap::io::MessageReader::new_with_options(Framed::new(input), options)
}

pub(super) fn is_cut(error: &mcap::McapError) -> bool {
    matches!(error, mcap::McapError::UnexpectedEof | mcap::McapError::BadFooter)
}

fn read(
    topic: Topic,
    data: &[u8],
    announced: &mut Option<stored::VideoUnit>,
) -> Result<Option<Entry>, Malformed> {
    let mut unit = |payload: Bytes| match announced.take() {
        Some(unit) => unit.with(payload).map(|unit| Some(Entry::Unit(unit))),
        None => Err(Malformed("a picture that no unit announced".to_owned())),
    };
    Ok(Some(match topic {
        Topic::Start => Entry::Start(stored::RecordingStart::decode(data)?.into()),
        Topic::VideoUnit => {
            *announced = Some(stored::VideoUnit::decode(data)?);
            return Ok(None);
        }
        Topic::Video => return unit(CompressedVideo::decode(data)?.data),
        Topic::VideoPicture => return unit(CompressedImage::decode(data)?.data),
        Topic::VideoRaw => return unit(stored::RawPicture::decode(data)?.samples.into()),
        Topic::InputFrame => stored::FrameInput::decode(data)?.try_into()?,
        Topic::InputLocalisation => stored::LocalisationInput::decode(data)?.try_into()?,
        Topic::InputTelemetry => stored::TelemetryInput::decode(data)?.try_into()?,
        Topic::InputRequest => stored::RequestInput::decode(data)?.try_into()?,
        Topic::InputTick => stored::TickInput::decode(data)?.into(),
        Topic::Outcome => Entry::Outcome(stored::Outcome::decode(data)?.try_into()?),
        Topic::Truth => Entry::Truth(stored::WorldTruth::decode(data)?.into()),
    }))
}
