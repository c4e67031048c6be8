//! An emulated vehicle: its end of the protocol, camera mount and port, in one loop.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::Result;
use barrelman_sim::random::{CounterRng, Stream};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{CameraMount, MountPlant};
use barrelman_vocab::{Angle, Timestamp, VehicleRates};

use super::emulated_port::EmulatedPort;
use super::emulated_vehicle::EmulatedVehicle;
use super::log::{Direction, LoggedState, StationLog, VehicleState};
use crate::camera_link::{CameraLink, Pointing};
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// Depression of the camera at the start.
const START_DEPRESSION: Angle = Angle::from_degrees(24.0);
/// Height of the camera without a world, metres.
const START_HEIGHT_M: f64 = 10.0;
/// Longest wait for bytes; it bounds the delay of a tick.
const MAX_WAIT: Duration = Duration::from_millis(10);
/// Delay of received bytes while the fault `delay` is active.
const FAULT_DELAY: Duration = Duration::from_millis(400);

/// The kinds of faults that an emulated vehicle at a port has.
pub const EMULATOR_FAULTS: [FaultKind; 10] = [
    FaultKind::Stall,
    FaultKind::Drop,
    FaultKind::Delay,
    FaultKind::Duplicate,
    FaultKind::Corrupt,
    FaultKind::Disconnect,
    FaultKind::Reboot,
    FaultKind::Takeover,
    FaultKind::Silence,
    FaultKind::Cut,
];

/// An emulated vehicle at a port.
#[derive(Debug)]
pub struct Emulator<V> {
    port: EmulatedPort,
    vehicle: V,
    mount: CameraMount,
    /// The simulated world whose camera the emulator moves, if there is one.
    world: Option<CameraLink>,
    log: StationLog,
    /// Steps through the bytes that are damaged.
    corrupted: usize,
    /// Share of the packets that get lost, in both directions.
    loss_share: f64,
    /// Number of packets that passed or got lost.
    packets: u64,
    faults: FaultPlan,
    clock: Clock,
    started: Timestamp,
    /// The last rates that the mount was commanded.
    commanded: VehicleRates,
    is_unplugged: bool,
    faults_applied_at: Option<Timestamp>,
    /// Received bytes, each with the time at which they reach the station.
    pending: VecDeque<(Timestamp, Vec<u8>)>,
}

impl<V: EmulatedVehicle> Emulator<V> {
    /// An emulator that has just been switched on.
    pub fn new(port: EmulatedPort, vehicle: V, log: StationLog, faults: FaultPlan, clock: Clock) -> Self {
        let now = clock.now();
        Self {
            port,
            vehicle,
            mount: CameraMount::at_rest(MountPlant::laboratory(), START_DEPRESSION),
            world: None,
            log,
            faults,
            clock,
            started: now,
            commanded: VehicleRates::REST,
            is_unplugged: false,
            faults_applied_at: None,
            corrupted: 0,
            loss_share: 0.0,
            packets: 0,
            pending: VecDeque::new(),
        }
    }

    /// The same emulator, moving the camera of a simulated world.
    #[must_use]
    pub fn with_world(self, link: CameraLink) -> Self {
        Self { world: Some(link), ..self }
    }

    /// The same emulator, losing this share of the packets in both directions.
    #[must_use]
    pub fn with_loss(self, loss_share: f64) -> Self {
        Self { loss_share, ..self }
    }

    /// The URL of the port, for clients.
    pub fn url(&self) -> String {
        self.port.url()
    }

    /// Runs until `is_ended` returns true.
    ///
    /// # Errors
    /// If the log cannot be written, or the port cannot be plugged in again.
    pub fn run(&mut self, mut is_ended: impl FnMut() -> bool) -> Result<()> {
        let mut buffer = [0; 1024];
        while !is_ended() {
            let read = self.port.read(&mut buffer, MAX_WAIT);
            let now = self.clock.now();
            self.advance(now);
            self.apply_faults(now)?;
            self.receive(&buffer[..read], now)?;
            let mut packets = Vec::new();
            self.vehicle.advance(self.pointing(), now, &mut packets);
            self.apply_rates(now, None)?;
            self.send(&packets, now)?;
        }
        Ok(())
    }

    fn is_active(&self, kind: FaultKind, now: Timestamp) -> bool {
        self.faults.is_active(kind, now)
    }

