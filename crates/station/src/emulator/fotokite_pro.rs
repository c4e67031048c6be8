//! The emulated Fotokite Pro: ground station, camera mount and port, in one loop.

use std::collections::VecDeque;
use std::time::Duration;

use anyhow::Result;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{CameraMount, MountPlant};
use barrelman_vocab::telemetry::Quaternion;
use barrelman_vocab::{Angle, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings, StationRates};

use super::host_port::HostPort;
use super::log::{Direction, LoggedState, StationLog};
use crate::link::camera_link::{CameraLink, Pointing};
use barrelman_host::clock::Clock;
use barrelman_host::fault::{FaultKind, FaultPlan};

/// How far down the camera looks at the start.
const START_DEPRESSION: Angle = Angle::from_degrees(24.0);
/// Longest wait for bytes: bounds how late a tick is.
const MAX_WAIT: Duration = Duration::from_millis(10);
/// How late bytes are heard while the fault `delay` is in force.
const DELAY: Duration = Duration::from_millis(400);

/// An emulated Fotokite Pro.
#[derive(Debug)]
pub struct FotokitePro {
    port: HostPort,
    station: GroundStation,
    settings: GroundStationSettings,
    mount: CameraMount,
    /// The world whose camera it moves, if there is one.
    world: Option<CameraLink>,
    profile: VehicleProfile,
    log: StationLog,
    faults: FaultPlan,
    clock: Clock,
    started: Timestamp,
    /// The rates that the mount was told last.
    followed: StationRates,
    unplugged: bool,
    faults_applied_at: Option<Timestamp>,
    pending: VecDeque<(Timestamp, Vec<u8>)>,
}

impl FotokitePro {
    /// An emulator that was just switched on.
    pub fn new(
        port: HostPort,
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
            followed: StationRates::default(),
            unplugged: false,
            faults_applied_at: None,
            pending: VecDeque::new(),
        }
    }

    /// The same emulator with a world's camera on it.
    #[must_use]
    pub fn in_world(self, link: CameraLink) -> Self {
        Self { world: Some(link), ..self }
    }

    /// Where clients connect to.
    pub fn place(&self) -> String {
        self.port.place()
    }

    /// Runs until `ended` says so.
    ///
    /// # Errors
    /// If the log cannot be written.
    pub fn run(&mut self, mut ended: impl FnMut() -> bool) -> Result<()> {
        let mut buffer = [0; 1024];
        while !ended() {
            let read = self.port.read(&mut buffer, MAX_WAIT);
            let now = self.clock.now();
            self.advance(now);
            self.apply_faults(now)?;
            self.receive(&buffer[..read], now)?;
            self.station.tick(now);
            self.follow(now, None)?;
            let mut lines = Vec::new();
            let reading = self.reading();
            self.station.write_telemetry(&reading, now, &mut lines);
            self.send(&lines, now)?;
        }
        Ok(())
    }

    fn active(&self, kind: FaultKind, now: Timestamp) -> bool {
        self.faults.is_active(kind, now)
    }

    fn apply_faults(&mut self, now: Timestamp) -> Result<()> {
        if self.faults.count_started(FaultKind::Reboot, self.faults_applied_at, now) > 0 {
            self.station = GroundStation::boot(self.settings, now);
        }
        self.faults_applied_at = Some(now);
        let unplugged = self.active(FaultKind::Disconnect, now);
        match (self.unplugged, unplugged) {
            (false, true) => self.port.unplug(),
            (true, false) => self.port.plug()?,
            _ => {}
        }
        self.unplugged = unplugged;
        Ok(())
    }

    fn receive(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let deaf = [FaultKind::Drop, FaultKind::Stall].iter().any(|kind| self.active(*kind, now));
        if !bytes.is_empty() && !deaf && !self.unplugged {
            let due = if self.active(FaultKind::Delay, now) { now.plus(DELAY) } else { now };
            let mut received = bytes.to_vec();
            if self.active(FaultKind::Corrupt, now) {
                received[0] ^= 0x55;
            }
            if self.active(FaultKind::Duplicate, now) {
                self.pending.push_back((due, received.clone()));
            }
            self.pending.push_back((due, received));
        }
        while let Some((_, received)) = self.pending.pop_front_if(|(due, _)| *due <= now) {
            self.receive_bytes(&received, now)?;
        }
        Ok(())
    }

    /// Takes bytes one by one, so that every line is logged with the state that it led to.
    fn receive_bytes(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        let mut answer = Vec::new();
        for byte in bytes {
            let mut line = None;
            self.station.receive(&[*byte], now, &mut answer, |received| line = Some(received.to_owned()));
            if let Some(line) = line {
                self.follow(now, Some(&line))?;
            }
        }
        self.send(&answer, now)
    }

    /// Hands rates that have changed to the camera mount, and logs the line that did it. Rates that ended by
    /// themselves are logged too.
    fn follow(&mut self, now: Timestamp, line: Option<&str>) -> Result<()> {
        let rates = self.station.rates();
        let changed = rates != self.followed;
        if changed {
            self.followed = rates;
            let rates = VehicleRates { yaw: rates.yaw, pitch: rates.pitch };
            self.mount.command(self.profile.from_vehicle(rates));
            if let Some(world) = &self.world {
                world.send_latched(rates);
            }
        }
        match line {
            Some(line) => self.log.add(now, Direction::In, line, self.state()),
            None if changed => self.log.add(now, Direction::None, "", self.state()),
            None => Ok(()),
        }
    }

    fn send(&mut self, bytes: &[u8], now: Timestamp) -> Result<()> {
        if bytes.is_empty() || self.unplugged || self.active(FaultKind::Stall, now) {
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
        LoggedState::of(&self.station, pan.radians(), tilt.radians())
    }

    fn pointing(&self) -> Pointing {
        let own = Pointing { pan: self.mount.pan.angle(), tilt: self.mount.tilt.angle() };
        self.world.as_ref().and_then(CameraLink::pointing).unwrap_or(own)
    }

    fn reading(&self) -> SensorReadings {
        // The vehicle counts yaw to the left about the vertical, and pitch downwards.
        let half = |angle: Angle| -angle.radians() / 2.0;
        let Pointing { pan, tilt } = self.pointing();
        let (yaw, pitch) = (half(pan), half(tilt));
        SensorReadings {
            attitude: Quaternion { w: yaw.cos(), x: 0.0, y: 0.0, z: yaw.sin() },
            gimbal: Quaternion { w: pitch.cos(), x: 0.0, y: pitch.sin(), z: 0.0 },
            elevation_rad: 0.2,
            azimuth_rad: 0.0,
            altitude_m: 10.0,
            tether_m: 10.2,
            ground_battery_v: 15.8,
            backup_battery_v: 8.1,
            flight_mode: 2,
            flags: 0,
        }
    }
}
