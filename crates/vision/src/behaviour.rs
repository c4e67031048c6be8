//! Behaviour versions of the trackers: which results a tracker gives.
//!
//! Recordings, drives and campaigns store the version of the tracker that made them, so that a replay can tell a
//! change of the tracker from a fault. Raise a tracker's version by 1 in the commit that changes its results: when
//! the same frames, the same selection and the same settings give a track that differs in any bit. A change that
//! leaves every result as it was (speed, names, structure) does not raise the version. `CHANGELOG.md` names each rise.

/// Behaviour version of [`FusedTracker`](crate::FusedTracker).
pub const FUSED: u32 = 21;

/// Behaviour version of [`CamShift`](crate::CamShift).
pub const CAMSHIFT: u32 = 1;
