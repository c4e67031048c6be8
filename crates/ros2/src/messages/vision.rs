//! `vision_msgs`, version 4.

use serde::Serialize;

use super::{Header, PoseWithCovariance};

/// `vision_msgs/Point2D`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Point2D {
    /// Pixels to the right.
    pub x: f64,
    /// Pixels downwards.
    pub y: f64,
}

/// `vision_msgs/Pose2D`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Pose2D {
    /// The place.
    pub position: Point2D,
    /// The rotation, rad.
    pub theta: f64,
}

/// `vision_msgs/BoundingBox2D`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct BoundingBox2D {
    /// The centre.
    pub center: Pose2D,
    /// Width, pixels.
    pub size_x: f64,
    /// Height, pixels.
    pub size_y: f64,
}

/// `vision_msgs/ObjectHypothesis`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ObjectHypothesis {
    /// The class.
    pub class_id: String,
    /// The confidence, 0 to 1.
    pub score: f64,
}

/// `vision_msgs/ObjectHypothesisWithPose`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ObjectHypothesisWithPose {
    /// The hypothesis.
    pub hypothesis: ObjectHypothesis,
    /// The pose.
    pub pose: PoseWithCovariance,
}

/// `vision_msgs/Detection2D`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Detection2D {
    /// Time of capture and frame of reference.
    pub header: Header,
    /// What the object may be.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// The box.
    pub bbox: BoundingBox2D,
    /// The name of the track.
    pub id: String,
}

/// `vision_msgs/Detection2DArray`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Detection2DArray {
    /// Time of capture and frame of reference.
    pub header: Header,
    /// The objects.
    pub detections: Vec<Detection2D>,
}
