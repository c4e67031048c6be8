//! The names of the frames of reference: below the node's own name, so that those of two nodes differ.

use crate::messages::{Header, Time};

/// The frames of reference of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames {
    /// The node's name without its leading slash.
    pub node: String,
}

impl Frames {
    /// The picture: x to the right, y downwards, z ahead.
    pub fn picture(&self, stamp: Time) -> Header {
        self.header(stamp, "camera_optical")
    }

    /// The camera: x ahead, y to the left, z upwards.
    pub fn camera(&self, stamp: Time) -> Header {
        self.header(stamp, "camera")
    }

    /// The followed boat.
    pub fn boat(&self, stamp: Time) -> Header {
        self.header(stamp, "boat")
    }

    /// A mark, by its kind and number.
    pub fn mark(&self, stamp: Time, kind: &str, id: u32) -> Header {
        self.header(stamp, &format!("{}_{id}", kind.replace('-', "_")))
    }

    fn header(&self, stamp: Time, name: &str) -> Header {
        Header { stamp, frame_id: format!("{}/{name}", self.node) }
    }
}
