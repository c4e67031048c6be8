//! The world of a trial, advanced in ticks.
//!
//! In each tick the platform sways, the camera's axes turn as commanded, and the target moves.
//! [`World::truth`] and [`World::write_snapshot`] describe the state at the present tick. Rendering, latency
//! and control are not part of the world.

use barrelman_vocab::{Angle, CameraCommand, ImagePoint, Timestamp};

use crate::boat::{HelmCommand, JetBoat};
use crate::camera_axis::CameraAxis;
use crate::camera_mount::CameraMount;
use crate::electronics::Electronics;
use crate::helmsman::Helmsman;
use crate::kite::{Kite, SETTLING_TICKS};
use crate::optics::Optics;
use crate::path::InvalidPath;
use crate::pose::{BodyPose, CameraPose, WorldPoint};
use crate::pursuit::{Pursuit, wrap_angle};
use crate::scenario::{CameraSetup, Platform, Scenario, TargetScript};
use crate::scenery::Scenery;
use crate::sea::Sea;
use crate::snapshot::{Boat, Ground, Light, SceneObject, Snapshot, Target};
use crate::sway::SwayingPlatform;
use crate::tick::TICKS_PER_SECOND;
use crate::wind::TurbulentWind;

/// The true state at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// The tick.
    pub tick: u64,
    /// Time since the start of the trial.
    pub at: Timestamp,
    /// The camera.
    pub camera: CameraPose,
    /// The target.
    pub target: BodyPose,
    /// Projection of the target's position, also beyond the border of the picture. A target behind the camera
    /// is projected far out on its side.
    pub image: ImagePoint,
    /// Whether the projection lies within the picture.
    pub in_picture: bool,
    /// The camera's focal length, pixels.
    pub focal_px: f64,
    /// From the camera to the target, metres.
    pub range_m: f64,
    /// Rates of the camera's axes, rad/s: pan, tilt.
    pub rates: (f64, f64),
}

/// The world of a trial.
#[derive(Debug, Clone)]
pub struct World {
    camera: CameraSetup,
    light: Light,
    mount: CameraMount,
    platform: MovingPlatform,
    sea: Option<Sea>,
    /// The wind at the target.
    wind: Option<TurbulentWind>,
    target: MovingTarget,
    scenery: Scenery,
    electronics: Electronics,
    /// Steers the boat instead of the helmsman.
    helm_override: Option<HelmCommand>,
    tick: u64,
    /// `None`: the world has no end.
    last_tick: Option<u64>,
}

#[derive(Debug, Clone)]
enum MovingPlatform {
    Swaying(Box<SwayingPlatform>),
    Kite(Box<Kite>),
}

#[derive(Debug, Clone)]
enum MovingTarget {
    Pursuit { pursuit: Box<Pursuit>, on_water: bool },
    Boat { boat: Box<JetBoat>, helmsman: Helmsman },
}

/// Ticks before the start of the trial have numbers from here on.
const SETTLING_TICK_OFFSET: u64 = 1 << 40;
/// Reference height of the surface wind, m.
const SURFACE_WIND_HEIGHT_M: f64 = 3.0;

