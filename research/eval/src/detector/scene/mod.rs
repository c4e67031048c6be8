//! Random rendered scenes with the boxes of all people and boats: the simulator's water, sky, shores, buoys
//! and rescue boat, with boats and people of random shapes and colours drawn over them.
//!
//! Several pictures show one sea, each with a camera, light and objects of its own. Every number follows from
//! the seed and the picture's number. Not handled: boxes of people on board, objects that the simulator's
//! objects hide, and land, on which boats float as on water.

mod canvas;
mod mesh;
mod shapes;

pub(super) use shapes::Kind;

use anyhow::{Context, Result};
use barrelman_sim::render::{ENCODING, RenderSettings, Renderer, Serial, WaterColour};
use barrelman_sim::snapshot::{Boat, Ground, Light, ObjectKind, SceneObject, SensorState, Target};
use barrelman_sim::{BodyPose, CameraPose, Optics, Sea, SeaState, Snapshot, Wind, WorldPoint};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::{Angle, Picture, PictureSize, PixelBox};

use canvas::{Canvas, Finish, View};
use mesh::Mesh;

/// Size of the pictures.
const SIZE: PictureSize = PictureSize::new(640, 360);
/// Pictures of one sea.
pub(super) const PICTURES_OF_SEA: u64 = 8;
/// Where the simulator's boat is not in sight, metres.
const FAR_M: f64 = -20_000.0;
/// Largest range of objects, metres.
const MAX_RANGE_M: f64 = 900.0;

/// An object that is labelled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Labelled {
    pub(super) kind: Kind,
    pub(super) bounds: PixelBox,
}

/// Renders the pictures of a sea, and shows each with its boxes.
///
/// # Errors
/// If what `show` does fails.
pub(super) fn render_sea(
    seed: u64,
    number: u64,
    mut show: impl FnMut(u64, &Picture, &[Labelled]) -> Result<()>,
) -> Result<()> {
    let mut rng = SplitMix64::of_stream(seed, number);
    let state = SeaState::new((rng.uniform() * 4.5) as u8).context("sea states 0 to 4")?;
    let wind = Wind { speed_mps: state.wind_mps(), towards: Angle::from_degrees(rng.between(0.0, 360.0)) };
    let sea = Sea::new(state, wind, rng.next_u64());
    let focal_px = rng.between(0.6, 2.2) * f64::from(SIZE.width);
    let optics = Optics { picture: SIZE, focal_px, barrel: 0.0 };
    let waters = [WaterColour::Lake, WaterColour::Sea, WaterColour::Green];
    let water = waters[(rng.uniform() * 3.0) as usize % 3];
    let settings = RenderSettings { water, ..RenderSettings::new(optics, Some(sea.clone()), rng.next_u64()) };
    let mut renderer = Renderer::new(settings);
    let mut picture = Picture::black(SIZE, ENCODING);
    for index in 0..PICTURES_OF_SEA {
        let tick = 2400 * (index + 1);
        let labelled = Scene { sea: &sea, optics, tick, rng: &mut rng }.render(&mut renderer, &mut picture);
        show(number * PICTURES_OF_SEA + index, &picture, &labelled)?;
    }
    Ok(())
}

/// One picture in the making.
struct Scene<'a> {
    sea: &'a Sea,
    optics: Optics,
    tick: u64,
    rng: &'a mut SplitMix64,
}

