//! A picture that turns against the command stops the camera; sway, and a camera that differs from its
//! profile, do not.

use core::time::Duration;
use std::sync::{Arc, Mutex};

use barrelman_control::CameraModel;
use barrelman_pilot::{Input, Mode, Pilot};
use barrelman_sim::random::{CounterRng, Stream};
use barrelman_vision::{BackgroundShift, Explanation, SelectionError, SelectionReport, Tracker};
use barrelman_vocab::profile::{AxisDynamics, CameraDynamics};
use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
use barrelman_vocab::{
    AngularRate, CameraCommand, CameraRequest, ImagePoint, MotionPrior, OperatorRequest, Picture, PixelBox,
    StopCause, Track, VehicleProfile, VideoFrame,
};

use crate::scenes::{BOTTOM, INSIDE, LEFT, PICTURE, RIGHT, TOP, at, seen, settings};

/// What the tracker answers to the next frame.
type Answer = Arc<Mutex<(ImagePoint, Option<BackgroundShift>)>>;

struct ScriptedTracker(Answer);

impl Tracker for ScriptedTracker {
    fn select(&mut self, _: &VideoFrame, selection: PixelBox) -> Result<SelectionReport, SelectionError> {
        Err(SelectionError::Empty { selection, picture: PICTURE })
    }
    fn track(&mut self, frame: &VideoFrame, _: Option<&MotionPrior>) -> Track {
        Track::Tracking(seen(self.0.lock().unwrap().0, frame.capture.at))
    }
    fn forget(&mut self) {}
    fn reject(&mut self) -> bool {
        false
    }
    fn explain(&self, _: &mut Explanation) {}
    fn background_shift(&self) -> Option<BackgroundShift> {
        self.0.lock().unwrap().1
    }
}

/// A camera as it is, which may differ from the profile.
#[derive(Debug, Clone, Copy)]
struct TrueCamera {
    pan_gain: f64,
    tilt_gain: f64,
    /// Added to each dead time, seconds, and factor of each lag.
    dead_time_s: f64,
    lag_factor: f64,
    /// Standard deviation of the sway, radians per square root of a second.
    sway: f64,
}

const AS_PROFILE: TrueCamera =
    TrueCamera { pan_gain: 1.0, tilt_gain: 1.0, dead_time_s: 0.0, lag_factor: 1.0, sway: 0.0 };

impl TrueCamera {
    fn model(&self, profile: &VehicleProfile) -> CameraModel {
        let axis = |axis: AxisDynamics| {
            let later = |dead_time: Duration| dead_time.as_secs_f64() + self.dead_time_s;
            AxisDynamics {
                start_dead_time: Duration::from_secs_f64(later(axis.start_dead_time)),
                stop_dead_time: Duration::from_secs_f64(later(axis.stop_dead_time)),
                lag: axis.lag.mul_f64(self.lag_factor),
                ..axis
            }
        };
        let CameraDynamics { pan, tilt, .. } = profile.camera;
        CameraModel::new(
            CameraDynamics { pan: axis(pan), tilt: axis(tilt), ..profile.camera },
            profile.limits,
            None,
        )
    }
}

/// Engages a pilot for `seconds`, in which the target is seen where `target` says, and the background as the
/// true camera turns. Returns when and why the pilot stopped, in milliseconds.
fn run(
    camera: TrueCamera,
    seed: u64,
    seconds: u64,
    target: impl Fn(f64) -> ImagePoint,
) -> Option<(u64, StopCause)> {
    let answer: Answer = Arc::new(Mutex::new((INSIDE, None)));
    let settings = settings();
    let mut model = camera.model(&settings.profile);
    let mut pilot = Pilot::new(settings, Box::new(ScriptedTracker(Arc::clone(&answer))));
    assert_eq!(
        pilot.step(Input::Request(OperatorRequest::Camera(CameraRequest::Engage)), at(0)).mode.to_string(),
        "holding: nothing selected"
    );
    let noise = CounterRng::new(seed, Stream::SwayYaw);
    let picture = Arc::new(Picture::black(PICTURE, ColourEncoding::JPEG));
    const FRAME_MS: u64 = 33;
    for index in 1..seconds * 1_000 / FRAME_MS {
        let now_ms = index * FRAME_MS;
        let ago = |ms| at(now_ms).minus(Duration::from_millis(ms));
        let (from, to) = (ago(FRAME_MS + 200), ago(200));
        let point = ImagePoint { x: 40.0, y: -30.0 };
        let [pan, tilt] = model.shifts_by_axis(point, from, to, PICTURE).unwrap();
        let sway_px = 330.0 * camera.sway * (FRAME_MS as f64 / 1e3).sqrt();
        let shift = BackgroundShift {
            u_px: pan[0] + tilt[0] + sway_px * noise.normal(2 * index),
            v_px: -(pan[1] + tilt[1]) + sway_px * noise.normal(2 * index + 1),
            centre: point.in_pixels(PICTURE),
        };
        *answer.lock().unwrap() = (target(now_ms as f64 / 1e3), Some(shift));
        let capture = Capture { at: to, quality: CaptureQuality::Sensor };
        let frame = VideoFrame { sequence: index, capture, picture: Arc::clone(&picture) };
        let outcome = pilot.step(Input::Frame(&frame), at(now_ms));
        if let Mode::Stopped(cause) = outcome.mode {
            assert!(outcome.command.is_rest());
            return Some((now_ms, cause));
        }
        let turned = |rate: AngularRate, gain: f64| rate * gain;
        let CameraCommand { pan, tilt, .. } = outcome.command;
        let command = CameraCommand::turning(turned(pan, camera.pan_gain), turned(tilt, camera.tilt_gain));
        model.apply_command(command, at(now_ms));
    }
    None
}