impl World {
    /// The world at the start of a trial.
    ///
    /// # Errors
    /// [`InvalidPath`] where the target's way-points make no path.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, InvalidPath> {
        let water = scenario.water;
        let target = MovingTarget::new(scenario, seed)?;
        let camera = scenario.camera.clone();
        let position = target.pose().position;
        let (pan_off, tilt_off) = camera.first_view.sampled_offset(seed);
        let pan = Angle::from_radians(wrap_angle(libm::atan2(position.x, position.y) + pan_off.radians()));
        let tilt = Angle::from_radians(tilt_off.radians() - depression(camera.height_m, position));
        let calm = crate::sea::Wind { speed_mps: 0.0, towards: Angle::ZERO };
        let mean = water.map_or(calm, |water| water.wind);
        let platform = match scenario.platform {
            Platform::Swaying(sway) => MovingPlatform::Swaying(Box::new(SwayingPlatform::new(&sway, seed))),
            Platform::Kite { gustiness } => {
                let wind = TurbulentWind::new(mean, camera.height_m, gustiness, seed);
                let mut kite = Kite::new(camera.height_m, wind, mean.towards, seed);
                // The kite has settled in the wind when the trial begins.
                for tick in 0..SETTLING_TICKS {
                    kite.advance(SETTLING_TICK_OFFSET + tick, false);
                }
                MovingPlatform::Kite(Box::new(kite))
            }
        };
        Ok(Self {
            mount: CameraMount::at_angles(scenario.mount, pan, tilt),
            platform,
            sea: water
                .map(|water| Sea::new(water.state, water.wind, seed).with_current(water.current_m_per_s)),
            wind: water.map(|water| {
                TurbulentWind::new(water.wind, SURFACE_WIND_HEIGHT_M, 1.0, seed.wrapping_add(1 << 40))
            }),
            target,
            scenery: Scenery::new(&scenario.objects, seed),
            electronics: Electronics::new(&camera.electronics, seed),
            light: scenario.light,
            camera,
            helm_override: None,
            tick: 0,
            last_tick: Some((scenario.max_s * f64::from(TICKS_PER_SECOND)) as u64),
        })
    }

    /// The same world without an end: neither the scenario's time nor a target at the end of its path ends
    /// it. A helmsman goes round or waits ([`Helmsman::without_end`]); another target rests at the end of its
    /// path.
    #[must_use]
    pub fn without_end(self) -> Self {
        let target = match self.target {
            MovingTarget::Pursuit { .. } => self.target,
            MovingTarget::Boat { boat, helmsman } => {
                MovingTarget::Boat { boat, helmsman: helmsman.without_end() }
            }
        };
        Self { target, last_tick: None, ..self }
    }

    /// The camera's tilt at the start of a scenario's trials without random offsets.
    ///
    /// # Errors
    /// [`InvalidPath`] where the target's way-points make no path.
    pub fn nominal_tilt(scenario: &Scenario) -> Result<Angle, InvalidPath> {
        let position = MovingTarget::new(scenario, 0)?.pose().position;
        let (_, off) = scenario.camera.first_view.mean;
        Ok(Angle::from_radians(off - depression(scenario.camera.height_m, position)))
    }

    /// Passes a command to the camera, at the present tick.
    pub fn command(&mut self, command: CameraCommand) {
        self.mount.command(command);
    }

    /// Steers the boat from now on; `None` returns control to the helmsman.
    pub fn override_helm(&mut self, helm: Option<HelmCommand>) {
        self.helm_override = helm;
    }

    /// Whether the target is a boat that can be steered. Other targets follow their path regardless.
    pub const fn is_steerable(&self) -> bool {
        matches!(self.target, MovingTarget::Boat { .. })
    }

    /// Speed of the target ahead, m/s.
    pub const fn target_speed_m_per_s(&self) -> f64 {
        match &self.target {
            MovingTarget::Pursuit { pursuit, .. } => pursuit.speed_m_per_s(),
            MovingTarget::Boat { boat, .. } => boat.speed_ahead_mps(),
        }
    }

    /// Advances by one tick.
    pub fn advance(&mut self) {
        self.advance_motion();
        self.electronics.advance(self.tick);
        self.mount.advance();
        self.tick += 1;
    }

    fn advance_motion(&mut self) {
        match &mut self.platform {
            MovingPlatform::Swaying(swaying) => swaying.advance(self.tick),
            MovingPlatform::Kite(kite) => kite.advance(self.tick, self.mount.pan.is_commanded()),
        }
        if let Some(wind) = &mut self.wind {
            wind.advance(self.tick);
        }
        match &mut self.target {
            MovingTarget::Pursuit { pursuit, .. } => pursuit.advance(self.tick),
            MovingTarget::Boat { boat, helmsman } => {
                let own = helmsman.helm_command(boat);
                if let Some(sea) = &self.sea {
                    let wind = self.wind.as_ref().map_or((0.0, 0.0), TurbulentWind::velocity);
                    boat.advance(self.helm_override.unwrap_or(own), sea, wind, self.tick);
                }
            }
        }
    }

    /// Rates of the camera's axes, rad/s: pan, tilt.
    pub const fn camera_rates(&self) -> (f64, f64) {
        (self.mount.pan.rate().radians_per_second(), self.mount.tilt.rate().radians_per_second())
    }

    /// Ticks since the start of the trial.
    pub const fn tick(&self) -> u64 {
        self.tick
    }

    /// Time of a tick since the start of the trial.
    pub const fn time_of(tick: u64) -> Timestamp {
        // Whole nanoseconds, rounded down: 25 ms are three ticks to the nanosecond.
        Timestamp::from_nanos(tick * 1_000_000_000 / TICKS_PER_SECOND as u64)
    }

    /// Present time.
    pub const fn now(&self) -> Timestamp {
        Self::time_of(self.tick)
    }

    /// Whether the camera takes a video frame at this tick.
    pub const fn is_frame_due(&self) -> bool {
        self.tick.is_multiple_of(self.camera.ticks_per_picture())
    }

    /// Whether the trial is over. A boat whose helm is overridden does not arrive.
    pub fn is_over(&self) -> bool {
        let Some(last_tick) = self.last_tick else { return false };
        let arrived = match &self.target {
            MovingTarget::Pursuit { pursuit, .. } => pursuit.is_over(),
            MovingTarget::Boat { helmsman, .. } => self.helm_override.is_none() && helmsman.has_arrived(),
        };
        arrived || self.tick >= last_tick
    }

    /// The sea, if there is one.
    pub const fn sea(&self) -> Option<&Sea> {
        self.sea.as_ref()
    }

    /// The camera's present pose.
    pub fn camera_pose(&self) -> CameraPose {
        let ((yaw, pitch, roll), off) = self.platform_offset();
        let turned =
            |axis: &CameraAxis, by: Angle| Angle::from_radians(axis.angle().radians() + by.radians());
        CameraPose {
            position: WorldPoint { x: off.x, y: off.y, z: self.camera.height_m + off.z },
            pan: turned(&self.mount.pan, yaw),
            tilt: turned(&self.mount.tilt, pitch),
            roll,
        }
    }

    /// The present optics, with the zoom.
    pub fn optics(&self) -> Optics {
        Optics { focal_px: self.zoom() * self.camera.optics.focal_px, ..self.camera.optics }
    }

    /// The present focal length over the scenario's.
    fn zoom(&self) -> f64 {
        let by_itself = self.camera.zoom.map_or(1.0, |zoom| zoom.factor_at(self.tick));
        by_itself * self.mount.zoom_factor().unwrap_or(1.0)
    }

    /// The present horizontal field of view of the frame, of a camera that zooms; `None`: it does not.
    pub fn zoomed_field_of_view(&self) -> Option<Angle> {
        if self.camera.zoom.is_none() && self.mount.zoom_factor().is_none() {
            return None;
        }
        let half_width = 0.5 * f64::from(self.camera.frame.width);
        let focal_px = self.optics().focal_px;
        Some(Angle::from_radians(2.0 * libm::atan(half_width / focal_px)))
    }

    /// The target's present pose.
    pub fn target_pose(&self) -> BodyPose {
        self.target.pose()
    }

    /// Offset of the platform now: attitude (yaw, pitch, roll) and position.
    fn platform_offset(&self) -> ((Angle, Angle, Angle), WorldPoint) {
        match &self.platform {
            MovingPlatform::Swaying(swaying) => (swaying.attitude_offset(), swaying.displacement()),
            MovingPlatform::Kite(kite) => (kite.attitude_offset(self.mount.pan.angle()), kite.displacement()),
        }
    }

    /// Writes the present objects beside the target into `out`, reusing its memory: people, buoys, other
    /// craft.
    pub fn write_objects(&self, out: &mut Vec<SceneObject>) {
        self.scenery.write_objects(self.tick, self.sea.as_ref(), out);
    }

    /// The true state now.
    pub fn truth(&self) -> Truth {
        let (camera, target) = (self.camera_pose(), self.target_pose());
        let (right, down, ahead) = camera.camera_from_world(target.position);
        let optics = self.optics();
        let picture = optics.picture;
        let seen = optics.project((right, down, ahead.max(MIN_AHEAD_M)));
        let image = seen.map_or(ImagePoint { x: 0.0, y: 0.0 }, |seen| seen.in_image(picture));
        let (half_width, half_height) = (0.5 * f64::from(picture.width), 0.5 * f64::from(picture.height));
        Truth {
            tick: self.tick,
            at: self.now(),
            camera,
            target,
            image,
            in_picture: ahead > MIN_AHEAD_M && image.x.abs() < half_width && image.y.abs() < half_height,
            focal_px: optics.focal_px,
            range_m: camera.position.vector_to(target.position).norm(),
            rates: self.camera_rates(),
        }
    }

    /// Writes what is visible now into `snapshot`, reusing its memory.
    pub fn write_snapshot(&self, snapshot: &mut Snapshot) {
        let first_row = self.camera_pose();
        let (pan, tilt) = self.camera_rates();
        let turned = |angle: Angle, rate: f64| {
            Angle::from_radians(angle.radians() + rate * self.camera.rolling_shutter_s)
        };
        snapshot.tick = self.tick;
        snapshot.first_row = first_row;
        snapshot.last_row =
            CameraPose { pan: turned(first_row.pan, pan), tilt: turned(first_row.tilt, tilt), ..first_row };
        snapshot.zoom = self.zoom();
        snapshot.light = self.light;
        snapshot.ground = if self.sea.is_some() { Ground::Water } else { Ground::Floor };
        snapshot.target = self.target.to_snapshot(self.target_pose());
        snapshot.sensor = self.electronics.state();
        self.write_objects(&mut snapshot.objects);
    }

    /// A snapshot of the present state.
    pub fn snapshot(&self) -> Snapshot {
        let mut snapshot = Snapshot {
            tick: self.tick,
            first_row: self.camera_pose(),
            last_row: self.camera_pose(),
            zoom: 1.0,
            light: self.light,
            ground: Ground::Floor,
            target: self.target.to_snapshot(self.target_pose()),
            objects: Vec::new(),
            sensor: self.electronics.state(),
        };
        self.write_snapshot(&mut snapshot);
        snapshot
    }
}

