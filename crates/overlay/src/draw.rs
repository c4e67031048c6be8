//! Draws scenes on copies of video frames.

use barrelman_vocab::{Picture, VideoFrame};

use super::blend;
use super::camera_arrow::CameraArrow;
use super::canvas::Canvas;
use super::placement::LabelPlacement;
use super::region::RegionLayer;
use super::scene::Scene;
use super::status_strip::StatusStrip;
use super::style::{Detail, Style};
use super::target::{self, TargetView};
use super::tracker_panel::{self, TrackerPanel};

/// Draws scenes on copies of video frames. Reuses its buffers from one frame to the next.
#[derive(Debug, Default)]
pub struct Overlay {
    canvas: Canvas,
    region_layer: RegionLayer,
    placement: LabelPlacement,
    strip: StatusStrip,
    panel: TrackerPanel,
    arrow: CameraArrow,
}

impl Overlay {
    /// An overlay with nothing drawn yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes `out` a copy of the frame's picture with the scene drawn on it. The picture may have any size.
    /// Elements of the scene with numbers that are not finite are left out.
    pub fn draw(&mut self, frame: &VideoFrame, scene: &Scene<'_>, out: &mut Picture) {
        let picture = &*frame.picture;
        let size = picture.size();
        out.reshape(size, picture.colour());
        for (copy, original) in out.planes_mut().into_iter().zip([picture.y(), picture.u(), picture.v()]) {
            copy.copy_from_slice(original.data);
        }
        self.canvas.begin(Style::for_picture(size));
        let view = TargetView::from_scene(scene, size);
        let percept = view.as_ref().map(|view| &view.percept);
        if self.region_layer.begin(&mut self.canvas, size, scene.region, percept) {
            self.compose(frame, scene, view.as_ref());
            blend::blend_layer(&self.canvas.layer, out);
        }
    }

    fn compose(&mut self, frame: &VideoFrame, scene: &Scene<'_>, view: Option<&TargetView>) {
        let Self { canvas, placement, strip, panel, arrow, .. } = self;
        placement.begin(frame.picture.size().bounds(), canvas.style.margin);
        if let Some(view) = view {
            placement.reserve(view.bounds);
        }

        if let Some(window) = scene.explanation.and_then(|explanation| explanation.search_window) {
            tracker_panel::draw_search_window(canvas, window);
        }
        if canvas.style.detail > Detail::Bare {
            strip.draw(canvas, placement, frame, scene, view);
        }
        if let Some(explanation) = scene.explanation.filter(|_| canvas.style.detail > Detail::Bare) {
            panel.draw(canvas, placement, explanation, view.map(|view| view.bounds));
        }
        if let Some(view) = view {
            target::draw(canvas, view);
        }
        arrow.draw(canvas, placement, scene);
        if let Some(view) = view.filter(|_| canvas.style.detail == Detail::Full) {
            target::label(canvas, placement, view);
        }
    }
}
