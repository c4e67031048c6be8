//! The socket as a page sees it, through the router and a pipe in memory: no test opens a network connection.

use std::collections::VecDeque;

use axum::http::StatusCode;
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{CameraRequest, EncodedUnit, OperatorRequest};
use hyper::server::conn::http1;
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream, duplex};

use super::super::api::HEAD_BYTES;
use super::super::in_memory::{CONTROL_TOKEN, InMemory, LIVE, WATCH_TOKEN, block_on};
use super::super::left_moving::LeftMoving;
use super::super::routes;
use super::super::seats::MAX_CLIENTS;
use super::super::tokens::Tokens;
use super::*;
use crate::operator::SessionRequest;
use crate::snapshot::Level;
use crate::test_scenes::{at, idle};

/// Larger than all that a test leaves unread.
const PIPE_BYTES: usize = 1 << 20;
const TEXT: u8 = 1;
const BINARY: u8 = 2;
const CLOSE: u8 = 8;

/// A page: the other end of a socket.
struct Page {
    pipe: DuplexStream,
    /// Messages that were received while another type was waited for.
    passed: VecDeque<Value>,
}

/// What a page receives.
#[derive(Debug, PartialEq)]
enum Received {
    Text(Value),
    Binary(Vec<u8>),
    /// The code and the reason with which the program ends the connection.
    Close(u16, String),
    /// The end of the connection.
    End,
}

impl Page {
    /// Asks for a socket. Returns the status of the answer, and the page.
    async fn ask(session: &InMemory, token: &str, name: &str) -> (StatusCode, Self) {
        Self::ask_through(PIPE_BYTES, session, token, name).await
    }

    /// The same through a pipe that takes so many bytes that are not read.
    async fn ask_through(bytes: usize, session: &InMemory, token: &str, name: &str) -> (StatusCode, Self) {
        let (mut pipe, program) = duplex(bytes);
        let router = TowerToHyperService::new(routes::router(Arc::clone(&session.console)));
        tokio::spawn(http1::Builder::new().serve_connection(TokioIo::new(program), router).with_upgrades());
        let head = format!(
            "GET /api/v1/socket?client={name} HTTP/1.1\r\nhost: 127.0.0.1:8480\r\nauthorization: Bearer {token}\r\n\
             connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n\
             sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        pipe.write_all(head.as_bytes()).await.unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            answer.push(pipe.read_u8().await.unwrap());
        }
        (StatusCode::from_bytes(&answer[9..12]).unwrap(), Self { pipe, passed: VecDeque::new() })
    }

    /// A page that is connected and has read everything up to its first snapshot.
    async fn open(session: &InMemory, token: &str, name: &str) -> Self {
        let (status, mut page) = Self::ask(session, token, name).await;
        assert_eq!(status, StatusCode::SWITCHING_PROTOCOLS);
        page.next_of("snapshot").await;
        page.passed.clear();
        page
    }

    /// Sends a frame. Its mask is zero, so that the payload goes as it is.
    async fn send_frame(&mut self, kind: u8, payload: &[u8]) {
        let mut frame = vec![0x80 | kind, 0x80 | 126];
        frame.extend(u16::try_from(payload.len()).unwrap().to_be_bytes());
        frame.extend([0; 4]);
        frame.extend(payload);
        // A connection that has ended is seen when the page reads.
        let _ = self.pipe.write_all(&frame).await;
    }

    /// Sends a part of a message that more parts follow.
    async fn send_part(&mut self, kind: u8, payload: &[u8]) {
        let mut frame = vec![kind, 0x80 | u8::try_from(payload.len()).unwrap(), 0, 0, 0, 0];
        frame.extend(payload);
        let _ = self.pipe.write_all(&frame).await;
    }

    /// Reads until the connection ends, by a frame or without one.
    async fn end_of_flood(&mut self) {
        let mut rest = Vec::new();
        let _ = self.pipe.read_to_end(&mut rest).await;
    }

    async fn send(&mut self, message: Value) {
        self.send_frame(TEXT, message.to_string().as_bytes()).await;
    }

    async fn request(&mut self, id: u64, request: Value) {
        self.send(json!({"type": "request", "id": id, "request": request})).await;
    }

    /// Waits until the program has read everything that this page sent.
    async fn wait_until_read(&mut self) {
        self.send(json!({"type": "ping", "sent_ms": 1.5})).await;
        self.next_of("pong").await;
    }

