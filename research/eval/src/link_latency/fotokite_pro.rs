//! The emulated ground station of a Fotokite Pro, over TCP.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings};

use super::heard::Heard;

/// Starts the ground station: its address, and what it hears.
pub(super) fn start(clock: Clock) -> Result<(String, Receiver<Heard>)> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let address = format!("tcp://{}", listener.local_addr()?);
    let (heard, yaw_rates) = channel();
    std::thread::Builder::new().name("station".to_owned()).spawn(move || {
        // The station ends with its client.
        let _ = listener.accept().map(|(client, _)| serve(client, clock, &heard));
    })?;
    Ok((address, yaw_rates))
}

/// The emulated ground station: answers, and tells each yaw rate with the time of its bytes.
fn serve(mut client: TcpStream, clock: Clock, heard: &Sender<Heard>) -> std::io::Result<()> {
    client.set_nodelay(true)?;
    client.set_read_timeout(Some(Duration::from_millis(5)))?;
    let mut station = GroundStation::boot(GroundStationSettings::default(), clock.now());
    let (mut buffer, mut answer) = ([0; 1024], Vec::new());
    loop {
        let read = match client.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(read) => read,
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => 0,
            Err(error) => return Err(error),
        };
        let (arrived, now) = (Instant::now(), clock.now());
        station.receive(&buffer[..read], now, &mut answer, |line| {
            let rate = line.strip_prefix("Yaw ").and_then(|rate| rate.trim().parse().ok());
            if let Some(rate) = rate {
                // Without a reader, the measurement has ended.
                let _ = heard.send((rate, arrived));
            }
        });
        station.tick(now);
        station.write_telemetry(&SensorReadings::LEVEL, now, &mut answer);
        client.write_all(&answer)?;
        answer.clear();
    }
}
