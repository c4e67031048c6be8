//! Test scenes for a tracker: a boat on rough water under a moving camera, with the exact truth of each
//! frame.
//!
//! A scene stands in for video from 15 to 60 m above the water: the boat moves, turns and stops; the camera
//! follows with pans and sway, and may lose the boat. A scene is a pure function of its script and seed, with
//! the same bits on every machine, and each frame can be rendered on its own. The water is a flat plane
//! (`view.rs`) seen at a fixed depression of 40 to 80 degrees. The seed determines the depression, the colour
//! and roughness of the water, the light, the lens blur, the exposure and the sensor noise.
//!
//! Not handled: perspective within a picture, roll, rolling shutter, reflections, spray over the hull, rain,
//! compression.
#![forbid(unsafe_code)]

mod script;

mod boat_motion;
mod camera_motion;
mod canvas;
mod choices;
mod colour;
mod conditions;
mod framing;
mod object;
mod outline;
mod placement;
mod scenery;
mod shore;
mod trajectory;
mod view;
mod wake;
mod water;
mod waves;

pub use self::script::{SceneKind, SceneScript, TargetPaint};

use barrelman_vocab::rng::{self, SplitMix64};
use barrelman_vocab::{Angle, Picture, PictureSize, PixelBox, PixelPoint};

use self::canvas::{Canvas, Sensor};
use self::conditions::{Conditions, REFERENCE};
use self::object::{Body, ObjectExposure, PaintScheme, PlanePose, SceneObject};
use self::outline::{Outline, Shape};
use self::placement::{MAX_DISTRACTORS, PlacementContext};
use self::script::FRAMES_PER_SECOND;
use self::shore::Shore;
use self::trajectory::Trajectory;
use self::wake::Wake;
use self::water::Water;

/// Upper bound of the hull's length as a share of the picture's shorter side, so that the boat has room to
/// move.
const MAX_HULL_SHARE: f64 = 0.3;
/// Lower bound of the hull's length, px: below it, bow and stern cannot be told apart.
const MIN_HULL_PX: f64 = 8.0;
/// A boat at this speed or more is under way, hull lengths per second.
const MIN_UNDER_WAY_SPEED: f64 = 0.3;

/// Random streams: what is sampled for one part of a scene does not change another part.
mod stream {
    pub(super) const CONDITIONS: u64 = 1;
    pub(super) const BOAT: u64 = 2;
    pub(super) const TRAJECTORY: u64 = 3;
    pub(super) const SHORE: u64 = 4;
    pub(super) const DISTRACTORS: u64 = 5;
    pub(super) const CLUTTER: u64 = 6;
    pub(super) const SENSOR: u64 = 7;
    /// This stream and the three that follow.
    pub(super) const WATER: u64 = 10;
}

/// Where everything is in one frame, at the middle of its exposure. Shapes are those of the rendered
/// silhouette before blur.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneTruth {
    /// Time since the start of the clip, s.
    pub time_s: f64,
    /// Upright box around the boat's part in the picture, without the wake; empty where the boat is outside.
    pub bounds: PixelBox,
    /// Share of the boat's silhouette in the picture, 0 to 1.
    pub visible_share: f64,
    /// Middle of the hull's centre line, halfway from stern to bow; may lie outside the picture.
    pub centre: PixelPoint,
    /// Direction of the hull's centre line in the picture, towards the bow, anticlockwise from image right,
    /// within +-180 degrees. A foreshortened hull is not symmetric about it; for the principal axis see
    /// [`WaterScene::silhouette_axis`].
    pub heading: Angle,
    /// Length of the hull's centre line in the picture, px.
    pub major_px: f64,
    /// Extent of the silhouette across the centre line, px.
    pub minor_px: f64,
    /// Whether the boat moves over the water at more than 0.3 hull lengths per second.
    pub is_under_way: bool,
    /// Shift of a resting point at the centre of the picture since the frame before, px (u right, v down).
    /// Where the camera zooms, other points shift by up to 1.5 px more.
    pub camera_shift: (f64, f64),
    /// Boxes around the distractors' parts in the picture; empty boxes where there are fewer.
    pub distractors: [PixelBox; MAX_DISTRACTORS],
}

/// A scene, ready to be rendered.
#[derive(Debug, Clone)]
pub struct WaterScene {
    script: SceneScript,
    seed: u64,
    frames: u64,
    conditions: Conditions,
    boat: Body,
    wake_strength: f64,
    trajectory: Trajectory,
    shore: Option<Shore>,
    clutter: Vec<SceneObject>,
    distractors: Vec<SceneObject>,
    water: Water,
    wake: Wake,
    canvas: Canvas,
}

