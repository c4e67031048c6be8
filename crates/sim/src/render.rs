//! Renders the world as the camera sees it, on the CPU, into planar YUV, with the truth about the target.
//!
//! A frame goes through these [`RenderStage`]s. Each stage except the wake is spread over the caller's
//! [`ParallelFor`]:
//!
//! 1. waves: slopes on three tiles, by Fourier transforms ([`waves`]);
//! 2. the grid of the wake ([`wake`]);
//! 3. reflections and shadows of objects, each in a small tile ([`frame_objects`], [`raster`], [`resolve`]);
//! 4. rows ([`shade_row`]): rays through the lens ([`rays`]), the surface where they meet it ([`surface`]),
//!    its light ([`shading`], [`floor`], [`land`]); quantities that change slowly along a row are computed at
//!    every eighth pixel ([`nodes`]);
//! 5. objects as supersampled tiles, composited over the rows from far to near;
//! 6. rows again ([`develop_rows`]): softness and motion blur, exposure, tone, noise, YUV ([`sensor`]).
//!
//! Stages 4 to 6 go band by band, so that the light of a band is still in the cache when it is developed. The
//! truth is then measured on the target's tile and the tiles in front of it ([`truth`]).
//!
//! The picture depends on the settings and the snapshot, and through the wake on earlier snapshots. It does
//! not depend on the number of threads or the vector instructions: all arithmetic keeps to operations that
//! round alike everywhere ([`barrelman_simd`]). After the first frames nothing is allocated.
//!
//! Not handled: waves that hide an object behind them (the water cuts objects at their own position only),
//! several wakes, light between objects, depth of field, compression.

#![allow(
    clippy::needless_range_loop,
    clippy::manual_clamp,
    reason = "kernels index many arrays by one number, and max-min compiles to two vector instructions"
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

/// Colour encoding of rendered pictures.
pub const ENCODING: ColourEncoding =
    ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Limited };

/// The stages of a frame, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RenderStage {
    /// The tiles of waves.
    Waves,
    /// The boat's wake.
    Wake,
    /// Poses of camera, objects and light; tiles of reflections and shadows.
    ReflectionsAndShadows,
    /// Water, sky and land, or the floor, as linear light.
    Water,
    /// Tiles of the objects, composited over the rows.
    Objects,
    /// From light to samples.
    Sensor,
}

impl RenderStage {
    /// All stages in their order.
    pub const ALL: [Self; 6] =
        [Self::Waves, Self::Wake, Self::ReflectionsAndShadows, Self::Water, Self::Objects, Self::Sensor];
}

/// Renders the pictures of one camera.
#[derive(Debug)]
pub struct Renderer {
    /// The optics are those of the present zoom.
    settings: RenderSettings,
    /// Focal length of the settings, pixels.
    focal_px: f64,
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
    /// A renderer. Textures and shapes are made here, which takes a few tenths of a second.
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
            focal_px: settings.optics.focal_px,
            settings,
        }
    }

    /// The settings of the renderer, with the zoom of the last snapshot.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Advances the wake to a snapshot without rendering it.
    pub fn advance_wake(&mut self, snapshot: &Snapshot) {
        if self.settings.effects.wake && snapshot.ground == Ground::Water {
            get_mut(&mut self.wake).advance_to(self.settings.simd, snapshot);
        }
    }

    /// Renders a snapshot into `picture`, which takes the renderer's size and [`ENCODING`]. Snapshots come in
    /// the order of their ticks; where a tick is earlier than the one before, the wake starts anew.
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

    /// Runs one stage of [`Self::render`], for benchmarks. The stage works on what the stages before it left;
    /// all stages in order give the same picture.
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
                self.settings.optics.focal_px = snapshot.zoom * self.focal_px;
                self.camera.optics = self.settings.optics;
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
