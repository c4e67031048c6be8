//! `link-latency`: the time from a command to its bytes at the far end of the port, through the guard where
//! the vehicle has one, beside a bare write.
//!
//! ```text
//!   link.send(rates) --> pipe --> barrelman-guard: session, port --> TCP or UDP on the loopback --> emulated vehicle
//!   write(packet) ---------------------------------------------> TCP or UDP on the loopback --> reader
//! ```
//! A Fotokite Sigma and an ONVIF camera have no guard: their link's threads send an HTTP request, beside a
//! bare write of such a request. Both are done in turns, so that whatever else the machine does meets both.

mod heard;

mod vehicle;

mod bare;
mod fotokite_pro;
mod fotokite_sigma;
mod http_vehicle;
mod mavlink_gimbal;
mod onvif;

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use barrelman_host::clock::Clock;
use barrelman_link::LinkReport;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{AngularRate, VehicleRates};
use clap::Args;

use self::heard::{Heard, PATIENCE};
use crate::output::print_line;
use crate::statistics::TimingSummary;
use crate::vehicle::Vehicle;

/// Least time between two commands: longer than the spacing of lines on the wire.
const SPACING: Duration = Duration::from_millis(70);
/// Difference of one command from the next, rad/s: more than a vehicle's protocol rounds away.
const RATE_STEP: f64 = 0.002;
/// Time to live of a command.
const LIVES: Duration = Duration::from_millis(400);

/// `link-latency`.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The vehicle.
    #[arg(long, value_enum, default_value_t = Vehicle::FotokitePro)]
    vehicle: Vehicle,
    /// Number of commands.
    #[arg(long, default_value_t = 1_000)]
    commands: u32,
    /// The guard's program [default: barrelman-guard beside this program].
    #[arg(long, value_name = "FILE")]
    guard: Option<PathBuf>,
}

/// Measures. Returns whether the requirement holds.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let clock = Clock::start();
    let (address, yaw_rates) = options.vehicle.start(clock)?;
    let (report, reports) = channel();
    let link = options.vehicle.open(&address, options.guard.as_deref(), clock, report)?;
    wait_until_up(&reports)?;
    let mut bare = options.vehicle.bare()?;
    let (mut linked_ms, mut bare_ms) = (Vec::new(), Vec::new());
    for index in 0..options.commands {
        // No two rates in a row are alike: each is a line of its own.
        let yaw = 0.05 + RATE_STEP * f64::from(index % 150);
        let rates = VehicleRates { yaw: AngularRate::from_radians_per_second(yaw), ..VehicleRates::REST };
        let sent = Instant::now();
        link.send(rates, Some(clock.now().plus(LIVES)));
        linked_ms.push(milliseconds(arrival(&yaw_rates, yaw)?.duration_since(sent)));
        // Not in step with the guard's heartbeat or the station's telemetry.
        std::thread::sleep(SPACING / 2 + Duration::from_micros(u64::from(index * 7_919 % 9_973)));
        bare_ms.push(milliseconds(bare.write(yaw)?));
        std::thread::sleep(SPACING / 2 + Duration::from_micros(u64::from(index * 104_729 % 9_967)));
    }
    let name = link.name();
    link.send(VehicleRates::REST, None);
    ensure!(link.close(), "zeros and stop were not sent at the end");
    print_line(&format!("{} commands each; time to the bytes at the far end, ms", options.commands));
    let [linked, bare] = [(name, &linked_ms), ("bare write", &bare_ms)].map(|(name, times)| {
        let summary = TimingSummary::from_times_ms(times);
        print_line(&format!(
            "{name:<16} median {:>6.3}   99th percentile {:>6.3}   mean {:>6.3}",
            summary.median, summary.p99, summary.mean
        ));
        summary
    });
    let later_ms = linked.p99 - bare.p99;
    let limit_ms = options.vehicle.limit_ms();
    let holds = later_ms <= limit_ms;
    let verdict = if holds { "holds" } else { "is missed" };
    print_line(&format!("99th percentile {later_ms:+.3} ms (at most +{limit_ms} ms): {verdict}"));
    Ok(holds)
}

fn milliseconds(duration: Duration) -> f64 {
    1e3 * duration.as_secs_f64()
}

fn wait_until_up(reports: &Receiver<LinkReport>) -> Result<()> {
    loop {
        match reports.recv_timeout(PATIENCE).context("the link does not come up")? {
            LinkReport::Telemetry(telemetry) if telemetry.report == Report::Link(LinkState::Up) => {
                return Ok(());
            }
            LinkReport::Lost { reason, .. } => bail!("the link was lost: {reason}"),
            _ => {}
        }
    }
}

/// When the packet with this yaw rate arrived.
fn arrival(yaw_rates: &Receiver<Heard>, wanted: f64) -> Result<Instant> {
    loop {
        let (rate, at) = yaw_rates.recv_timeout(PATIENCE).context("a command did not arrive")?;
        if (rate - wanted).abs() < 0.5 * RATE_STEP {
            return Ok(at);
        }
    }
}