impl Scene<'_> {
    fn render(&mut self, renderer: &mut Renderer, picture: &mut Picture) -> Vec<Labelled> {
        let camera = self.camera();
        let view = View::new(self.optics, &camera);
        let light = Light {
            sun_bearing: Angle::from_degrees(self.rng.between(-180.0, 180.0)),
            sun_elevation: Angle::from_degrees(self.rng.between(8.0, 75.0)),
            overcast: (1.6 * self.rng.uniform() - 0.3).clamp(0.0, 1.0),
        };
        let snapshot = self.snapshot(camera, light, &view);
        let rescue_boat = renderer.render(&snapshot, picture, &Serial).bounds;
        let mut canvas = Canvas::new(SIZE.width, SIZE.height);
        let kinds = self.draw_objects(&mut canvas, &view, &light, rescue_boat);
        canvas.composite(picture, self.rng.between(0.85, 1.3));
        let bounds = canvas.bounds(kinds.len());
        let drawn = kinds.into_iter().zip(bounds).filter(|(kind, _)| *kind != Kind::Other);
        let drawn = drawn.filter_map(|(kind, bounds)| Some(Labelled { kind, bounds: bounds? }));
        let rescue_boat = rescue_boat.map(|bounds| Labelled { kind: Kind::Boat, bounds });
        drawn.chain(rescue_boat).collect()
    }

    /// A camera 1.5 to 90 m above the water, from nearly level to straight down.
    fn camera(&mut self) -> CameraPose {
        // Cameras that see the horizon, and others.
        let low = self.rng.uniform() < 0.4;
        let depression_deg = if low { self.rng.between(2.0, 20.0) } else { self.rng.between(10.0, 90.0) };
        let range_m = 4.0 * libm::exp(self.rng.between(0.0, 3.6));
        let height_m = (range_m * libm::sin(depression_deg.to_radians())).clamp(1.5, 90.0);
        CameraPose {
            position: WorldPoint { x: 0.0, y: 0.0, z: height_m },
            pan: Angle::ZERO,
            tilt: Angle::from_degrees(-depression_deg),
            roll: Angle::from_degrees(self.rng.between(-5.0, 5.0)),
        }
    }

    /// The simulator's part: water and light, sometimes its boat, buoys, a pier or a shore.
    fn snapshot(&mut self, camera: CameraPose, light: Light, view: &View) -> Snapshot {
        let pose = if self.rng.uniform() < 0.3 { self.place(view).map(|(pose, _)| pose) } else { None };
        let far = BodyPose { position: WorldPoint { x: 0.0, y: FAR_M, z: 0.0 }, ..level(0.0) };
        let boat = Boat {
            pose: pose.unwrap_or(far),
            velocity: (0.0, 0.0),
            thrust: 0.0,
            nozzle: Angle::from_degrees(self.rng.between(-20.0, 20.0)),
        };
        let mut objects = Vec::new();
        for _ in 0..(self.rng.uniform() * 3.0) as u32 {
            let kind = if self.rng.uniform() < 0.6 { ObjectKind::Buoy } else { ObjectKind::MarkBuoy };
            let seed = self.rng.next_u64() % 4;
            objects.extend(self.place(view).map(|(pose, _)| SceneObject { kind, pose, seed }));
        }
        let ashore = self.rng.uniform();
        if ashore < 0.4 {
            let kind = if ashore < 0.25 {
                ObjectKind::Shore
            } else {
                ObjectKind::Pier {
                    length_m: self.rng.between(5.0, 30.0),
                    breadth_m: self.rng.between(1.2, 4.0),
                }
            };
            let (x, y) = (self.rng.between(-20.0, 20.0), 5.0 * libm::exp(self.rng.between(0.0, 5.5)));
            let pose = level(self.rng.between(-40.0, 60.0));
            let pose = BodyPose { position: WorldPoint { x, y, z: 0.0 }, ..pose };
            objects.push(SceneObject { kind, pose, seed: self.rng.next_u64() % 100 });
        }
        let mut gain = || self.rng.between(0.85, 1.2);
        let sensor = SensorState { exposure: gain(), red: gain(), blue: gain(), exposure_s: 0.006 };
        Snapshot {
            tick: self.tick,
            first_row: camera,
            last_row: camera,
            zoom: 1.0,
            light,
            ground: Ground::Water,
            target: Target::Boat(boat),
            objects,
            sensor,
        }
    }

    /// Draws people, boats and other objects, apart from each other. The kinds are in the order of their
    /// numbers.
    fn draw_objects(
        &mut self,
        canvas: &mut Canvas,
        view: &View,
        light: &Light,
        rescue_boat: Option<PixelBox>,
    ) -> Vec<Kind> {
        let count = if self.rng.uniform() < 0.1 { 0 } else { 1 + (self.rng.uniform() * 6.0) as u16 };
        let mut placed: Vec<(Kind, Mesh, f64)> = Vec::new();
        let mut foam = Vec::new();
        let mut taken: Vec<PixelBox> = rescue_boat.into_iter().collect();
        for _ in 0..count {
            let Some((pose, water_m)) = self.place(view) else { continue };
            let (kind, mesh) = match self.rng.uniform() {
                draw if draw < 0.42 => (Kind::Person, shapes::person(self.rng)),
                draw if draw < 0.84 => (Kind::Boat, shapes::boat(self.rng)),
                _ => (Kind::Other, shapes::other(self.rng)),
            };
            let (length, mesh) = (mesh.length(), mesh.placed(&pose));
            let Some(extent) = extent(view, &mesh) else { continue };
            if extent.w > 1.2 * f64::from(SIZE.width) || taken.iter().any(|other| other.iou(extent) > 0.02) {
                continue;
            }
            taken.push(extent);
            if kind != Kind::Other && self.rng.uniform() < 0.45 {
                let flat = BodyPose { position: pose.position, ..level(pose.heading.degrees()) };
                foam.push((shapes::foam(self.rng, length).placed(&flat), water_m));
            }
            placed.push((kind, mesh, water_m));
        }
        let mirror = self.rng.between(0.0, 0.35);
        for (_, mesh, water_m) in &placed {
            let finish = Finish { object: 0, water_m: *water_m, opacity: mirror };
            canvas.draw(view, light, &mirrored(mesh, *water_m), finish);
        }
        canvas.next_layer();
        for (mesh, water_m) in &foam {
            let finish = Finish { object: 0, water_m: *water_m, opacity: 0.7 };
            canvas.draw(view, light, mesh, finish);
        }
        canvas.next_layer();
        for ((_, mesh, water_m), object) in placed.iter().zip(0..) {
            canvas.draw(view, light, mesh, Finish { object, water_m: *water_m, opacity: 1.0 });
        }
        placed.into_iter().map(|(kind, ..)| kind).collect()
    }

    /// A pose afloat at a random point of the picture, and the height of the water there; `None` in the sky.
    fn place(&mut self, view: &View) -> Option<(BodyPose, f64)> {
        let (u, v) =
            (self.rng.uniform() * f64::from(SIZE.width), self.rng.uniform() * f64::from(SIZE.height));
        let (x, y) = view.on_water(u, v, MAX_RANGE_M)?;
        let surface = self.sea.surface_at(x, y, self.tick);
        let pose = BodyPose {
            position: WorldPoint { x, y, z: surface.elevation },
            heading: Angle::from_degrees(self.rng.between(0.0, 360.0)),
            pitch: Angle::from_degrees(self.rng.between(-4.0, 8.0)),
            roll: Angle::from_degrees(self.rng.between(-6.0, 6.0)),
        };
        Some((pose, surface.elevation))
    }
}

