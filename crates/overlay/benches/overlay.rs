//! Time to draw a scene on a copy of a frame.

use std::sync::Arc;

use barrelman_control::{MotorSchema, Percept, Region};
use barrelman_overlay::{Overlay, Scene};
use barrelman_pilot::{Advice, Mode};
use barrelman_sim::practice::PracticeClip;
use barrelman_vision::{Explanation, FusedConfig, FusedTracker, Tracker as _};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PictureSize, Timestamp, Track, VehicleProfile, VideoFrame};
use divan::Bencher;

fn main() {
    divan::main();
}

/// A boat in the right sector, which has a large area, with all elements.
#[divan::bench(args = [PictureSize::new(640, 360), PictureSize::new(1280, 720), PictureSize::new(1920, 1080)])]
fn servoing_with_explanation(bencher: Bencher<'_, '_>, size: PictureSize) {
    draw(bencher, size, 108);
}

/// A boat within the region.
#[divan::bench(args = [PictureSize::new(640, 360), PictureSize::new(1280, 720), PictureSize::new(1920, 1080)])]
fn resting_with_explanation(bencher: Bencher<'_, '_>, size: PictureSize) {
    draw(bencher, size, 60);
}

fn draw(bencher: Bencher<'_, '_>, size: PictureSize, number: u32) {
    let profile = VehicleProfile::fotokite_pro();
    let clip = PracticeClip::new(size, 3);
    let mut picture = Picture::black(size, clip.colour());
    clip.render(number, &mut picture);
    let capture = Capture { at: Timestamp::from_secs_f64(3.6), quality: CaptureQuality::Sensor };
    let frame = VideoFrame { sequence: u64::from(number), capture, picture: Arc::new(picture) };

    let mut tracker = FusedTracker::new(FusedConfig::default()).expect("the defaults are valid");
    let report = tracker.select(&frame, clip.truth(number).bounds).expect("the boat is red");
    let mut explanation = Explanation::default();
    tracker.explain(&mut explanation);

    let track = Track::Tracking(report.localisation);
    let region = Region::from_shares(profile.region, size);
    let percept = Percept::new(report.localisation.centre.in_image(size), region);
    let command = MotorSchema::new(profile.motor_schema_rates).command(&percept);
    let scene = Scene {
        percept: Some(percept),
        advice: Some(Advice { command, sector: None }),
        command,
        rates: Some(profile.to_vehicle(command)),
        mode: Some(Mode::Servoing),
        link: Some("up"),
        explanation: Some(&explanation),
        ..Scene::from_track(&track, region)
    };
    let mut overlay = Overlay::new();
    let mut out = Picture::black(size, clip.colour());
    bencher.bench_local(|| overlay.draw(&frame, &scene, &mut out));
}
