//! Draws the world as a camera sees it, on the CPU, into planar YUV, with the truth about the target.
//!
//! One frame goes through these [`Stage`]s, each but the wake spread over the caller's [`Bands`]:
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
//! of bands, threads or vector instructions. All arithmetic keeps to operations that round alike everywhere
//! ([`barrelman_simd`]). After the first frames nothing is allocated.
//!
//! What is not in here: waves that hide a thing behind them (things are cut by the water at their own place alone),
//! several wakes, light that things cast on each other, depth of field, compression.

#![allow(
    clippy::needless_range_loop,
    clippy::manual_clamp,
    reason = "kernels run over many arrays by one number, and max-min is what becomes two vector instructions"
)]

mod bands;
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
mod raster;
mod thing;

mod frame;
mod sensor;

pub use bands::{Bands, Serial};
pub use settings::{Effects, RenderSettings, WaterColour, WaveGrid};
pub use truth::{DrawnTruth, TargetMask};

use std::sync::{Mutex, PoisonError};

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

use self::camera::Camera;
use self::frame::{Frame, View};
use self::light::Lighting;
use self::raster::{Image, Scene, Tile, Waterline};
use self::texture::Texture;
use self::thing::{Instance, Shapes};
use self::wake::Wake;
use crate::sea::{Sea, SeaState, Wind};
use crate::snapshot::{Ground, Snapshot, ThingKind};

/// How a drawn picture's samples stand for colours.
pub const ENCODING: ColourEncoding =
    ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited };

/// What is done for a frame, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The tiles of waves.
    Waves,
    /// The boat's wake.
    Wake,
    /// Where camera, things and light are; mirror images and shadows.
    Images,
    /// Water, sky and land, or the floor, as linear light.
    Water,
    /// Things, drawn and laid over.
    Things,
    /// From light to samples.
    Sensor,
}

impl Stage {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Waves, Self::Wake, Self::Images, Self::Water, Self::Things, Self::Sensor];
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
    rough: f32,
    wake: Mutex<Wake>,
    things: Things,
    frame: Frame,
    truth: DrawnTruth,
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
struct Things {
    list: Vec<Instance>,
    waterlines: Vec<Option<Waterline>>,
    /// Numbers in `list` from far to near.
    order: Vec<usize>,
    at_work: Vec<Mutex<Drawn>>,
    /// In the order of `list`.
    drawn: Vec<Drawn>,
    shores: Vec<land::Shore>,
}

/// The images of one thing.
#[derive(Debug, Default)]
struct Drawn {
    itself: Tile,
    mirror: Tile,
    shadow: Tile,
    /// Pixels by which a slope of 1 moves the mirror image.
    reach: f32,
}