/// Angle below the horizon of a point on the water, seen from this height above the origin, radians.
fn depression(height_m: f64, position: WorldPoint) -> f64 {
    libm::atan2(height_m, libm::hypot(position.x, position.y))
}

impl MovingTarget {
    fn new(scenario: &Scenario, seed: u64) -> Result<Self, InvalidPath> {
        Ok(match &scenario.target {
            TargetScript::Pursuit(script) => {
                let pursuit = Box::new(Pursuit::new(script.clone(), seed)?);
                Self::Pursuit { pursuit, on_water: scenario.water.is_some() }
            }
            TargetScript::Boat(script) => {
                let (helmsman, boat) = Helmsman::new(script, seed)?;
                // A boat at rest in a current drifts with it.
                let boat = match scenario.water.map(|water| water.current_m_per_s) {
                    Some(current) if current != (0.0, 0.0) => boat.with_velocity(current),
                    _ => boat,
                };
                Self::Boat { boat: Box::new(boat), helmsman }
            }
        })
    }

    fn pose(&self) -> BodyPose {
        match self {
            Self::Pursuit { pursuit, .. } => {
                let (x, y) = pursuit.position();
                BodyPose {
                    position: WorldPoint { x, y, z: 0.0 },
                    heading: pursuit.heading(),
                    pitch: Angle::ZERO,
                    roll: Angle::ZERO,
                }
            }
            Self::Boat { boat, .. } => boat.pose(),
        }
    }

    fn to_snapshot(&self, pose: BodyPose) -> Target {
        match self {
            Self::Pursuit { on_water: false, .. } => Target::FloorTarget(pose),
            Self::Pursuit { pursuit, on_water: true } => {
                let (s, c) = libm::sincos(pose.heading.radians());
                let speed = pursuit.speed_m_per_s();
                let thrust = crate::boat::throttle_for_speed(speed);
                Target::Boat(Boat { pose, velocity: (speed * c, speed * s), thrust, nozzle: Angle::ZERO })
            }
            Self::Boat { boat, .. } => {
                let (thrust, nozzle) = boat.jet();
                Target::Boat(Boat { pose, velocity: boat.velocity_over_ground(), thrust, nozzle })
            }
        }
    }
}

/// A target less far ahead of the camera than this is treated as beside it, metres.
const MIN_AHEAD_M: f64 = 0.06;
