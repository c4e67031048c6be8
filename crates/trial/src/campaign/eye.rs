//! Pictures of a world for a trial in pixels: the renderer, and the frame that its pictures lie in.

use std::sync::Arc;

use barrelman_sim::render::{ENCODING, ParallelFor, RenderSettings, RenderedTruth, Renderer, WaveGrid};
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::{Snapshot, World};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PixelBox, VideoFrame};

use super::simulation::{Eye, View};

/// Draws what a world's camera sees.
pub struct DrawnEye<'a> {
    renderer: Renderer,
    camera: CameraSetup,
    bands: &'a dyn ParallelFor,
    snapshot: Snapshot,
    /// The picture without its frame; not used where there is none.
    bare: Picture,
    /// Pictures that were handed out, to be used again when nobody holds them any more.
    pool: Vec<Arc<Picture>>,
    sequence: u64,
    truth: RenderedTruth,
}

/// Pictures that are kept to be used again.
const POOL: usize = 32;

impl<'a> DrawnEye<'a> {
    /// The eye of a trial; `simd` bounds which vector instructions it uses, the pictures are the same with all.
    pub fn new(
        world: &World,
        camera: CameraSetup,
        seed: u64,
        simd: barrelman_simd::Simd,
        bands: &'a dyn ParallelFor,
    ) -> Self {
        let settings = RenderSettings {
            simd,
            grid: WaveGrid::Coarse,
            readout_s: camera.rolling_shutter_s,
            ..RenderSettings::new(camera.optics, world.sea().cloned(), seed)
        };
        Self {
            renderer: Renderer::new(settings),
            bare: Picture::black(camera.optics.picture, ENCODING),
            camera,
            bands,
            snapshot: world.snapshot(),
            pool: Vec::new(),
            sequence: 0,
            truth: RenderedTruth::default(),
        }
    }

    /// What was true of the last picture, in pixels of the bare picture.
    pub const fn truth(&self) -> &RenderedTruth {
        &self.truth
    }

    /// A picture that nobody holds.
    fn free_picture(&mut self) -> Picture {
        let free = self.pool.iter().position(|picture| Arc::strong_count(picture) == 1);
        free.map(|index| self.pool.swap_remove(index))
            .and_then(|picture| Arc::try_unwrap(picture).ok())
            .unwrap_or_else(|| Picture::black(self.camera.frame, ENCODING))
    }
}

impl Eye for DrawnEye<'_> {
    fn look(&mut self, world: &World) -> View {
        world.write_snapshot(&mut self.snapshot);
        let (frame, picture) = (self.camera.frame, self.camera.optics.picture);
        let mut framed = self.free_picture();
        let off = if frame == picture {
            self.truth.clone_from(self.renderer.render(&self.snapshot, &mut framed, self.bands));
            (0, 0)
        } else {
            self.truth.clone_from(self.renderer.render(&self.snapshot, &mut self.bare, self.bands));
            // Whole chroma samples: the letter-box lies on even pixels.
            let off = |frame: u32, picture: u32| ((frame - picture) / 4 * 2) as usize;
            let off = (off(frame.width, picture.width), off(frame.height, picture.height));
            lay(&self.bare, &mut framed, off);
            off
        };
        let target = self.truth.bounds.map(|bounds| PixelBox {
            u: bounds.u + off.0 as f64,
            v: bounds.v + off.1 as f64,
            ..bounds
        });
        let framed = Arc::new(framed);
        if self.pool.len() < POOL {
            self.pool.push(Arc::clone(&framed));
        }
        let capture = Capture { at: world.now(), quality: CaptureQuality::Sensor };
        let sequence = self.sequence;
        self.sequence += 1;
        View { frame: VideoFrame { sequence, capture, picture: framed }, target }
    }
}

/// Lays a picture into a larger one, whose margins are black already.
fn lay(picture: &Picture, frame: &mut Picture, (left, top): (usize, usize)) {
    let width = frame.size().width as usize;
    let chroma_width = frame.chroma_size().width as usize;
    let planes = [picture.y(), picture.u(), picture.v()];
    let widths = [width, chroma_width, chroma_width];
    let shares = [1, 2, 2];
    for (((plane, out), width), share) in planes.iter().zip(frame.planes_mut()).zip(widths).zip(shares) {
        for row in 0..plane.height {
            let start = (top / share + row) * width + left / share;
            out[start..start + plane.width].copy_from_slice(plane.row(row));
        }
    }
}
