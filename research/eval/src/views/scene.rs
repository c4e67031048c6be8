//! What is in the world of a view at a tick: the camera, the boat on its way, and the objects around it.
//!
//! World coordinates: x to the right of the camera, y ahead, z up, metres; the camera stands above the
//! origin.

use barrelman_sim::snapshot::{Boat, Ground, Light, ObjectKind, SceneObject, SensorState, Target};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{BodyPose, CameraPose, Sea, Snapshot, WorldPoint};
use barrelman_vocab::Angle;

use super::catalogue::{Surroundings, View};

/// The tick at which a view is rendered: 20 s after the start.
pub(super) const END_TICK: u64 = TICKS_PER_SECOND as u64 * 20;

/// Time from the first row of the rolling shutter to the last, seconds.
const READOUT_S: f64 = 0.018;
/// Distance to the boat where the camera looks nearly along the horizon, and the largest otherwise, metres.
const LEVEL_VIEW_DISTANCE_M: f64 = 9.0;
const MAX_DISTANCE_M: f64 = 18.0;
/// Share of the wave's slope that a floating body follows.
const SLOPE_SHARE: f64 = 0.6;

/// The world of a view at a tick.
pub(super) fn snapshot(view: &View, sea: &Sea, tick: u64) -> Snapshot {
    let ahead_m = view.height_m / view.depression_deg.to_radians().tan();
    let ahead_m =
        if view.depression_deg < 10.0 { LEVEL_VIEW_DISTANCE_M } else { ahead_m.min(MAX_DISTANCE_M) };
    let camera = |pan_rad: f64| CameraPose {
        position: world_point(0.0, 0.0, view.height_m),
        pan: Angle::from_radians(pan_rad),
        tilt: Angle::from_degrees(-view.depression_deg),
        roll: Angle::ZERO,
    };
    let (ground, target) = match view.surroundings {
        Surroundings::LaboratoryFloor => {
            (Ground::Floor, Target::FloorTarget(level_pose(0.3, ahead_m, 140.0)))
        }
        _ => (Ground::Water, Target::Boat(boat(sea, ahead_m, tick))),
    };
    Snapshot {
        tick,
        first_row: camera(0.0),
        last_row: camera((view.pan_deg_per_s * READOUT_S).to_radians()),
        zoom: 1.0,
        light: Light {
            sun_bearing: Angle::from_degrees(view.sun_deg.0),
            sun_elevation: Angle::from_degrees(view.sun_deg.1),
            overcast: view.overcast,
        },
        ground,
        target,
        objects: Placement { sea, ahead_m, tick }.objects(&view.surroundings),
        sensor: SensorState { exposure: 1.0, red: 1.0, blue: 1.0, exposure_s: 0.006 },
    }
}

/// Places objects relative to where the boat will be.
struct Placement<'a> {
    sea: &'a Sea,
    /// Distance of the boat at the end, metres.
    ahead_m: f64,
    tick: u64,
}

impl Placement<'_> {
    fn objects(&self, surroundings: &Surroundings) -> Vec<SceneObject> {
        match surroundings {
            Surroundings::People => self.people(),
            Surroundings::PierAndShore => {
                let mut objects = self.people();
                objects.extend(pier_and_shore());
                objects
            }
            Surroundings::Arena => self.arena(),
            Surroundings::LaboratoryFloor => self.floor_marks(),
        }
    }

    fn floating(&self, kind: ObjectKind, x: f64, y: f64, heading_deg: f64, seed: u64) -> SceneObject {
        SceneObject { kind, pose: floating_pose(self.sea, x, self.ahead_m + y, heading_deg, self.tick), seed }
    }

    fn people(&self) -> Vec<SceneObject> {
        vec![
            self.floating(ObjectKind::LifeJacket, 2.4, -1.1, 70.0, 1),
            self.floating(ObjectKind::LifeJacket, -1.9, 2.4, -100.0, 2),
            self.floating(ObjectKind::LifeJacket, -0.6, 9.5, 20.0, 3),
            self.floating(ObjectKind::Swimmer, -3.0, 1.3, -60.0, 1),
            self.floating(ObjectKind::Swimmer, 1.7, 2.9, -120.0, 0),
            self.floating(ObjectKind::Buoy, 4.2, 4.6, 0.0, 0),
            self.floating(ObjectKind::Buoy, -4.6, 6.4, 0.0, 1),
        ]
    }

    fn arena(&self) -> Vec<SceneObject> {
        let buoys = [(-3.2, -3.0, 1), (3.0, -2.6, 2), (-3.6, 3.6, 1), (3.8, 3.4, 2), (0.2, 6.5, 1)];
        let mut objects: Vec<SceneObject> =
            buoys.into_iter().map(|(x, y, seed)| self.floating(ObjectKind::Buoy, x, y, 0.0, seed)).collect();
        objects.push(self.floating(ObjectKind::RedCraft, -2.4, 9.0, 30.0, 0));
        objects
    }

    fn floor_marks(&self) -> Vec<SceneObject> {
        let marks = [(-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5), (0.0, 0.0), (0.0, 3.0)];
        marks
            .into_iter()
            .zip(0..)
            .map(|((x, y), seed)| SceneObject {
                kind: ObjectKind::FloorMark,
                pose: level_pose(x, self.ahead_m + y, 0.0),
                seed,
            })
            .collect()
    }
}