    fn apply_faults(&mut self, now: Timestamp) -> Result<()> {
        if self.faults.count_started(FaultKind::Reboot, self.faults_applied_at, now) > 0 {
            self.vehicle.reboot(now);
        }
        if self.faults.count_started(FaultKind::Takeover, self.faults_applied_at, now) > 0 {
            let mut packets = Vec::new();
            self.vehicle.take_over(now, &mut packets);
            self.log.add(now, Direction::None, "another client takes the control", self.state())?;
            self.send(&packets, now)?;
        }
        self.faults_applied_at = Some(now);
        let is_unplugged = self.is_active(FaultKind::Disconnect, now);
        match (self.is_unplugged, is_unplugged) {
            (false, true) => self.port.unplug(),
            (true, false) => self.port.plug()?,
            _ => {}
        }
        self.is_unplugged = is_unplugged;
        Ok(())
    }

    /// Whether the next packet gets lost: the same packets each time.
    fn loses_packet(&mut self) -> bool {
        self.packets += 1;
        CounterRng::new(0, Stream::LinePackets).unit(self.packets) < self.loss_share
    }

    fn receive(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let is_lost = !bytes.is_empty() && self.loses_packet();
        let is_dropped = is_lost
            || [FaultKind::Drop, FaultKind::Stall, FaultKind::Cut]
                .iter()
                .any(|kind| self.is_active(*kind, now));
        if !bytes.is_empty() && !is_dropped && !self.is_unplugged {
            let due = if self.is_active(FaultKind::Delay, now) { now.plus(FAULT_DELAY) } else { now };
            let mut received = bytes.to_vec();
            if self.is_active(FaultKind::Corrupt, now) {
                // Another byte each time, so that any byte is damaged sooner or later.
                let at = self.corrupted % received.len();
                self.corrupted = self.corrupted.wrapping_add(7);
                received[at] ^= 0x55;
            }
            if self.is_active(FaultKind::Duplicate, now) {
                self.pending.push_back((due, received.clone()));
            }
            self.pending.push_back((due, received));
        }
        while let Some((_, received)) = self.pending.pop_front_if(|(due, _)| *due <= now) {
            self.receive_bytes(&received, now)?;
        }
        Ok(())
    }

    fn receive_bytes(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let (mut answers, mut messages) = (Vec::new(), Vec::new());
        self.vehicle.receive(bytes, now, &mut answers, &mut |text, state| messages.push((text, state)));
        for (text, state) in messages {
            self.apply_rates(now, Some((&text, state)))?;
        }
        self.send(&answers, now)
    }

    /// Applies changed rates to the camera mount, and logs the received message with the state after it. A
    /// change without a message (rates that timed out) is logged too.
    fn apply_rates(&mut self, now: Timestamp, message: Option<(&str, VehicleState)>) -> Result<()> {
        let rates = message.map_or_else(|| self.vehicle.rates(), |(_, state)| state.rates);
        let is_changed = rates != self.commanded;
        if is_changed {
            self.commanded = rates;
            self.mount.command(self.vehicle.profile().from_vehicle(rates));
            if let Some(world) = &self.world {
                world.send_latched(rates);
            }
        }
        match message {
            Some((text, state)) => self.log.add(now, Direction::In, text, self.logged(state)),
            None if is_changed => self.log.add(now, Direction::None, "", self.state()),
            None => Ok(()),
        }
    }

    fn send(&mut self, packets: &[Vec<u8>], now: Timestamp) -> Result<()> {
        let is_silent = [FaultKind::Stall, FaultKind::Silence, FaultKind::Cut]
            .iter()
            .any(|kind| self.is_active(*kind, now));
        if self.is_unplugged || is_silent {
            return Ok(());
        }
        let state = self.state();
        for packet in packets.iter().filter(|packet| !packet.is_empty()) {
            if self.loses_packet() {
                continue;
            }
            self.port.write(packet);
            for text in self.vehicle.texts(packet) {
                self.log.add(now, Direction::Out, &text, state)?;
            }
        }
        Ok(())
    }

    fn advance(&mut self, now: Timestamp) {
        let target = (now.since(self.started).as_secs_f64() * f64::from(TICKS_PER_SECOND)) as u64;
        while self.mount.tick() < target {
            self.mount.advance();
        }
    }

    fn state(&self) -> LoggedState {
        self.logged(self.vehicle.state())
    }

    fn logged(&self, state: VehicleState) -> LoggedState {
        let Pointing { pan, tilt, .. } = self.pointing();
        LoggedState::new(state, pan.radians(), tilt.radians())
    }

    fn pointing(&self) -> Pointing {
        let (pan, tilt) = (self.mount.pan.angle(), self.mount.tilt.angle());
        let own = Pointing { pan, tilt, height_m: START_HEIGHT_M, field_of_view: None };
        self.world.as_ref().and_then(CameraLink::pointing).unwrap_or(own)
    }
}
