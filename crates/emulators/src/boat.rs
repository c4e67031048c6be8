//! An emulated boat at a UDP socket, which may move the boat of a simulated world.

use std::io::{ErrorKind, Write as _};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use anyhow::{Context, Result};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_vocab::{Timestamp, VesselCommand, VesselOrder};
use barrelman_wire::lab_udp::{LabReceiver, decode, pwm_us};
use barrelman_wire::mavlink::RoverBoat;
use barrelman_wire::mavlink::rover::MANUAL;
use barrelman_wire::mavlink::rover_boat::{HOLD, RoverBoatSettings};
use serde::Serialize;

use crate::simulated_boat::SimulatedBoat;

/// Longest wait for a datagram: the resolution of the time-outs.
const MAX_WAIT: Duration = Duration::from_millis(10);

/// What receives the datagrams.
#[derive(Debug)]
pub enum Helm {
    /// The laboratory's receiver, with the time-out that the original lacks.
    Laboratory(LabReceiver),
    /// The laboratory's receiver as it was: it keeps the last command.
    WithoutTimeout(VesselCommand),
    /// An ArduPilot boat, whose remote control's switch may choose MANUAL at a time, or HOLD in MANUAL.
    Rover(Box<RoverBoat>, Option<Timestamp>),
}

impl Helm {
    /// The laboratory's receiver; with `keeps_last` as it was, without a time-out.
    pub fn laboratory(keeps_last: bool) -> Self {
        if keeps_last {
            Self::WithoutTimeout(VesselCommand::NEUTRAL)
        } else {
            Self::Laboratory(LabReceiver::default())
        }
    }

    /// An ArduPilot boat in MANUAL, whose remote control's switch chooses MANUAL again at a time, or HOLD
    /// where the boat is in MANUAL.
    pub fn rover(is_armed: bool, sticks_at: Option<Timestamp>, now: Timestamp) -> Self {
        let settings = RoverBoatSettings { is_armed, ..RoverBoatSettings::default() };
        Self::Rover(Box::new(RoverBoat::new(settings, now)), sticks_at)
    }

    /// A datagram arrived. Returns its description; answers go to `out`.
    fn received(&mut self, datagram: &[u8], now: Timestamp, out: &mut Vec<Vec<u8>>) -> Vec<String> {
        match self {
            Self::Laboratory(receiver) => receiver.received(datagram, now),
            Self::WithoutTimeout(last) => *last = decode(datagram).unwrap_or(*last),
            Self::Rover(boat, _) => {
                let mut texts = Vec::new();
                boat.receive(datagram, now, out, |text| texts.push(text));
                return texts;
            }
        }
        vec!["datagram".to_owned()]
    }

    /// Time passes.
    fn advance(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if let Self::Rover(boat, sticks_at) = self {
            if sticks_at.is_some_and(|at| at <= now) {
                *sticks_at = None;
                boat.switch_to(if boat.mode() == MANUAL { HOLD } else { MANUAL });
            }
            boat.advance(now, out);
        }
    }

    fn command(&self, now: Timestamp) -> VesselCommand {
        match self {
            Self::Laboratory(receiver) => receiver.command(now),
            Self::WithoutTimeout(last) => *last,
            Self::Rover(boat, _) => boat.command(now),
        }
    }
}

/// A boat at its socket.
#[derive(Debug)]
pub struct EmulatedBoat {
    socket: UdpSocket,
    client: Option<SocketAddr>,
    helm: Helm,
    boat: Option<SimulatedBoat>,
    log: Option<OutputFile>,
    clock: Clock,
    in_force: VesselCommand,
}

/// A row of the log: what arrived, or a change by itself.
#[derive(Serialize)]
struct Row<'a> {
    mono_ns: u64,
    /// What arrived; empty: the command changed by itself.
    raw: &'a str,
    throttle: f64,
    rudder: f64,
    /// The same as RC values, microseconds.
    throttle_us: u16,
    rudder_us: u16,
}

impl EmulatedBoat {
    /// A boat at this address, which moves `boat`.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn open(
        address: SocketAddr,
        helm: Helm,
        boat: Option<SimulatedBoat>,
        log: Option<OutputFile>,
        clock: Clock,
    ) -> Result<Self> {
        let socket = UdpSocket::bind(address).with_context(|| format!("cannot listen on {address}"))?;
        socket.set_read_timeout(Some(MAX_WAIT))?;
        Ok(Self { socket, client: None, helm, boat, log, clock, in_force: VesselCommand::NEUTRAL })
    }

    /// The URL of the port, for clients.
    ///
    /// # Errors
    /// If the socket has no address.
    pub fn url(&self) -> Result<String> {
        Ok(format!("udp://{}", self.socket.local_addr()?))
    }

    /// Whether other machines can send.
    pub fn is_public(&self) -> bool {
        self.socket.local_addr().is_ok_and(|address| !address.ip().is_loopback())
    }

    /// Runs until `is_ended` returns true.
    ///
    /// # Errors
    /// If the socket fails, or the log cannot be written.
    pub fn run(&mut self, mut is_ended: impl FnMut() -> bool) -> Result<()> {
        let mut buffer = [0; 512];
        let mut out = Vec::new();
        while !is_ended() {
            let received = match self.socket.recv_from(&mut buffer) {
                Ok((length, from)) => {
                    self.client = Some(from);
                    Some(length)
                }
                // A client that is gone, or a signal, makes the next read fail once.
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::WouldBlock
                            | ErrorKind::TimedOut
                            | ErrorKind::Interrupted
                            | ErrorKind::ConnectionRefused
                    ) =>
                {
                    None
                }
                Err(error) => return Err(error).context("the boat's port has failed"),
            };
            let now = self.clock.now();
            let texts = match received {
                Some(length) => self.helm.received(&buffer[..length], now, &mut out),
                None => Vec::new(),
            };
            self.helm.advance(now, &mut out);
            if let Some(client) = self.client {
                for packet in out.drain(..) {
                    // A client that is gone hears nothing.
                    let _ = self.socket.send_to(&packet, client);
                }
            }
            out.clear();
            let command = self.helm.command(now);
            let has_changed = std::mem::replace(&mut self.in_force, command) != command;
            if let Some(boat) = &self.boat {
                boat.send_latched(VesselOrder::Commanded(command));
            }
            for text in &texts {
                self.write(text, now)?;
            }
            if texts.is_empty() && has_changed {
                self.write("", now)?;
            }
        }
        Ok(())
    }

    fn write(&mut self, raw: &str, now: Timestamp) -> Result<()> {
        let Some(log) = &mut self.log else { return Ok(()) };
        let VesselCommand { throttle, rudder } = self.in_force;
        let (throttle_us, rudder_us) = pwm_us(self.in_force);
        let mono_ns = self.clock.start_on_monotonic_ns() + now.as_nanos();
        let mut line =
            serde_json::to_string(&Row { mono_ns, raw, throttle, rudder, throttle_us, rudder_us })?;
        line.push('\n');
        Ok(log.write_all(line.as_bytes())?)
    }
}
