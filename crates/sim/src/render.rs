//! Draws the world as a camera sees it, on the CPU, into planar YUV, with the truth about the target.
//!
//! One frame goes through these [`RenderStage`]s, each but the wake spread over the caller's [`ParallelFor`]:
//!
//! 1. waves: three tiles of slopes by Fourier transforms ([`waves`]);
//! 2. the wake's grid ([`wake`]);
//! 3. mirror images and shadows of things, each as a small tile ([`raster`]);
//! 4. rows: rays through the lens ([`rays`]), the surface where they meet it ([`surface`]), its light ([`shading`],
//!    [`floor`], [`land`]); what changes slowly along a row is computed at every eighth pixel ([`nodes`]);
//! 5. things as supersampled tiles, laid over the rows from far to near;
//! 6. rows again: softness and motion blur, exposure, tone, noise, YUV ([`sensor`]).
//!
//! The last three go band by band, so that the light of a band is still at hand when it is developed. Then the truth is
//! told: the target's tile, less what stands before it ([`truth`]).
//!
//! The picture depends on the settings and the snapshot, and through the wake on the snapshots before; not on the number
//! of parallel, threads or vector instructions. All arithmetic keeps to operations that round alike everywhere
//! ([`barrelman_simd`]). After the first frames nothing is allocated.
//!
//! What is not in here: waves that hide a thing behind them (things are cut by the water at their own place alone),
//! several wakes, light that things cast on each other, depth of field, compression.

#![allow(
    clippy::needless_range_loop,
    clippy::manual_clamp,
    reason = "kernels run over many arrays by one number, and max-min is what becomes two vector instructions"
)]

mod parallel;
mod settings;
mod truth;

mod camera;
mod rays;

mod fourier;
mod phase;
mod quad_map;
mod wake;
mod waves;

mod chunk;
mod light;
mod nodes;
mod shading;
mod surface;
mod texture;

mod floor;
mod land;

mod mesh;
mod object;
mod raster;

mod frame;
mod sensor;

pub use parallel::{ParallelFor, Serial};
pub use settings::{Effects, RenderSettings, WaterColour, WaveGrid};
pub use truth::{RenderedTruth, TargetMask};

use std::sync::{Mutex, PoisonError};

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

use self::camera::Camera;
use self::frame::{Frame, View};
use self::light::Lighting;
use self::object::{Instance, Shapes};
use self::raster::{Image, Scene, Tile, Waterline};
use self::texture::Texture;
use self::wake::Wake;
use crate::sea::{Sea, SeaState, Wind};
use crate::snapshot::{Ground, ObjectKind, Snapshot};

/// How a drawn picture's samples stand for colours.
pub const ENCODING: ColourEncoding =
    ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited };

/// What is done for a frame, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RenderStage {
    /// The tiles of waves.
    Waves,
    /// The boat's wake.
    Wake,
    /// Where camera, things and light are; mirror images and shadows.
    ReflectionsAndShadows,
    /// Water, sky and land, or the floor, as linear light.
    Water,
    /// Things, drawn and laid over.
    FrameObjects,
    /// From light to samples.
    Sensor,
}

impl RenderStage {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Waves, Self::Wake, Self::ReflectionsAndShadows, Self::Water, Self::FrameObjects, Self::Sensor];
}

/// Draws one camera's pictures.
#[derive(Debug)]
pub struct Renderer {
    settings: RenderSettings,
    sea: Sea,
    camera: Camera,
    textures: Textures,
    shapes: Shapes,
    waves: [Mutex<waves::Tile>; 3],
    unresolved_variance: f32,
    wake: Mutex<Wake>,
    objects: FrameObjects,
    frame: Frame,
    truth: RenderedTruth,
}

/// Textures for everything.
#[derive(Debug)]
struct Textures {
    clouds: Texture,
    gusts: Texture,
    grain: Texture,
    lace: Texture,
}

/// The things of a frame and their images.
#[derive(Debug, Default)]
struct FrameObjects {
    list: Vec<Instance>,
    waterlines: Vec<Option<Waterline>>,
    /// Numbers in `list` from far to near.
    order: Vec<usize>,
    at_work: Vec<Mutex<ObjectTiles>>,
    /// In the order of `list`.
    drawn: Vec<ObjectTiles>,
    shores: Vec<land::Shore>,
}

/// The images of one thing.
#[derive(Debug, Default)]
struct ObjectTiles {
    itself: Tile,
    reflection: Tile,
    shadow: Tile,
    /// Pixels by which a slope of 1 moves the mirror image.
    reach: f32,
}

