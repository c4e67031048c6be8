//! Draws the world as a camera sees it, on the CPU, into planar YUV, with the truth about the target.
//!
//! One frame goes through these stages; those marked * are spread over the caller's [`Bands`]:
//!
//! 1. *waves: three tiles of slopes by Fourier transforms ([`waves`]), and the wake's grid ([`wake`]);
//! 2. *things: each with its mirror image and shadow as a small supersampled tile ([`raster`]);
//! 3. *rows: rays through the lens ([`rays`]), the surface where they meet it ([`surface`]), its light ([`shading`],
//!    [`floor`], [`land`]), things laid over it from far to near;
//! 4. *rows again: softness and motion blur, exposure, tone, noise, YUV ([`sensor`]);
//! 5. truth: the target's tile, less what stands before it ([`truth`]).
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
        picture.reshape(self.settings.optics.picture, ENCODING);
        self.camera.pose(snapshot);
        let light = Lighting::new(&snapshot.light, snapshot.tick);
        if snapshot.ground == Ground::Water {
            self.make_waves(snapshot, bands);
        }
        self.draw_things(snapshot, &light, bands);
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
            light: &light,
            snapshot,
        };
        self.frame.draw(&view, picture, bands);
        self.tell_truth(snapshot);
        &self.truth
    }

    fn make_waves(&mut self, snapshot: &Snapshot, bands: &dyn Bands) {
        let (simd, waves, wake) = (self.settings.simd, &self.waves, &self.wake);
        let with_wake = self.settings.effects.wake;
        bands.run(4, &|part| match waves.get(part) {
            Some(tile) => locked(tile).advance(simd, snapshot.tick),
            None if with_wake => locked(wake).follow(simd, snapshot),
            None => {}
        });
    }

    fn draw_things(&mut self, snapshot: &Snapshot, light: &Lighting, bands: &dyn Bands) {
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
        let eye = self.camera.row(self.settings.optics.picture.height as usize / 2).place;
        things.order.clear();
        things.order.extend(0..count);
        let list = &things.list;
        let far = |index: &usize| list[*index].distance_from(eye);
        things.order.sort_unstable_by(|a, b| far(b).total_cmp(&far(a)).then(a.cmp(b)));
        things.shores.clear();
        things.shores.extend(
            snapshot.things.iter().filter(|thing| thing.kind == ThingKind::Shore).map(land::Shore::new),
        );
        let (camera, shapes, effects) = (&self.camera, &self.shapes, self.settings.effects);
        let (at_work, waterlines) = (&things.at_work, &things.waterlines);
        let size = self.settings.optics.picture;
        let sunny = light.sun[0] > 0.05 && light.to_sun[2] > 0.1;
        bands.run(count, &|index| {
            let mut drawn = locked(&at_work[index]);
            let (thing, cut) = (&list[index], waterlines[index].as_ref());
            let mesh = shapes.of(thing.shape);
            let whole =
                if thing.is_target { (size.width as i32 / 2, size.height as i32 / 2) } else { (0, 0) };
            let scene = Scene { camera, light, margin: whole };
            drawn.itself.draw(&scene, mesh, thing, cut, Image::Itself);
            let scene = Scene { margin: (8, 8), ..scene };
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
        for (work, drawn) in things.at_work.iter_mut().zip(&mut things.drawn) {
            core::mem::swap(held(work), drawn);
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
