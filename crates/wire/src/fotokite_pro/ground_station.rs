//! The ground station's end of the protocol, for the emulator and the tests: a shell, remote control,
//! telemetry.
//!
//! ```text
//!            RemoteControl start
//!   Shell <-----------------------> RemoteControlled
//!   (echo, prompt)    stop          (silent; motion lines count once checksums are off)
//! ```
//!
//! Rates are latched: each rate stays in force until the next line for its axis, or until a time-out (a
//! setting, since the real behaviour is unknown). The station answers to the commands in
//! `docs/wire/fotokite-pro.md`; the answer to any other line is `nsh: X: command not found`. The station
//! contains no vehicle: the caller reads the rates and supplies the sensor readings.

use core::fmt::Write as _;
use core::time::Duration;

use barrelman_vocab::telemetry::Quaternion;
use barrelman_vocab::{AngularRate, Timestamp};

pub use super::sensor_readings::SensorReadings;

use super::command::{GIMBAL_LIMIT, Stream, YAW_LIMIT};
use super::lines::LineSplitter;
use super::telemetry::{MODE_REMOTE_CONTROLLED, TETHER_METRES_PER_COUNT};
use super::telemetry_reader::PROMPT;

/// Lines beyond this number within one second are lost.
pub const MAX_LINES_PER_SECOND: u32 = 100;
/// Initial telemetry rate, messages per second.
pub const DEFAULT_TELEMETRY_PER_SECOND: f64 = 1.0;

/// Settings for behaviour of the real ground station that is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundStationSettings {
    /// Whether the shell echoes received bytes.
    pub echo: bool,
    /// Time without a line for an axis after which its rate becomes zero. `None`: no time-out.
    pub rate_timeout: Option<Duration>,
    /// Whether `stop` leaves the rates in force, the worst that a real ground station may do.
    pub stop_keeps_rates: bool,
}

impl Default for GroundStationSettings {
    fn default() -> Self {
        Self { echo: true, rate_timeout: None, stop_keeps_rates: false }
    }
}

/// The rates in force, in the vehicle's own signs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StationRates {
    /// Yaw of the flight unit.
    pub yaw: AngularRate,
    /// Pitch of the gimbal.
    pub pitch: AngularRate,
    /// Roll of the gimbal.
    pub roll: AngularRate,
}

/// State of the station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StationState {
    /// The shell with its prompt.
    Shell,
    /// Remote control: motion commands are executed.
    RemoteControlled,
}

/// The ground station.
#[derive(Debug, Clone)]
pub struct GroundStation {
    settings: GroundStationSettings,
    state: StationState,
    checksums: bool,
    rates: StationRates,
    last_motion: LastMotion,
    lines: LineSplitter,
    last_byte: u8,
    streams: Vec<Stream>,
    telemetry_per_second: f64,
    staged_per_second: Option<f64>,
    next_telemetry: Option<Timestamp>,
    booted: Timestamp,
    param_lines: u64,
    line_rate: LineRateLimit,
}

/// Time of the last line for each axis while its rate is in force.
#[derive(Debug, Clone, Copy, Default)]
struct LastMotion {
    yaw: Option<Timestamp>,
    pitch: Option<Timestamp>,
    roll: Option<Timestamp>,
}

#[derive(Debug, Clone, Copy, Default)]
struct LineRateLimit {
    second: u64,
    lines: u32,
    lost: u64,
}

impl LineRateLimit {
    /// Counts a line. Returns whether the line exceeds the limit and is lost.
    fn exceeds(&mut self, now: Timestamp) -> bool {
        let second = now.as_nanos() / 1_000_000_000;
        if second != self.second {
            self.second = second;
            self.lines = 0;
        }
        self.lines += 1;
        let lost = self.lines > MAX_LINES_PER_SECOND;
        self.lost += u64::from(lost);
        lost
    }
}

impl GroundStation {
    /// A ground station that was switched on at `now`.
    pub fn boot(settings: GroundStationSettings, now: Timestamp) -> Self {
        Self {
            settings,
            state: StationState::Shell,
            checksums: true,
            rates: StationRates::default(),
            last_motion: LastMotion::default(),
            lines: LineSplitter::default(),
            last_byte: 0,
            streams: Vec::new(),
            telemetry_per_second: DEFAULT_TELEMETRY_PER_SECOND,
            staged_per_second: None,
            next_telemetry: None,
            booted: now,
            param_lines: 0,
            line_rate: LineRateLimit::default(),
        }
    }

