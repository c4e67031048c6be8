//! No allocation per frame once the buffers have their size.

use std::time::Duration;

use barrelman_vision::{
    CamShift, CamShiftConfig, Explanation, FusedConfig, FusedTracker, RefinementWeights, Tracker,
};
use barrelman_vocab::{MotionPrior, Track, VideoFrame};

use crate::scenes::{BLUE, Hull, Paint, RED, Scene, frame, pixels};

#[test]
fn tracking_and_explaining_allocate_nothing_after_the_first_frames() {
    let boat = |left: usize| frame((640, 480), BLUE, &[(RED, [left, 100 + left / 2, 60, 30])]);
    let path: Vec<_> = (0..20).map(|step| boat(40 + 20 * step)).collect();
    let gone = frame((640, 480), BLUE, &[]);
    let mut tracker = CamShift::new(CamShiftConfig::default()).unwrap();
    let mut explanation = Explanation::default();
    tracker.select(&path[0], pixels(40.0, 120.0, 60.0, 30.0)).unwrap();
    for frame in [&gone; 70] {
        // Grows the window, and with it the explanation's buffer, to the whole picture.
        tracker.track(frame, None);
        tracker.explain(&mut explanation);
    }
    let allocations = allocation_counter::measure(|| {
        for frame in path.iter().chain([&gone; 10]).chain(path.iter().rev()) {
            tracker.track(frame, None);
            tracker.explain(&mut explanation);
        }
    });
    assert_eq!(allocations.count_total, 0);
}

/// A boat that leaves the picture to the right, stays away for a while, and returns elsewhere.
fn voyage() -> Vec<VideoFrame> {
    let hull = Hull {
        paint: Paint { colour: RED, contrast: 50.0, pattern: 2 },
        centre: (160.0, 120.0),
        length: 60.0,
        breadth: 34.0,
        turned_deg: 20.0,
    };
    let water = Paint { colour: BLUE, contrast: 30.0, pattern: 1 };
    let mut scene =
        Scene { size: (320, 240), water, shift: (0.0, 0.0), clutter: Vec::new(), hulls: vec![hull] };
    let frame = |step: u64| {
        let boat = &mut scene.hulls[0];
        match step {
            0..45 => boat.centre.0 = 160.0 + 5.0 * step as f64,
            45..70 => boat.centre.0 = 1000.0,
            _ => boat.centre = (80.0 + step as f64, 70.0),
        }
        boat.turned_deg = 20.0 + step as f64;
        scene.at_ms(33 * step)
    };
    (0..90).map(frame).collect()
}

#[test]
fn following_losing_and_finding_again_allocate_nothing_after_the_first_frames() {
    let voyage = voyage();
    let prior = MotionPrior {
        shift_u_px: 0.0,
        shift_v_px: 0.0,
        scale: 1.0,
        std_dev_px: 1.0,
        interval: Duration::from_millis(33),
    };
    let mut tracker = FusedTracker::new(FusedConfig::default()).unwrap();
    let mut explanation = Explanation::default();
    let mut lost = 0;
    for round in 0..3 {
        // The first round gives the buffers their size. In the last round the motion comes from a prior.
        tracker.select(&voyage[0], pixels(129.0, 100.0, 62.0, 40.0)).unwrap();
        let prior = (round == 2).then_some(&prior);
        tracker.track(&voyage[1], prior);
        let mut tracked = 0;
        let allocations = allocation_counter::measure(|| {
            for frame in &voyage[2..] {
                match tracker.track(frame, prior) {
                    Track::Lost { .. } => lost += 1,
                    _ => tracked += 1,
                }
                tracker.explain(&mut explanation);
            }
        });
        assert!(lost > 20 && tracked > 40, "{lost} {tracked}");
        assert_eq!(allocations.count_total == 0, round > 0, "round {round}: {allocations:?}");
    }
}

/// The documented bound on the memory of a tracker, without the frames that it shares with their source, and
/// without the weights of the network, which all trackers share.
const MEMORY: u64 = 6 << 20;

/// Of the measured sizes, pictures of 1920 x 1080 with a target of about 40 pixels take the most memory: the
/// target is small enough for a map of target probabilities at full resolution.
#[test]
fn a_tracker_needs_no_more_memory_than_documented() {
    let hull = Hull {
        paint: Paint { colour: RED, contrast: 50.0, pattern: 2 },
        centre: (160.0, 120.0),
        length: 40.0,
        breadth: 22.0,
        turned_deg: 20.0,
    };
    let water = Paint { colour: BLUE, contrast: 30.0, pattern: 1 };
    let mut scene =
        Scene { size: (1920, 1080), water, shift: (0.0, 0.0), clutter: Vec::new(), hulls: vec![hull] };
    // The boat turns, which enlarges the crop and is out of view after a gap.
    let visible: Vec<_> = (0..16_u32)
        .map(|step| {
            scene.hulls[0].turned_deg = 20.0 + 5.0 * f64::from(step);
            scene.at_ms(u64::from(33 * step))
        })
        .collect();
    scene.hulls[0].centre.0 = 5000.0;
    let hidden: Vec<_> = [2000, 2033, 2066].map(|at_ms| scene.at_ms(at_ms)).into();
    let mut tracks = Vec::with_capacity(visible.len() + hidden.len());
    let mut tracker = None;
    let weights = RefinementWeights::built_in();
    let allocations = allocation_counter::measure(|| {
        let mut selected = FusedTracker::with_weights(FusedConfig::default(), weights).unwrap();
        selected.select(&visible[0], hull.bounds()).unwrap();
        tracks.extend(visible[1..].iter().chain(&hidden).map(|frame| selected.track(frame, None)));
        tracker = Some(selected);
    });
    let lost = tracks.iter().filter(|track| matches!(track, Track::Lost { .. })).count();
    assert_eq!(lost, hidden.len(), "{tracks:?}");
    assert!(tracker.is_some() && allocations.bytes_max < MEMORY, "{allocations:?}");
}
