//! The things of a snapshot as shapes with a pose: a pier becomes its stretches, a shore the huts and crates on it.

pub(super) mod paint;
mod shapes;

use barrelman_vocab::Angle;

use super::mesh::{Mesh, Part};
use crate::noise;
use crate::pose::{BodyPose, WorldPoint};
use crate::snapshot::{Snapshot, Target, Thing, ThingKind};

/// A kind of shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Boat,
    RedCraft,
    Buoy,
    LifeJacket,
    Swimmer,
    PierWithPosts,
    Pier,
    Hut,
    Crate,
    FloorTarget,
    FloorMark,
}

/// One shape in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instance {
    pub(super) shape: Shape,
    pub(super) pose: BodyPose,
    /// How far it is stretched along its axes.
    pub(super) scale: [f32; 3],
    pub(super) seed: u64,
    pub(super) is_target: bool,
    /// How a boat's nozzle is turned, radians to the left.
    nozzle: f32,
}

/// All shapes, built once.
#[derive(Debug)]
pub(super) struct Shapes(Vec<Mesh>);

impl Shapes {
    pub(super) fn new() -> Self {
        let shapes = vec![
            shapes::boat(),
            shapes::red_craft(),
            shapes::buoy(),
            shapes::life_jacket(),
            shapes::swimmer(),
            shapes::pier(STRETCH_M, 1.0, true),
            shapes::pier(STRETCH_M, 1.0, false),
            shapes::hut(),
            shapes::crate_on_beach(),
            shapes::floor_target(),
            shapes::floor_mark(),
        ];
        Self(shapes.into_iter().map(Mesh::measured).collect())
    }

    pub(super) fn of(&self, shape: Shape) -> &Mesh {
        &self.0[shape as usize]
    }
}

impl Instance {
    fn new(shape: Shape, pose: BodyPose, seed: u64) -> Self {
        Self { shape, pose, scale: [1.0; 3], seed, is_target: false, nozzle: 0.0 }
    }

    /// Forward, left and up of the body in the world.
    pub(super) fn axes(&self) -> [[f32; 3]; 3] {
        body_axes(&self.pose)
    }

    /// Whether water cuts it.
    pub(super) fn is_afloat(&self) -> bool {
        !matches!(self.shape, Shape::FloorTarget | Shape::FloorMark | Shape::Hut | Shape::Crate)
    }

    /// Whether its shadow is worth drawing: paint has none, and a hut's falls inland.
    pub(super) fn casts_shadow(&self) -> bool {
        !matches!(self.shape, Shape::FloorMark | Shape::Hut | Shape::Crate)
    }

    /// How high over the water the things stand that the mirror image is mostly of, metres.
    pub(super) fn mirror_height_m(&self) -> f64 {
        match self.shape {
            Shape::Pier | Shape::PierWithPosts => 1.0,
            Shape::Buoy => 0.4,
            _ => 0.22,
        }
    }

    /// From a place of the world to its origin, metres.
    pub(super) fn distance_from(&self, place: WorldPoint) -> f64 {
        place.to(self.pose.place).length()
    }

    /// A corner of the mesh in the body's frame of reference, stretched, the nozzle turned.
    pub(super) fn bent(&self, mesh: &Mesh, index: usize, place: [f32; 3]) -> [f32; 3] {
        let mut p: [f32; 3] = core::array::from_fn(|i| place[i] * self.scale[i]);
        if self.nozzle != 0.0 && self.shape == Shape::Boat && mesh.vertices[index].part == Part::Nozzle {
            let behind = p[0] + NOZZLE_PIVOT_M;
            p[1] += behind * self.nozzle;
        }
        p
    }
}

/// The nozzle turns about a place so far behind the boat's middle.
const NOZZLE_PIVOT_M: f32 = 0.58;
/// A mark is so much smaller than a buoy.
const MARK_SCALE: f32 = 0.45;
/// Length of a stretch of pier, metres.
const STRETCH_M: f32 = 3.0;

