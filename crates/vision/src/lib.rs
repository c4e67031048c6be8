//! Video frame in, localisation out: where the selected boat is in the picture.
//!
//! [`Tracker`] is the interface of every tracker. [`FusedTracker`], the default, combines a correlation
//! filter with a colour model. [`CamShift`] is the tracker of the published system (Biswas, Karnan,
//! Dhulipala, Dufek and Murphy, arXiv 1710.02932): a hue histogram of the selection, its back projection,
//! mean shift to the mode, and size and orientation from the image moments.
//!
//! [`Proposer`] proposes the box of the object at a point, for a selection; [`Saliency`] finds the points of
//! a picture that stand out from the water.
//!
//! All coordinates are *pixel* coordinates: u to the right, v downwards, origin at the top left corner of the
//! picture, pixel (0,0) covering [0,1) x [0,1). Reported angles of an axis are anticlockwise from image
//! right, as seen.
//!
//! # What this crate does not contain
//! No I/O, clock, thread or randomness: the same frames give the same track, bit for bit, on every machine
//! (integers for sums over pixels, `libm` for transcendental functions). No allocation per frame once the
//! buffers have their size. No knowledge of what a localisation is used for: no camera, camera rates or
//! region of interest. The camera's motion comes in as an optional
//! [`MotionPrior`](barrelman_vocab::MotionPrior).
#![deny(unsafe_code)]

mod tracker;

mod explanation;

mod fused;

mod background;
mod colour_model;
mod components;
mod correlation;
mod crop;
mod decimation;
mod features;
mod fourier;
mod gradients;
mod heading;
mod integral_image;
mod layout;
mod motion;
mod paint;
mod peak;
mod probability_view;
mod redetection;
mod refinement;
mod sampling;
mod silhouette;
mod simd;
mod vector;

mod camshift;
mod config;

mod back_projection;
mod histogram;
mod hue;
mod hue_weight_table;
mod mean_shift;
mod moments;
mod window;

mod picture_growth;
mod picture_motion;
mod proposal;
mod saliency;

#[cfg(test)]
mod test_picture;

pub use camshift::CamShift;
pub use config::{CamShiftConfig, CamShiftConfigError};
pub use explanation::{Explanation, GreyMap, TrackerState};
pub use fused::{FusedConfig, FusedConfigError, FusedSetting, FusedTracker};
pub use histogram::{EmptyHistogram, HueHistogram};
pub use hue::{BELOW_FLOORS, Floors, YuvToHue};
pub use mean_shift::{
    CamShiftTarget, EDGE_MARGIN_PX, MOMENT_MARGIN_PX, SearchResult, TerminationCriteria, cam_shift,
};
pub use moments::{MomentSource, Moments, WeightMap};
pub use picture_growth::PictureGrowth;
pub use picture_motion::{PATCH_CENTRES, PATCHES, PatchShift, PictureMotion};
pub use proposal::{NoProposal, ObjectSizes, Proposal, Proposer};
pub use refinement::{
    MEASUREMENTS, RefinementWeights, RefinementWeightsError, RefinementWindow, WINDOW_CHANNELS,
    WINDOW_SIDE_CELLS,
};
pub use saliency::{MAX_PLACES, Saliency};
pub use tracker::{BackgroundShift, SelectionError, SelectionReport, Tracker};
pub use window::Window;
