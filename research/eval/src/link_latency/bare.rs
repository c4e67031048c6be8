//! The same way without link and guard: a bare write, and a reader.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::heard::PATIENCE;

/// Writes to itself.
pub(super) trait BareLoop {
    /// Writes a packet with this yaw rate. The time until it arrived.
    ///
    /// # Errors
    /// If the packet does not arrive.
    fn write(&mut self, yaw: f64) -> Result<Duration>;
}

/// A connection, and a reader that tells when bytes arrive.
pub(super) struct BareStream {
    writer: TcpStream,
    arrivals: Receiver<Instant>,
}

impl BareStream {
    pub(super) fn open() -> Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let writer = TcpStream::connect(listener.local_addr()?)?;
        writer.set_nodelay(true)?;
        let (mut reader, _) = listener.accept()?;
        let (arrived, arrivals) = channel();
        std::thread::Builder::new().name("reader".to_owned()).spawn(move || {
            let mut buffer = [0; 4096];
            while reader.read(&mut buffer).is_ok_and(|read| read > 0) {
                if arrived.send(Instant::now()).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { writer, arrivals })
    }
}

impl BareLoop for BareStream {
    fn write(&mut self, yaw: f64) -> Result<Duration> {
        let sent = Instant::now();
        self.writer.write_all(format!("\rYaw {yaw:.6}\r").as_bytes())?;
        time_to(&self.arrivals, sent)
    }
}

/// A connection that carries requests as long as those of a link, and a reader that tells when they arrive.
pub(super) struct BareRequests {
    stream: BareStream,
    request: fn(f64) -> (&'static str, String),
}

impl BareRequests {
    /// Those of a Fotokite Sigma.
    pub(super) fn of_sigma() -> Result<Self> {
        let request = |yaw: f64| {
            let body = format!(r#"{{"duration":0.45,"pan_speed":{:.3},"tilt_speed":0.0}}"#, yaw.to_degrees());
            ("/v1/camera/control/rotate_with_speed", body)
        };
        Ok(Self { stream: BareStream::open()?, request })
    }

    /// Those of an ONVIF camera, as long as the link's with their proof of who asks.
    pub(super) fn of_onvif() -> Result<Self> {
        const MESSAGE_BYTES: usize = 1_330;
        let request = |yaw: f64| ("/onvif/ptz_service", format!("{yaw:<MESSAGE_BYTES$}"));
        Ok(Self { stream: BareStream::open()?, request })
    }
}

impl BareLoop for BareRequests {
    fn write(&mut self, yaw: f64) -> Result<Duration> {
        let (path, body) = (self.request)(yaw);
        let request = format!(
            "POST {path} HTTP/1.1\r\nhost: 127.0.0.1:10000\r\nauthorization: Bearer token\r\n\
             content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
            body.len()
        );
        let sent = Instant::now();
        self.stream.writer.write_all(request.as_bytes())?;
        time_to(&self.stream.arrivals, sent)
    }
}

/// Two sockets, and a reader that tells when datagrams arrive.
pub(super) struct BareDatagrams {
    sender: UdpSocket,
    arrivals: Receiver<Instant>,
}

impl BareDatagrams {
    pub(super) fn open() -> Result<Self> {
        let reader = UdpSocket::bind("127.0.0.1:0")?;
        let sender = UdpSocket::bind("127.0.0.1:0")?;
        sender.connect(reader.local_addr()?)?;
        let (arrived, arrivals) = channel();
        std::thread::Builder::new().name("reader".to_owned()).spawn(move || {
            let mut buffer = [0; 64];
            while reader.recv(&mut buffer).is_ok() {
                if arrived.send(Instant::now()).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { sender, arrivals })
    }
}

impl BareLoop for BareDatagrams {
    /// A datagram as long as GIMBAL_MANAGER_SET_PITCHYAW.
    fn write(&mut self, yaw: f64) -> Result<Duration> {
        let mut datagram = [0; 35];
        datagram[..8].copy_from_slice(&yaw.to_le_bytes());
        let sent = Instant::now();
        self.sender.send(&datagram)?;
        time_to(&self.arrivals, sent)
    }
}

fn time_to(arrivals: &Receiver<Instant>, sent: Instant) -> Result<Duration> {
    let arrived = arrivals.recv_timeout(PATIENCE).context("a packet did not arrive")?;
    Ok(arrived.duration_since(sent))
}