    async fn next(&mut self) -> Received {
        let mut head = [0; 2];
        if self.pipe.read_exact(&mut head).await.is_err() {
            return Received::End;
        }
        let length = match head[1] {
            126 => u64::from(self.pipe.read_u16().await.unwrap()),
            127 => self.pipe.read_u64().await.unwrap(),
            length => u64::from(length),
        };
        let mut payload = vec![0; length as usize];
        self.pipe.read_exact(&mut payload).await.unwrap();
        match head[0] & 0x0f {
            TEXT => Received::Text(serde_json::from_slice(&payload).unwrap()),
            BINARY => Received::Binary(payload),
            CLOSE if payload.len() >= 2 => {
                let reason = String::from_utf8(payload[2..].to_vec()).unwrap();
                Received::Close(u16::from_be_bytes([payload[0], payload[1]]), reason)
            }
            _ => Received::End,
        }
    }

    /// The next message of this type. Messages of other types are kept for later.
    async fn next_of(&mut self, kind: &str) -> Value {
        if let Some(index) = self.passed.iter().position(|message| message["type"] == kind)
            && let Some(message) = self.passed.remove(index)
        {
            return message;
        }
        loop {
            match self.next().await {
                Received::Text(message) if message["type"] == kind => return message,
                Received::Text(message) => self.passed.push_back(message),
                Received::Binary(_) => {}
                end => panic!("{end:?} instead of {kind}"),
            }
        }
    }

    /// The end of the connection, after what was still to be read.
    async fn end(&mut self) -> Received {
        loop {
            match self.next().await {
                Received::Text(_) | Received::Binary(_) => {}
                end => return end,
            }
        }
    }
}

#[test]
fn a_page_is_told_everything_before_the_first_snapshot() {
    let session = InMemory::new(LIVE);
    session.console.events.add(at(0), Level::Info, "mode", "idle");
    block_on(async {
        let (_, mut page) = Page::ask(&session, CONTROL_TOKEN, "a1").await;
        let mut kinds = Vec::new();
        for _ in 0..4 {
            let Received::Text(message) = page.next().await else { panic!("four messages of text") };
            kinds.push(message["type"].as_str().unwrap().to_owned());
            match kinds.last().map(String::as_str) {
                Some("hello") => assert_eq!(message["may_control"], true),
                Some("events") => assert_eq!(message["events"][0]["text"], "idle"),
                Some("control") => {
                    assert_eq!((&message["holder"], &message["clients"]), (&json!(0), &json!([0])))
                }
                _ => assert_eq!(message["step"], 0),
            }
        }
        assert_eq!(kinds, ["hello", "events", "control", "snapshot"]);
    });
}

#[test]
fn a_socket_needs_a_token() {
    let session = InMemory::new(LIVE);
    block_on(async {
        for (token, status) in [
            ("", StatusCode::UNAUTHORIZED),
            ("guess", StatusCode::UNAUTHORIZED),
            (WATCH_TOKEN, StatusCode::SWITCHING_PROTOCOLS),
            (CONTROL_TOKEN, StatusCode::SWITCHING_PROTOCOLS),
        ] {
            assert_eq!(Page::ask(&session, token, "").await.0, status, "{token:?}");
        }
    });
}

#[test]
fn each_request_gets_its_answer_by_its_number() {
    let mut session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, CONTROL_TOKEN, "a1").await;
        page.request(5, json!({"kind": "engage"})).await;
        page.request(6, json!({"kind": "nudge", "pan": 2, "tilt": 0})).await;
        page.request(7, json!({"kind": "disengage"})).await;
        page.wait_until_read().await;
        session.take_requests();
        let mut answers = Vec::new();
        for _ in 0..3 {
            let answer = page.next_of("answer").await;
            answers.push((answer["id"].as_u64().unwrap(), answer["answer"].as_str().unwrap().to_owned()));
        }
        // A refusal need not wait for the session.
        answers.sort_unstable();
        let expected = [(5, "accepted"), (6, "refused"), (7, "accepted")];
        assert_eq!(answers, expected.map(|(id, answer)| (id, answer.to_owned())));
    });
    let pilot = SessionRequest::Pilot;
    assert_eq!(
        session.taken,
        [
            pilot(OperatorRequest::Camera(CameraRequest::Engage)),
            pilot(OperatorRequest::Camera(CameraRequest::Disengage))
        ]
    );
}