    /// Processes bytes from the client, appends the answer to `out`, and passes each received line to
    /// `on_line`.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        now: Timestamp,
        out: &mut Vec<u8>,
        mut on_line: impl FnMut(&str),
    ) {
        for &byte in bytes {
            // The `\n` of `\r\n` does not end another line.
            let second_half = byte == b'\n' && self.last_byte == b'\r';
            self.last_byte = byte;
            if second_half {
                continue;
            }
            let ends = byte == b'\r' || byte == b'\n';
            if self.state == StationState::Shell && self.settings.echo {
                if ends { out.extend_from_slice(b"\r\n") } else { out.push(byte) }
            }
            let empty = ends && self.lines.partial().is_empty();
            let mut complete = None;
            self.lines.feed(&[byte], |line| complete = Some(line.to_owned()));
            let was = self.state;
            if let Some(line) = &complete {
                on_line(line);
                if !self.line_rate.exceeds(now) {
                    self.execute(line, now, out);
                }
            }
            let in_shell = self.state == StationState::Shell;
            let came_back = in_shell && was == StationState::RemoteControlled;
            if in_shell && (empty || complete.is_some()) || came_back {
                self.prompt(out);
            }
        }
    }

    fn prompt(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(PROMPT.as_bytes());
        out.push(b' ');
    }

    fn execute(&mut self, line: &str, now: Timestamp, out: &mut Vec<u8>) {
        let (word, rest) = line.trim().split_once(' ').unwrap_or((line.trim(), ""));
        let arguments = rest.trim();
        match (word, arguments) {
            ("stop", "") => {
                self.state = StationState::Shell;
                self.checksums = true;
                if !self.settings.stop_keeps_rates {
                    self.rest();
                }
            }
            ("RemoteControl", "start") => {
                self.state = StationState::RemoteControlled;
                self.checksums = true;
            }
            ("Checksum", "0") => self.checksums = false,
            ("Checksum", "1") => self.checksums = true,
            ("Pset", _) => self.stage_parameter(arguments),
            ("Pcommit", "") => {
                if let Some(per_second) = self.staged_per_second.take() {
                    self.telemetry_per_second = per_second;
                    self.next_telemetry = self.next_telemetry.map(|_| now);
                }
            }
            ("Get_GroundStatus" | "Get_Att" | "Get_Pos" | "Get_FlightStatus" | "Get_Gimbal", "0") => {
                let stream = match word {
                    "Get_GroundStatus" => Stream::GroundStatus,
                    "Get_Att" => Stream::Attitude,
                    "Get_Pos" => Stream::Position,
                    "Get_FlightStatus" => Stream::FlightStatus,
                    _ => Stream::Gimbal,
                };
                if !self.streams.contains(&stream) {
                    self.streams.push(stream);
                }
                self.next_telemetry.get_or_insert(now);
            }
            (
                "Yaw" | "GimbalPitch" | "GimbalRoll" | "Gimbal" | "Pos" | "Pos2" | "PosV" | "PosH" | "PosL",
                _,
            ) => {
                self.execute_motion(word, arguments, now);
            }
            _ if self.state == StationState::Shell => {
                // Writing to memory cannot fail.
                let mut answer = String::new();
                let _ = write!(answer, "nsh: {word}: command not found\r\n");
                out.extend_from_slice(answer.as_bytes());
            }
            _ => {}
        }
    }

    /// Another client takes the control at the ground station itself: this program's commands no longer
    /// count, and its rates end.
    pub fn take_over(&mut self) {
        self.state = StationState::Shell;
        self.checksums = true;
        self.rest();
    }

    fn rest(&mut self) {
        self.rates = StationRates::default();
        self.last_motion = LastMotion::default();
    }

    /// Parameter 117 is the telemetry rate. Other parameters are accepted without effect.
    fn stage_parameter(&mut self, arguments: &str) {
        if let Some(("117", value)) = arguments.split_once(',')
            && let Ok(per_second) = value.trim().parse::<f64>()
            && per_second > 0.0
            && per_second <= 100.0
        {
            self.staged_per_second = Some(per_second);
        }
    }

    /// Executes a motion command: only under remote control and without checksums. Motion of the kite itself
    /// (`Pos...`) is accepted and ignored, since the emulator's kite does not move.
    fn execute_motion(&mut self, word: &str, arguments: &str, now: Timestamp) {
        if self.state != StationState::RemoteControlled || self.checksums {
            return;
        }
        let Some(values) = arguments
            .split(',')
            .map(|text| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()))
            .collect::<Option<Vec<f64>>>()
        else {
            return;
        };
        let rate = AngularRate::from_radians_per_second;
        match (word, values.as_slice()) {
            ("Yaw", &[yaw]) => {
                self.rates.yaw = rate(yaw).clamped(YAW_LIMIT);
                self.last_motion.yaw = Some(now);
            }
            ("GimbalPitch", &[pitch]) => {
                self.rates.pitch = rate(pitch).clamped(GIMBAL_LIMIT);
                self.last_motion.pitch = Some(now);
            }
            ("GimbalRoll", &[roll]) => {
                self.rates.roll = rate(roll).clamped(GIMBAL_LIMIT);
                self.last_motion.roll = Some(now);
            }
            ("Gimbal", &[pitch, roll]) => {
                self.rates.pitch = rate(pitch).clamped(GIMBAL_LIMIT);
                self.rates.roll = rate(roll).clamped(GIMBAL_LIMIT);
                self.last_motion.pitch = Some(now);
                self.last_motion.roll = Some(now);
            }
            _ => {}
        }
    }

    /// Applies the time-out of rates.
    pub fn tick(&mut self, now: Timestamp) {
        let Some(timeout) = self.settings.rate_timeout else { return };
        let axes = [
            (&mut self.rates.yaw, &mut self.last_motion.yaw),
            (&mut self.rates.pitch, &mut self.last_motion.pitch),
            (&mut self.rates.roll, &mut self.last_motion.roll),
        ];
        for (rate, last) in axes {
            if last.is_some_and(|last| now.since(last) >= timeout) {
                *rate = AngularRate::ZERO;
                *last = None;
            }
        }
    }

    /// Appends the telemetry lines that are due to `out`.
    pub fn write_telemetry(&mut self, vehicle: &SensorReadings, now: Timestamp, out: &mut Vec<u8>) {
        let Some(due) = self.next_telemetry.filter(|due| *due <= now) else { return };
        let period = Duration::from_secs_f64(1.0 / self.telemetry_per_second);
        let next = due.plus(period);
        self.next_telemetry = Some(if next <= now { now.plus(period) } else { next });
        let mut text = String::new();
        for stream in &self.streams {
            // Writing to memory cannot fail.
            let _ = self.write_stream(*stream, vehicle, now, &mut text);
        }
        // The real station also sends an undocumented line that clients must tolerate.
        if self.param_lines.is_multiple_of(10) {
            text.push_str("!Param 117,10.000000\r\n");
        }
        self.param_lines += 1;
        out.extend_from_slice(text.as_bytes());
    }

    fn write_stream(
        &self,
        stream: Stream,
        vehicle: &SensorReadings,
        now: Timestamp,
        text: &mut String,
    ) -> core::fmt::Result {
        let uptime_s = now.since(self.booted).as_secs_f64();
        match stream {
            Stream::GroundStatus => {
                let mode = match self.state {
                    StationState::Shell => 0,
                    StationState::RemoteControlled => MODE_REMOTE_CONTROLLED,
                };
                let counts = (vehicle.tether_m / TETHER_METRES_PER_COUNT) as i64;
                write!(text, "!GSStatus {mode},{uptime_s:.1},{:.2},{counts}\r\n", vehicle.ground_battery_v)
            }
            Stream::Attitude => write_quaternion(text, "Attitude", vehicle.attitude),
            Stream::Gimbal => write_quaternion(text, "Gimbal", vehicle.gimbal),
            Stream::Position => write!(
                text,
                "!Pos {:.6},{:.6},{:.3}\r\n",
                vehicle.elevation_rad, vehicle.azimuth_rad, vehicle.altitude_m
            ),
            Stream::FlightStatus => write!(
                text,
                "!FlightStatus {},{uptime_s:.1},{:.2},{}\r\n",
                vehicle.flight_mode, vehicle.backup_battery_v, vehicle.flags
            ),
        }
    }

    /// Time of the next `tick` or `write_telemetry`; `None` if nothing is pending.
    pub fn wake_at(&self) -> Option<Timestamp> {
        let last = [self.last_motion.yaw, self.last_motion.pitch, self.last_motion.roll];
        let times_out = self
            .settings
            .rate_timeout
            .and_then(|timeout| last.into_iter().flatten().min().map(|at| at.plus(timeout)));
        [self.next_telemetry, times_out].into_iter().flatten().min()
    }

    /// Rate of a telemetry stream, messages per second; `None` if the client has not requested it.
    pub fn stream_per_second(&self, stream: Stream) -> Option<f64> {
        self.streams.contains(&stream).then_some(self.telemetry_per_second)
    }

    /// The rates in force.
    pub const fn rates(&self) -> StationRates {
        self.rates
    }

    /// The current state.
    pub const fn state(&self) -> StationState {
        self.state
    }

    /// Number of lines that were lost because the client sent too many.
    pub const fn dropped_lines(&self) -> u64 {
        self.line_rate.lost
    }
}

fn write_quaternion(text: &mut String, name: &str, q: Quaternion) -> core::fmt::Result {
    write!(text, "!{name} {:.6},{:.6},{:.6},{:.6}\r\n", q.w, q.x, q.y, q.z)
}