impl Renderer {
    /// A renderer; textures and shapes are made here, which takes a few tenths of a second.
    pub fn new(settings: RenderSettings) -> Self {
        let calm = Wind { speed_mps: 1.5, towards: barrelman_vocab::Angle::ZERO };
        let sea = settings.sea.clone().unwrap_or_else(|| Sea::new(SeaState::ALL[0], calm, settings.seed));
        let (tiles, unresolved_variance) = waves::tiles(&sea, settings.grid.points());
        let seed = settings.seed;
        Self {
            camera: Camera::new(settings.optics),
            textures: Textures {
                clouds: Texture::fractal(seed ^ 0xC1, 64, 1, 0.52),
                gusts: Texture::fractal(seed ^ 0x65, 64, 4, 0.55),
                grain: Texture::fractal(seed ^ 0x62, 16, 1, 0.75),
                lace: Texture::lace(seed ^ 0x1A, 16),
            },
            shapes: Shapes::new(),
            waves: tiles.map(Mutex::new),
            unresolved_variance,
            wake: Mutex::new(Wake::new()),
            objects: FrameObjects::default(),
            frame: Frame::new(settings.optics.picture, seed),
            truth: RenderedTruth::default(),
            sea,
            settings,
        }
    }

    /// What it was made for.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Takes a snapshot into the wake without drawing it.
    pub fn advance_wake(&mut self, snapshot: &Snapshot) {
        if self.settings.effects.wake && snapshot.ground == Ground::Water {
            get_mut(&mut self.wake).advance_to(self.settings.simd, snapshot);
        }
    }

    /// Draws a snapshot into `picture`, which takes the renderer's size and [`ENCODING`]. Snapshots come in the
    /// order of their ticks; where they jump back, the wake starts anew.
    pub fn render(
        &mut self,
        snapshot: &Snapshot,
        picture: &mut Picture,
        parallel: &dyn ParallelFor,
    ) -> &RenderedTruth {
        for stage in [RenderStage::Waves, RenderStage::Wake, RenderStage::ReflectionsAndShadows] {
            self.render_stage(stage, snapshot, picture, parallel);
        }
        let light = Lighting::new(&snapshot.light, snapshot.tick);
        self.render_direct_tiles(&light, parallel);
        picture.reshape(self.settings.optics.picture, ENCODING);
        let (frame, view) = self.view(snapshot, &light);
        frame.render(&view, picture, parallel);
        self.measure_truth(snapshot);
        &self.truth
    }

    /// One stage of [`Self::render`] alone, for measuring: it works on what the stages before it have left, and all of
    /// them in order give the same picture.
    pub fn render_stage(
        &mut self,
        stage: RenderStage,
        snapshot: &Snapshot,
        picture: &mut Picture,
        parallel: &dyn ParallelFor,
    ) {
        let (simd, waves) = (self.settings.simd, &self.waves);
        let light = Lighting::new(&snapshot.light, snapshot.tick);
        match stage {
            RenderStage::Waves if snapshot.ground == Ground::Water => {
                parallel.run(waves.len(), &|part| lock(&waves[part]).advance(simd, snapshot.tick));
            }
            RenderStage::Waves => {}
            RenderStage::Wake => self.advance_wake(snapshot),
            RenderStage::ReflectionsAndShadows => {
                self.camera.pose(snapshot);
                self.list_objects(snapshot);
                self.render_secondary_tiles(&light, parallel);
            }
            RenderStage::Water => {
                let (frame, view) = self.view(snapshot, &light);
                frame.shade(&view, parallel);
            }
            RenderStage::FrameObjects => {
                self.render_direct_tiles(&light, parallel);
                let (frame, view) = self.view(snapshot, &light);
                frame.composite(&view, parallel);
            }
            RenderStage::Sensor => {
                picture.reshape(self.settings.optics.picture, ENCODING);
                let (frame, view) = self.view(snapshot, &light);
                frame.develop(&view, picture, parallel);
            }
        }
    }

