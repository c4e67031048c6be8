//! The topics.

use std::cell::Cell;

use anyhow::Result;
use ros2_client::error::WriteError;
use ros2_client::qos::QosProfile;
use ros2_client::{MessageTypeName, Name, Node, Publisher};
use serde::Serialize;

use super::qos;
use crate::messages::{CompressedImage, Detection2DArray, DiagnosticArray, NavSatFix, TwistStamped};
use crate::notice::say;

/// All topics of the node.
pub struct Topics {
    /// `~/detections`.
    pub detections: Topic<Detection2DArray>,
    /// `~/camera_rate`.
    pub camera_rate: Topic<TwistStamped>,
    /// `~/image/compressed`.
    pub pictures: Topic<CompressedImage>,
    /// `~/boat/fix`.
    pub boat: Topic<NavSatFix>,
    /// `~/marks`.
    pub marks: Topic<NavSatFix>,
    /// `/diagnostics`.
    pub diagnostics: Topic<DiagnosticArray>,
}

impl Topics {
    pub(super) fn advertise(node: &mut Node, path: &str) -> Result<Self> {
        let below = |part: &str| format!("{path}{part}");
        let vision = ("vision_msgs", "Detection2DArray");
        let (image, fix) = (("sensor_msgs", "CompressedImage"), ("sensor_msgs", "NavSatFix"));
        Ok(Self {
            detections: Topic::advertise(node, path, "detections", vision, qos::sensor_data())?,
            camera_rate: Topic::advertise(
                node,
                path,
                "camera_rate",
                ("geometry_msgs", "TwistStamped"),
                qos::sensor_data(),
            )?,
            pictures: Topic::advertise(node, &below("/image"), "compressed", image, qos::sensor_data())?,
            boat: Topic::advertise(node, &below("/boat"), "fix", fix, qos::sensor_data())?,
            marks: Topic::advertise(node, path, "marks", fix, qos::state())?,
            diagnostics: Topic::advertise(
                node,
                "/",
                "diagnostics",
                ("diagnostic_msgs", "DiagnosticArray"),
                qos::state(),
            )?,
        })
    }
}

/// A topic with messages of one type.
pub struct Topic<M: Serialize> {
    name: String,
    publisher: Publisher<M>,
    has_failed: Cell<bool>,
}

impl<M: Serialize> Topic<M> {
    fn advertise(
        node: &mut Node,
        namespace: &str,
        name: &str,
        (package, message): (&str, &str),
        qos: QosProfile,
    ) -> Result<Self> {
        let full = Name::new(namespace, name)?;
        let topic = node.create_topic(&full, MessageTypeName::new(package, message), &qos)?;
        let publisher = node.create_publisher(&topic, Some(qos))?;
        let name = format!("{}/{name}", namespace.trim_end_matches('/'));
        Ok(Self { name, publisher, has_failed: Cell::new(false) })
    }

    /// Publishes a message. Does not wait: where subscribers do not keep up, the message is lost.
    pub fn publish(&self, message: M) {
        match self.publisher.publish(message) {
            Ok(()) | Err(WriteError::WouldBlock { .. }) => {}
            Err(error) if !self.has_failed.replace(true) => {
                say(&format!("a message of {} could not be published: {error}", self.name));
            }
            // Said once.
            Err(_) => {}
        }
    }

    pub(super) fn has_subscribers(&self, node: &Node) -> bool {
        self.publisher.get_subscription_count(node) > 0
    }
}
