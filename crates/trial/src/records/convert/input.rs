//! Inputs of the pilot, and notes, from their stored forms.

use barrelman_pilot::{ClassName, Classification, Detection, Detections, MAX_DETECTIONS};
use barrelman_vocab::{Note, OperatorRequest, PictureSize, Telemetry, Timestamp, Track};

use super::malformed::{Malformed, missing};
use crate::records::entry::Entry;
use crate::records::recorded_input::{FrameFingerprint, RecordedInput};
use crate::records::stored;

fn input(step: u64, now_ns: u64, input: RecordedInput) -> Entry {
    Entry::Input { step, now: Timestamp::from_nanos(now_ns), input }
}

impl TryFrom<stored::FrameInput> for Entry {
    type Error = Malformed;

    fn try_from(frame: stored::FrameInput) -> Result<Self, Malformed> {
        let fingerprint = FrameFingerprint::try_from(&frame)?;
        Ok(input(frame.step, frame.now_ns, RecordedInput::Frame(fingerprint)))
    }
}

impl TryFrom<stored::LocalisationInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::LocalisationInput) -> Result<Self, Malformed> {
        let track = Track::try_from(message.track.ok_or_else(|| missing("track"))?)?;
        Ok(input(message.step, message.now_ns, RecordedInput::Localisation(track)))
    }
}

impl From<stored::TickInput> for Entry {
    fn from(tick: stored::TickInput) -> Self {
        input(tick.step, tick.now_ns, RecordedInput::Tick)
    }
}

impl TryFrom<stored::TelemetryInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::TelemetryInput) -> Result<Self, Malformed> {
        let (step, now_ns) = (message.step, message.now_ns);
        let kind = if message.of_vessel { RecordedInput::VesselTelemetry } else { RecordedInput::Telemetry };
        Ok(input(step, now_ns, kind(Telemetry::try_from(message)?)))
    }
}

impl From<&Detections> for stored::DetectionsInput {
    fn from(detections: &Detections) -> Self {
        Self {
            captured_ns: detections.captured.as_nanos(),
            picture_width: detections.picture.width,
            picture_height: detections.picture.height,
            found: detections.found.iter().take(MAX_DETECTIONS).map(stored::Detection::from).collect(),
            ..Self::default()
        }
    }
}

impl From<&Detection> for stored::Detection {
    fn from(detection: &Detection) -> Self {
        let Classification { class, score } = detection.classification;
        Self { bounds: Some(detection.bounds.into()), class: class.as_str().to_owned(), score }
    }
}

impl TryFrom<stored::Detection> for Detection {
    type Error = Malformed;

    fn try_from(stored: stored::Detection) -> Result<Self, Malformed> {
        let class = ClassName::new(&stored.class).ok_or_else(|| missing("class"))?;
        let bounds = stored.bounds.ok_or_else(|| missing("bounds"))?.into();
        Ok(Self { bounds, classification: Classification { class, score: stored.score } })
    }
}

impl TryFrom<stored::DetectionsInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::DetectionsInput) -> Result<Self, Malformed> {
        if message.found.len() > MAX_DETECTIONS {
            return Err(Malformed(format!("more than {MAX_DETECTIONS} detections of one video frame")));
        }
        let found: Result<_, _> = message.found.into_iter().map(Detection::try_from).collect();
        let detections = Detections {
            captured: Timestamp::from_nanos(message.captured_ns),
            picture: PictureSize::new(message.picture_width, message.picture_height),
            found: found?,
        };
        Ok(input(message.step, message.now_ns, RecordedInput::Detections(Box::new(detections))))
    }
}

impl TryFrom<stored::Note> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::Note) -> Result<Self, Malformed> {
        let text = message.text.try_into().map_err(Malformed)?;
        Ok(Self::Note { at: Timestamp::from_nanos(message.at_ns), note: Note { text } })
    }
}

impl TryFrom<stored::RequestInput> for Entry {
    type Error = Malformed;

    fn try_from(message: stored::RequestInput) -> Result<Self, Malformed> {
        let (step, now_ns) = (message.step, message.now_ns);
        Ok(input(step, now_ns, RecordedInput::Request(OperatorRequest::try_from(message)?)))
    }
}