impl WaterScene {
    /// Plans the whole clip, which takes as long as rendering a few frames.
    pub fn new(script: SceneScript, seed: u64) -> Self {
        let shorter = f64::from(script.size.width.min(script.size.height));
        let relative = f64::from(script.size.width) / f64::from(REFERENCE.width);
        let hull = script.boat_px.min(MAX_HULL_SHARE * shorter).max(MIN_HULL_PX);
        let frames = ((script.seconds * f64::from(FRAMES_PER_SECOND)).round() as u64).max(1);
        let conditions = Conditions::new(&script, hull, seed, stream::CONDITIONS);

        let mut rng = SplitMix64::of_stream(seed, stream::BOAT);
        let fullness = rng.between(1.6, 2.8);
        let outline = Outline::new(Shape::Hull { fullness }, hull, hull * rng.between(0.3, 0.46));
        let paint = colour::yuv(colour::hull(script.target, &mut rng));
        let cockpit = [rng.between(34.0, 80.0), rng.between(36.0, 80.0), rng.between(40.0, 84.0)];
        let stripe = match script.target {
            TargetPaint::White => [60.0, 90.0, 160.0],
            _ => [222.0, 222.0, 214.0],
        };
        let paint_scheme = PaintScheme::Boat {
            hull: paint,
            cockpit: colour::yuv(cockpit),
            stripe: colour::yuv(stripe),
            engine: colour::yuv([28.0, 28.0, 32.0]),
        };
        let wake_strength = rng.between(0.3, 1.3);

        let count = frames as usize;
        let trajectory = Trajectory::new(
            &script,
            count,
            &outline,
            &conditions,
            SplitMix64::of_stream(seed, stream::TRAJECTORY),
        );
        let context = PlacementContext {
            trajectory: &trajectory,
            frames: count,
            outline: &outline,
            paint: script.target,
            relative,
        };
        let shore = Shore::new(&context, SplitMix64::of_stream(seed, stream::SHORE));
        let distractors = if script.kind == SceneKind::ExitAndReturnWithDistractor {
            scenery::distractors(
                &context,
                shore.as_ref(),
                paint,
                SplitMix64::of_stream(seed, stream::DISTRACTORS),
            )
        } else {
            Vec::new()
        };
        let clutter = scenery::clutter(
            &context,
            shore.as_ref(),
            &distractors,
            SplitMix64::of_stream(seed, stream::CLUTTER),
        );

        let canvas = Canvas::new(script.size, rng::hash(seed, stream::SENSOR, 0));
        let water = Water::new(&conditions, relative, canvas.y.width, seed, stream::WATER);
        let wake = Wake::new(&canvas.u);
        let boat = Body { outline, paint_scheme };
        Self {
            script,
            seed,
            frames,
            conditions,
            boat,
            wake_strength,
            trajectory,
            shore,
            clutter,
            distractors,
            water,
            wake,
            canvas,
        }
    }

    /// Number of frames, at least one.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Frame rate: 30.
    pub const fn frames_per_second(&self) -> u32 {
        FRAMES_PER_SECOND
    }

    /// Picture size.
    pub const fn size(&self) -> PictureSize {
        self.script.size
    }

    /// The operator's selection in the first frame: the box around the boat. It lies within the inner 90 % of
    /// the picture's width and height.
    pub fn selection(&self) -> PixelBox {
        self.truth(0).bounds
    }

    /// Renders a frame and returns its truth. Frames beyond the last equal the last. The picture takes the
    /// scene's size and encoding (BT.709, limited range).
    pub fn render(&mut self, frame: u64, out: &mut Picture) -> SceneTruth {
        self.render_frame(frame, true, out);
        self.truth(frame)
    }

    /// Renders the same picture without the boat and its wake: the difference to [`Self::render`] is the
    /// boat.
    pub fn render_without_target(&mut self, frame: u64, out: &mut Picture) {
        self.render_frame(frame, false, out);
    }