/// A target that makes the camera turn to all sides, with rests.
fn around(seconds: f64) -> ImagePoint {
    [RIGHT, INSIDE, TOP, LEFT, RIGHT, INSIDE, BOTTOM, LEFT, INSIDE, TOP, BOTTOM]
        [(seconds / 1.7) as usize % 11]
}

#[test]
fn a_wrong_sign_is_named_and_stops_the_camera() {
    for (camera, point, cause) in [
        (TrueCamera { pan_gain: -1.0, ..AS_PROFILE }, RIGHT, StopCause::PanOpposed),
        (TrueCamera { pan_gain: -1.0, ..AS_PROFILE }, LEFT, StopCause::PanOpposed),
        (TrueCamera { tilt_gain: -1.0, ..AS_PROFILE }, TOP, StopCause::TiltOpposed),
        (TrueCamera { tilt_gain: -1.0, ..AS_PROFILE }, BOTTOM, StopCause::TiltOpposed),
    ] {
        for sway in [0.0, 0.02, 0.05] {
            let (ms, stopped) = run(TrueCamera { sway, ..camera }, 1, 10, |_| point).expect("stopped");
            assert_eq!(stopped, cause, "{camera:?}");
            // Dead time, lag, the steady part and 0.3 s of motion; sway takes its time.
            assert!(
                ms >= 500 && ms <= if sway < 0.05 { 2_200 } else { 4_000 },
                "{camera:?}, sway {sway}: {ms} ms"
            );
        }
    }
}

#[test]
fn in_calm_air_a_wrong_sign_stops_the_camera_after_half_a_second() {
    const RESTS_S: f64 = 3.0;
    for (camera, point, cause, ms_to_speed) in [
        // Dead time of the video and of the axis, then the lag until half of the rate.
        (TrueCamera { pan_gain: -1.0, ..AS_PROFILE }, RIGHT, StopCause::PanOpposed, 200 + 200 + 291),
        (TrueCamera { tilt_gain: -1.0, ..AS_PROFILE }, TOP, StopCause::TiltOpposed, 200 + 100 + 69),
    ] {
        for sway in [0.0, 0.003] {
            let after_rest = |seconds| if seconds < RESTS_S { INSIDE } else { point };
            let (ms, stopped) = run(TrueCamera { sway, ..camera }, 1, 10, after_rest).expect("stopped");
            assert_eq!(stopped, cause, "{camera:?}");
            let after_speed = ms as i64 - (1e3 * RESTS_S) as i64 - ms_to_speed;
            assert!((250..=530).contains(&after_speed), "{cause:?}, sway {sway}: {after_speed} ms");
        }
    }
}

#[test]
fn a_camera_that_turns_as_it_is_told_is_never_stopped() {
    let mut moved = 0;
    for seed in 0..60 {
        let rng = CounterRng::new(seed, Stream::Plant);
        let camera = TrueCamera {
            pan_gain: rng.between(0, (0.7, 1.3)),
            tilt_gain: rng.between(1, (0.7, 1.3)),
            dead_time_s: rng.between(2, (-0.09, 0.15)),
            lag_factor: rng.between(3, (0.5, 1.5)),
            sway: rng.between(4, (0.0, 0.05)),
        };
        assert_eq!(run(camera, seed, 60, around), None, "seed {seed}: {camera:?}");
        moved += 1;
    }
    assert_eq!(moved, 60);
}

#[test]
fn a_camera_that_does_not_turn_at_all_is_not_said_to_turn_the_wrong_way() {
    for seed in 0..20 {
        let camera = TrueCamera { pan_gain: 0.0, tilt_gain: 0.0, sway: 0.03, ..AS_PROFILE };
        assert_eq!(run(camera, seed, 30, around), None, "seed {seed}");
    }
}
