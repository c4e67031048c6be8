//! The topics of a recording and their schemas.

use std::collections::BTreeMap;

use foxglove::Encode;
use foxglove::messages::{CompressedImage, CompressedVideo, ImageAnnotations, LocationFix, Log};

/// Descriptors of this program's messages, compiled from `proto/barrelman.proto`.
pub(super) const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/barrelman.binpb"));

/// A topic of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Topic {
    Start,
    VideoUnit,
    Video,
    VideoPicture,
    VideoRaw,
    SecondVideo,
    SecondPicture,
    SecondRaw,
    InputFrame,
    InputLocalisation,
    InputTelemetry,
    InputDetections,
    InputRequest,
    InputTick,
    Outcome,
    Truth,
    Note,
    Annotations,
    Log,
    Location,
}

impl Topic {
    pub(super) const ALL: [Self; 20] = [
        Self::Start,
        Self::VideoUnit,
        Self::Video,
        Self::VideoPicture,
        Self::VideoRaw,
        Self::SecondVideo,
        Self::SecondPicture,
        Self::SecondRaw,
        Self::InputFrame,
        Self::InputLocalisation,
        Self::InputTelemetry,
        Self::InputDetections,
        Self::InputRequest,
        Self::InputTick,
        Self::Outcome,
        Self::Truth,
        Self::Note,
        Self::Annotations,
        Self::Log,
        Self::Location,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Start => "/recording/start",
            Self::VideoUnit => "/video/unit",
            Self::Video => "/video",
            Self::VideoPicture => "/video/picture",
            Self::VideoRaw => "/video/raw",
            Self::SecondVideo => "/second/video",
            Self::SecondPicture => "/second/video/picture",
            Self::SecondRaw => "/second/video/raw",
            Self::InputFrame => "/input/frame",
            Self::InputLocalisation => "/input/localisation",
            Self::InputTelemetry => "/input/telemetry",
            Self::InputDetections => "/input/detections",
            Self::InputRequest => "/input/request",
            Self::InputTick => "/input/tick",
            Self::Outcome => "/outcome",
            Self::Truth => "/truth",
            Self::Note => "/note",
            Self::Annotations => "/video/annotations",
            Self::Log => "/log",
            Self::Location => "/boat/location",
        }
    }

    pub(super) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// Name of the schema, and its descriptors.
    pub(super) fn schema(self) -> (String, Vec<u8>) {
        let own = |message: &str| (format!("barrelman.{message}"), DESCRIPTORS.to_vec());
        let known = |schema: Option<foxglove::Schema>| {
            schema.map(|schema| (schema.name, schema.data.into_owned())).unwrap_or_default()
        };
        match self {
            Self::Start => own("RecordingStart"),
            Self::VideoUnit => own("VideoUnit"),
            Self::Video | Self::SecondVideo => known(CompressedVideo::get_schema()),
            Self::VideoPicture | Self::SecondPicture => known(CompressedImage::get_schema()),
            Self::VideoRaw | Self::SecondRaw => own("RawPicture"),
            Self::InputFrame => own("FrameInput"),
            Self::InputLocalisation => own("LocalisationInput"),
            Self::InputTelemetry => own("TelemetryInput"),
            Self::InputDetections => own("DetectionsInput"),
            Self::InputRequest => own("RequestInput"),
            Self::InputTick => own("TickInput"),
            Self::Outcome => own("Outcome"),
            Self::Truth => own("WorldTruth"),
            Self::Note => own("Note"),
            Self::Annotations => known(ImageAnnotations::get_schema()),
            Self::Log => known(Log::get_schema()),
            Self::Location => known(LocationFix::get_schema()),
        }
    }

    /// Adds the topic's schema and channel to a file. Returns the number of the channel.
    pub(super) fn register<W: std::io::Write + std::io::Seek>(
        self,
        writer: &mut mcap::Writer<W>,
    ) -> mcap::McapResult<u16> {
        let (name, descriptors) = self.schema();
        let schema = writer.add_schema(&name, "protobuf", &descriptors)?;
        writer.add_channel(schema, self.name(), "protobuf", &BTreeMap::new())
    }
}