fn pier_and_shore() -> [SceneObject; 3] {
    let pier = ObjectKind::Pier { length_m: 9.0, breadth_m: 1.8 };
    [
        SceneObject { kind: pier, pose: level_pose(-8.5, 19.0, 8.0), seed: 3 },
        SceneObject { kind: ObjectKind::Shore, pose: level_pose(-6.0, 17.0, 84.0), seed: 5 },
        SceneObject { kind: ObjectKind::Shore, pose: level_pose(0.0, 300.0, 3.0), seed: 8 },
    ]
}

fn world_point(x: f64, y: f64, z: f64) -> WorldPoint {
    WorldPoint { x, y, z }
}

/// A body that lies level at height 0.
fn level_pose(x: f64, y: f64, heading_deg: f64) -> BodyPose {
    BodyPose {
        position: world_point(x, y, 0.0),
        heading: Angle::from_degrees(heading_deg),
        pitch: Angle::ZERO,
        roll: Angle::ZERO,
    }
}

/// A body that floats: at the height of the water, inclined by part of the wave's slope.
fn floating_pose(sea: &Sea, x: f64, y: f64, heading_deg: f64, tick: u64) -> BodyPose {
    let surface = sea.surface_at(x, y, tick);
    let heading = Angle::from_degrees(heading_deg);
    let (sin, cos) = (heading.radians().sin(), heading.radians().cos());
    let along = surface.slope.0 * cos + surface.slope.1 * sin;
    let across = surface.slope.1 * cos - surface.slope.0 * sin;
    BodyPose {
        position: world_point(x, y, surface.elevation),
        heading,
        pitch: Angle::from_radians(SLOPE_SHARE * along),
        roll: Angle::from_radians(SLOPE_SHARE * across),
    }
}

/// The boat comes from the lower right and turns to the left as it goes away, along a circle that ends ahead
/// of the camera.
fn boat(sea: &Sea, ahead_m: f64, tick: u64) -> Boat {
    const SPEED_M_PER_S: f64 = 1.9;
    const TURN_RAD_PER_S: f64 = 0.055;
    const LAST_HEADING_DEG: f64 = 118.0;
    const BOW_UP_RAD: f64 = 0.05;
    let remaining_s = (END_TICK as f64 - tick as f64) / f64::from(TICKS_PER_SECOND);
    let last_heading = LAST_HEADING_DEG.to_radians();
    let heading = last_heading - TURN_RAD_PER_S * remaining_s;
    let radius_m = SPEED_M_PER_S / TURN_RAD_PER_S;
    let x = -radius_m * (last_heading.sin() - heading.sin());
    let y = ahead_m + radius_m * (last_heading.cos() - heading.cos());
    let mut pose = floating_pose(sea, x, y, heading.to_degrees(), tick);
    pose.pitch = Angle::from_radians(pose.pitch.radians() + BOW_UP_RAD);
    let velocity = (SPEED_M_PER_S * heading.cos(), SPEED_M_PER_S * heading.sin());
    Boat { pose, velocity, thrust: 0.5, nozzle: Angle::from_degrees(5.0) }
}
