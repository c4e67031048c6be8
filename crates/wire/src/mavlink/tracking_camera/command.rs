//! Commands to the camera: COMMAND_LONG (76) and COMMAND_INT (75), read by hand.
//!
//! A number that the dialect does not know is a command, too, and gets its answer: silence makes ground
//! stations repeat. Fields that are left out of a payload are zero.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{PictureSize, PixelBox, PixelPoint};
use mavlink::MessageData as _;
use mavlink::dialects::common::{COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, MavCmd, MavResult};

use super::image_status;
use super::request::TrackingRequest;
use super::times::{LEAST_STATUS_INTERVAL, STATUS_INTERVAL};
use crate::mavlink::frame::{Frame, FrameWriter};

/// Where the fields behind the parameters begin; they are the same in both messages.
const COMMAND_AT: usize = 28;
const TARGET_AT: usize = 30;
/// Corners of a rectangle may be outside of the picture by this share, as ground stations round.
const TOLERANCE: f32 = 1e-3;
/// A received command.
#[derive(Debug, Clone, Copy)]
pub(super) struct Command {
    /// The sender.
    pub(super) from: Address,
    to: Address,
    number: u16,
    parameters: [f32; 7],
}

/// What to track, in shares of the picture from its left top corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Selection {
    Rectangle {
        left: f32,
        top: f32,
        right: f32,
        bottom: f32,
    },
    /// The object at a point.
    Point {
        x: f32,
        y: f32,
    },
}

/// What a command orders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    Track(Result<Selection, &'static str>),
    Forget,
    /// Send this message once.
    Send {
        message: u32,
        index: f32,
    },
    /// Send the status of the track at this interval, or not.
    SetStatusInterval(Option<Duration>),
    /// Begin or end the video stream, which always runs.
    Stream(f32),
    /// A value that has no meaning, for this reason.
    Wrong(&'static str),
    Unknown,
}

impl Command {
    /// The command in a frame; `None`: another message.
    pub(super) fn read(frame: &Frame<'_>) -> Option<Self> {
        let is_long = frame.message == COMMAND_LONG_DATA::ID;
        if !is_long && frame.message != COMMAND_INT_DATA::ID {
            return None;
        }
        let payload = frame.payload();
        let byte = |at: usize| payload.get(at).copied().unwrap_or(0);
        let word = |at: usize| [byte(at), byte(at + 1), byte(at + 2), byte(at + 3)];
        let mut parameters: [f32; 7] = core::array::from_fn(|index| f32::from_le_bytes(word(4 * index)));
        if !is_long {
            for index in [4, 5] {
                let value = i32::from_le_bytes(word(4 * index));
                parameters[index] = if value == i32::MAX { f32::NAN } else { value as f32 };
            }
        }
        Some(Self {
            from: frame.from,
            to: Address::new(byte(TARGET_AT), byte(TARGET_AT + 1)),
            number: u16::from_le_bytes([byte(COMMAND_AT), byte(COMMAND_AT + 1)]),
            parameters,
        })
    }

    /// Whether the command is for the camera, or for all.
    pub(super) fn is_for(&self, own: Address) -> bool {
        let is_system = self.to.system == own.system || self.to.system == Address::EVERYONE.system;
        let is_component =
            self.to.component == own.component || self.to.component == Address::EVERYONE.component;
        is_system && is_component
    }

    /// Whether the command is for the camera by its component id.
    pub(super) fn names(&self, own: Address) -> bool {
        self.to.component == own.component
    }

    /// Whether both are the same command of the same sender.
    pub(super) fn repeats(&self, other: &Self) -> bool {
        let bits = |command: &Self| command.parameters.map(f32::to_bits);
        self.from == other.from && self.number == other.number && bits(self) == bits(other)
    }

