//! Writes entries as an MCAP file.
//!
//! Messages collect in a chunk in memory; [`RecordingWriter::flush`] closes the chunk and writes it to the
//! output, so that a killed process loses only the entries after the last flush.

use std::collections::BTreeMap;
use std::io::Write;

use barrelman_pilot::Mode;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{EncodedUnit, Timestamp, VehicleProfile, VideoNumber};
use foxglove::messages::{CompressedImage, CompressedVideo};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;

use super::entry::{Entry, RecordedOutcome, RecordingStart};
use super::foxglove_view;
use super::live_channels::LiveChannels;
use super::recorded_input::RecordedInput;
use super::stored;
use super::stored_sortie;
use super::topics::Topic;
use crate::sortie::{Sortie, SortieObserver};

/// A recording could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the recording cannot be written")]
pub struct WriteError(#[from] mcap::McapError);

/// Where the pictures of a codec stand, with Foxglove's name of the format.
enum Channel {
    Video(&'static str),
    Picture(&'static str),
    Raw,
}

impl Channel {
    const fn of(codec: UnitCodec) -> Self {
        match codec {
            UnitCodec::H264AnnexB => Self::Video("h264"),
            UnitCodec::H265AnnexB => Self::Video("h265"),
            UnitCodec::Vp9 => Self::Video("vp9"),
            UnitCodec::Av1 => Self::Video("av1"),
            UnitCodec::Jpeg => Self::Picture("jpeg"),
            UnitCodec::Png => Self::Picture("png"),
            UnitCodec::RawYuv420 { .. } => Self::Raw,
        }
    }

    const fn topic(&self, video: VideoNumber) -> Topic {
        match (self, video) {
            (Self::Video(_), VideoNumber::First) => Topic::Video,
            (Self::Picture(_), VideoNumber::First) => Topic::VideoPicture,
            (Self::Raw, VideoNumber::First) => Topic::VideoRaw,
            (Self::Video(_), VideoNumber::Second) => Topic::SecondVideo,
            (Self::Picture(_), VideoNumber::Second) => Topic::SecondPicture,
            (Self::Raw, VideoNumber::Second) => Topic::SecondRaw,
        }
    }
}

/// Writes an MCAP file.
pub struct RecordingWriter<W: Write> {
    writer: mcap::Writer<NoSeek<W>>,
    channels: BTreeMap<Topic, u16>,
    unix_start_ns: u64,
    /// The region that is drawn for other programs.
    region: RegionShares,
    observer: SortieObserver,
    last_mode: Option<Mode>,
    /// Where each message goes, too.
    live: Option<LiveChannels>,
    sequence: u32,
    buffer: Vec<u8>,
}

impl<W: Write> RecordingWriter<W> {
    /// Begins a recording with its start. `profile`: of the vehicle, for the summary and for what other
    /// programs show.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn begin(output: W, start: &RecordingStart, profile: &VehicleProfile) -> Result<Self, WriteError> {
        let mut writer = mcap::WriteOptions::new()
            .profile("")
            .library(format!("barrelman {}", start.program))
            .compression(None)
            // Chunks are written whole, with their length in front: the output need not seek.
            .disable_seeking(true)
            .create(NoSeek::new(output))?;
        let mut channels = BTreeMap::new();
        for topic in Topic::ALL {
            channels.insert(topic, topic.register(&mut writer)?);
        }
        let mut recording = Self {
            writer,
            channels,
            unix_start_ns: start.unix_ns,
            region: profile.region,
            observer: SortieObserver::new(profile.clone()),
            last_mode: None,
            live: None,
            sequence: 0,
            buffer: Vec::new(),
        };
        recording.observer.begin(start);
        recording.write_message(Topic::Start, Timestamp::ZERO, &stored::RecordingStart::from(start))?;
        Ok(recording)
    }

    /// The same recording, whose messages are passed on from now on, too.
    #[must_use]
    pub fn with_live(self, live: Option<LiveChannels>) -> Self {
        Self { live, ..self }
    }

    /// Adds an entry.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn write(&mut self, entry: &Entry) -> Result<(), WriteError> {
        self.observer.add(entry);
        match entry {
            Entry::Start(start) => {
                self.write_message(Topic::Start, Timestamp::ZERO, &stored::RecordingStart::from(start))
            }
            Entry::Unit(video, unit) => self.write_unit(*video, unit),
            Entry::Input { step, now, input } => self.write_input(*step, *now, input),
            Entry::Outcome(outcome) => {
                self.write_message(Topic::Outcome, outcome.at, &stored::Outcome::from(outcome))?;
                self.show(outcome)
            }
            Entry::Note { at, note } => {
                let text = note.text.as_str().to_owned();
                self.write_message(Topic::Note, *at, &stored::Note { at_ns: at.as_nanos(), text })
            }
            Entry::Truth(truth) => {
                self.write_message(Topic::Truth, truth.at, &stored::WorldTruth::from(truth))
            }
        }
    }

    fn write_unit(&mut self, video: VideoNumber, unit: &EncodedUnit) -> Result<(), WriteError> {
        let at = unit.capture.at;
        self.write_message(Topic::VideoUnit, at, &stored::VideoUnit::announcing(video, unit))?;
        let timestamp = Some(self.foxglove_time(at));
        let frame_id = match video {
            VideoNumber::First => "camera",
            VideoNumber::Second => "second camera",
        };
        let frame_id = frame_id.to_owned();
        let data = unit.payload.clone();
        let channel = Channel::of(unit.codec);
        let topic = channel.topic(video);
        match channel {
            Channel::Video(format) => {
                let format = format.to_owned();
                self.write_message(topic, at, &CompressedVideo { timestamp, frame_id, data, format })
            }
            Channel::Picture(format) => {
                let image = CompressedImage { timestamp, frame_id, data, format: format.to_owned() };
                self.write_message(topic, at, &image)
            }
            Channel::Raw => self.write_message(topic, at, &stored::RawPicture { samples: data.to_vec() }),
        }
    }

    fn write_input(&mut self, step: u64, now: Timestamp, input: &RecordedInput) -> Result<(), WriteError> {
        let now_ns = now.as_nanos();
        match input {
            RecordedInput::Frame(stamp) => self.write_message(
                Topic::InputFrame,
                now,
                &stored::FrameInput { step, now_ns, ..stamp.into() },
            ),
            RecordedInput::Localisation(track) => {
                let message = stored::LocalisationInput { step, now_ns, track: Some(track.into()) };
                self.write_message(Topic::InputLocalisation, now, &message)
            }
            RecordedInput::Telemetry(telemetry) => {
                let message = stored::TelemetryInput { step, now_ns, ..telemetry.into() };
                self.write_message(Topic::InputTelemetry, now, &message)
            }
            RecordedInput::VesselTelemetry(telemetry) => {
                let message = stored::TelemetryInput { step, now_ns, of_vessel: true, ..telemetry.into() };
                self.write_message(Topic::InputTelemetry, now, &message)
            }
            RecordedInput::Detections(found) => self.write_message(
                Topic::InputDetections,
                now,
                &stored::DetectionsInput { step, now_ns, ..(&**found).into() },
            ),
            RecordedInput::Request(request) => self.write_message(
                Topic::InputRequest,
                now,
                &stored::RequestInput { step, now_ns, ..request.into() },
            ),
            RecordedInput::Tick => {
                self.write_message(Topic::InputTick, now, &stored::TickInput { step, now_ns })
            }
        }
    }

    fn show(&mut self, outcome: &RecordedOutcome) -> Result<(), WriteError> {
        let at = outcome.at;
        if let Some(age) = outcome.age {
            let captured = at.minus(age);
            let shown = foxglove_view::annotations(outcome, self.region, self.foxglove_time(captured));
            shown.map_or(Ok(()), |shown| self.write_message(Topic::Annotations, captured, &shown))?;
            let location = foxglove_view::location(outcome, self.foxglove_time(at));
            location.map_or(Ok(()), |location| self.write_message(Topic::Location, at, &location))?;
        }
        let event = foxglove_view::log(outcome, self.last_mode.replace(outcome.mode), self.foxglove_time(at));
        event.map_or(Ok(()), |event| self.write_message(Topic::Log, at, &event))
    }

    fn foxglove_time(&self, at: Timestamp) -> foxglove::messages::Timestamp {
        let unix_ns = self.unix_ns(at);
        foxglove::messages::Timestamp::new((unix_ns / 1_000_000_000) as u32, (unix_ns % 1_000_000_000) as u32)
    }

    fn unix_ns(&self, at: Timestamp) -> u64 {
        self.unix_start_ns.saturating_add(at.as_nanos())
    }

    fn write_message(
        &mut self,
        topic: Topic,
        at: Timestamp,
        message: &impl prost::Message,
    ) -> Result<(), WriteError> {
        self.buffer.clear();
        // Encoding into a vector cannot fail: it grows as needed.
        let _ = message.encode(&mut self.buffer);
        let time = self.unix_ns(at);
        if let Some(live) = &self.live {
            live.log(topic, &self.buffer, time);
        }
        let header = MessageHeader {
            channel_id: self.channels[&topic],
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        Ok(self.writer.write_to_known_channel(&header, &self.buffer)?)
    }

    /// Writes all entries so far to the output.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.writer.flush()?)
    }

    /// Ends the recording with its summary and the file's index. Returns the summary.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn finish(mut self) -> Result<Sortie, WriteError> {
        let sortie = self.observer.finish();
        self.writer.write_metadata(&stored_sortie::metadata_of(&sortie))?;
        self.writer.finish()?;
        Ok(sortie)
    }
}