/// Forward, left and up of a body in the world.
pub(super) fn body_axes(pose: &BodyPose) -> [[f32; 3]; 3] {
    let (sh, ch) = libm::sincos(pose.heading.radians());
    let (sp, cp) = libm::sincos(pose.pitch.radians());
    let (sr, cr) = libm::sincos(pose.roll.radians());
    let forward = [ch * cp, sh * cp, sp];
    let (level, up) = ([-sh, ch, 0.0], [-sp * ch, -sp * sh, cp]);
    let left: [f64; 3] = core::array::from_fn(|i| level[i] * cr + up[i] * sr);
    let up: [f64; 3] = core::array::from_fn(|i| up[i] * cr - level[i] * sr);
    [forward, left, up].map(|axis| axis.map(|v| v as f32))
}

/// Writes down every shape of a snapshot. The target comes first.
pub(super) fn instances(snapshot: &Snapshot, list: &mut Vec<Instance>) {
    list.clear();
    let mut target = match snapshot.target {
        Target::Boat(boat) => Instance {
            nozzle: libm::tan(boat.nozzle.radians()) as f32,
            ..Instance::new(Shape::Boat, boat.pose, 0)
        },
        Target::FloorTarget(pose) => Instance::new(Shape::FloorTarget, pose, 0),
    };
    target.is_target = true;
    list.push(target);
    for thing in &snapshot.things {
        match thing.kind {
            ThingKind::FloorMark => list.push(Instance::new(Shape::FloorMark, thing.pose, thing.seed)),
            ThingKind::Buoy => list.push(Instance::new(Shape::Buoy, thing.pose, thing.seed)),
            ThingKind::MarkBuoy => list.push(Instance {
                scale: [MARK_SCALE; 3],
                ..Instance::new(Shape::Buoy, thing.pose, paint::YELLOW_BUOY)
            }),
            ThingKind::LifeJacket => list.push(Instance::new(Shape::LifeJacket, thing.pose, thing.seed)),
            ThingKind::Swimmer => list.push(Instance::new(Shape::Swimmer, thing.pose, thing.seed)),
            ThingKind::RedCraft => list.push(Instance::new(Shape::RedCraft, thing.pose, thing.seed)),
            ThingKind::Pier { length_m, breadth_m } => pier(thing, length_m, breadth_m, list),
            ThingKind::Shore => on_shore(thing, list),
        }
    }
}

fn pier(thing: &Thing, length_m: f64, breadth_m: f64, list: &mut Vec<Instance>) {
    let count = libm::ceil(length_m / f64::from(STRETCH_M)).max(1.0) as usize;
    let step = length_m / count as f64;
    let (sin, cos) = libm::sincos(thing.pose.heading.radians());
    for index in 0..count {
        let along = (index as f64 + 0.5) * step - 0.5 * length_m;
        let place =
            WorldPoint { x: thing.pose.place.x + along * cos, y: thing.pose.place.y + along * sin, z: 0.0 };
        let shape = if index % 2 == 0 { Shape::PierWithPosts } else { Shape::Pier };
        let pose = BodyPose { place, pitch: Angle::ZERO, roll: Angle::ZERO, ..thing.pose };
        let scale = [(step / f64::from(STRETCH_M)) as f32, breadth_m as f32, 1.0];
        list.push(Instance { scale, ..Instance::new(shape, pose, thing.seed) });
    }
}

/// Huts and crates behind the coast.
fn on_shore(thing: &Thing, list: &mut Vec<Instance>) {
    let (sin, cos) = libm::sincos(thing.pose.heading.radians());
    for index in 0..14_u64 {
        let chance = |stream| noise::unit(thing.seed, stream, index);
        let is_hut = index % 3 == 0;
        let along = (index as f64 - 7.0) * 9.0 + 7.0 * chance(1);
        let inland = if is_hut { 13.0 + 5.0 * chance(2) } else { 6.5 + 4.0 * chance(2) };
        let place = WorldPoint {
            x: thing.pose.place.x + along * cos - inland * sin,
            y: thing.pose.place.y + along * sin + inland * cos,
            z: if is_hut { -0.3 } else { 0.0 },
        };
        let heading = Angle::from_radians(thing.pose.heading.radians() + 0.5 * (chance(3) - 0.5));
        let pose = BodyPose { place, heading, pitch: Angle::ZERO, roll: Angle::ZERO };
        let shape = if is_hut { Shape::Hut } else { Shape::Crate };
        let seed = if is_hut { noise::hash(thing.seed, 4, index) } else { 2 * (index % 2) };
        list.push(Instance::new(shape, pose, seed));
    }
}
