//! Draws scenes on copies of video frames.

use barrelman_vocab::{Picture, VideoFrame};

use super::blend;
use super::camera::CameraArrow;
use super::panel::{self, Panel};
use super::pen::Pen;
use super::placement::LabelPlacement;
use super::region::RegionLayer;
use super::scene::Scene;
use super::strip::Strip;
use super::style::{Detail, Style};
use super::target::{self, TargetView};

/// Draws scenes on copies of video frames. Keeps its buffers from one frame to the next.
#[derive(Debug, Default)]
pub struct Overlay {
    pen: Pen,
    region_layer: RegionLayer,
    placement: LabelPlacement,
    strip: Strip,
    panel: Panel,
    arrow: CameraArrow,
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
        let view = TargetView::of(scene, size);
        let percept = view.as_ref().map(|view| &view.percept);
        if self.region_layer.begin(&mut self.pen, size, scene.region, percept) {
            self.compose(frame, scene, view.as_ref());
            blend::onto(&self.pen.layer, out);
        }
    }

    fn compose(&mut self, frame: &VideoFrame, scene: &Scene<'_>, view: Option<&TargetView>) {
        let Self { pen, placement, strip, panel, arrow, .. } = self;
        placement.begin(frame.picture.size().bounds(), pen.style.margin);
        if let Some(view) = view {
            placement.reserve(view.bounds);
        }

        if let Some(window) = scene.explanation.and_then(|explanation| explanation.search_window) {
            panel::draw_search_window(pen, window);
        }
        if pen.style.detail > Detail::Bare {
            strip.draw(pen, placement, frame, scene, view);
        }
        if let Some(explanation) = scene.explanation.filter(|_| pen.style.detail > Detail::Bare) {
            panel.draw(pen, placement, explanation, view.map(|view| view.bounds));
        }
        if let Some(view) = view {
            target::draw(pen, view);
        }
        arrow.draw(pen, placement, scene);
        if let Some(view) = view.filter(|_| pen.style.detail == Detail::Full) {
            target::label(pen, placement, view);
        }
    }
}
