//! The purposes of motion.

/// What the camera may move for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Purpose {
    /// To follow the target.
    Follow,
    /// To turn as the operator holds it, slowly.
    Nudge,
    /// To search for a target that is lost, slowly.
    Search,
    /// To measure the camera's axes, slowly.
    Calibrate,
}
