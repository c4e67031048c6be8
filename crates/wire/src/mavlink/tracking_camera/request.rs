//! What a ground station asks the operator gateway for, and the answers.

use barrelman_vocab::{PixelBox, PixelPoint};

/// Names a request until it is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct RequestNumber(pub(super) u32);

/// What a ground station asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TrackingRequest {
    /// Track what is in this box of the picture.
    Select(PixelBox),
    /// Track the object at this point of the picture.
    SelectAt(PixelPoint),
    /// Follow nothing.
    Forget,
}

/// The operator gateway's answer to a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TrackingAnswer {
    /// The request is in force.
    Accepted,
    /// The request has no effect, for this reason.
    Refused(String),
    /// A later request took its place.
    Superseded,
}
