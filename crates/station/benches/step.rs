//! What one video frame of 1280x720 costs on one core: decode, localisation, and the pilot's whole step.

use std::cell::Cell;
use std::sync::Arc;

use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{Input, LawSettings, Pilot, PilotSettings};
use barrelman_sim::practice::{FRAMES_PER_SECOND, PracticeClip};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::encoder::{EncoderSettings, H264Encoder};
use barrelman_video::mode::DecodeMode;
use barrelman_vision::Tracker;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{
    CameraRequest, OperatorRequest, Picture, PictureSize, Timestamp, VehicleProfile, VideoFrame,
};
use divan::Bencher;

const SIZE: PictureSize = PictureSize::new(1280, 720);
/// Frames of the clip that are gone through: the boat leaves the region to the right and comes back.
const FRAMES: u32 = 180;

fn main() {
    divan::main();
}

fn at(frame: u32) -> Timestamp {
    Timestamp::from_secs_f64(f64::from(frame) / f64::from(FRAMES_PER_SECOND))
}

fn frames(clip: &PracticeClip) -> Vec<VideoFrame> {
    let frame = |index| {
        let mut picture = Picture::black(SIZE, clip.colour());
        clip.render(index, &mut picture);
        let capture = Capture { at: at(index), quality: CaptureQuality::Sensor };
        VideoFrame { sequence: u64::from(index), capture, picture: Arc::new(picture) }
    };
    (0..FRAMES).map(frame).collect()
}

fn tracker(name: TrackerName) -> Box<dyn Tracker> {
    TrackerSettings::new(name).build().expect("the defaults lie in their ranges")
}

/// Goes round and round through the frames.
fn next(index: &Cell<usize>, count: usize) -> usize {
    index.replace((index.get() + 1) % count)
}

#[divan::bench]
fn decode(bencher: Bencher<'_, '_>) {
    let clip = PracticeClip::new(SIZE, 1);
    let settings = EncoderSettings::for_pictures(SIZE, f64::from(FRAMES_PER_SECOND));
    let mut encoder = H264Encoder::new(settings);
    let unit = |(index, frame): (usize, &VideoFrame)| {
        let encoded = encoder.encode(&frame.picture, frame.capture.at).expect("the picture can be encoded");
        EncodedUnit {
            epoch: 0,
            index: index as u64,
            capture: frame.capture,
            key: encoded.key,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: encoded.bytes.into(),
        }
    };
    let units: Vec<EncodedUnit> = frames(&clip).iter().enumerate().map(unit).collect();
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    let index = Cell::new(0);
    bencher.bench_local(|| {
        let unit = &units[next(&index, units.len())];
        decoder.decode(unit, &mut |frame| drop(divan::black_box(frame))).expect("our own stream is intact");
    });
}

#[divan::bench(args = [TrackerName::Fused, TrackerName::Camshift])]
fn localisation(bencher: Bencher<'_, '_>, name: TrackerName) {
    let clip = PracticeClip::new(SIZE, 1);
    let frames = frames(&clip);
    let mut tracker = tracker(name);
    tracker.select(&frames[0], clip.truth(0).selection).expect("the boat is red");
    let index = Cell::new(0);
    bencher.bench_local(|| tracker.track(&frames[next(&index, frames.len())], None));
}

#[divan::bench(args = [TrackerName::Fused, TrackerName::Camshift])]
fn whole_step(bencher: Bencher<'_, '_>, name: TrackerName) {
    let clip = PracticeClip::new(SIZE, 1);
    let frames = frames(&clip);
    let settings = PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawSettings::MotorSchema };
    let mut pilot = Pilot::new(settings, tracker(name));
    let selection = OperatorRequest::Camera(CameraRequest::SelectNext(clip.truth(0).selection));
    pilot.step(Input::Request(selection), Timestamp::ZERO);
    pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::Engage)), Timestamp::ZERO);
    let index = Cell::new(0);
    bencher.bench_local(|| {
        let frame = &frames[next(&index, frames.len())];
        pilot.step(Input::Frame(frame), frame.capture.at)
    });
}
