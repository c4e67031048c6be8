//! What an operator, or what speaks for one, may ask of the pilot.

use crate::image::PixelBox;

/// A request to the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorRequest {
    /// Follow what is in this box of the next video frame.
    Select(PixelBox),
    /// Let the camera be moved. The only way out of a stop.
    Engage,
    /// Go on tracking, but rest the camera.
    Disengage,
    /// Rest the camera at once and until the next `Engage`.
    Stop(StopCause),
}

/// Why a stop was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StopCause {
    /// The operator pressed Stop.
    Operator,
    /// The program is about to end (signal, quit key, closed output).
    Ending,
    /// The video came to its end.
    VideoEnded,
    /// A part of the program failed.
    Fault,
}
