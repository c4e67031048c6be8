//! What one video frame of 1280x720 costs on one core: decode, localisation, and the pilot's whole step.

use std::cell::Cell;
use std::sync::Arc;

use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{CommandPath, Input, LawSettings, Pilot, PilotSettings, VesselSettings};
use barrelman_sim::practice::{FRAMES_PER_SECOND, PracticeClip};
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::encoder::{EncoderSettings, H264Encoder};
use barrelman_video::mode::DecodeMode;
use barrelman_vision::Tracker;
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{
    CameraRequest, DrawnMark, MarkKind, OperatorRequest, Picture, PictureSize, PixelPoint, Timestamp,
    VehicleProfile, VesselProfile, VesselRequest, VideoFrame,
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

/// Draws four people, who drift to the right; returns where they are.
fn draw_people(picture: &mut Picture, frame: u32) -> [PixelPoint; 4] {
    let places =
        [(140, 90), (1000, 120), (180, 600), (1020, 610)].map(|(left, top)| (left + frame as usize / 3, top));
    let width = SIZE.width as usize;
    let [y, u, v] = picture.planes_mut();
    for (index, (left, top)) in places.into_iter().enumerate() {
        for (row, column) in (0..14).flat_map(|row| (0..22).map(move |column| (row, column))) {
            let is_head = row < 6 && (7..15).contains(&column);
            y[(top + row) * width + left + column] =
                if is_head { 35 } else { 170 + 12 * ((column / 5 + index) % 4) as u8 };
            let chroma = (top + row) / 2 * (width / 2) + (left + column) / 2;
            (u[chroma], v[chroma]) = if is_head { (125, 135) } else { (85, 185) };
        }
    }
    places.map(|(left, top)| PixelPoint { u: left as f64 + 11.0, v: top as f64 + 7.0 })
}

/// The whole step with the boat and four marks that are held. 180 frames, there and back, so that nobody
/// jumps.
#[divan::bench]
fn whole_step_with_four_marks(bencher: Bencher<'_, '_>) {
    let clip = PracticeClip::new(SIZE, 1);
    let frame = |index| {
        let mut picture = Picture::black(SIZE, clip.colour());
        clip.render(index, &mut picture);
        let people = draw_people(&mut picture, index);
        (Arc::new(picture), people)
    };
    let pictures: Vec<(Arc<Picture>, [PixelPoint; 4])> = (0..FRAMES).map(frame).collect();
    let settings = PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawSettings::MotorSchema };
    let vessel = VesselSettings {
        profile: VesselProfile::SIMULATOR,
        guidance: GuidanceLaw::LineOfSight,
        path: CommandPath::Simulated,
    };
    let mut pilot = Pilot::new(settings, tracker(TrackerName::Fused)).keeping_frames().with_vessel(vessel);
    let selection = OperatorRequest::Camera(CameraRequest::SelectNext(clip.truth(0).selection));
    pilot.step(Input::Request(selection), Timestamp::ZERO);
    let shown = Cell::new(0_u32);
    let step = |pilot: &mut Pilot| {
        let count = shown.replace(shown.get() + 1);
        let place = count % (2 * FRAMES);
        let index = if place < FRAMES { place } else { 2 * FRAMES - 1 - place };
        let capture = Capture { at: at(count + 1), quality: CaptureQuality::Sensor };
        let (picture, people) = &pictures[index as usize];
        let frame = VideoFrame { sequence: u64::from(count), capture, picture: Arc::clone(picture) };
        (pilot.step(Input::Frame(&frame), capture.at), *people, capture.at)
    };
    let (_, people, captured_ns) = step(&mut pilot);
    for at in people {
        let mark = DrawnMark { mark: MarkKind::Person, at, captured_ns };
        pilot.step(Input::Request(OperatorRequest::Vessel(VesselRequest::Mark(mark))), captured_ns);
    }
    for _ in 0..30 {
        step(&mut pilot);
    }
    let (outcome, ..) = step(&mut pilot);
    assert_eq!(
        outcome.vessel.marks.iter().filter(|mark| mark.is_held()).count(),
        4,
        "{:?}",
        outcome.vessel.marks
    );
    bencher.bench_local(|| step(&mut pilot).0);
    let (outcome, ..) = step(&mut pilot);
    assert_eq!(
        outcome.vessel.marks.iter().filter(|mark| mark.is_held()).count(),
        4,
        "{:?}",
        outcome.vessel.marks
    );
}
