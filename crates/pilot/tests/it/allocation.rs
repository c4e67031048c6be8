//! Steps do not allocate after the buffers have reached their size.

use std::sync::Arc;

use barrelman_control::optimal::OptimalSettings;
use barrelman_pilot::{Input, LawSettings, Pilot, PilotSettings};
use barrelman_sim::practice::PracticeClip;
use barrelman_vision::{CamShift, CamShiftConfig, FusedConfig, FusedTracker, Tracker};
use barrelman_vocab::OptimalMode;
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{
    CameraRequest, OperatorRequest, Picture, PictureSize, PixelBox, Timestamp, Track, VideoFrame,
};

use crate::scenes::SceneInput::{Engage, Lost, Reports, Tick};
use crate::scenes::settings;

/// Number of allocations of this thread during some work.
fn allocations_of(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

const SIZE: PictureSize = PictureSize::new(640, 480);

fn drawn(clip: &PracticeClip, index: u32, sequence: u64, captured: Timestamp) -> VideoFrame {
    let mut picture = Picture::black(SIZE, clip.colour());
    clip.render(index, &mut picture);
    let capture = Capture { at: captured, quality: CaptureQuality::Sensor };
    VideoFrame { sequence, capture, picture: Arc::new(picture) }
}

#[test]
fn steps_with_camshift_allocate_nothing_after_the_first_rounds() {
    let tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    steps_allocate_nothing_after_the_first_rounds(Box::new(tracker), LawSettings::MotorSchema);
}

#[test]
fn steps_with_the_optimal_law_allocate_nothing_after_the_first_rounds() {
    let tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    let law = LawSettings::Optimal(OptimalSettings::new(OptimalMode::MinimumEnergy));
    steps_allocate_nothing_after_the_first_rounds(Box::new(tracker), law);
}

#[test]
fn steps_with_the_fused_tracker_allocate_nothing_after_the_first_rounds() {
    let tracker = FusedTracker::new(FusedConfig::default()).unwrap();
    steps_allocate_nothing_after_the_first_rounds(Box::new(tracker), LawSettings::MotorSchema);
}

#[track_caller]
fn steps_allocate_nothing_after_the_first_rounds(tracker: Box<dyn Tracker>, law: LawSettings) {
    let clip = PracticeClip::new(SIZE, 1);
    let mut pilot = Pilot::new(PilotSettings { law, ..settings() }, tracker);
    let mut sequence = 0_u64;
    let mut round = || {
        let (mut allocations, mut moved, mut followed) = (0, 0, 0);
        // Every third frame: the boat passes all four sectors twice in 240 frames, fast enough to be lost
        // occasionally.
        for index in (0..clip.frames()).step_by(3) {
            let captured = Timestamp::from_nanos(1_000_000_000 + sequence * 33_000_000);
            let now = captured.plus(core::time::Duration::from_millis(50));
            let frame = drawn(&clip, index, sequence, captured);
            if sequence == 0 {
                // The inner half of the box: no water.
                let hull = clip.truth(0).bounds;
                let inner = PixelBox {
                    u: hull.u + hull.w / 4.0,
                    v: hull.v + hull.h / 4.0,
                    w: hull.w / 2.0,
                    h: hull.h / 2.0,
                };
                pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::SelectNext(inner))), now);
            }
            allocations += allocations_of(|| {
                pilot.step(Engage.input(now), now);
                let outcome = pilot.step(Input::Frame(&frame), now);
                pilot.step(Reports.input(now), now);
                pilot.step(Tick.input(now), now);
                moved += usize::from(!outcome.command.is_rest());
                followed += usize::from(matches!(outcome.track, Track::Tracking(_)));
            });
            sequence += 1;
        }
        (allocations, moved, followed)
    };
    let (first, ..) = round();
    // The second round adds what the buffers need for the boxes of a tracker that knows the boat already.
    round();
    assert!(first > 0, "the allocator is not counted");
    let (allocations, moved, followed) = round();
    assert!(
        moved > 50 && followed > 120,
        "{moved} moving and {followed} tracked of 240: the test shows nothing"
    );
    assert_eq!(allocations, 0);
}

#[test]
fn localisations_and_refusals_allocate_nothing() {
    let clip = PracticeClip::new(SIZE, 1);
    let mut pilot = Pilot::new(settings(), Box::new(CamShift::new(CamShiftConfig::default()).unwrap()));
    let now = Timestamp::from_nanos(1_000_000_000);
    let frame = drawn(&clip, 0, 0, now);
    let earlier = drawn(&clip, 1, 1, Timestamp::from_nanos(5));
    let outside = PixelBox { u: 900.0, v: 900.0, w: 5.0, h: 5.0 };
    let allocations = allocations_of(|| {
        pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::SelectNext(outside))), now);
        let refused = pilot.step(Input::Frame(&frame), now);
        let went_back = pilot.step(Input::Frame(&earlier), now);
        pilot.step(Lost.input(now), now);
        assert!(refused.notice.is_some() && went_back.notice.is_some());
    });
    assert_eq!(allocations, 0);
}
