//! A part of a recording to be watched: the video from a key unit on to the next one a second later, and what
//! the pilot made of each picture.
//!
//! A part is a sequence of items: length of the content as u32, little-endian; kind, one byte; content. Kind
//! 1 is a unit of video as the socket sends it, kind 2 a scene ([`Scene`], JSON).

use std::collections::BTreeMap;
use std::io::{self, Read, Seek};
use std::time::Duration;

use anyhow::{Context as _, Result, bail};
use barrelman_control::Region;
use barrelman_trial::records::{
    Entry, FrameFingerprint, IndexedRecording, RecordedInput, RecordedOutcome, RecordedVessel,
};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::jpeg;
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::unit::UnitCodec;
use barrelman_vocab::{EncodedUnit, MarkKind, Timestamp, VideoFrame, VideoNumber, WaterPoint};
use serde::Serialize;

use crate::api::{AxisRates, ModeStatus, PerceptStatus, RegionStatus, TrackStatus, VideoHead, VideoKind};
use crate::status::{axes_of, mode_of, percept_of, region_of};
use crate::track_status::track_of;

/// Least length of a part.
const LENGTH: Duration = Duration::from_secs(1);
/// The outcome of a picture comes at most so long after its capture.
const SETTLED: Duration = Duration::from_secs(1);
/// Largest part, bytes.
const MAX_BYTES: usize = 48 << 20;

const UNIT: u8 = 1;
const SCENE: u8 = 2;

/// What the pilot made of a picture, as in a snapshot.
#[derive(Debug, Serialize)]
struct Scene {
    captured_ns: u64,
    /// Width and height of the picture, pixels.
    size: [u32; 2],
    mode: ModeStatus,
    track: TrackStatus,
    region: RegionStatus,
    percept: Option<PerceptStatus>,
    advice: Option<AxisRates>,
    command: AxisRates,
    vessel: Option<SceneVessel>,
}

/// What was known of the water: the map.
#[derive(Debug, Serialize)]
struct SceneVessel {
    /// Corners of what the picture shows of the water, metres.
    footprint: Option<Vec<[f64; 2]>>,
    marks: Vec<SceneMark>,
    progress: Option<SceneProgress>,
}

#[derive(Debug, Serialize)]
struct SceneMark {
    kind: MarkKind,
    destination: bool,
    water_m: [f64; 2],
    std_dev_m: f64,
    radius_m: f64,
}

#[derive(Debug, Serialize)]
struct SceneProgress {
    boat_m: [f64; 2],
    course_deg: Option<f64>,
}

impl SceneVessel {
    fn of(vessel: &RecordedVessel) -> Self {
        let on_water = |point: WaterPoint| [point.x, point.y];
        let destination = vessel.destination.map(|(id, _)| id);
        Self {
            footprint: vessel.view.map(|corners| corners.map(on_water).to_vec()),
            marks: vessel
                .marks
                .iter()
                .map(|mark| SceneMark {
                    kind: mark.kind,
                    destination: destination == Some(mark.id),
                    water_m: on_water(mark.at),
                    std_dev_m: mark.std_dev_m,
                    radius_m: mark.radius_m,
                })
                .collect(),
            progress: vessel.progress.map(|progress| SceneProgress {
                boat_m: on_water(progress.boat),
                course_deg: progress.course_rad.map(f64::to_degrees),
            }),
        }
    }
}

/// How the video of a part is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// As it was received, where browsers can decode that; JPEG otherwise.
    AsReceived,
    /// As JPEG.
    Jpeg,
}

/// Whether pictures may be encoded anew now.
pub(super) type MayEncode<'a> = &'a dyn Fn() -> bool;

/// Why pictures are not encoded anew.
pub(super) const ENGAGED: &str =
    "pictures are not encoded anew while the camera is engaged: disengage it first";

