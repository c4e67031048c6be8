//! The camera of a trial in pixels: renders the world and letter-boxes the pictures into video frames.

use std::sync::Arc;

use barrelman_sim::render::{ENCODING, ParallelFor, RenderSettings, RenderedTruth, Renderer, WaveGrid};
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::{Snapshot, World};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, PixelBox, VideoFrame};

use super::frame_source::{CapturedFrame, FrameSource};
use crate::target_in_picture::TargetInPicture;

/// Renders what a world's camera sees.
pub struct RenderedCamera<'a> {
    renderer: Renderer,
    camera: CameraSetup,
    bands: &'a dyn ParallelFor,
    snapshot: Snapshot,
    /// The picture without letter-box margins; unused where frame and picture have the same size.
    unframed: Picture,
    /// Pictures handed out, reused once all other references to them are dropped.
    pool: Vec<Arc<Picture>>,
    sequence: u64,
    truth: RenderedTruth,
}

/// Upper bound of the pool, pictures.
const MAX_POOLED: usize = 32;

impl<'a> RenderedCamera<'a> {
    /// The camera of a trial. `simd` is the highest level of vector instructions that the renderer may use;
    /// the pictures are bit-identical at every level.
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
            unframed: Picture::black(camera.optics.picture, ENCODING),
            camera,
            bands,
            snapshot: world.snapshot(),
            pool: Vec::new(),
            sequence: 0,
            truth: RenderedTruth::default(),
        }
    }

    /// Ground truth of the last picture, in pixels of the picture without margins.
    pub const fn truth(&self) -> &RenderedTruth {
        &self.truth
    }

    /// Takes an unreferenced picture from the pool, or makes a new one.
    fn free_picture(&mut self) -> Picture {
        let free = self.pool.iter().position(|picture| Arc::strong_count(picture) == 1);
        free.map(|index| self.pool.swap_remove(index))
            .and_then(|picture| Arc::try_unwrap(picture).ok())
            .unwrap_or_else(|| Picture::black(self.camera.frame, ENCODING))
    }
}

impl FrameSource for RenderedCamera<'_> {
    fn capture(&mut self, world: &World) -> CapturedFrame {
        world.write_snapshot(&mut self.snapshot);
        let (frame, picture) = (self.camera.frame, self.camera.optics.picture);
        let mut framed = self.free_picture();
        let margins = if frame == picture {
            self.truth.clone_from(self.renderer.render(&self.snapshot, &mut framed, self.bands));
            (0, 0)
        } else {
            self.truth.clone_from(self.renderer.render(&self.snapshot, &mut self.unframed, self.bands));
            // Even numbers of pixels, so that chroma samples stay whole.
            let margin = |frame: u32, picture: u32| ((frame - picture) / 4 * 2) as usize;
            let margins = (margin(frame.width, picture.width), margin(frame.height, picture.height));
            copy_into(&self.unframed, &mut framed, margins);
            margins
        };
        let bounds = self.truth.bounds.map(|bounds| PixelBox {
            u: bounds.u + margins.0 as f64,
            v: bounds.v + margins.1 as f64,
            ..bounds
        });
        let framed = Arc::new(framed);
        if self.pool.len() < MAX_POOLED {
            self.pool.push(Arc::clone(&framed));
        }
        let capture = Capture { at: world.now(), quality: CaptureQuality::Sensor };
        let sequence = self.sequence;
        self.sequence += 1;
        let target = TargetInPicture { bounds, visible_share: self.truth.visible_share };
        CapturedFrame { frame: VideoFrame { sequence, capture, picture: framed }, target }
    }
}

/// Copies a picture into a larger one at an offset; leaves the margins, which are black, as they are.
fn copy_into(picture: &Picture, frame: &mut Picture, (left, top): (usize, usize)) {
    let width = frame.size().width as usize;
    let chroma_width = frame.chroma_size().width as usize;
    let planes = [picture.y(), picture.u(), picture.v()];
    let widths = [width, chroma_width, chroma_width];
    let subsamplings = [1, 2, 2];
    for (((plane, out), width), subsampling) in
        planes.iter().zip(frame.planes_mut()).zip(widths).zip(subsamplings)
    {
        for row in 0..plane.height {
            let start = (top / subsampling + row) * width + left / subsampling;
            out[start..start + plane.width].copy_from_slice(plane.row(row));
        }
    }
}
