//! `link-latency`: the time from a command to its bytes at the far end of the port, through the guard, beside a bare write.
//!
//! ```text
//!   link.send(rates) --> pipe --> barrelman-guard: session, port --> TCP or UDP on the loopback --> emulated vehicle
//!   write(packet) ---------------------------------------------> TCP or UDP on the loopback --> reader
//! ```
//! Both are done in turns, so that whatever else the machine does meets both.

mod heard;

mod bare;
mod fotokite_pro;
mod mavlink_gimbal;

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use barrelman_host::clock::Clock;
use barrelman_link::guarded::GuardedLinkSettings;
use barrelman_link::{GuardedLink, LinkReport, LinkUrl};
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{AngularRate, VehicleProfile, VehicleRates};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing};
use clap::{Args, ValueEnum};

use self::bare::{BareDatagrams, BareLoop, BareStream};
use self::heard::{Heard, PATIENCE};
use crate::output::print_line;
use crate::statistics::TimingSummary;

/// The 99th percentile may be later than that of a bare write by this, milliseconds.
const LIMIT_MS: f64 = 1.0;
/// Least time between two commands: longer than the spacing of lines on the wire.
const SPACING: Duration = Duration::from_millis(70);
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

/// A vehicle whose port a guard owns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Vehicle {
    /// A Fotokite Pro, over TCP.
    FotokitePro,
    /// A MAVLink gimbal, over UDP.
    MavlinkGimbal,
}

impl Vehicle {
    fn profile(self) -> VehicleProfile {
        match self {
            Self::FotokitePro => VehicleProfile::fotokite_pro(),
            Self::MavlinkGimbal => VehicleProfile::mavlink_gimbal(),
        }
    }

    /// Starts the emulated vehicle: its address, and what it hears.
    fn start(self, clock: Clock) -> Result<(String, Receiver<Heard>)> {
        match self {
            Self::FotokitePro => fotokite_pro::start(clock),
            Self::MavlinkGimbal => mavlink_gimbal::start(clock),
        }
    }

    /// The same way without link and guard.
    fn bare(self) -> Result<Box<dyn BareLoop>> {
        Ok(match self {
            Self::FotokitePro => Box::new(BareStream::open()?),
            Self::MavlinkGimbal => Box::new(BareDatagrams::open()?),
        })
    }
}

/// Measures. Returns whether the requirement holds.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let guard = match &options.guard {
        Some(guard) => guard.clone(),
        None => std::env::current_exe()?.with_file_name("barrelman-guard"),
    };
    ensure!(
        guard.exists(),
        "the guard {} is not there: build it (`cargo build --release -p barrelman`)",
        guard.display()
    );
    let clock = Clock::start();
    let (address, yaw_rates) = options.vehicle.start(clock)?;
    let url = LinkUrl::parse(&address)?;
    let (report, reports) = channel();
    let profile = options.vehicle.profile();
    let limits = profile.protocol.rate_limits();
    let protocol = ByteProtocolName::of(profile.protocol).context("the vehicle's port carries no bytes")?;
    let settings = GuardedLinkSettings {
        guard,
        protocol: ByteProtocol { protocol, framing: Framing::CarriageReturns, baud: url.baud() },
        url,
        limits: VehicleRates { yaw: limits.pan, pitch: limits.tilt },
        clock,
    };
    let link = GuardedLink::open(settings, move |content| report.send(content).is_ok())?;
    wait_until_up(&reports)?;
    let mut bare = options.vehicle.bare()?;
    let (mut linked_ms, mut bare_ms) = (Vec::new(), Vec::new());
    for index in 0..options.commands {
        // No two rates in a row are alike: each is a line of its own.
        let yaw = 0.05 + 0.0003 * f64::from(index % 1_000);
        let rates = VehicleRates { yaw: AngularRate::from_radians_per_second(yaw), ..VehicleRates::REST };
        let sent = Instant::now();
        link.send(rates, Some(clock.now().plus(LIVES)));
        linked_ms.push(milliseconds(arrival(&yaw_rates, yaw)?.duration_since(sent)));
        // Not in step with the guard's heartbeat or the station's telemetry.
        std::thread::sleep(SPACING / 2 + Duration::from_micros(u64::from(index * 7_919 % 9_973)));
        bare_ms.push(milliseconds(bare.write(yaw)?));
        std::thread::sleep(SPACING / 2 + Duration::from_micros(u64::from(index * 104_729 % 9_967)));
    }
    link.send(VehicleRates::REST, None);
    ensure!(link.close(), "zeros and stop were not sent at the end");
    print_line(&format!("{} commands each; time to the bytes at the far end, ms", options.commands));
    let [linked, bare] = [("link and guard", &linked_ms), ("bare write", &bare_ms)].map(|(name, times)| {
        let summary = TimingSummary::from_times_ms(times);
        print_line(&format!(
            "{name:<16} median {:>6.3}   99th percentile {:>6.3}   mean {:>6.3}",
            summary.median, summary.p99, summary.mean
        ));
        summary
    });
    let later_ms = linked.p99 - bare.p99;
    let holds = later_ms <= LIMIT_MS;
    let verdict = if holds { "holds" } else { "is missed" };
    print_line(&format!("99th percentile {later_ms:+.3} ms (at most +{LIMIT_MS} ms): {verdict}"));
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
        if (rate - wanted).abs() < 5e-5 {
            return Ok(at);
        }
    }
}
