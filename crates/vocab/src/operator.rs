//! Requests to the pilot from the operator, or from a program on behalf of the operator.

use crate::image::PixelBox;

/// A request to the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorRequest {
    /// Track the content of this box of the next video frame.
    Select(PixelBox),
    /// Let the pilot move the camera. After a stop, only `Engage` allows motion again.
    Engage,
    /// Continue tracking with the camera at rest. This also ends a stop, without allowing motion.
    Disengage,
    /// Rest the camera immediately. The camera stays at rest until the next `Engage`.
    Stop(StopCause),
}

/// The reason for a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StopCause {
    /// The operator pressed Stop.
    Operator,
    /// The program is ending (signal, quit key, closed output).
    Ending,
    /// The video ended.
    VideoEnded,
    /// A part of the program failed.
    Fault,
}
