//! The interface of the console for the page and for programs: JSON messages and the head of a video message.
//!
//! Every type here is plain data with a JSON Schema (`barrelman config api` prints the OpenAPI document).
//! Times are nanoseconds since the program's start (`_ns`), unless a name says otherwise; angles of the
//! picture are degrees, anticlockwise from image right; rates are rad/s, pan positive to the right, tilt
//! positive upwards. `null` stands for what is not known.
//!
//! ```text
//! page -> program   ClientMessage   request, video, ping
//! program -> page   ServerMessage   hello, snapshot, answer, events, event, control, pong
//!                   binary          one unit of video, with the head of `video_message`
//! ```

mod message;

mod place;
mod snapshot;
mod track;
mod vessel;

mod paths;
mod schema;
mod video_message;

pub use crate::snapshot::{DriveState, EventEntry, Level};
pub use message::{
    Answer, AnswerKind, ClientMessage, Hello, RequestBody, ServerMessage, VideoPath, WantedVideo,
};
pub use place::{PlaceStatus, WaterOnEarthStatus};
pub use schema::api_document;
pub use snapshot::{
    AxisRates, BoatStatus, CameraWork, CandidateStatus, ControlSeat, EncodedVideo, LinkStatus, ModeStatus,
    OtherVideoStatus, PerceptStatus, PositionStatus, ProposalStatus, RecordingStatus, RegionStatus,
    StatusSnapshot, VideoStatus, WorkFigures, ZoomStatus,
};
pub use track::TrackStatus;
pub use vessel::{MarkStatus, ProgressStatus, VesselStatus};
pub use video_message::{HEAD_BYTES, VideoHead, VideoKind};