/// A part.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) items: Vec<u8>,
    /// From when on the next part goes, since the first outcome; `None`: this is the last.
    pub(super) next: Option<Duration>,
    /// The time of the first outcome, on the recording's clock.
    pub(super) began: Timestamp,
}

/// The part that shows the moment `from` after the first outcome.
///
/// # Errors
/// If the recording cannot be read, holds no video, or has no key unit for too long. An [`io::Error`] of the
/// kind `ResourceBusy`: a picture would have to be encoded, and must not be.
pub(super) fn part_of<R: Read + Seek>(
    recording: &mut IndexedRecording<R>,
    from: Duration,
    form: Form,
    may_encode: MayEncode<'_>,
) -> Result<Part> {
    let began = first_step(recording)?.context("the recording holds no step")?;
    let from = began.plus(from);
    let video = tracked_video(recording, from)?;
    let Some(begin) = key_unit(recording, video, from)? else {
        bail!("the recording holds no video: `barrelman replay` renders the pictures of a simulated trial");
    };
    let [half_width, half_height] = recording.sortie()?.map_or([1.0, 1.0], |sortie| sortie.region);
    let shares = RegionShares { half_width, half_height };
    let mut builder = Builder::new(video, (begin, from), (form, may_encode), shares);
    let mut result = Ok(());
    recording.entries_from(begin, |entry| match builder.add(entry) {
        Ok(goes_on) => goes_on,
        Err(error) => {
            result = Err(error);
            false
        }
    })?;
    result?;
    Ok(Part { items: builder.items, next: builder.next.map(|next| next.since(began)), began })
}

/// The time of the first step.
pub(super) fn first_step<R: Read + Seek>(recording: &mut IndexedRecording<R>) -> Result<Option<Timestamp>> {
    Ok(recording.find_from(Timestamp::ZERO, |entry| match entry {
        Entry::Outcome(outcome) => Some(outcome.at),
        _ => None,
    })?)
}

/// The video that the pilot saw at a time.
fn tracked_video<R: Read + Seek>(recording: &mut IndexedRecording<R>, at: Timestamp) -> Result<VideoNumber> {
    if recording.start().videos.second.is_none() {
        return Ok(VideoNumber::First);
    }
    let found = recording.find_from(at, |entry| match entry {
        Entry::Input { input: RecordedInput::Frame(FrameFingerprint { video, .. }), .. } => Some(video),
        _ => None,
    })?;
    Ok(found.unwrap_or_default())
}

/// The unit of a video with which decoding has to start for a time: before it, or else the first of all.
pub(super) fn key_unit<R: Read + Seek>(
    recording: &mut IndexedRecording<R>,
    video: VideoNumber,
    at: Timestamp,
) -> Result<Option<Timestamp>> {
    if let Some(before) = recording.key_unit_before(video, at)? {
        return Ok(Some(before));
    }
    Ok(recording.find_from(at, |entry| match entry {
        Entry::Unit(number, unit) if number == video && unit.key => Some(unit.capture.at),
        _ => None,
    })?)
}

/// Collects the items of a part.
struct Builder<'a> {
    video: VideoNumber,
    /// From here on, a key unit begins the next part.
    until: Timestamp,
    form: Form,
    may_encode: MayEncode<'a>,
    shares: RegionShares,
    decoder: UnitDecoder,
    items: Vec<u8>,
    next: Option<Timestamp>,
    /// The frames of steps whose outcome has not come yet.
    frames: BTreeMap<u64, FrameFingerprint>,
}

