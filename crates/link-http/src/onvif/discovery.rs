//! Asks all cameras of the network, once, because somebody has asked for it.

use std::collections::BTreeSet;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use barrelman_wire::onvif::discovery::{FoundCamera, found, probe};

use super::seed;

/// How long answers are waited for. Cameras answer after up to half a second.
const PATIENCE: Duration = Duration::from_secs(2);
/// The question is repeated after this time, as datagrams get lost.
const REPEAT_AFTER: Duration = Duration::from_millis(500);
/// Largest answer, bytes.
const MAX_ANSWER: usize = 16 << 10;
/// Most cameras.
const MAX_CAMERAS: usize = 64;

/// The cameras that answer to a question at this address, in the order of their names.
///
/// # Errors
/// If the network takes no datagrams.
pub fn discover(at: SocketAddr) -> io::Result<Vec<FoundCamera>> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    let question = probe(seed()?);
    let began = Instant::now();
    socket.send_to(question.as_bytes(), at)?;
    let mut repeats_at = Some(began + REPEAT_AFTER);
    let mut cameras = BTreeSet::new();
    let mut answer = vec![0; MAX_ANSWER];
    while let Some(left) =
        (began + PATIENCE).checked_duration_since(Instant::now()).filter(|left| !left.is_zero())
    {
        if repeats_at.is_some_and(|at| Instant::now() >= at) {
            socket.send_to(question.as_bytes(), at)?;
            repeats_at = None;
        }
        socket.set_read_timeout(Some(left.min(Duration::from_millis(100))))?;
        match socket.recv_from(&mut answer) {
            Ok((length, _)) => cameras.extend(found(&answer[..length])),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
        if cameras.len() >= MAX_CAMERAS {
            break;
        }
    }
    Ok(cameras.into_iter().collect())
}
