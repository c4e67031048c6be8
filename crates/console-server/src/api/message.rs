//! Messages of the socket, in both directions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use barrelman_experiments::scenario::ScenarioChoice;

use super::snapshot::{ControlSeat, StatusSnapshot};
use crate::map::About;
use crate::snapshot::EventEntry;
use barrelman_vocab::{LawId, Request, VideoNumber};

/// The video that a page wants, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WantedVideo {
    /// The way.
    pub path: VideoPath,
    /// Which of the videos.
    #[serde(default)]
    pub video: VideoNumber,
}

impl WantedVideo {
    /// No video.
    pub const NONE: Self = Self { path: VideoPath::None, video: VideoNumber::First };
}

/// How a page receives video.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VideoPath {
    /// Received H.264 unchanged, for WebCodecs.
    H264,
    /// Received H.265 unchanged, for WebCodecs.
    H265,
    /// The newest picture as JPEG.
    Jpeg,
    /// No video.
    None,
}

/// A message to the program. Text, JSON, at most 4096 bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ClientMessage {
    /// A request. Answered by `answer` with the same `id`.
    Request {
        /// Number of the request, chosen by the page.
        id: u64,
        /// The request.
        request: Request,
        /// `stops_taken` of the newest state that the client has. What lets the camera or the boat move from
        /// now on is refused where somebody has stopped since: a network may have held the request up.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stops_taken: Option<u64>,
    },
    /// Choose how video is sent. Nothing is sent before the first choice.
    Video(WantedVideo),
    /// Measure the clocks. Answered by `pong`. Also shows that the page is alive: to be sent every second,
    /// and every 0.2 s while a boat is commanded. A page in control that is silent for 3 s loses the control,
    /// and for 0.9 s stops the boat.
    Ping {
        /// The page's own time, milliseconds.
        sent_ms: f64,
        /// How many snapshots and video messages the page has handled since it connected. A client that says
        /// it gets no more of them ahead than it has handled within 0.75 s, and one picture (JPEG) at a time.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        handled: Option<u64>,
    },
}

/// A message to the page. Text, JSON.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum ServerMessage {
    /// The first message.
    Hello(Box<Hello>),
    /// The newest state; at most 100 a second, fewer where the reader is slow.
    Snapshot(Box<StatusSnapshot>),
    /// The answer to a request.
    Answer(Answer),
    /// The events of the last hour, oldest first; after `hello`.
    Events {
        /// The events.
        events: Vec<EventEntry>,
    },
    /// A new event.
    Event(EventEntry),
    /// Who controls, and who asks for the control; after `hello` and after each change.
    Control(ControlSeat),
    /// The answer to `ping`.
    Pong {
        /// The page's time, as sent.
        sent_ms: f64,
        /// The program's time.
        now_ns: u64,
        /// Snapshots and video messages that were sent before, on this connection.
        sent: u64,
    },
}

/// What does not change while the page is open.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Hello {
    /// Number of this page.
    pub client: u64,
    /// Whether the page's token permits control; a page without it watches and can only stop.
    pub may_control: bool,
    /// Version of the program.
    pub version: &'static str,
    /// `run` or `demo`.
    pub command: &'static str,
    /// Where the video comes from, without passwords; of a simulated world, the first one.
    pub source: String,
    /// Where the second video comes from, without passwords; `null`: there is one video.
    pub second_source: Option<String>,
    /// Where commands go, without passwords; `null`: a dry run.
    pub link: Option<String>,
    /// The vehicle profile.
    pub vehicle: String,
    /// The scenarios that a new drive can have; empty: the world is not simulated.
    pub scenarios: Vec<ScenarioChoice>,
    /// The laws that can be chosen.
    pub laws: Vec<LawId>,
    /// Rate of a nudge, rad/s.
    pub nudge_rate: f64,
    /// The map under boat and marks; `null`: there is none.
    pub map: Option<About>,
    /// What happens when the controlling page is gone: `stay` or `stop`.
    pub on_console_lost: &'static str,
}

/// The answer to a request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Answer {
    /// Number of the request.
    pub id: u64,
    /// The answer.
    pub answer: AnswerKind,
    /// Why a request was refused or superseded, or what was noticed; in words for the operator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What became of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AnswerKind {
    /// The request is in force.
    Accepted,
    /// The request has no effect.
    Refused,
    /// A later request took its place.
    Superseded,
}