impl<'a> Builder<'a> {
    fn new(
        video: VideoNumber,
        (begin, from): (Timestamp, Timestamp),
        (form, may_encode): (Form, MayEncode<'a>),
        shares: RegionShares,
    ) -> Self {
        Self {
            video,
            until: begin.max(from).plus(LENGTH),
            form,
            may_encode,
            shares,
            decoder: UnitDecoder::new(DecodeMode::Live),
            items: Vec::new(),
            next: None,
            frames: BTreeMap::new(),
        }
    }

    /// Adds an entry. Returns whether further ones are needed.
    fn add(&mut self, entry: Entry) -> Result<bool> {
        match entry {
            Entry::Unit(number, unit) if number == self.video => {
                if self.next.is_none() && unit.key && unit.capture.at >= self.until {
                    self.next = Some(unit.capture.at);
                }
                if self.next.is_none() {
                    self.add_unit(&unit)?;
                }
            }
            Entry::Input { step, input: RecordedInput::Frame(frame), .. } if frame.video == self.video => {
                self.frames.insert(step, frame);
            }
            Entry::Outcome(outcome) => {
                if let Some(frame) = self.frames.remove(&outcome.step) {
                    self.add_scene(&frame, &outcome)?;
                }
                return Ok(self.next.is_none_or(|next| outcome.at < next.plus(SETTLED)));
            }
            Entry::Unit(..)
            | Entry::Input { .. }
            | Entry::Start(_)
            | Entry::Truth(_)
            | Entry::Note { .. } => {}
        }
        Ok(true)
    }

    fn add_unit(&mut self, unit: &EncodedUnit) -> Result<()> {
        let kind = match (unit.codec, self.form) {
            (UnitCodec::H264AnnexB, Form::AsReceived) => Some(VideoKind::H264),
            (UnitCodec::H265AnnexB, Form::AsReceived) => Some(VideoKind::H265),
            (UnitCodec::Jpeg, _) => Some(VideoKind::Jpeg),
            (
                UnitCodec::H264AnnexB
                | UnitCodec::H265AnnexB
                | UnitCodec::Vp9
                | UnitCodec::Av1
                | UnitCodec::Png
                | UnitCodec::RawYuv420 { .. },
                _,
            ) => None,
        };
        if let Some(kind) = kind {
            return self
                .add_item(UNIT, &VideoHead::of_unit(kind, unit, VideoNumber::First).message(&unit.payload));
        }
        if !(self.may_encode)() {
            bail!(io::Error::new(io::ErrorKind::ResourceBusy, ENGAGED));
        }
        let mut frames = Vec::new();
        // A damaged unit gives no picture: the next key unit does.
        let _ = self.decoder.decode(unit, &mut |frame| frames.push(frame));
        frames.iter().try_for_each(|frame| self.add_picture(frame))
    }

    fn add_picture(&mut self, frame: &VideoFrame) -> Result<()> {
        let payload = jpeg::encode(&frame.picture).context("a picture cannot be encoded as JPEG")?;
        self.add_item(UNIT, &VideoHead::of_picture(frame, VideoNumber::First).message(&payload))
    }

    fn add_scene(&mut self, frame: &FrameFingerprint, outcome: &RecordedOutcome) -> Result<()> {
        let scene = Scene {
            captured_ns: frame.capture.at.as_nanos(),
            size: [frame.size.width, frame.size.height],
            mode: mode_of(outcome.mode),
            track: track_of(&outcome.track, outcome.at),
            region: region_of(Region::from_shares(self.shares, frame.size)),
            percept: percept_of(outcome.percept, outcome.advice),
            advice: outcome.advice.map(|advice| axes_of(advice.command)),
            command: axes_of(outcome.command),
            vessel: outcome.vessel.as_deref().map(SceneVessel::of),
        };
        self.add_item(SCENE, &serde_json::to_vec(&scene)?)
    }

    fn add_item(&mut self, kind: u8, content: &[u8]) -> Result<()> {
        if self.items.len() + content.len() > MAX_BYTES {
            bail!(
                "its video has no key frame for more than {} MiB: make the film to watch it, and set the camera \
                 to one key frame a second",
                MAX_BYTES >> 20
            );
        }
        self.items.extend_from_slice(&(content.len() as u32).to_le_bytes());
        self.items.push(kind);
        self.items.extend_from_slice(content);
        Ok(())
    }
}
