//! A worker in front of a TCP connection of the machine whose other end is slow.

use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use barrelman_host::clock::Clock;
use rustix::net::sockopt;

use super::tests::fotokite_worker;
use crate::mailbox::Mailbox;
use crate::port_io::{MachineIo, PortIo as _};
use crate::url::Endpoint;

/// More than the buffers of the connection take while the other end does not read.
const SENT: usize = 60_000;

#[test]
fn what_was_sent_last_arrives_although_telemetry_is_not_read() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    sockopt::set_socket_recv_buffer_size(&listener, 4096).unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let vehicle = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(&[b't'; 1000]).unwrap();
        std::thread::sleep(Duration::from_millis(150));
        stream.write_all(b"telemetry").unwrap();
        let mut received = Vec::new();
        // A connection that is reset gives what it had.
        let _ = stream.read_to_end(&mut received);
        received
    });
    let mailbox = Arc::new(Mailbox::new().unwrap());
    let io = MachineIo {
        endpoint: Endpoint::Tcp { address },
        clock: Clock::start(),
        mailbox: Arc::clone(&mailbox),
    };
    let worker = fotokite_worker(mailbox, io, |_| true);
    let mut port = worker.io.open().unwrap();
    worker.io.send(&mut port, &[&vec![b'x'; SENT][..], b"stop"].concat()).unwrap();
    worker.let_arrive(&mut port);
    drop(port);
    let received = vehicle.join().unwrap();
    assert_eq!(received.len(), SENT + 4);
    assert!(received.ends_with(b"stop"));
}