/// The body of `POST /api/v1/requests`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RequestBody {
    /// Number of the request, returned in the answer.
    #[serde(default)]
    pub id: u64,
    /// The request.
    pub request: Request,
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::{CameraRequest, DrawnSelection, PixelBox, SeatRequest, Timestamp};
    use serde_json::{Value, json};

    use super::*;

    /// A message of a page in its JSON form is this message.
    #[track_caller]
    fn check(json: Value, expected: ClientMessage) {
        let text = json.to_string();
        assert_eq!(serde_json::from_str::<ClientMessage>(&text).unwrap(), expected, "{text}");
        assert_eq!(serde_json::to_value(expected).unwrap(), json);
    }

    #[test]
    fn messages_of_a_page_are_read_and_written_in_one_form() {
        let request = CameraRequest::Engage.into();
        check(
            json!({"type": "request", "id": 3, "request": {"kind": "engage"}}),
            ClientMessage::Request { id: 3, request, stops_taken: None },
        );
        let bounds = PixelBox { u: 1.5, v: 2.0, w: 3.0, h: 4.0 };
        let captured_ns = Timestamp::from_nanos(u64::MAX);
        let request = CameraRequest::Select(DrawnSelection { bounds, captured_ns }).into();
        check(
            json!({"type": "request", "id": u64::MAX, "request": {
                "kind": "select", "bounds": {"u": 1.5, "v": 2.0, "w": 3.0, "h": 4.0}, "captured_ns": u64::MAX,
            }}),
            ClientMessage::Request { id: u64::MAX, request, stops_taken: None },
        );
        let request = SeatRequest::GiveControl { client: 2 }.into();
        check(
            json!({"type": "request", "id": 0, "request": {"kind": "give-control", "client": 2}, "stops_taken": 4}),
            ClientMessage::Request { id: 0, request, stops_taken: Some(4) },
        );
        check(
            json!({"type": "video", "path": "h264", "video": "first"}),
            ClientMessage::Video(WantedVideo { path: VideoPath::H264, video: VideoNumber::First }),
        );
        check(
            json!({"type": "video", "path": "jpeg", "video": "first"}),
            ClientMessage::Video(WantedVideo { path: VideoPath::Jpeg, video: VideoNumber::First }),
        );
        check(
            json!({"type": "video", "path": "none", "video": "first"}),
            ClientMessage::Video(WantedVideo { path: VideoPath::None, video: VideoNumber::First }),
        );
        check(json!({"type": "ping", "sent_ms": 12.5}), ClientMessage::Ping { sent_ms: 12.5, handled: None });
        check(
            json!({"type": "ping", "sent_ms": 12.5, "handled": 7}),
            ClientMessage::Ping { sent_ms: 12.5, handled: Some(7) },
        );
    }

    #[test]
    fn other_messages_of_a_page_are_not_read() {
        for text in [
            "",
            "1",
            "\"stop\"",
            "[]",
            "{}",
            r#"{"type":"stop"}"#,
            r#"{"type":"request","id":1}"#,
            r#"{"type":"request","request":{"kind":"stop"}}"#,
            r#"{"type":"request","id":1.5,"request":{"kind":"stop"}}"#,
            r#"{"type":"request","id":-1,"request":{"kind":"stop"}}"#,
            r#"{"type":"request","id":1,"request":{"kind":"stop"},"more":1}"#,
            r#"{"type":"video","path":"mjpeg"}"#,
            r#"{"type":"video","path":"H264"}"#,
            r#"{"type":"ping"}"#,
            r#"{"type":"ping","sent_ms":"1"}"#,
            r#"{"type":"ping","sent_ms":1} {"type":"ping","sent_ms":1}"#,
        ] {
            assert!(serde_json::from_str::<ClientMessage>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn each_message_to_a_page_says_what_it_is() {
        let kind = |message| serde_json::to_value::<ServerMessage>(message).unwrap();
        let answer = |reason| Answer { id: 3, answer: AnswerKind::Refused, reason };
        for (message, expected) in [
            (ServerMessage::Answer(answer(None)), json!({"type": "answer", "id": 3, "answer": "refused"})),
            (
                ServerMessage::Answer(answer(Some("why".to_owned()))),
                json!({"type": "answer", "id": 3, "answer": "refused", "reason": "why"}),
            ),
            (ServerMessage::Events { events: vec![] }, json!({"type": "events", "events": []})),
            (
                ServerMessage::Control(ControlSeat { holder: Some(1), ..ControlSeat::default() }),
                json!({
                    "type": "control", "holder": 1, "holder_connected": false, "clients": [], "asking": [],
                    "program": null,
                }),
            ),
            (
                ServerMessage::Pong { sent_ms: 1.5, now_ns: 7, sent: 3 },
                json!({"type": "pong", "sent_ms": 1.5, "now_ns": 7, "sent": 3}),
            ),
        ] {
            assert_eq!(kind(message), expected);
        }
    }
}
