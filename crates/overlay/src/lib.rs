//! Draws track, law and camera command on a copy of a video frame.
//!
//! An [`Overlay`] takes a frame and a [`Scene`] (the state of the program at that frame) and fills a picture
//! of the same size and encoding. The frame itself is not changed. The overlay shows the elliptical region
//! and its sectors, the track, the line from the picture's centre to the target with r and the angle as in
//! Biswas et al. (`biswas2017`), P, the camera command and a status strip. With an explanation of the tracker
//! it also shows the search window, the tracker's state and confidence, back projection, response and hue
//! histogram.
//!
//! The overlay is drawn in red, green and blue on a transparent layer, which is blended into the samples with
//! the frame's matrix and range. Samples under a transparent part of the layer do not change.
//!
//! # Layout
//! Only the target's own box and axes are drawn over the target. The strip, the panel, the camera's arrows
//! and the labels are placed beside it, and keep their places while these are free. Line widths and text
//! scale with the picture; small pictures show less.
//!
//! # Cost
//! One copy of the frame, and work in proportion to the pixels drawn on: at most the whole picture once,
//! where a sector is active. The region is drawn again only when the region or the active sector changes, and
//! each glyph once for each size of picture. Vector drawing allocates a little memory for every frame.
//! `benches/overlay.rs` measures the cost.
//!
//! # Film
//! [`film::Film`] writes the annotated frames as an MP4 file.
//!
//! # Grid
//! [`grid::draw`] draws pixel coordinates over a picture, to read a selection from.
//!
//! # Not handled
//! Threads: the caller chooses the thread.

pub mod film;
pub mod grid;

mod draw;
mod fitted;
mod scene;

mod region;
mod target;

mod camera_arrow;
mod status_strip;
mod tracker_panel;

mod canvas;
mod placement;
mod style;

mod blend;
mod layer;
mod shapes;
mod text;

pub use draw::Overlay;
pub use scene::Scene;
