//! A tracking camera: what ground stations find, select on, and read the target's place from.
//!
//! ```text
//!   ground station --2004, 2005, 2010--> TrackingCamera --Asked by--> operator gateway
//!   ground station <------- ack -------- TrackingCamera <--answered-- operator gateway
//!   ground station <------- 275 -------- TrackingCamera <---- show -- newest snapshot
//! ```
//! The camera is a component of the vehicle's system. It appears when the first picture is known, because the
//! picture's size is a part of its description. A track command selects and never engages; its answer is that
//! of the operator gateway where that comes within [`times::ANSWER_WITHIN`], and ACCEPTED otherwise: ground
//! stations repeat a command after 0.5 s, and the target is confirmed on several video frames. What becomes
//! of the selection is in the status of the track, and a refusal also in a text.
//!
//! The protocol is [MAVLink's camera protocol][page], version 2; `docs/wire/mavlink-camera.md` lists what is
//! answered.
//!
//! [page]: https://mavlink.io/en/services/camera.html

use core::time::Duration;

use barrelman_vocab::mavlink::{Address, ComponentId, SystemId};
use barrelman_vocab::{PictureSize, Timestamp};
use mavlink::MessageData as _;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavResult, MavType};

use super::frame::{Frame, FrameReader, FrameWriter};
use super::heartbeat::heartbeat;
use super::signing::Signing;

pub mod times;

mod request;

mod command;
mod description;
mod image_status;
mod status_text;
mod waiting;

use command::{Command, Order};
use times::{HEARTBEAT_INTERVAL, STATUS_INTERVAL};
use waiting::WaitingCommands;

pub use description::{CameraDescription, VideoStream};
pub use image_status::ShownTarget;
pub use request::{RequestNumber, TrackingAnswer, TrackingRequest};

/// The component id of an autopilot.
const AUTOPILOT: ComponentId = ComponentId(1);
/// The system of the camera until an autopilot is heard.
const FIRST_SYSTEM: SystemId = SystemId(1);

/// How the camera appears.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CameraSettings {
    /// The vehicle's system; `None`: that of the first autopilot that is heard, and 1 until then.
    pub system: Option<SystemId>,
    /// The camera's component, 100 to 105 for ground stations that look for cameras by their ids.
    pub component: ComponentId,
    /// Whether a predicted place is marked as COASTING. Ground stations of 2026 draw no rectangle then.
    pub marks_coasting: bool,
}

impl CameraSettings {
    /// The first camera of the first vehicle, whose predicted places look like measured ones.
    pub const DEFAULT: Self = Self { system: None, component: ComponentId(100), marks_coasting: false };
}

/// What the camera sees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shown {
    /// Size of the picture; `None`: there is none yet.
    pub picture: Option<PictureSize>,
    /// Video frames a second, 0 where that is not known yet.
    pub frames_per_second: f32,
    /// The target.
    pub target: ShownTarget,
}

/// A tracking camera on one link.
#[derive(Debug)]
pub struct TrackingCamera {
    settings: CameraSettings,
    description: CameraDescription,
    reader: FrameReader,
    writer: FrameWriter,
    has_heard_autopilot: bool,
    shown: Shown,
    /// Time between two statuses of the track; `None`: they are not sent.
    status_interval: Option<Duration>,
    status_at: Timestamp,
    heartbeat_at: Timestamp,
    waiting: WaitingCommands,
    texts: u16,
    /// Packets that are due now.
    out: Vec<Vec<u8>>,
}

impl TrackingCamera {
    /// A camera on a newly opened port. With `signing`, packets are signed, and others are not read.
    pub fn new(settings: CameraSettings, description: CameraDescription, signing: Option<Signing>) -> Self {
        let own = Address { system: settings.system.unwrap_or(FIRST_SYSTEM), component: settings.component };
        Self {
            settings,
            description,
            reader: FrameReader::new(signing, Timestamp::ZERO),
            writer: FrameWriter::new(own, signing),
            has_heard_autopilot: false,
            shown: Shown::default(),
            status_interval: None,
            status_at: Timestamp::ZERO,
            heartbeat_at: Timestamp::ZERO,
            waiting: WaitingCommands::default(),
            texts: 0,
            out: Vec::new(),
        }
    }

