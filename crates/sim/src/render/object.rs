//! The objects of a snapshot as shapes with poses: a pier becomes its sections, a shore the huts and crates
//! on it.

pub(super) mod paint;
mod shapes;

use barrelman_vocab::Angle;
use barrelman_vocab::rng;

use super::mesh::{Mesh, Part};
use crate::noise;
use crate::pose::{BodyPose, WorldPoint};
use crate::snapshot::{ObjectKind, SceneObject, Snapshot, Target};

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

/// A shape in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instance {
    pub(super) shape: Shape,
    pub(super) pose: BodyPose,
    /// Scale along the body's axes.
    pub(super) scale: [f32; 3],
    pub(super) seed: u64,
    pub(super) is_target: bool,
    /// Tangent of the nozzle's angle, positive to the left.
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
            shapes::pier(PIER_SECTION_M, 1.0, true),
            shapes::pier(PIER_SECTION_M, 1.0, false),
            shapes::hut(),
            shapes::crate_on_beach(),
            shapes::floor_target(),
            shapes::floor_mark(),
        ];
        Self(shapes.into_iter().map(Mesh::measured).collect())
    }

    pub(super) fn mesh(&self, shape: Shape) -> &Mesh {
        &self.0[shape as usize]
    }
}

impl Instance {
    fn new(shape: Shape, pose: BodyPose, seed: u64) -> Self {
        Self { shape, pose, scale: [1.0; 3], seed, is_target: false, nozzle: 0.0 }
    }

    /// Forward, left and up of the body, in the world.
    pub(super) fn axes(&self) -> [[f32; 3]; 3] {
        body_axes(&self.pose)
    }

    /// Whether the water cuts the shape.
    pub(super) fn is_afloat(&self) -> bool {
        !matches!(self.shape, Shape::FloorTarget | Shape::FloorMark | Shape::Hut | Shape::Crate)
    }

    /// Whether the shadow is rendered: paint has none, and that of a hut falls inland.
    pub(super) fn casts_shadow(&self) -> bool {
        !matches!(self.shape, Shape::FloorMark | Shape::Hut | Shape::Crate)
    }

    /// Height above the water of most of the reflection's sources, metres.
    pub(super) fn reflected_height_m(&self) -> f64 {
        match self.shape {
            Shape::Pier | Shape::PierWithPosts => 1.0,
            Shape::Buoy => 0.4,
            _ => 0.22,
        }
    }

    /// Distance from a point of the world to the origin, metres.
    pub(super) fn distance_from(&self, position: WorldPoint) -> f64 {
        position.vector_to(self.pose.position).norm()
    }

    /// A vertex in the body's frame of reference, scaled, with the nozzle turned.
    pub(super) fn deformed(&self, mesh: &Mesh, index: usize, position: [f32; 3]) -> [f32; 3] {
        let mut p: [f32; 3] = core::array::from_fn(|i| position[i] * self.scale[i]);
        if self.nozzle != 0.0 && self.shape == Shape::Boat && mesh.vertices[index].part == Part::Nozzle {
            let behind = p[0] + NOZZLE_PIVOT_M;
            p[1] += behind * self.nozzle;
        }
        p
    }
}

/// Distance of the nozzle's pivot behind the boat's middle, metres.
const NOZZLE_PIVOT_M: f32 = 0.58;
/// Size of a mark buoy over that of a buoy.
const MARK_SCALE: f32 = 0.45;
/// Length of a pier section, metres.
const PIER_SECTION_M: f32 = 3.0;

/// Forward, left and up of a body, in the world.
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

/// Lists the shapes of a snapshot. The target comes first.
pub(super) fn list_instances(snapshot: &Snapshot, list: &mut Vec<Instance>) {
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
    for object in &snapshot.objects {
        match object.kind {
            ObjectKind::FloorMark => list.push(Instance::new(Shape::FloorMark, object.pose, object.seed)),
            ObjectKind::Buoy => list.push(Instance::new(Shape::Buoy, object.pose, object.seed)),
            ObjectKind::MarkBuoy => list.push(Instance {
                scale: [MARK_SCALE; 3],
                ..Instance::new(Shape::Buoy, object.pose, paint::YELLOW_BUOY)
            }),
            ObjectKind::LifeJacket => list.push(Instance::new(Shape::LifeJacket, object.pose, object.seed)),
            ObjectKind::Swimmer => list.push(Instance::new(Shape::Swimmer, object.pose, object.seed)),
            ObjectKind::RedCraft => list.push(Instance::new(Shape::RedCraft, object.pose, object.seed)),
            ObjectKind::Pier { length_m, breadth_m } => pier(object, length_m, breadth_m, list),
            ObjectKind::Shore => shore_objects(object, list),
        }
    }
}

fn pier(object: &SceneObject, length_m: f64, breadth_m: f64, list: &mut Vec<Instance>) {
    let count = libm::ceil(length_m / f64::from(PIER_SECTION_M)).max(1.0) as usize;
    let step = length_m / count as f64;
    let (sin, cos) = libm::sincos(object.pose.heading.radians());
    for index in 0..count {
        let along = (index as f64 + 0.5) * step - 0.5 * length_m;
        let position = WorldPoint {
            x: object.pose.position.x + along * cos,
            y: object.pose.position.y + along * sin,
            z: 0.0,
        };
        let shape = if index % 2 == 0 { Shape::PierWithPosts } else { Shape::Pier };
        let pose = BodyPose { position, pitch: Angle::ZERO, roll: Angle::ZERO, ..object.pose };
        let scale = [(step / f64::from(PIER_SECTION_M)) as f32, breadth_m as f32, 1.0];
        list.push(Instance { scale, ..Instance::new(shape, pose, object.seed) });
    }
}

/// Huts and crates on a shore.
fn shore_objects(object: &SceneObject, list: &mut Vec<Instance>) {
    let (sin, cos) = libm::sincos(object.pose.heading.radians());
    for index in 0..14_u64 {
        let random = |stream| noise::unit(object.seed, stream, index);
        let is_hut = index % 3 == 0;
        let along = (index as f64 - 7.0) * 9.0 + 7.0 * random(1);
        let inland = if is_hut { 13.0 + 5.0 * random(2) } else { 6.5 + 4.0 * random(2) };
        let position = WorldPoint {
            x: object.pose.position.x + along * cos - inland * sin,
            y: object.pose.position.y + along * sin + inland * cos,
            z: if is_hut { -0.3 } else { 0.0 },
        };
        let heading = Angle::from_radians(object.pose.heading.radians() + 0.5 * (random(3) - 0.5));
        let pose = BodyPose { position, heading, pitch: Angle::ZERO, roll: Angle::ZERO };
        let shape = if is_hut { Shape::Hut } else { Shape::Crate };
        let seed = if is_hut { rng::hash(object.seed, 4, index) } else { 2 * (index % 2) };
        list.push(Instance::new(shape, pose, seed));
    }
}
