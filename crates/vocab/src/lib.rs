//! The types that all other crates share: time, angles, rates, image points, video frames, the messages
//! between the stages, and the vehicle profiles.
//!
//! Nothing in this crate does I/O or reads a clock. The types are plain data with few methods. Requests and
//! what they consist of have one serialised form ([`request`]); no other type has any. `docs/coordinates.md`
//! shows the frames of reference and the signs.
#![forbid(unsafe_code)]

pub mod time;

pub mod angle;
pub mod image;
pub mod lens;
pub mod unit;
pub mod video;
pub mod videos;

pub mod earth;
pub mod track;
pub mod water;

pub mod acceptance;
pub mod command;
pub mod drill;
pub mod drive_mode;
pub mod equipment;
pub mod hold_cause;
pub mod law;
pub mod mavlink;
pub mod named;
pub mod profile;
pub mod request;
pub mod short_text;
pub mod speed_curve;
pub mod stop_cause;
pub mod telemetry;
pub mod vehicle_text;
pub mod vessel;

pub mod link_command;
pub mod zoom;

pub mod rng;

pub use angle::{Angle, AngularRate, wrapped};
pub use command::{CameraCommand, RENEWAL_GRACE};
pub use drill::DrillName;
pub use equipment::{Equipment, EquipmentChange, EquipmentKind, UsedEquipment};
pub use hold_cause::HoldCause;
pub use image::{ImagePoint, PictureSize, PixelBox, PixelPoint};
pub use law::{Framed, LawId, LawName, OptimalMode};
pub use lens::{BrownConrady, Distortion, Lens};
pub use link_command::LinkCommand;
pub use named::Named;
pub use profile::{VehicleProfile, VehicleRates};
pub use request::{
    CameraRequest, DrawnMark, DrawnSelection, MarkKind, MovedMark, NewDrill, NewDrive, Note, NoteRequest,
    NoteText, Nudge, OperatorRequest, Request, SeatRequest, Tap, TestMotions, VesselRequest, VesselStopper,
    VideoRequest, WorldRequest,
};
pub use short_text::ShortText;
pub use stop_cause::StopCause;
pub use telemetry::Telemetry;
pub use time::Timestamp;
pub use track::{Localisation, MotionPrior, Track};
pub use unit::EncodedUnit;
pub use vessel::{FailSafe, KeepWay, VesselCommand, VesselLimits, VesselOrder, VesselProfile};
pub use video::{Picture, VideoFrame};
pub use videos::{VideoNumber, Videos};
pub use water::{CameraAboveWater, Sighting, SightingNoise, WaterCovariance, WaterFix, WaterPoint};
pub use zoom::{ZoomAbility, ZoomDynamics, ZoomRate};