#[test]
fn one_page_controls_and_every_page_can_stop() {
    let mut session = InMemory::new(LIVE);
    block_on(async {
        let mut first = Page::open(&session, CONTROL_TOKEN, "a1").await;
        let mut second = Page::open(&session, CONTROL_TOKEN, "b2").await;
        let mut watcher = Page::open(&session, WATCH_TOKEN, "c3").await;
        for (page, reason) in
            [(&mut second, "another page is in control"), (&mut watcher, "only watch and stop")]
        {
            page.request(1, json!({"kind": "engage"})).await;
            let answer = page.next_of("answer").await;
            assert_eq!(answer["answer"], "refused");
            assert!(answer["reason"].as_str().unwrap().contains(reason), "{answer}");
            page.request(2, json!({"kind": "stop"})).await;
            page.wait_until_read().await;
            session.take_requests();
            assert_eq!(
                page.next_of("answer").await,
                json!({"type": "answer", "id": 2, "answer": "accepted"})
            );
        }
        first.wait_until_read().await;
    });
    assert_eq!((session.taken.len(), session.console.gateway.stop_latch().taken()), (0, 2));
}

#[test]
fn pages_see_who_asks_takes_and_gives() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut first = Page::open(&session, CONTROL_TOKEN, "a1").await;
        let mut second = Page::open(&session, CONTROL_TOKEN, "b2").await;
        assert_eq!(first.next_of("control").await["clients"], json!([0, 1]));
        second.request(1, json!({"kind": "ask-control"})).await;
        assert_eq!(first.next_of("control").await["asking"], json!([1]));
        first.request(1, json!({"kind": "give-control", "client": 1})).await;
        let given = first.next_of("control").await;
        assert_eq!((&given["holder"], &given["asking"]), (&json!(1), &json!([])));
        first.request(2, json!({"kind": "take-control"})).await;
        assert_eq!(first.next_of("event").await["text"], "page 1 asks for the control");
        assert_eq!(first.next_of("control").await["holder"], 0);
    });
}

#[test]
fn the_seat_of_a_page_that_is_gone_is_kept_for_its_name() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut other = Page::open(&session, CONTROL_TOKEN, "b2").await;
        let holder = Page::open(&session, CONTROL_TOKEN, "a1").await;
        other.request(1, json!({"kind": "give-control", "client": 1})).await;
        while other.next_of("control").await["holder"] != 1 {}
        drop(holder);
        let is_gone = |seat: &Value| seat["holder"] == 1 && seat["holder_connected"] == false;
        while !is_gone(&other.next_of("control").await) {}
        let _third = Page::open(&session, CONTROL_TOKEN, "c3").await;
        assert_eq!(other.next_of("control").await["holder_connected"], false, "another name is another page");
        let _again = Page::open(&session, CONTROL_TOKEN, "a1").await;
        let seat = other.next_of("control").await;
        assert_eq!((&seat["holder"], &seat["holder_connected"]), (&json!(3), &json!(true)));
    });
}

#[test]
fn a_page_that_breaks_the_rules_is_disconnected() {
    let text = |text: &str| (TEXT, text.as_bytes().to_vec());
    for (kind, payload) in [
        text("stop"),
        text("{}"),
        text(r#"{"type":"request","id":1,"request":{"kind":"take-off"}}"#),
        text(&" ".repeat(5000)),
        (TEXT, vec![0xff, 0xfe]),
        (BINARY, vec![1, 2, 3]),
        (CLOSE, 1000_u16.to_be_bytes().to_vec()),
    ] {
        let session = InMemory::new(LIVE);
        block_on(async {
            let mut page = Page::open(&session, CONTROL_TOKEN, "a1").await;
            page.send_frame(kind, &payload).await;
            page.end().await;
            let seat = session.console.seat_changes.borrow().clone();
            assert_eq!((seat.clients, seat.holder_connected), (vec![], false), "{kind} {payload:?}");
        });
    }
}

#[test]
fn a_page_that_floods_is_disconnected() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, CONTROL_TOKEN, "a1").await;
        // Several times what the limit passes in the time that it takes to read them.
        for _ in 0..5000 {
            page.send(json!({"type": "ping", "sent_ms": 0.0})).await;
        }
        page.request(1, json!({"kind": "deselect"})).await;
        assert_eq!(page.end().await, Received::End);
        assert!(session.console.gateway.next_request().is_none(), "what follows the flood is not read");
        assert_eq!(session.console.seat_changes.borrow().clients, [0; 0]);
    });
}

/// Frames that are no message, and count like messages.
const PING: u8 = 9;
const PONG: u8 = 10;

