//! The objects of one frame: their shapes, their order from far to near, and an image tile of each object, of
//! its reflection and of its shadow.

use std::sync::Mutex;

use super::camera::Camera;
use super::image_tile::{ImageKind, ImageTile, Scene, Source};
use super::land::Shore;
use super::light::Lighting;
use super::object::{self, Instance, Shapes};
use super::parallel::{ParallelFor, get_mut, lock};
use super::settings::{Effects, RenderSettings};
use super::waterline::Waterline;
use crate::pose::WorldPoint;
use crate::sea::Sea;
use crate::snapshot::{Ground, ObjectKind, Snapshot};

/// Reflections and shadows reach this many pixels beyond the picture, because waves shift them.
const SECONDARY_MARGIN_PX: i32 = 8;
/// Shadows are rendered where the sun is stronger than this and the sine of its elevation larger than that.
const MIN_SHADOW_SUN: f32 = 0.05;
const MIN_SHADOW_SINE: f32 = 0.1;

/// The objects of a frame and their image tiles.
#[derive(Debug, Default)]
pub(super) struct FrameObjects {
    pub(super) list: Vec<Instance>,
    waterlines: Vec<Option<Waterline>>,
    /// Indices into `list`, from far to near.
    pub(super) order: Vec<usize>,
    in_work: Vec<Mutex<ObjectTiles>>,
    /// In the order of `list`.
    pub(super) tiles: Vec<ObjectTiles>,
    pub(super) shores: Vec<Shore>,
}

/// The image tiles of one object.
#[derive(Debug, Default)]
pub(super) struct ObjectTiles {
    pub(super) direct: ImageTile,
    pub(super) reflection: ImageTile,
    pub(super) shadow: ImageTile,
    /// Pixels by which a water slope of 1 shifts the reflection.
    pub(super) shift_per_slope: f32,
}

impl FrameObjects {
    /// Lists the objects of a snapshot. `sea` is where they float; it is flat where the settings have no sea.
    pub(super) fn list(
        &mut self,
        settings: &RenderSettings,
        sea: &Sea,
        camera: &Camera,
        snapshot: &Snapshot,
    ) {
        object::list_instances(snapshot, &mut self.list);
        let count = self.list.len();
        self.in_work.resize_with(count.max(self.in_work.len()), Mutex::default);
        self.tiles.resize_with(count.max(self.tiles.len()), ObjectTiles::default);
        self.waterlines.clear();
        for object in &self.list {
            let position = object.pose.position;
            let waterline = (snapshot.ground == Ground::Water && object.is_afloat()).then(|| {
                let surface = sea.surface_at(position.x, position.y, snapshot.tick);
                let is_calm = settings.sea.is_none();
                Waterline {
                    position: WorldPoint { z: if is_calm { 0.0 } else { surface.elevation }, ..position },
                    slope: if is_calm { (0.0, 0.0) } else { surface.slope },
                }
            });
            self.waterlines.push(waterline);
        }
        let viewpoint = camera.middle().position;
        self.order.clear();
        self.order.extend(0..count);
        let list = &self.list;
        let distance = |index: &usize| list[*index].distance_from(viewpoint);
        self.order.sort_unstable_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.cmp(b)));
        self.shores.clear();
        self.shores.extend(
            snapshot.objects.iter().filter(|object| object.kind == ObjectKind::Shore).map(Shore::new),
        );
    }

    /// Renders reflections and shadows.
    pub(super) fn render_secondary(
        &mut self,
        (camera, light): (&Camera, &Lighting),
        shapes: &Shapes,
        effects: Effects,
        parallel: &dyn ParallelFor,
    ) {
        let (list, in_work, waterlines) = (&self.list, &self.in_work, &self.waterlines);
        let viewpoint = camera.middle().position;
        let is_sunny = light.sun[0] > MIN_SHADOW_SUN && light.to_sun[2] > MIN_SHADOW_SINE;
        parallel.run(list.len(), &|index| {
            let tiles = &mut *lock(&in_work[index]);
            let (object, waterline) = (&list[index], waterlines[index].as_ref());
            let mesh = shapes.mesh(object.shape);
            let scene = Scene { camera, light, margin: (SECONDARY_MARGIN_PX, SECONDARY_MARGIN_PX) };
            let source = Source { scene: &scene, mesh, object, waterline };
            tiles.reflection.clear();
            if effects.reflection && waterline.is_some() {
                tiles.reflection.render(&source, ImageKind::Reflection);
            }
            tiles.shadow.clear();
            if effects.shadow && is_sunny && object.casts_shadow() {
                tiles.shadow.render(&source, ImageKind::Shadow);
            }
            let range = object.distance_from(viewpoint).max(0.5);
            tiles.shift_per_slope = (camera.optics.focal_px / range * object.reflected_height_m()) as f32;
        });
        for (work, tiles) in self.in_work.iter_mut().map(get_mut).zip(&mut self.tiles) {
            core::mem::swap(&mut work.reflection, &mut tiles.reflection);
            core::mem::swap(&mut work.shadow, &mut tiles.shadow);
            tiles.shift_per_slope = work.shift_per_slope;
        }
    }

    /// Renders the objects themselves; the target also up to half a picture beyond the border, so that its
    /// visible share is known.
    pub(super) fn render_direct(
        &mut self,
        (camera, light): (&Camera, &Lighting),
        shapes: &Shapes,
        parallel: &dyn ParallelFor,
    ) {
        let (list, in_work, waterlines) = (&self.list, &self.in_work, &self.waterlines);
        let size = camera.optics.picture;
        parallel.run(list.len(), &|index| {
            let object = &list[index];
            let margin =
                if object.is_target { (size.width as i32 / 2, size.height as i32 / 2) } else { (0, 0) };
            let scene = Scene { camera, light, margin };
            let (mesh, waterline) = (shapes.mesh(object.shape), waterlines[index].as_ref());
            let source = Source { scene: &scene, mesh, object, waterline };
            lock(&in_work[index]).direct.render(&source, ImageKind::Direct);
        });
        for (work, tiles) in self.in_work.iter_mut().map(get_mut).zip(&mut self.tiles) {
            core::mem::swap(&mut work.direct, &mut tiles.direct);
        }
    }

    /// The target's tile, and those of the objects nearer than the target.
    pub(super) fn target_and_occluders(&self) -> (&ImageTile, impl Iterator<Item = &ImageTile> + Clone) {
        let nearer = self.order.iter().skip_while(|&&index| !self.list[index].is_target).skip(1);
        (&self.tiles[0].direct, nearer.map(|&index| &self.tiles[index].direct))
    }
}
