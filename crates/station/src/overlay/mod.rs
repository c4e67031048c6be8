//! What the program sees, asks for and why, drawn on a copy of a video frame.
//!
//! An [`Overlay`] takes a frame and a [`Scene`] (what is known at that frame) and fills a picture of the same size
//! and encoding. The frame itself is never written to. Shown are the elliptical region and its sectors, the track,
//! the line from the picture's centre to the target with r and the angle as in Biswas et al. (`biswas2017`), P, the
//! camera command and a status strip; with an explanation of the tracker also its search window,
//! its own word for its state, its confidence, back projection, response and hue histogram.
//!
//! It is drawn in red, green and blue on a transparent layer, which is then mixed into the samples with the frame's
//! own matrix and range. Samples under a transparent part of the layer keep their bits.
//!
//! # Layout
//! Nothing but its own box and axes is drawn over the target: the strip, the panel, the camera's arrow and the labels
//! each look for a place that is free of it, and stay there until it is not. Line widths and text grow with the
//! picture; small pictures show less.
//!
//! # Cost
//! One copy of the frame, and work in proportion to the pixels drawn on: at most the whole picture once, where a
//! sector is active. The region is drawn anew only when it or the active sector changes, and each glyph once for
//! each size of picture. Vector drawing allocates a little on every frame. `benches/overlay.rs` measures it.
//!
//! # What it does not handle
//! No files, no encoding, no thread.

mod scene;

mod region;
mod target;

mod camera;
mod panel;
mod strip;

mod placing;
mod style;

mod blend;
mod layer;
mod shapes;
mod text;

use barrelman_vocab::{Picture, VideoFrame};

pub use scene::Scene;

use camera::CameraArrow;
use layer::Layer;
use panel::Panel;
use placing::Places;
use region::Ground;
use strip::Strip;
use style::{Detail, Style};
use target::Sight;
use text::Typeface;

/// Draws scenes on copies of video frames. Keeps its buffers from one frame to the next.
#[derive(Debug, Default)]
pub struct Overlay {
    pen: Pen,
    ground: Ground,
    places: Places,
    strip: Strip,
    panel: Panel,
    arrow: CameraArrow,
}

/// What the parts of an overlay draw with.
#[derive(Debug, Default)]
struct Pen {
    layer: Layer,
    type_face: Typeface,
    style: Style,
}

impl Overlay {
    /// An overlay with nothing drawn yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes `out` a copy of the frame's picture with the scene drawn on it. Takes any size of picture; a number
    /// in the scene that is not finite leaves out what rests on it.
    pub fn draw(&mut self, frame: &VideoFrame, scene: &Scene<'_>, out: &mut Picture) {
        let picture = &*frame.picture;
        let size = picture.size();
        out.reshape(size, picture.colour());
        for (copy, original) in out.planes_mut().into_iter().zip([picture.y(), picture.u(), picture.v()]) {
            copy.copy_from_slice(original.data);
        }
        self.pen.begin(Style::of(size));
        let sight = Sight::of(scene, size);
        let percept = sight.as_ref().map(|sight| &sight.percept);
        if self.ground.begin(&mut self.pen, size, scene.region, percept) {
            self.compose(frame, scene, sight.as_ref());
            blend::onto(&self.pen.layer, out);
        }
    }

    fn compose(&mut self, frame: &VideoFrame, scene: &Scene<'_>, sight: Option<&Sight>) {
        let Self { pen, places, strip, panel, arrow, .. } = self;
        places.begin(frame.picture.size().bounds(), pen.style.margin);
        if let Some(sight) = sight {
            places.keep_clear(sight.bounds);
        }

        if let Some(window) = scene.explanation.and_then(|explanation| explanation.search_window) {
            panel::draw_search_window(pen, window);
        }
        if pen.style.detail > Detail::Bare {
            strip.draw(pen, places, frame, scene, sight);
        }
        if let Some(explanation) = scene.explanation.filter(|_| pen.style.detail > Detail::Bare) {
            panel.draw(pen, places, explanation, sight.map(|sight| sight.bounds));
        }
        if let Some(sight) = sight {
            target::draw(pen, sight);
        }
        arrow.draw(pen, places, scene);
        if let Some(sight) = sight.filter(|_| pen.style.detail == Detail::Full) {
            target::label(pen, places, sight);
        }
    }
}

impl Pen {
    fn begin(&mut self, style: Style) {
        if self.style.text_px != style.text_px {
            self.type_face.forget();
        }
        self.style = style;
    }
}