    /// The camera's address.
    pub const fn address(&self) -> Address {
        self.writer.address()
    }

    /// Sets what the camera sees now.
    pub const fn show(&mut self, shown: Shown) {
        self.shown = shown;
    }

    /// Appends the packets that are due now to `out`, and returns when to call again at the latest.
    pub fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) -> Timestamp {
        self.writer.set_time(now);
        let mut next = now.plus(HEARTBEAT_INTERVAL);
        if let Some(picture) = self.shown.picture {
            if self.heartbeat_at <= now {
                self.out.push(self.writer.write(&heartbeat(MavType::MAV_TYPE_CAMERA)));
                self.heartbeat_at = now.plus(HEARTBEAT_INTERVAL);
            }
            next = next.min(self.heartbeat_at);
            if let Some(interval) = self.status_interval {
                if self.status_at <= now {
                    self.send_status(picture);
                    self.status_at = now.plus(interval);
                }
                next = next.min(self.status_at);
            }
        }
        for overdue in self.waiting.overdue(now) {
            self.acknowledge(&overdue, MavResult::MAV_RESULT_ACCEPTED);
        }
        out.append(&mut self.out);
        self.waiting.next_due().map_or(next, |due| next.min(due))
    }

    /// Processes received bytes, and passes what a ground station asks for to `ask`.
    pub fn received(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        ask: &mut dyn FnMut(RequestNumber, TrackingRequest),
    ) {
        self.writer.set_time(now);
        let mut commands = Vec::new();
        let mut autopilot = None;
        self.reader.read(bytes, |frame| {
            if is_autopilot(frame) {
                autopilot.get_or_insert(frame.from.system);
            }
            commands.extend(Command::read(frame));
        });
        self.writer.follow(&self.reader);
        if let Some(system) = autopilot {
            self.on_autopilot(system);
        }
        for command in commands {
            self.on_command(&command, now, ask);
        }
    }

    /// The operator gateway has answered a request.
    pub fn answered(&mut self, number: RequestNumber, answer: &TrackingAnswer, now: Timestamp) {
        self.writer.set_time(now);
        let result = match answer {
            TrackingAnswer::Accepted => MavResult::MAV_RESULT_ACCEPTED,
            TrackingAnswer::Refused(_) => MavResult::MAV_RESULT_DENIED,
            TrackingAnswer::Superseded => MavResult::MAV_RESULT_CANCELLED,
        };
        if let TrackingAnswer::Refused(reason) = answer {
            self.tell(reason);
        }
        if let Some(command) = self.waiting.answered(number, result) {
            self.acknowledge(&command, result);
        }
    }

    /// The camera belongs to the system of the first autopilot.
    fn on_autopilot(&mut self, system: SystemId) {
        if self.settings.system.is_none() && !self.has_heard_autopilot {
            self.has_heard_autopilot = true;
            self.writer.set_address(Address { system, component: self.settings.component });
        }
    }

    fn on_command(
        &mut self,
        command: &Command,
        now: Timestamp,
        ask: &mut dyn FnMut(RequestNumber, TrackingRequest),
    ) {
        let own = self.address();
        if command.from == own || !command.is_for(own) {
            return;
        }
        let result = match command.order() {
            Order::Track(selection) => return self.on_track_command(command, selection.map(Some), now, ask),
            Order::Forget => return self.on_track_command(command, Ok(None), now, ask),
            Order::Send { message, index } => return self.on_message_request(command, message, index, now),
            Order::SetStatusInterval(interval) => {
                self.status_interval = interval;
                self.status_at = now;
                MavResult::MAV_RESULT_ACCEPTED
            }
            Order::Stream(id) if self.description.stream.is_some() => {
                if CameraDescription::is_stream(id) {
                    MavResult::MAV_RESULT_ACCEPTED
                } else {
                    MavResult::MAV_RESULT_DENIED
                }
            }
            Order::Wrong(reason) => {
                self.tell(reason);
                MavResult::MAV_RESULT_DENIED
            }
            // A command to all components may be meant for another one.
            Order::Stream(_) | Order::Unknown if !command.names(own) => return,
            Order::Stream(_) | Order::Unknown => MavResult::MAV_RESULT_UNSUPPORTED,
        };
        self.acknowledge(command, result);
    }

    fn on_track_command(
        &mut self,
        command: &Command,
        selection: Result<Option<command::Selection>, &'static str>,
        now: Timestamp,
        ask: &mut dyn FnMut(RequestNumber, TrackingRequest),
    ) {
        let request = match (selection, self.shown.picture) {
            (Ok(None), _) => TrackingRequest::Forget,
            (Ok(Some(selection)), Some(picture)) => selection.request(picture),
            (Ok(Some(_)), None) => {
                self.tell("no picture has arrived yet: select again when the video is up");
                return self.acknowledge(command, MavResult::MAV_RESULT_TEMPORARILY_REJECTED);
            }
            (Err(reason), _) => {
                self.tell(reason);
                return self.acknowledge(command, MavResult::MAV_RESULT_DENIED);
            }
        };
        if let TrackingRequest::Select(_) | TrackingRequest::SelectAt(_) = request {
            // Ground stations of 2025 do not ask for the status of the track.
            self.status_interval.get_or_insert(STATUS_INTERVAL);
            if let Some(told) = self.waiting.repeated(command, now) {
                return told.into_iter().for_each(|result| self.acknowledge(command, result));
            }
            if self.waiting.is_full() {
                return self.acknowledge(command, MavResult::MAV_RESULT_TEMPORARILY_REJECTED);
            }
        }
        ask(self.waiting.add(*command, now), request);
    }

    /// Answers the request for a message: first the acknowledgement, then the message.
    fn on_message_request(&mut self, command: &Command, message: u32, index: f32, now: Timestamp) {
        let is_supported = message == image_status::ID || self.description.has(message);
        if !is_supported {
            if command.names(self.address()) {
                self.acknowledge(command, MavResult::MAV_RESULT_UNSUPPORTED);
            }
            return;
        }
        if !CameraDescription::has_index(message, index) {
            return self.acknowledge(command, MavResult::MAV_RESULT_DENIED);
        }
        let Some(picture) = self.shown.picture else {
            return self.acknowledge(command, MavResult::MAV_RESULT_TEMPORARILY_REJECTED);
        };
        self.acknowledge(command, MavResult::MAV_RESULT_ACCEPTED);
        if message == image_status::ID {
            self.send_status(picture);
        } else {
            let frames_per_second = self.shown.frames_per_second;
            let asked = description::Asked { message, picture, frames_per_second, now };
            self.description.write(&asked, &mut self.writer, &mut self.out);
        }
    }

    fn send_status(&mut self, picture: PictureSize) {
        let status = image_status::encode(self.shown.target, picture, self.settings.marks_coasting);
        self.out.push(self.writer.write(&status));
    }

    fn acknowledge(&mut self, command: &Command, result: MavResult) {
        self.out.push(command.acknowledgement(result, &mut self.writer));
    }

    /// Tells the operator of a ground station why something is refused.
    fn tell(&mut self, text: &str) {
        self.texts = self.texts.wrapping_add(1).max(1);
        status_text::write(text, self.texts, &mut self.writer, &mut self.out);
    }
}

/// Whether a frame is the heartbeat of an autopilot, of any type: those of later dialects have numbers that
/// are not known here.
fn is_autopilot(frame: &Frame<'_>) -> bool {
    const TYPE_AT: usize = 4;
    const AUTOPILOT_AT: usize = 5;
    let is_heartbeat = frame.message == HEARTBEAT_DATA::ID && frame.from.component == AUTOPILOT;
    let at = |index: usize| frame.payload().get(index).copied().unwrap_or(0);
    is_heartbeat
        && at(AUTOPILOT_AT) != MavAutopilot::MAV_AUTOPILOT_INVALID as u8
        && at(TYPE_AT) != MavType::MAV_TYPE_GCS as u8
}