impl Renderer {
    /// A renderer; textures and shapes are made here, which takes a few tenths of a second.
    pub fn new(settings: RenderSettings) -> Self {
        let calm = Wind { speed_mps: 1.5, towards: barrelman_vocab::Angle::ZERO };
        let sea = settings.sea.clone().unwrap_or_else(|| Sea::new(SeaState::ALL[0], calm, settings.seed));
        let (tiles, rough) = waves::tiles(&sea, settings.grid.points());
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
            rough,
            wake: Mutex::new(Wake::new()),
            things: Things::default(),
            frame: Frame::new(settings.optics.picture, seed),
            truth: DrawnTruth::default(),
            sea,
            settings,
        }
    }

    /// What it was made for.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Takes a snapshot into the wake without drawing it.
    pub fn observe(&mut self, snapshot: &Snapshot) {
        if self.settings.effects.wake && snapshot.ground == Ground::Water {
            held(&mut self.wake).follow(self.settings.simd, snapshot);
        }
    }

    /// Draws a snapshot into `picture`, which takes the renderer's size and [`ENCODING`]. Snapshots come in the
    /// order of their ticks; where they jump back, the wake starts anew.
    pub fn draw(&mut self, snapshot: &Snapshot, picture: &mut Picture, bands: &dyn Bands) -> &DrawnTruth {
        for stage in [Stage::Waves, Stage::Wake, Stage::Images] {
            self.draw_stage(stage, snapshot, picture, bands);
        }
        let light = Lighting::new(&snapshot.light, snapshot.tick);
        self.draw_things(&light, bands);
        picture.reshape(self.settings.optics.picture, ENCODING);
        let (frame, view) = self.view(snapshot, &light);
        frame.draw(&view, picture, bands);
        self.tell_truth(snapshot);
        &self.truth
    }

    /// One stage of [`Self::draw`] alone, for measuring: it works on what the stages before it have left, and all of
    /// them in order give the same picture.
    pub fn draw_stage(
        &mut self,
        stage: Stage,
        snapshot: &Snapshot,
        picture: &mut Picture,
        bands: &dyn Bands,
    ) {
        let (simd, waves) = (self.settings.simd, &self.waves);
        let light = Lighting::new(&snapshot.light, snapshot.tick);
        match stage {
            Stage::Waves if snapshot.ground == Ground::Water => {
                bands.run(waves.len(), &|part| locked(&waves[part]).advance(simd, snapshot.tick));
            }
            Stage::Waves => {}
            Stage::Wake => self.observe(snapshot),
            Stage::Images => {
                self.camera.pose(snapshot);
                self.list_things(snapshot);
                self.draw_images(&light, bands);
            }
            Stage::Water => {
                let (frame, view) = self.view(snapshot, &light);
                frame.shade(&view, bands);
            }
            Stage::Things => {
                self.draw_things(&light, bands);
                let (frame, view) = self.view(snapshot, &light);
                frame.lay_over(&view, bands);
            }
            Stage::Sensor => {
                picture.reshape(self.settings.optics.picture, ENCODING);
                let (frame, view) = self.view(snapshot, &light);
                frame.develop(&view, picture, bands);
            }
        }
    }

    fn view<'a>(&'a mut self, snapshot: &'a Snapshot, light: &'a Lighting) -> (&'a mut Frame, View<'a>) {
        let wake = held(&mut self.wake);
        let view = View {
            settings: &self.settings,
            sea: &self.sea,
            camera: &self.camera,
            textures: &self.textures,
            tiles: self.waves.each_mut().map(|tile| &*held(tile)),
            rough: self.rough,
            wake: (self.settings.effects.wake && snapshot.ground == Ground::Water).then_some(&*wake),
            things: &self.things,
            light,
            snapshot,
        };
        (&mut self.frame, view)
    }

    fn list_things(&mut self, snapshot: &Snapshot) {
        let things = &mut self.things;
        thing::instances(snapshot, &mut things.list);
        let count = things.list.len();
        things.at_work.resize_with(count.max(things.at_work.len()), Mutex::default);
        things.drawn.resize_with(count.max(things.drawn.len()), Drawn::default);
        things.waterlines.clear();
        for thing in &things.list {
            let place = thing.pose.place;
            let cut = (snapshot.ground == Ground::Water && thing.is_afloat()).then(|| {
                let surface = self.sea.at(place.x, place.y, snapshot.tick);
                let calm = self.settings.sea.is_none();
                Waterline {
                    place: crate::pose::WorldPoint { z: if calm { 0.0 } else { surface.elevation }, ..place },
                    slope: if calm { (0.0, 0.0) } else { surface.slope },
                }
            });
            things.waterlines.push(cut);
        }
        let eye = self.camera.middle().place;
        things.order.clear();
        things.order.extend(0..count);
        let list = &things.list;
        let far = |index: &usize| list[*index].distance_from(eye);
        things.order.sort_unstable_by(|a, b| far(b).total_cmp(&far(a)).then(a.cmp(b)));
        things.shores.clear();
        things.shores.extend(
            snapshot.things.iter().filter(|thing| thing.kind == ThingKind::Shore).map(land::Shore::new),
        );
    }

    /// Mirror images and shadows.
    fn draw_images(&mut self, light: &Lighting, bands: &dyn Bands) {
        let things = &mut self.things;
        let (camera, shapes, effects) = (&self.camera, &self.shapes, self.settings.effects);
        let (list, at_work, waterlines) = (&things.list, &things.at_work, &things.waterlines);
        let eye = camera.middle().place;
        let sunny = light.sun[0] > 0.05 && light.to_sun[2] > 0.1;
        bands.run(list.len(), &|index| {
            let drawn = &mut *locked(&at_work[index]);
            let (thing, cut) = (&list[index], waterlines[index].as_ref());
            let mesh = shapes.of(thing.shape);
            let scene = Scene { camera, light, margin: (8, 8) };
            drawn.mirror.skip();
            if effects.mirror && cut.is_some() {
                drawn.mirror.draw(&scene, mesh, thing, cut, Image::Mirror);
            }
            drawn.shadow.skip();
            if effects.shadow && sunny && thing.casts_shadow() {
                drawn.shadow.draw(&scene, mesh, thing, cut, Image::Shadow);
            }
            let range = thing.distance_from(eye).max(0.5);
            drawn.reach = (camera.optics.focal_px / range * thing.mirror_height_m()) as f32;
        });
        for (work, drawn) in things.at_work.iter_mut().map(held).zip(&mut things.drawn) {
            core::mem::swap(&mut work.mirror, &mut drawn.mirror);
            core::mem::swap(&mut work.shadow, &mut drawn.shadow);
            drawn.reach = work.reach;
        }
    }

    /// The things themselves.
    fn draw_things(&mut self, light: &Lighting, bands: &dyn Bands) {
        let things = &mut self.things;
        let (camera, shapes) = (&self.camera, &self.shapes);
        let (list, at_work, waterlines) = (&things.list, &things.at_work, &things.waterlines);
        let size = self.settings.optics.picture;
        bands.run(list.len(), &|index| {
            let thing = &list[index];
            let whole =
                if thing.is_target { (size.width as i32 / 2, size.height as i32 / 2) } else { (0, 0) };
            let scene = Scene { camera, light, margin: whole };
            let (mesh, cut) = (shapes.of(thing.shape), waterlines[index].as_ref());
            locked(&at_work[index]).itself.draw(&scene, mesh, thing, cut, Image::Itself);
        });
        for (work, drawn) in things.at_work.iter_mut().map(held).zip(&mut things.drawn) {
            core::mem::swap(&mut work.itself, &mut drawn.itself);
        }
    }

    fn tell_truth(&mut self, snapshot: &Snapshot) {
        self.truth.measure(&self.camera, snapshot);
        let things = &self.things;
        let nearer = things.order.iter().skip_while(|&&index| !things.list[index].is_target).skip(1);
        let before = nearer.map(|&index| &things.drawn[index].itself);
        self.truth.cover(&self.camera, &things.drawn[0].itself, before);
    }
}

/// A lock that a panic elsewhere cannot spoil: what it guards is written anew for each frame.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn held<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}
