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

mod frame_objects;
mod image_tile;
mod mesh;
mod object;
mod raster;
mod resolve;
mod secondary_image;
mod waterline;

mod develop_rows;
mod frame;
mod light_rows;
mod sensor;
mod shade_row;
mod view;

pub use parallel::{ParallelFor, Serial};
pub use settings::{Effects, RenderSettings, WaterColour, WaveGrid};
pub use truth::{RenderedTruth, TargetMask};

use std::sync::Mutex;

use barrelman_vocab::Picture;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

use self::camera::Camera;
use self::frame::Frame;
use self::frame_objects::FrameObjects;
use self::light::Lighting;
use self::object::Shapes;
use self::parallel::{get_mut, lock};
use self::texture::Textures;
use self::view::FrameView;
use self::wake::Wake;
use self::waves::WaveTile;
use crate::sea::{Sea, SeaState, Wind};
use crate::snapshot::{Ground, Snapshot};

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
    Objects,
    /// From light to samples.
    Sensor,
}

impl RenderStage {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Waves, Self::Wake, Self::ReflectionsAndShadows, Self::Water, Self::Objects, Self::Sensor];
}

/// Draws one camera's pictures.
#[derive(Debug)]
pub struct Renderer {
    settings: RenderSettings,
    sea: Sea,
    camera: Camera,
    textures: Textures,
    shapes: Shapes,
    waves: [Mutex<WaveTile>; 3],
    unresolved_variance: f32,
    wake: Mutex<Wake>,
    objects: FrameObjects,
    frame: Frame,
    truth: RenderedTruth,
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
            textures: Textures::new(seed),
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
        self.render_objects(&light, parallel);
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
                self.objects.list(&self.settings, &self.sea, &self.camera, snapshot);
                let scene = (&self.camera, &light);
                self.objects.render_secondary(scene, &self.shapes, self.settings.effects, parallel);
            }
            RenderStage::Water => {
                let (frame, view) = self.view(snapshot, &light);
                frame.shade(&view, parallel);
            }
            RenderStage::Objects => {
                self.render_objects(&light, parallel);
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

    fn view<'a>(&'a mut self, snapshot: &'a Snapshot, light: &'a Lighting) -> (&'a mut Frame, FrameView<'a>) {
        let wake = get_mut(&mut self.wake);
        let view = FrameView {
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

    fn render_objects(&mut self, light: &Lighting, parallel: &dyn ParallelFor) {
        self.objects.render_direct((&self.camera, light), &self.shapes, parallel);
    }

    fn measure_truth(&mut self, snapshot: &Snapshot) {
        self.truth.measure(&self.camera, snapshot);
        let (target, occluders) = self.objects.target_and_occluders();
        self.truth.cover(&self.camera, target, occluders);
    }
}