#[test]
fn every_kind_of_frame_counts_against_the_limit() {
    let begun = r#"{"type":"ping","#;
    for (what, first, kind, payload) in [
        ("pings", None, PING, ""),
        ("pings with a content", None, PING, "0123456789"),
        ("pongs", None, PONG, ""),
        ("tiny messages", None, TEXT, r#"{"type":"ping","sent_ms":0}"#),
        // The first part of a message, and then empty parts without end.
        ("empty parts of a message", Some(begun), 0, ""),
    ] {
        let session = InMemory::new(LIVE);
        block_on(async {
            let mut page = Page::open(&session, WATCH_TOKEN, "a1").await;
            if let Some(first) = first {
                page.send_part(TEXT, first.as_bytes()).await;
            }
            // Several times what the limit passes in the time that it takes to read them.
            for _ in 0..5000 {
                match first {
                    Some(_) => page.send_part(kind, payload.as_bytes()).await,
                    None => page.send_frame(kind, payload.as_bytes()).await,
                }
            }
            page.end_of_flood().await;
            assert_eq!(session.console.seat_changes.borrow().clients, [0; 0], "{what}");
        });
    }
}

#[test]
fn a_stop_in_the_piece_that_exceeds_the_limit_is_taken() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "a1").await;
        // A ping has six bytes: the last of them and the stop come in one piece. Then one more piece, for the
        // end.
        let mut flood = [0x89, 0x80, 0, 0, 0, 0].repeat(400);
        let stop = br#"{"type":"request","id":1,"request":{"kind":"stop"}}"#;
        flood.extend([0x81, 0x80 | stop.len() as u8, 0, 0, 0, 0]);
        flood.extend(stop);
        flood.extend([0x89, 0x80, 0, 0, 0, 0].repeat(400));
        page.pipe.write_all(&flood).await.unwrap();
        page.end_of_flood().await;
    });
    assert_eq!(session.console.gateway.stop_latch().pending(), Some(1));
}

#[test]
fn with_too_many_pages_the_one_that_was_silent_longest_is_told_to_go() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut pages = Vec::new();
        for _ in 0..MAX_CLIENTS {
            pages.push(Page::open(&session, CONTROL_TOKEN, "").await);
        }
        let _newest = Page::open(&session, WATCH_TOKEN, "").await;
        assert_eq!(pages[1].end().await, Received::Close(1013, "too many pages are open".to_owned()));
        pages[0].request(1, json!({"kind": "deselect"})).await;
        pages[0].wait_until_read().await;
        assert!(session.console.gateway.next_request().is_some(), "the page in control stays");
    });
}

/// All tokens and cookies end, and no page has learned of it yet.
fn end_all_passes(session: &InMemory) {
    let tokens = Tokens { control: "control-new-345678".to_owned(), watch: "watch-new-345678".to_owned() };
    session.console.access.renew(tokens, &[]);
}

#[test]
fn a_page_that_is_signed_out_can_stop_and_nothing_else() {
    let session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, CONTROL_TOKEN, "a1").await;
        end_all_passes(&session);
        page.request(1, json!({"kind": "engage"})).await;
        page.request(2, json!({"kind": "stop"})).await;
        assert_eq!(page.end().await, Received::Close(1008, "signed out".to_owned()));
        while session.console.gateway.stop_latch().pending().is_none() {
            tokio::task::yield_now().await;
        }
        assert!(session.console.gateway.next_request().is_none(), "it commands nothing");
    });
}

#[test]
fn a_page_that_takes_nothing_is_disconnected_once_it_is_signed_out() {
    let session = InMemory::new(LIVE);
    block_on(async {
        // Less than the first message: the half that writes waits.
        let (status, _page) = Page::ask_through(64, &session, CONTROL_TOKEN, "a1").await;
        assert_eq!(status, StatusCode::SWITCHING_PROTOCOLS);
        let mut seats = session.console.seat_changes.subscribe();
        seats.wait_for(|seat| !seat.clients.is_empty()).await.unwrap();
        end_all_passes(&session);
        session.console.sign_out();
        let gone = seats.wait_for(|seat| seat.clients.is_empty());
        assert!(timeout(SEND_TIMEOUT / 2, gone).await.is_ok());
    });
}

#[test]
fn every_page_is_told_of_the_end_of_the_program() {
    block_on(async {
        let session = InMemory::new(LIVE);
        let mut pages = [
            Page::open(&session, CONTROL_TOKEN, "control").await,
            Page::open(&session, WATCH_TOKEN, "watch").await,
        ];
        session.console.end(LeftMoving { camera: false, boat: true }).await;
        for page in &mut pages {
            let said = "the program ends: the boat may be under way";
            assert_eq!(page.end().await, Received::Close(1001, said.to_owned()));
        }
        assert!(session.console.with_seats(|seats| seats.state()).clients.is_empty());
    });
}

