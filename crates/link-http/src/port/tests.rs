//! The port against a server on the loopback interface that answers as it is told.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::{Mutex, mpsc};

use barrelman_link::url::{Endpoint, LinkUrl};
use barrelman_vocab::ZoomRate;
use barrelman_wire::fotokite_sigma::Call;

use tokio::time::Instant;

use super::*;
use crate::authorization::Authorization;
use crate::connection::Connector;
use crate::runtime::LinkRuntime;
use crate::settings::{Credential, HttpProtocol, SigmaAccess, Trust};

/// What the server does with each request, in the order of their arrival.
#[derive(Debug, Clone, Copy)]
enum Does {
    Answers(u16, &'static str),
    Hangs,
    Closes,
}

/// A request as the server got it: its first line, its token, its body, and the number of its connection.
#[derive(Debug, Clone, PartialEq)]
struct Got {
    line: String,
    token: Option<String>,
    body: String,
    connection: usize,
}

fn serve(does: &'static [Does]) -> (HttpSettings, mpsc::Receiver<Got>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/api", listener.local_addr().unwrap());
    let Endpoint::Http(address) = LinkUrl::parse(&url).unwrap().endpoint else { panic!("{url}") };
    let (got, queue) = mpsc::channel();
    let next = Arc::new(Mutex::new(does.iter()));
    std::thread::spawn(move || {
        for (connection, stream) in listener.incoming().enumerate() {
            let (got, next) = (got.clone(), Arc::clone(&next));
            std::thread::spawn(move || serve_connection(stream.unwrap(), connection, &got, &next));
        }
    });
    let credential = Credential::Token("t0ken".to_owned());
    (
        HttpSettings {
            address,
            trust: Trust::WellKnown,
            protocol: HttpProtocol::FotokiteSigma(SigmaAccess {
                credential,
                stream: None,
                full_zoom: ZoomRate::from_per_second(0.3),
            }),
        },
        queue,
    )
}

fn serve_connection(
    stream: TcpStream,
    connection: usize,
    got: &mpsc::Sender<Got>,
    next: &Mutex<std::slice::Iter<'_, Does>>,
) -> Option<()> {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    loop {
        let mut lines = Vec::new();
        loop {
            let mut line = String::new();
            if reader.read_line(&mut line).ok()? == 0 {
                return None;
            }
            if line.trim().is_empty() {
                break;
            }
            lines.push(line.trim().to_owned());
        }
        let header = |name: &str| {
            lines.iter().find_map(|line| {
                line.to_lowercase().strip_prefix(name).map(|_| line[name.len()..].trim().to_owned())
            })
        };
        let length = header("content-length:").map_or(0, |text| text.parse().unwrap());
        let mut body = vec![0; length];
        reader.read_exact(&mut body).ok()?;
        let body = String::from_utf8(body).unwrap();
        let is_health = lines[0].contains("/health");
        // The turn of a request is settled before the test hears of the request, and may make the next one.
        let does =
            if is_health { Some(Does::Answers(200, "{}")) } else { next.lock().unwrap().next().copied() };
        if !is_health {
            let token = header("authorization:");
            got.send(Got { line: lines[0].clone(), token, body, connection }).ok()?;
        }
        match does? {
            Does::Answers(status, text) => {
                let answer = format!("HTTP/1.1 {status} X\r\nContent-Length: {}\r\n\r\n{text}", text.len());
                (&stream).write_all(answer.as_bytes()).ok()?;
            }
            Does::Hangs => {}
            Does::Closes => return None,
        }
    }
}

fn request(id: u64, lane: Lane, call: Call) -> Request<Call> {
    Request { id, lane, call }
}

/// The next packet that arrives.
fn next_packet(port: &HttpPort) -> Received {
    let mailbox: Mailbox = Mailbox::new().unwrap();
    loop {
        wait_for_port(&mailbox, Some(&*port.inbox), Duration::from_millis(200));
        if let Some(packet) = port.inbox.take().pop_front() {
            return packet;
        }
    }
}

#[test]
fn a_request_bears_the_token_and_its_answer_comes_back() {
    let (settings, got) = serve(&[Does::Answers(201, r#"{"a": 1}"#)]);
    let port = open(&settings).unwrap();
    port.send(&request(7, Lane::Control, Call::RequestControl));
    let body = br#"{"a": 1}"#.to_vec();
    assert_eq!(next_packet(&port), Received::Answer { id: 7, status: 201, body });
    let got = got.recv().unwrap();
    assert_eq!(got.line, "POST /api/v1/handoff/control/request HTTP/1.1");
    assert_eq!(got.token.as_deref(), Some("Bearer t0ken"));
    assert_eq!(got.body, r#"{"operator_name":"Barrelman"}"#);
}

#[test]
fn a_request_that_hangs_is_given_up_and_the_next_one_has_another_connection() {
    let (settings, got) = serve(&[Does::Hangs, Does::Answers(202, "")]);
    let port = open(&settings).unwrap();
    port.send(&request(1, Lane::Turn, Call::CameraState));
    assert_eq!(next_packet(&port), Received::NoAnswer { id: 1 });
    port.send(&request(2, Lane::Turn, Call::CameraState));
    assert_eq!(next_packet(&port), Received::Answer { id: 2, status: 202, body: Vec::new() });
    assert_ne!(got.recv().unwrap().connection, got.recv().unwrap().connection);
}

#[test]
fn a_lane_that_hangs_holds_up_no_other() {
    let (settings, got) = serve(&[Does::Hangs, Does::Answers(202, "")]);
    let port = open(&settings).unwrap();
    port.send(&request(1, Lane::State, Call::FlightState));
    let first = got.recv().unwrap();
    port.send(&request(2, Lane::Stop, Call::CameraState));
    assert_eq!(next_packet(&port), Received::Answer { id: 2, status: 202, body: Vec::new() });
    assert!(first.line.contains("flight"));
}

#[test]
fn a_connection_that_the_vehicle_closed_is_replaced() {
    let (settings, got) = serve(&[Does::Answers(200, ""), Does::Closes, Does::Answers(200, "")]);
    let port = open(&settings).unwrap();
    for id in 1..=2 {
        port.send(&request(id, Lane::Camera, Call::CameraState));
        assert!(matches!(next_packet(&port), Received::Answer { id: answered, .. } if answered == id));
    }
    assert_eq!(got.iter().take(3).count(), 3);
}

#[test]
fn a_vehicle_that_is_not_there_is_named() {
    let unused = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (settings, _got) = serve(&[]);
    let settings = HttpSettings {
        address: barrelman_link::url::HttpAddress { port: unused.port(), ..settings.address.clone() },
        ..settings
    };
    let error = open(&settings).map(drop).unwrap_err().to_string();
    assert!(error.contains(&unused.port().to_string()), "{error}");
}

/// A request with this much of its time left; `None`: it is over.
fn queued(id: u64, left: Option<Duration>) -> Queued {
    let queued = Queued::now(&request(id, Lane::Turn, Call::STOP));
    Queued { deadline: Instant::now() + left.unwrap_or_default(), ..queued }
}

fn open(settings: &HttpSettings) -> Result<HttpPort, PortError> {
    let HttpProtocol::FotokiteSigma(SigmaAccess { credential, .. }) = settings.protocol.clone() else {
        panic!()
    };
    let reach = move |settings: &HttpSettings| crate::fotokite_sigma::reach(settings, &credential);
    HttpPort::open(settings, reach, Call::LANES)
}

fn connector(settings: &HttpSettings) -> Connector {
    Connector::new(settings, Authorization::Bearer("t0ken".into())).unwrap()
}

fn block_on<T>(future: impl Future<Output = T>) -> T {
    LinkRuntime::new().unwrap().block_on(future)
}

#[test]
fn a_request_that_waited_longer_than_its_time_is_never_sent() {
    let (settings, got) = serve(&[Does::Answers(202, "")]);
    let inbox = Arc::new(Inbox::new().unwrap());
    let (requests, queue) = channel(LANE_CAPACITY);
    requests.try_send(queued(1, None)).unwrap();
    requests.try_send(queued(2, Some(Duration::from_secs(60)))).unwrap();
    drop(requests);
    let connector = connector(&settings);
    block_on(lane::serve(connector, queue, Arc::clone(&inbox)));
    let answers = [Received::NoAnswer { id: 1 }, Received::Answer { id: 2, status: 202, body: Vec::new() }];
    assert_eq!(inbox.take(), answers);
    assert_eq!(got.try_iter().count(), 1);
}

#[test]
fn a_request_whose_time_ends_while_the_lane_connects_is_not_sent() {
    let (settings, got) = serve(&[Does::Answers(202, "")]);
    let connector = connector(&settings);
    let (mut connection, overdue) = (None, queued(1, None));
    let answer = block_on(async {
        let answer = lane::ask(&connector, &mut connection, &overdue).await;
        assert!(connection.is_some(), "the lane connected");
        // The next request on the same connection is the first that the vehicle gets.
        let next = queued(2, Some(Duration::from_secs(60)));
        assert!(lane::ask(&connector, &mut connection, &next).await.is_some());
        answer
    });
    assert_eq!(answer, None);
    assert_eq!(got.try_iter().count(), 1);
}
