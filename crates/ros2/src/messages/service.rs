//! `std_srvs/Trigger`.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// The request, which has no field. ROS 2 sends one byte in its place.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// Without meaning.
    pub structure_needs_at_least_one_member: u8,
}

impl Message for TriggerRequest {}

/// The response.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether the request is in force.
    pub success: bool,
    /// What became of it, in words.
    pub message: String,
}

impl Message for TriggerResponse {}