#[test]
fn events_and_snapshots_follow_each_other() {
    let mut session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "").await;
        session.step(&idle(at(40)));
        assert_eq!(page.next_of("event").await["text"], "disengaged");
        session.step(&idle(at(80)));
        session.step(&idle(at(120)));
        // A page gets the newest, which may be the first or the last of three.
        while page.next_of("snapshot").await["at_ns"] != 120_000_000 {}
    });
}

#[test]
fn a_ping_is_answered_with_the_time_of_the_session() {
    let session = InMemory::new(LIVE);
    session.console.time.set(at(5000));
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "").await;
        page.send(json!({"type": "ping", "sent_ms": 12.25})).await;
        let pong = page.next_of("pong").await;
        assert_eq!(pong["sent_ms"], 12.25);
        assert!(pong["now_ns"].as_u64().unwrap() >= at(5000).as_nanos(), "{pong}");
    });
}

fn unit(index: u64, key: bool) -> EncodedUnit {
    EncodedUnit {
        epoch: 0,
        index,
        capture: Capture { at: at(index), quality: CaptureQuality::Sender },
        key,
        shown: true,
        rotation: Rotation::None,
        codec: UnitCodec::H264AnnexB,
        payload: Bytes::from_static(&[9, 9, 9]),
    }
}

/// The numbers of the next units.
async fn indices(page: &mut Page, count: usize) -> Vec<u8> {
    let mut indices = Vec::new();
    while indices.len() < count {
        match page.next().await {
            Received::Binary(message) => {
                assert_eq!(message[HEAD_BYTES..], [9, 9, 9]);
                indices.push(message[16]);
            }
            Received::Text(_) => {}
            end => panic!("{end:?} after {indices:?}"),
        }
    }
    indices
}

#[test]
fn h264_begins_with_a_key_frame_and_goes_on_without_a_gap() {
    let session = InMemory::new(LIVE);
    let add = |index, key| session.console.videos.first.relay.add(&unit(index, key));
    for (index, key) in [(1, true), (2, false), (3, true), (4, false)] {
        add(index, key);
    }
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "").await;
        page.send(json!({"type": "video", "path": "h264"})).await;
        assert_eq!(indices(&mut page, 2).await, [3, 4]);
        add(5, false);
        add(6, true);
        assert_eq!(indices(&mut page, 2).await, [5, 6]);
        page.send(json!({"type": "video", "path": "none"})).await;
        page.wait_until_read().await;
        add(7, false);
        page.wait_until_read().await;
        page.send(json!({"type": "video", "path": "h264"})).await;
        assert_eq!(indices(&mut page, 2).await, [6, 7], "video that was switched off is not sent");
    });
}

#[test]
fn a_page_that_lost_units_goes_on_with_the_next_key_frame() {
    let session = InMemory::new(LIVE);
    let add = |index, key| session.console.videos.first.relay.add(&unit(index, key));
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "").await;
        add(0, false);
        page.send(json!({"type": "video", "path": "h264"})).await;
        page.wait_until_read().await;
        add(1, false);
        add(2, true);
        assert_eq!(indices(&mut page, 1).await, [2], "decoding cannot start before a key frame");
        // More at once than a page may be behind.
        (3..100).for_each(|index| add(index, index == 90));
        assert_eq!(indices(&mut page, 3).await, [90, 91, 92]);
    });
}

#[test]
fn a_page_that_does_not_keep_up_gets_nothing_until_it_has() {
    let mut session = InMemory::new(LIVE);
    block_on(async {
        let mut page = Page::open(&session, WATCH_TOKEN, "").await;
        page.send(json!({"type": "ping", "sent_ms": 0, "handled": 0})).await;
        page.send(json!({"type": "video", "path": "h264"})).await;
        page.wait_until_read().await;
        (0..20).for_each(|index| session.console.videos.first.relay.add(&unit(index, index == 0)));
        assert_eq!(indices(&mut page, 2).await, [0, 1]);
        session.step(&idle(at(40)));
        for sent_ms in 1..3 {
            page.send(json!({"type": "ping", "sent_ms": sent_ms})).await;
            loop {
                match page.next().await {
                    Received::Text(message) if message["type"] == "pong" => break,
                    Received::Text(message) => assert_eq!(message["type"], "event", "{message}"),
                    other => panic!("{other:?} for a page that handles nothing"),
                }
            }
        }
        page.send(json!({"type": "ping", "sent_ms": 3, "handled": 1000})).await;
        assert_eq!(indices(&mut page, 3).await, [2, 3, 4]);
    });
}
