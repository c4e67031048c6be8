//! What a detector found in a video frame: an input of the pilot, which cannot tell how it was computed.

use core::fmt;
use core::time::Duration;

use barrelman_vocab::{MotionPrior, PictureSize, PixelBox, Timestamp};

/// Most detections of a video frame that the pilot uses.
pub const MAX_DETECTIONS: usize = 32;
/// Oldest detections that are used: by then the sea has moved what they are about.
const MAX_AGE: Duration = Duration::from_millis(1500);
/// Largest distance of the boxes of one object, in sizes of the object.
const SAME_DISTANCE: f64 = 1.0;

/// The name of a class of objects, as a detector's settings give it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ClassName {
    length: u8,
    bytes: [u8; Self::MAX_BYTES],
}

impl ClassName {
    /// Longest name, bytes of UTF-8.
    pub const MAX_BYTES: usize = 24;

    /// A name; `None` if it is empty, too long, or has control characters.
    pub fn new(name: &str) -> Option<Self> {
        let mut bytes = [0; Self::MAX_BYTES];
        bytes.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        let is_printable = !name.is_empty() && !name.chars().any(char::is_control);
        is_printable.then_some(Self { length: name.len() as u8, bytes })
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }

    /// Whether the objects are boats: detections of them verify the boat that was found again.
    pub fn is_boat(&self) -> bool {
        self.as_str() == "boat"
    }

    /// Whether the objects are persons, who are proposed as marks.
    pub fn is_person(&self) -> bool {
        self.as_str() == "person"
    }
}

impl fmt::Debug for ClassName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// What a detector says an object is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Classification {
    /// The class.
    pub class: ClassName,
    /// The detector's score, 0 to 1.
    pub score: f64,
}

/// An object that a detector found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// The box, pixels.
    pub bounds: PixelBox,
    /// What the object is.
    pub classification: Classification,
}

impl Detection {
    /// The same in a later picture, which has moved.
    pub(crate) fn moved(self, by: &MotionPrior, picture: PictureSize) -> Self {
        let (PixelBox { w, h, .. }, by) = (self.bounds, by.at(self.bounds.centre(), picture));
        let centre = self.bounds.centre();
        let (u, v) = (centre.u + by.shift_u_px, centre.v + by.shift_v_px);
        let (w, h) = (by.scale * w, by.scale * h);
        Self { bounds: PixelBox { u: u - 0.5 * w, v: v - 0.5 * h, w, h }, ..self }
    }
}

/// What a detector found in one video frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Detections {
    /// Time of capture of the video frame.
    pub captured: Timestamp,
    /// Size of its picture.
    pub picture: PictureSize,
    /// The objects, the highest score first. The pilot uses the first [`MAX_DETECTIONS`].
    pub found: Vec<Detection>,
}

/// Whether what was detected then, in a picture of this size, concerns a picture of now.
pub(crate) fn is_recent(
    (captured, picture): (Timestamp, PictureSize),
    (now, size): (Timestamp, PictureSize),
) -> bool {
    picture == size && captured <= now && now.since(captured) <= MAX_AGE
}

/// Whether two boxes may be those of one object: they overlap, or are side by side.
pub(crate) fn is_near(one: PixelBox, other: PixelBox) -> bool {
    let size = libm::sqrt(one.area().min(other.area()));
    let (from, to) = (one.centre(), other.centre());
    one.iou(other) > 0.0 || libm::hypot(from.u - to.u, from.v - to.v) < SAME_DISTANCE * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_name_is_short_printable_text() {
        let longest = "x".repeat(ClassName::MAX_BYTES);
        for name in ["person", "Boot \u{fc}", &longest] {
            assert_eq!(ClassName::new(name).unwrap().as_str(), name);
        }
        for name in ["", "a\nb", &format!("{longest}x")] {
            assert_eq!(ClassName::new(name), None, "{name:?}");
        }
    }
}