fn level(heading_deg: f64) -> BodyPose {
    let position = WorldPoint { x: 0.0, y: 0.0, z: 0.0 };
    BodyPose { position, heading: Angle::from_degrees(heading_deg), pitch: Angle::ZERO, roll: Angle::ZERO }
}

/// The box around a mesh, hidden parts included.
fn extent(view: &View, mesh: &Mesh) -> Option<PixelBox> {
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for corner in mesh.triangles.iter().flat_map(|(corners, _)| corners) {
        let [u, v, _] = view.project(*corner)?;
        low = [low[0].min(u), low[1].min(v)];
        high = [high[0].max(u), high[1].max(v)];
    }
    Some(PixelBox { u: low[0], v: low[1], w: high[0] - low[0], h: high[1] - low[1] })
}

/// The reflection of a mesh in the water.
fn mirrored(mesh: &Mesh, water_m: f64) -> Mesh {
    let mirror = |[x, y, z]: [f64; 3]| [x, y, 2.0 * water_m - z];
    let triangles = mesh.triangles.iter().map(|(corners, colour)| (corners.map(mirror), *colour)).collect();
    Mesh { triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(seed: u64) -> Vec<Vec<Labelled>> {
        let mut pictures = Vec::new();
        render_sea(seed, 0, |_, _, labelled| {
            pictures.push(labelled.to_vec());
            Ok(())
        })
        .unwrap();
        pictures
    }

    #[test]
    fn scenes_show_people_and_boats_within_the_picture() {
        let pictures = labels(1);
        assert_eq!(pictures.len() as u64, PICTURES_OF_SEA);
        let all: Vec<Labelled> = pictures.concat();
        for kind in [Kind::Person, Kind::Boat] {
            assert!(all.iter().any(|object| object.kind == kind), "{kind:?}");
        }
        for object in &all {
            assert_eq!(object.bounds.clipped(SIZE), object.bounds);
        }
    }
}
