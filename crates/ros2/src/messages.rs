//! The ROS 2 messages that the node publishes, field by field in the order of their definitions: the order is
//! the layout on the wire (CDR).
//!
//! The definitions are those of common_interfaces and vision_msgs (version 4) from Humble to Kilted.

mod diagnostic;
mod geometry;
mod sensor;
mod service;
mod standard;
mod vision;

pub use diagnostic::{DiagnosticArray, DiagnosticStatus, KeyValue, Level};
pub use geometry::{Point, Pose, PoseWithCovariance, Quaternion, Twist, TwistStamped, Vector3};
pub use sensor::{CompressedImage, CovarianceType, NavSatFix, NavSatStatus, Octets};
pub use service::{TriggerRequest, TriggerResponse};
pub use standard::{Header, Time};
pub use vision::{
    BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesis, ObjectHypothesisWithPose, Point2D, Pose2D,
};
