//! The emulated autopilot with a MAVLink gimbal, over UDP.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_vocab::Angle;
use barrelman_wire::mavlink::GimbalManager;
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, GimbalManagerSettings};

use super::heard::Heard;

/// The gimbal rests: its attitude is not what is measured.
const LEVEL: GimbalAngles = GimbalAngles { yaw: Angle::ZERO, pitch: Angle::ZERO };

/// Starts the autopilot: its address, and what it hears.
pub(super) fn start(clock: Clock) -> Result<(String, Receiver<Heard>)> {
    let socket = UdpSocket::bind("127.0.0.1:0")?;
    socket.set_read_timeout(Some(Duration::from_millis(5)))?;
    let address = format!("udp://{}", socket.local_addr()?);
    let (heard, yaw_rates) = channel();
    std::thread::Builder::new().name("autopilot".to_owned()).spawn(move || {
        // The autopilot ends with the measurement.
        let _ = serve(&socket, clock, &heard);
    })?;
    Ok((address, yaw_rates))
}

/// Answers, and tells each yaw rate that is new with the time of its bytes.
fn serve(socket: &UdpSocket, clock: Clock, heard: &Sender<Heard>) -> std::io::Result<()> {
    let mut manager = GimbalManager::boot(GimbalManagerSettings::default(), clock.now());
    let (mut buffer, mut out, mut client, mut last) = ([0; 2048], Vec::new(), None, 0.0);
    loop {
        let read = match socket.recv_from(&mut buffer) {
            Ok((read, from)) => {
                client = Some(from);
                read
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => return Err(error),
        };
        let (arrived, now) = (Instant::now(), clock.now());
        manager.receive(&buffer[..read], now, &mut out, |_, _| {});
        let yaw = manager.rates().yaw.radians_per_second();
        if yaw != last {
            last = yaw;
            if heard.send((yaw, arrived)).is_err() {
                return Ok(());
            }
        }
        manager.write_telemetry(LEVEL, now, &mut out);
        for packet in out.drain(..) {
            if let Some(client) = client {
                socket.send_to(&packet, client)?;
            }
        }
    }
}
