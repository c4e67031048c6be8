use std::io::{Read as _, Write as _};
use std::net::TcpListener;

use super::*;

fn at(s: u64) -> Timestamp {
    Timestamp::from_nanos(s * 1_000_000_000)
}

fn events() -> [Vec<u8>; 2] {
    [b"<one/>".to_vec(), b"<two/>".to_vec()]
}

const ALL_SENT: Sent = Sent { lost: 0, failure: None };

#[test]
fn each_event_is_a_datagram() {
    let receiver = UdpSocket::bind("127.0.0.1:0").unwrap();
    receiver.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let mut sender = Sender::open(TakRoute::Udp(receiver.local_addr().unwrap())).unwrap();
    assert_eq!(sender.send(&events(), at(0)), ALL_SENT);
    for expected in events() {
        let mut buffer = [0; 64];
        let (size, _) = receiver.recv_from(&mut buffer).unwrap();
        assert_eq!(buffer[..size], expected);
    }
}

#[test]
fn a_datagram_that_nobody_receives_is_no_failure() {
    let nobody = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut sender = Sender::open(TakRoute::Udp(nobody)).unwrap();
    for s in 0..3 {
        assert_eq!(sender.send(&events(), at(s)), ALL_SENT);
    }
}

#[test]
fn events_for_a_group_stay_in_the_own_network() {
    let socket = datagram_socket("239.2.3.1:6969".parse().unwrap()).unwrap();
    assert_eq!(socket.multicast_ttl_v4().unwrap(), 1);
}

/// Nobody listens there: the port is a privileged one of a service that is history.
const REFUSED: &str = "127.0.0.1:1";

fn is_failed(sent: &Sent) -> bool {
    sent.lost == 2 && sent.failure.is_some()
}

#[test]
fn a_connection_that_is_lost_is_made_again() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut sender = Sender::open(TakRoute::Tcp(server.local_addr().unwrap(), None)).unwrap();
    assert_eq!(sender.send(&events(), at(0)), ALL_SENT);
    let (mut accepted, _) = server.accept().unwrap();
    accepted.write_all(b"<event>of somebody else</event>").unwrap();
    let mut buffer = [0; 12];
    accepted.read_exact(&mut buffer).unwrap();
    assert_eq!(&buffer, b"<one/><two/>");
    assert_eq!(sender.send(&events(), at(1)), ALL_SENT);
    drop(accepted);
    assert!(is_failed(&sender.send(&events(), at(2))));
    assert!(is_failed(&sender.send(&events(), at(2))), "nothing is tried before the pause is over");
    assert_eq!(sender.send(&events(), at(3)), ALL_SENT);
    let (mut accepted, _) = server.accept().unwrap();
    accepted.read_exact(&mut buffer).unwrap();
    assert_eq!(&buffer, b"<one/><two/>");
}

#[test]
fn the_pauses_between_attempts_grow() {
    let mut connection = Connection {
        to: REFUSED.parse().unwrap(),
        encryption: None,
        line: None,
        pause: PAUSES.0,
        retry: None,
    };
    for (tried_at, next) in [(0, 1), (1, 3), (3, 7), (7, 15), (15, 31), (31, 61), (61, 91)] {
        assert!(is_failed(&connection.send(&events(), at(tried_at))));
        assert_eq!(connection.retry.as_ref().map(|(due, _)| *due), Some(at(next)));
    }
}

#[test]
fn a_probe_says_from_where_events_would_go() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = server.local_addr().unwrap();
    let loopback: IpAddr = "127.0.0.1".parse().unwrap();
    assert_eq!(probe(&TakRoute::Tcp(address, None)).unwrap(), loopback);
    assert_eq!(probe(&TakRoute::Udp(address)).unwrap(), loopback);
    assert!(probe(&TakRoute::Tcp(REFUSED.parse().unwrap(), None)).is_err());
}