    fn view<'a>(&'a mut self, snapshot: &'a Snapshot, light: &'a Lighting) -> (&'a mut Frame, View<'a>) {
        let wake = get_mut(&mut self.wake);
        let view = View {
            settings: &self.settings,
            sea: &self.sea,
            camera: &self.camera,
            textures: &self.textures,
            tiles: self.waves.each_mut().map(|tile| &*get_mut(tile)),
            unresolved_variance: self.unresolved_variance,
            wake: (self.settings.effects.wake && snapshot.ground == Ground::Water).then_some(&*wake),
            objects: &self.objects,
            light,
            snapshot,
        };
        (&mut self.frame, view)
    }

    fn list_objects(&mut self, snapshot: &Snapshot) {
        let objects = &mut self.objects;
        object::instances(snapshot, &mut objects.list);
        let count = objects.list.len();
        objects.at_work.resize_with(count.max(objects.at_work.len()), Mutex::default);
        objects.drawn.resize_with(count.max(objects.drawn.len()), ObjectTiles::default);
        objects.waterlines.clear();
        for object in &objects.list {
            let position = object.pose.position;
            let cut = (snapshot.ground == Ground::Water && object.is_afloat()).then(|| {
                let surface = self.sea.surface_at(position.x, position.y, snapshot.tick);
                let calm = self.settings.sea.is_none();
                Waterline {
                    position: crate::pose::WorldPoint {
                        z: if calm { 0.0 } else { surface.elevation },
                        ..position
                    },
                    slope: if calm { (0.0, 0.0) } else { surface.slope },
                }
            });
            objects.waterlines.push(cut);
        }
        let viewpoint = self.camera.middle().position;
        objects.order.clear();
        objects.order.extend(0..count);
        let list = &objects.list;
        let far = |index: &usize| list[*index].distance_from(viewpoint);
        objects.order.sort_unstable_by(|a, b| far(b).total_cmp(&far(a)).then(a.cmp(b)));
        objects.shores.clear();
        objects.shores.extend(
            snapshot.objects.iter().filter(|object| object.kind == ObjectKind::Shore).map(land::Shore::new),
        );
    }

    /// Mirror images and shadows.
    fn render_secondary_tiles(&mut self, light: &Lighting, parallel: &dyn ParallelFor) {
        let objects = &mut self.objects;
        let (camera, shapes, effects) = (&self.camera, &self.shapes, self.settings.effects);
        let (list, at_work, waterlines) = (&objects.list, &objects.at_work, &objects.waterlines);
        let viewpoint = camera.middle().position;
        let sunny = light.sun[0] > 0.05 && light.to_sun[2] > 0.1;
        parallel.run(list.len(), &|index| {
            let drawn = &mut *lock(&at_work[index]);
            let (object, cut) = (&list[index], waterlines[index].as_ref());
            let mesh = shapes.mesh(object.shape);
            let scene = Scene { camera, light, margin: (8, 8) };
            drawn.reflection.skip();
            if effects.reflection && cut.is_some() {
                drawn.reflection.draw(&scene, mesh, object, cut, Image::Reflection);
            }
            drawn.shadow.skip();
            if effects.shadow && sunny && object.casts_shadow() {
                drawn.shadow.draw(&scene, mesh, object, cut, Image::Shadow);
            }
            let range = object.distance_from(viewpoint).max(0.5);
            drawn.reach = (camera.optics.focal_px / range * object.reflected_height_m()) as f32;
        });
        for (work, drawn) in objects.at_work.iter_mut().map(get_mut).zip(&mut objects.drawn) {
            core::mem::swap(&mut work.reflection, &mut drawn.reflection);
            core::mem::swap(&mut work.shadow, &mut drawn.shadow);
            drawn.reach = work.reach;
        }
    }

    /// The things themselves.
    fn render_direct_tiles(&mut self, light: &Lighting, parallel: &dyn ParallelFor) {
        let objects = &mut self.objects;
        let (camera, shapes) = (&self.camera, &self.shapes);
        let (list, at_work, waterlines) = (&objects.list, &objects.at_work, &objects.waterlines);
        let size = self.settings.optics.picture;
        parallel.run(list.len(), &|index| {
            let object = &list[index];
            let whole =
                if object.is_target { (size.width as i32 / 2, size.height as i32 / 2) } else { (0, 0) };
            let scene = Scene { camera, light, margin: whole };
            let (mesh, cut) = (shapes.mesh(object.shape), waterlines[index].as_ref());
            lock(&at_work[index]).itself.draw(&scene, mesh, object, cut, Image::Direct);
        });
        for (work, drawn) in objects.at_work.iter_mut().map(get_mut).zip(&mut objects.drawn) {
            core::mem::swap(&mut work.itself, &mut drawn.itself);
        }
    }

    fn measure_truth(&mut self, snapshot: &Snapshot) {
        self.truth.measure(&self.camera, snapshot);
        let objects = &self.objects;
        let nearer = objects.order.iter().skip_while(|&&index| !objects.list[index].is_target).skip(1);
        let before = nearer.map(|&index| &objects.drawn[index].itself);
        self.truth.cover(&self.camera, &objects.drawn[0].itself, before);
    }
}

/// A lock that a panic elsewhere cannot spoil: what it guards is written anew for each frame.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn get_mut<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}
