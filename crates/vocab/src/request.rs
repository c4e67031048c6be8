//! Requests of the operator, or of a program on behalf of the operator.
//!
//! Each kind of request has an enum of its own, which the code that is about it matches without a wildcard:
//! [`CameraRequest`], [`VesselRequest`], [`WorldRequest`], [`VideoRequest`], [`NoteRequest`] and
//! [`SeatRequest`]; a stop concerns camera and vessel.
//!
//! The serialised form of a request is the same in the console's API, in a stored drive and in a recording: a
//! JSON object with the key `kind`, the name of the variant in kebab case, beside the fields of the variant:
//!
//! ```
//! use barrelman_vocab::{OperatorRequest, VesselCommand, VesselRequest};
//!
//! let json = r#"{"kind":"steer","throttle":0.5,"rudder":-0.2}"#;
//! let request: OperatorRequest = serde_json::from_str(json)?;
//! let expected = VesselRequest::Steer(VesselCommand { throttle: 0.5, rudder: -0.2 });
//! assert_eq!(request, expected.into());
//! assert_eq!(serde_json::to_string(&request)?, json);
//! # Ok::<(), serde_json::Error>(())
//! ```

mod camera;
mod note;
mod seat;
mod vessel;
mod video;
mod world;

mod form;

pub use camera::{CameraRequest, DrawnSelection, Nudge, Tap, TestMotions};
pub use note::{Note, NoteRequest, NoteText};
pub use seat::SeatRequest;
pub use vessel::{DrawnMark, MarkKind, MovedMark, VesselRequest, VesselStopper};
pub use video::VideoRequest;
pub use world::{NewDrill, NewDrive, WorldRequest};

use crate::stop_cause::StopCause;

/// A request to the pilot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorRequest {
    /// Rest the camera immediately, and stop the vessel. The camera stays at rest until the next
    /// [`Engage`](CameraRequest::Engage). Serialised as `{"kind":"stop","cause":"operator"}`; `cause` is
    /// `operator` by default.
    Stop(StopCause),
    /// About the camera and the target that it follows.
    Camera(CameraRequest),
    /// About the vessel.
    Vessel(VesselRequest),
}

/// A request of a page or of another program.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// To the pilot.
    Operator(OperatorRequest),
    /// About the simulated world.
    World(WorldRequest),
    /// About the choice between two videos.
    Video(VideoRequest),
    /// About the recording.
    Note(NoteRequest),
    /// About who has the control.
    Seat(SeatRequest),
}

impl From<CameraRequest> for OperatorRequest {
    fn from(request: CameraRequest) -> Self {
        Self::Camera(request)
    }
}

impl From<VesselRequest> for OperatorRequest {
    fn from(request: VesselRequest) -> Self {
        Self::Vessel(request)
    }
}

impl<T: Into<OperatorRequest>> From<T> for Request {
    fn from(request: T) -> Self {
        Self::Operator(request.into())
    }
}

impl From<WorldRequest> for Request {
    fn from(request: WorldRequest) -> Self {
        Self::World(request)
    }
}

impl From<VideoRequest> for Request {
    fn from(request: VideoRequest) -> Self {
        Self::Video(request)
    }
}

impl From<NoteRequest> for Request {
    fn from(request: NoteRequest) -> Self {
        Self::Note(request)
    }
}

impl From<SeatRequest> for Request {
    fn from(request: SeatRequest) -> Self {
        Self::Seat(request)
    }
}