    /// What the command orders.
    pub(super) fn order(&self) -> Order {
        let [first, second, third, fourth, fifth, ..] = self.parameters;
        let is = |command: MavCmd| self.number == command as u16;
        let old = OLD_REQUESTS.iter().find(|(number, _)| self.number == *number);
        if is(MavCmd::MAV_CMD_CAMERA_TRACK_RECTANGLE) {
            Order::Track(self.for_camera(fifth).and_then(|()| rectangle([first, second, third, fourth])))
        } else if is(MavCmd::MAV_CMD_CAMERA_TRACK_POINT) {
            Order::Track(self.for_camera(fourth).and_then(|()| point([first, second])))
        } else if is(MavCmd::MAV_CMD_CAMERA_STOP_TRACKING) {
            self.for_camera(first).map_or_else(Order::Wrong, |()| Order::Forget)
        } else if is(MavCmd::MAV_CMD_REQUEST_MESSAGE) {
            Order::Send { message: message_number(first), index: second }
        } else if let Some((_, message)) = old {
            // Those of streams name one.
            let index = if matches!(self.number, 2504 | 2505) { first } else { 0.0 };
            Order::Send { message: *message, index }
        } else if is(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL) && message_number(first) == image_status::ID {
            status_interval(second)
        } else if is(MavCmd::MAV_CMD_VIDEO_START_STREAMING) || is(MavCmd::MAV_CMD_VIDEO_STOP_STREAMING) {
            Order::Stream(first)
        } else {
            Order::Unknown
        }
    }

    /// Whether a camera id names this camera: 0 and NaN are all cameras.
    fn for_camera(&self, id: f32) -> Result<(), &'static str> {
        let is_own = id.is_nan() || id == 0.0 || id == f32::from(self.to.component.0);
        if is_own { Ok(()) } else { Err("there is no camera with this id: use 0") }
    }

    /// COMMAND_ACK (77) with this result, to the sender.
    pub(super) fn acknowledgement(&self, result: MavResult, writer: &mut FrameWriter) -> Vec<u8> {
        let [low, high] = self.number.to_le_bytes();
        let (system, component) = (self.from.system.0, self.from.component.0);
        // Between result and target: progress, and a second result.
        let payload = [low, high, result as u8, 0, 0, 0, 0, 0, system, component];
        writer.write_payload(COMMAND_ACK_DATA::ID, &payload)
    }
}

/// Commands of before REQUEST_MESSAGE, and the messages that they ask for.
const OLD_REQUESTS: [(u16, u32); 6] =
    [(521, 259), (522, 260), (525, 261), (527, 262), (2504, 269), (2505, 270)];

/// The number of a message in a parameter; a value that is none is a number that no message has.
fn message_number(parameter: f32) -> u32 {
    if (0.0..16_777_216.0).contains(&parameter) && parameter.fract() == 0.0 {
        parameter as u32
    } else {
        u32::MAX
    }
}

/// An interval in microseconds: -1 is never, 0 the usual one.
fn status_interval(microseconds: f32) -> Order {
    match microseconds {
        -1.0 => Order::SetStatusInterval(None),
        0.0 => Order::SetStatusInterval(Some(STATUS_INTERVAL)),
        _ => match Duration::try_from_secs_f64(f64::from(microseconds) * 1e-6) {
            Ok(interval) => Order::SetStatusInterval(Some(interval.max(LEAST_STATUS_INTERVAL))),
            Err(_) => Order::Wrong("the interval must be -1, 0 or a number of microseconds"),
        },
    }
}

fn rectangle(corners: [f32; 4]) -> Result<Selection, &'static str> {
    if !corners.iter().all(|value| (-TOLERANCE..=1.0 + TOLERANCE).contains(value)) {
        return Err("the corners must be shares of the picture, 0 to 1");
    }
    let [left, top, right, bottom] = corners.map(|value| value.clamp(0.0, 1.0));
    if left < right && top < bottom {
        Ok(Selection::Rectangle { left, top, right, bottom })
    } else {
        Err("the rectangle has no area: the second corner must lie right of and below the first one")
    }
}

fn point([x, y]: [f32; 2]) -> Result<Selection, &'static str> {
    if ![x, y].iter().all(|value| (-TOLERANCE..=1.0 + TOLERANCE).contains(value)) {
        return Err("the point must be given in shares of the picture, 0 to 1");
    }
    Ok(Selection::Point { x: x.clamp(0.0, 1.0), y: y.clamp(0.0, 1.0) })
}

impl Selection {
    /// The request for it in a picture of this size.
    pub(super) fn request(self, picture: PictureSize) -> TrackingRequest {
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        match self {
            Self::Rectangle { left, top, right, bottom } => {
                let [left, right] = [left, right].map(|share| f64::from(share) * width);
                let [top, bottom] = [top, bottom].map(|share| f64::from(share) * height);
                TrackingRequest::Select(PixelBox { u: left, v: top, w: right - left, h: bottom - top })
            }
            // The right and the lower edge are no pixels.
            Self::Point { x, y } => TrackingRequest::SelectAt(PixelPoint {
                u: (f64::from(x) * width).min(width - 0.5),
                v: (f64::from(y) * height).min(height - 0.5),
            }),
        }
    }
}
