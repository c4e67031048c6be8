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
//! # Film
//! [`film::Film`] writes the annotated frames as an MP4 file.
//!
//! # Not handled
//! No thread: the caller decides where frames are drawn.

pub mod film;

mod draw;
mod scene;

mod region;
mod target;

mod camera;
mod panel;
mod strip;

mod pen;
mod placement;
mod style;

mod blend;
mod layer;
mod shapes;
mod text;

pub use draw::Overlay;
pub use scene::Scene;
