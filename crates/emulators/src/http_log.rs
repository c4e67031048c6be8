//! The log of a vehicle that is emulated over HTTP: one JSON object per line, written without a buffer.

use std::io::Write as _;

use anyhow::Result;
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_vocab::{Timestamp, VehicleRates};
use serde::Serialize;

#[derive(Serialize)]
struct RequestRow<'a> {
    mono_ns: u64,
    method: &'a str,
    path: &'a str,
    body: &'a str,
    status: u16,
}

#[derive(Serialize)]
struct RatesRow {
    mono_ns: u64,
    pan_deg_per_s: f64,
    tilt_deg_per_s: f64,
    /// -1 to 1 of the zoom's largest speed.
    zoom: f64,
}

/// A request, without what proves who asks.
pub(super) struct LoggedRequest<'a> {
    pub(super) method: &'a str,
    pub(super) path: &'a str,
    pub(super) body: &'a str,
}

/// The log. Without a file, rows are discarded. No token is written.
pub(super) struct HttpLog {
    file: Option<OutputFile>,
    clock: Clock,
}

impl HttpLog {
    pub(super) const fn new(file: Option<OutputFile>, clock: Clock) -> Self {
        Self { file, clock }
    }

    /// A request was answered with this status.
    pub(super) fn on_request(
        &mut self,
        at: Timestamp,
        request: LoggedRequest<'_>,
        status: u16,
    ) -> Result<()> {
        let LoggedRequest { method, path, body } = request;
        let mono_ns = self.mono_ns(at);
        self.write(&RequestRow { mono_ns, method, path, body, status })
    }

    /// These rates are in force from now on.
    pub(super) fn on_rates(&mut self, at: Timestamp, rates: VehicleRates) -> Result<()> {
        let degrees = |rate: barrelman_vocab::AngularRate| rate.radians_per_second().to_degrees();
        let mono_ns = self.mono_ns(at);
        self.write(&RatesRow {
            mono_ns,
            pan_deg_per_s: degrees(rates.yaw),
            tilt_deg_per_s: degrees(rates.pitch),
            zoom: rates.zoom,
        })
    }

    fn mono_ns(&self, at: Timestamp) -> u64 {
        self.clock.start_on_monotonic_ns() + at.as_nanos()
    }

    fn write(&mut self, row: &impl Serialize) -> Result<()> {
        if let Some(file) = &mut self.file {
            let mut line = serde_json::to_string(row)?;
            line.push('\n');
            file.write_all(line.as_bytes())?;
        }
        Ok(())
    }
}
