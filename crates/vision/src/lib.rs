//! Video frame in, localisation out: where in the picture the selected boat is.
//!
//! [`Tracker`] is the seam: whoever follows the boat, now or later, stands behind it. [`CamShift`] is the tracker
//! of the published system (Biswas, Karnan, Dhulipala, Dufek and Murphy, arXiv 1710.02932): a hue histogram of the selection, its
//! back projection, mean shift to where the colour is, and size and direction from the moments there.
//!
//! Everything here counts in *pixel* coordinates: u to the right, v downwards, origin at the top left corner of
//! the picture, pixel (0,0) covering [0,1) x [0,1). Angles of an axis are anticlockwise from image right, as seen.
//!
//! # What is not in here
//! No I/O, no clock, no thread and no chance: the same frames give the same track, to the bit, on every machine
//! (integers where pixels are counted, `libm` beyond). No allocation per frame once the buffers have their size.
//! No knowledge of what a localisation is used for: no camera, no rates, no region of interest. The motion of the
//! camera comes in as a [`MotionPrior`](barrelman_vocab::MotionPrior), and a tracker works without it.
#![deny(unsafe_code)]

mod tracker;

pub mod behaviour;

mod camshift;
mod config;

mod back_projection;
mod likeness;

mod background;
mod colour_model;
mod correlation;
mod crop;
mod features;
mod fourier;
mod fused;
mod gradients;
mod heading;
mod layout;
mod motion;
mod redetection;
mod silhouette;
mod simd;

mod histogram;
mod hue;

mod mean_shift;
mod moments;
mod window;

mod explanation;

pub use camshift::CamShift;
pub use config::{CamShiftConfig, ConfigError};
pub use explanation::{Explanation, GreyMap, Stage};
pub use fused::{FusedConfig, FusedConfigError, FusedTracker};
pub use histogram::{HueHistogram, UncountableHues};
pub use hue::{BELOW_FLOORS, Floors, HueOfYuv};
pub use mean_shift::{Criteria, EDGE_PX, MARGIN, Search, Target, cam_shift};
pub use moments::{ByteMap, Mass, Moments};
pub use tracker::{SelectionError, SelectionReport, Tracker};
pub use window::Window;