    /// The truth of a frame.
    pub fn truth(&self, frame: u64) -> SceneTruth {
        let frame = self.clamped_frame(frame);
        let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
        let pose = self.trajectory.pose(frame);
        let view = &pose.view;
        let whole = self.boat.outline.silhouette(pose.boat, pose.heading, view);
        let (x, y) = (libm::cos(pose.heading), libm::sin(pose.heading));
        let (du, dv) = view.picture_offset(x, y);
        let length = libm::hypot(du, dv);
        let minor_px = whole.extent((-dv / length, du / length));
        let area = whole.area();
        let inside = whole.clipped(view.size);
        let bounds = canonical_box(inside.bounds().clipped(view.size));
        let mut distractors = [PixelBox::default(); MAX_DISTRACTORS];
        let seen = self.distractors.iter().map(|object| object.bounds(time_s, view));
        for (slot, bounds) in distractors.iter_mut().zip(seen.filter(|bounds| !bounds.is_empty())) {
            *slot = bounds;
        }
        SceneTruth {
            time_s,
            bounds,
            visible_share: if bounds.is_empty() { 0.0 } else { (inside.area() / area).min(1.0) },
            centre: view.picture(pose.boat),
            heading: Angle::from_radians(libm::atan2(-dv, du)),
            major_px: 2.0 * self.boat.outline.half_length * length,
            minor_px,
            is_under_way: pose.speed > MIN_UNDER_WAY_SPEED,
            camera_shift: self.camera_shift(frame),
            distractors,
        }
    }

    /// Direction of the principal axis of the whole hull's silhouette (second moments of area), anticlockwise
    /// from image right, within +-90 degrees. It differs from the heading's line by up to 9 degrees, by 1 on
    /// average.
    pub fn silhouette_axis(&self, frame: u64) -> Angle {
        let pose = self.trajectory.pose(self.clamped_frame(frame));
        let silhouette = self.boat.outline.silhouette(pose.boat, pose.heading, &pose.view);
        Angle::from_radians(silhouette.axis())
    }

    fn clamped_frame(&self, frame: u64) -> i64 {
        frame.min(self.frames - 1) as i64
    }

    /// Where the point at the centre of the picture was in the frame before, relative to the centre.
    fn camera_shift(&self, frame: i64) -> (f64, f64) {
        let (before, now) = (self.trajectory.pose(frame - 1).view, self.trajectory.pose(frame).view);
        let (was, centre) = (before.picture(now.camera), now.size.centre());
        (centre.u - was.u, centre.v - was.v)
    }

    fn render_frame(&mut self, frame: u64, with_target: bool, out: &mut Picture) {
        let frame = self.clamped_frame(frame);
        let time_s = frame as f64 / f64::from(FRAMES_PER_SECOND);
        let pose = *self.trajectory.pose(frame);
        let view = &pose.view;
        // Share of the time from frame to frame during which the picture is exposed.
        let open = self.conditions.exposure_s * f64::from(FRAMES_PER_SECOND);
        let sun = self.conditions.sun;
        let (before, after) = (self.camera_shift(frame), self.camera_shift(frame + 1));
        let camera = (open * (before.0 + after.0) / 2.0, open * (before.1 + after.1) / 2.0);

        self.wake.update(&self.trajectory, frame, &self.boat.outline, self.wake_strength);
        self.water.render(&mut self.canvas, view, &self.conditions, time_s, &self.wake);
        if let Some(shore) = &self.shore {
            let relative = f64::from(self.script.size.width) / f64::from(REFERENCE.width);
            shore.render(&mut self.canvas, view, &self.water, relative);
        }
        self.canvas.motion_blur(camera);
        for object in self.clutter.iter().chain(&self.distractors) {
            let (du, dv) = view.picture_offset(object.velocity.0, object.velocity.1);
            let own_s = self.conditions.exposure_s;
            let motion = (camera.0 + du * own_s, camera.1 + dv * own_s);
            object.body.render(
                &mut self.canvas,
                object.pose_at(time_s),
                ObjectExposure { view, motion, sun },
            );
        }
        if with_target {
            let (was, is_next) = (self.trajectory.pose(frame - 1), self.trajectory.pose(frame + 1));
            let (from, to) = (was.view.picture(was.boat), is_next.view.picture(is_next.boat));
            let motion = (open * (to.u - from.u) / 2.0, open * (to.v - from.v) / 2.0);
            let plane_pose = PlanePose { at: pose.boat, heading: pose.heading };
            self.boat.render(&mut self.canvas, plane_pose, ObjectExposure { view, motion, sun });
        }
        self.canvas.blur(self.conditions.blur_px);
        let noise_seed = rng::hash(self.seed, stream::SENSOR, frame as u64 + 1);
        let Conditions { saturation, noise, .. } = self.conditions;
        let sensor = Sensor { light: self.conditions.light(time_s), saturation, noise };
        self.canvas.expose(sensor, noise_seed, out);
    }
}

/// The box, or the default box where it is empty.
fn canonical_box(bounds: PixelBox) -> PixelBox {
    if bounds.is_empty() { PixelBox::default() } else { bounds }
}
