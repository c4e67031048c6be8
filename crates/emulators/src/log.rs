//! The emulator's log: one JSON object per line, written without a buffer.

use std::io::Write as _;

use anyhow::Result;
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use serde::Serialize;

use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;

/// Direction of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// From the client.
    In,
    /// To the client.
    Out,
    /// No line: the state changed by itself.
    None,
}

/// The state of an emulated vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleState {
    /// The state's name.
    pub name: &'static str,
    /// The rates in force, in the vehicle's own signs.
    pub rates: VehicleRates,
    /// The roll rate in force.
    pub roll: AngularRate,
    /// Number of lines that were lost because the client sent too many.
    pub lost_lines: u64,
}

/// The state of vehicle and camera, as logged.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoggedState {
    station: &'static str,
    yaw_rate: f64,
    pitch_rate: f64,
    zoom: f64,
    roll_rate: f64,
    pan_rad: f64,
    tilt_rad: f64,
    lost_lines: u64,
}

impl LoggedState {
    /// The state of a vehicle whose camera has these angles.
    pub fn new(state: VehicleState, pan_rad: f64, tilt_rad: f64) -> Self {
        Self {
            station: state.name,
            yaw_rate: state.rates.yaw.radians_per_second(),
            pitch_rate: state.rates.pitch.radians_per_second(),
            zoom: state.rates.zoom,
            roll_rate: state.roll.radians_per_second(),
            pan_rad,
            tilt_rad,
            lost_lines: state.lost_lines,
        }
    }
}

#[derive(Serialize)]
struct Row<'a> {
    mono_ns: u64,
    direction: Direction,
    raw: &'a str,
    state: LoggedState,
}

/// The log. Without a file, rows are discarded.
#[derive(Debug)]
pub struct StationLog {
    file: Option<OutputFile>,
    clock: Clock,
}

impl StationLog {
    /// A log that writes to `file`.
    pub const fn new(file: Option<OutputFile>, clock: Clock) -> Self {
        Self { file, clock }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn add(&mut self, at: Timestamp, direction: Direction, raw: &str, state: LoggedState) -> Result<()> {
        if let Some(file) = &mut self.file {
            let mono_ns = self.clock.start_on_monotonic_ns() + at.as_nanos();
            let mut line = serde_json::to_string(&Row { mono_ns, direction, raw, state })?;
            line.push('\n');
            file.write_all(line.as_bytes())?;
        }
        Ok(())
    }
}
