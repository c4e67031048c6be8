//! The emulated Fotokite Pro: ground station, camera mount and port, in one loop.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::Result;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{CameraMount, MountPlant};
use barrelman_vocab::telemetry::Quaternion;
use barrelman_vocab::{Angle, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
pub use barrelman_wire::fotokite_pro::ground_station::GroundStationSettings;
use barrelman_wire::fotokite_pro::ground_station::{SensorReadings, StationRates};

use super::emulated_port::EmulatedPort;
use super::log::{Direction, LoggedState, StationLog};
use crate::link::camera_link::{CameraLink, Pointing};
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// Depression of the camera at the start.
const START_DEPRESSION: Angle = Angle::from_degrees(24.0);
/// Longest wait for bytes; it bounds the delay of a tick.
const MAX_WAIT: Duration = Duration::from_millis(10);
/// Delay of received bytes while the fault `delay` is active.
const FAULT_DELAY: Duration = Duration::from_millis(400);

/// The kinds of faults that the emulated Fotokite Pro has.
pub const PRO_FAULTS: [FaultKind; 10] = [
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

/// An emulated Fotokite Pro.
#[derive(Debug)]
pub struct FotokitePro {
    port: EmulatedPort,
    station: GroundStation,
    settings: GroundStationSettings,
    mount: CameraMount,
    /// The simulated world whose camera the emulator moves, if there is one.
    world: Option<CameraLink>,
    profile: VehicleProfile,
    log: StationLog,
    /// Steps through the bytes that are damaged.
    corrupted: usize,
    faults: FaultPlan,
    clock: Clock,
    started: Timestamp,
    /// The last rates that the mount was commanded.
    commanded: StationRates,
    is_unplugged: bool,
    faults_applied_at: Option<Timestamp>,
    /// Received bytes, each with the time at which they reach the station.
    pending: VecDeque<(Timestamp, Vec<u8>)>,
}

impl FotokitePro {
    /// An emulator that has just been switched on.
    pub fn new(
        port: EmulatedPort,
        settings: GroundStationSettings,
        log: StationLog,
        faults: FaultPlan,
        clock: Clock,
    ) -> Self {
        let now = clock.now();
        Self {
            port,
            station: GroundStation::boot(settings, now),
            settings,
            mount: CameraMount::at_rest(MountPlant::laboratory(), START_DEPRESSION),
            world: None,
            profile: VehicleProfile::fotokite_pro(),
            log,
            faults,
            clock,
            started: now,
            commanded: StationRates::default(),
            is_unplugged: false,
            faults_applied_at: None,
            corrupted: 0,
            pending: VecDeque::new(),
        }
    }

    /// The same emulator, moving the camera of a simulated world.
    #[must_use]
    pub fn with_world(self, link: CameraLink) -> Self {
        Self { world: Some(link), ..self }
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
            self.station.tick(now);
            self.apply_rates(now, None)?;
            let mut lines = Vec::new();
            let readings = self.sensor_readings();
            self.station.write_telemetry(&readings, now, &mut lines);
            self.send(&lines, now)?;
        }
        Ok(())
    }

    fn is_active(&self, kind: FaultKind, now: Timestamp) -> bool {
        self.faults.is_active(kind, now)
    }

    fn apply_faults(&mut self, now: Timestamp) -> Result<()> {
        if self.faults.count_started(FaultKind::Reboot, self.faults_applied_at, now) > 0 {
            self.station = GroundStation::boot(self.settings, now);
        }
        if self.faults.count_started(FaultKind::Takeover, self.faults_applied_at, now) > 0 {
            self.station.take_over();
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

    fn receive(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let is_dropped =
            [FaultKind::Drop, FaultKind::Stall, FaultKind::Cut].iter().any(|kind| self.is_active(*kind, now));
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

    /// Passes bytes to the station one by one, so that every line is logged with the state after it.
    fn receive_bytes(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let mut answer = Vec::new();
        for byte in bytes {
            let mut line = None;
            self.station.receive(&[*byte], now, &mut answer, |received| line = Some(received.to_owned()));
            if let Some(line) = line {
                self.apply_rates(now, Some(&line))?;
            }
        }
        self.send(&answer, now)
    }

    /// Applies changed rates to the camera mount, and logs the received line. A change without a line (rates that timed
    /// out) is logged too.
    fn apply_rates(&mut self, now: Timestamp, line: Option<&str>) -> Result<()> {
        let rates = self.station.rates();
        let is_changed = rates != self.commanded;
        if is_changed {
            self.commanded = rates;
            let rates = VehicleRates { yaw: rates.yaw, pitch: rates.pitch };
            self.mount.command(self.profile.from_vehicle(rates));
            if let Some(world) = &self.world {
                world.send_latched(rates);
            }
        }
        match line {
            Some(line) => self.log.add(now, Direction::In, line, self.state()),
            None if is_changed => self.log.add(now, Direction::None, "", self.state()),
            None => Ok(()),
        }
    }

    fn send(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let is_silent = [FaultKind::Stall, FaultKind::Silence, FaultKind::Cut]
            .iter()
            .any(|kind| self.is_active(*kind, now));
        if bytes.is_empty() || self.is_unplugged || is_silent {
            return Ok(());
        }
        self.port.write(bytes);
        let text = String::from_utf8_lossy(bytes).into_owned();
        let state = self.state();
        for line in text.split("\r\n").filter(|line| !line.is_empty()) {
            self.log.add(now, Direction::Out, line, state)?;
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
        let Pointing { pan, tilt } = self.pointing();
        LoggedState::new(&self.station, pan.radians(), tilt.radians())
    }

    fn pointing(&self) -> Pointing {
        let own = Pointing { pan: self.mount.pan.angle(), tilt: self.mount.tilt.angle() };
        self.world.as_ref().and_then(CameraLink::pointing).unwrap_or(own)
    }

    fn sensor_readings(&self) -> SensorReadings {
        // The vehicle's yaw is positive to the left about the vertical, its pitch positive downwards.
        let half = |angle: Angle| -angle.radians() / 2.0;
        let Pointing { pan, tilt } = self.pointing();
        let (yaw, pitch) = (half(pan), half(tilt));
        SensorReadings {
            attitude: Quaternion { w: yaw.cos(), x: 0.0, y: 0.0, z: yaw.sin() },
            gimbal: Quaternion { w: pitch.cos(), x: 0.0, y: pitch.sin(), z: 0.0 },
            ..SensorReadings::LEVEL
        }
    }
}
