//! The nouns that every other crate speaks in: time, angles, rates, image points, video frames, the messages
//! between the stages and the vehicle profiles.
//!
//! Nothing here does I/O, reads a clock, or derives a file format. Types are plain data with the few methods
//! that state what they mean. Frames of reference and signs are drawn in `docs/coordinates.md`.
#![forbid(unsafe_code)]

pub mod time;

pub mod angle;
pub mod image;
pub mod unit;
pub mod video;

pub mod track;

pub mod command;
pub mod operator;
pub mod profile;
pub mod telemetry;

pub use angle::{Angle, AngularRate};
pub use command::CameraCommand;
pub use image::{ImagePoint, PictureSize, PixelBox, PixelPoint};
pub use operator::{OperatorRequest, StopCause};
pub use profile::{VehicleProfile, VehicleRates};
pub use telemetry::Telemetry;
pub use time::Timestamp;
pub use track::{Localisation, MotionPrior, Track};
pub use unit::EncodedUnit;
pub use video::{Picture, VideoFrame};
