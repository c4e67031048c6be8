//! `link-latency`: the time from a command to its bytes at the far end of the port, through the guard, beside a bare write.
//!
//! ```text
//!   link.send(rates) --> pipe --> barrelman-guard: session, port --> TCP on the loopback --> emulated ground station
//!   write(line) -----------------------------------------------> TCP on the loopback --> reader
//! ```
//! Both are done in turns, so that whatever else the machine does meets both.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use barrelman_host::clock::Clock;
use barrelman_link::guarded::GuardedLinkSettings;
use barrelman_link::{GuardedLink, LinkReport, LinkUrl};
use barrelman_vocab::profile::Protocol;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{AngularRate, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing};
use clap::Args;

use crate::output::print_line;
use crate::statistics::TimingSummary;

/// The 99th percentile may be later than that of a bare write by this, milliseconds.
const LIMIT_MS: f64 = 1.0;
/// Least time between two commands: longer than the spacing of lines on the wire.
const SPACING: Duration = Duration::from_millis(70);
/// Longest wait for the bytes of a command, and for the link to be up.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time to live of a command.
const LIVES: Duration = Duration::from_millis(400);

/// `link-latency`.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Number of commands.
    #[arg(long, default_value_t = 1_000)]
    commands: u32,
    /// The guard's program [default: barrelman-guard beside this program].
    #[arg(long, value_name = "FILE")]
    guard: Option<PathBuf>,
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
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let url = LinkUrl::parse(&format!("tcp://{}", listener.local_addr()?))?;
    let (heard, yaw_rates) = channel();
    std::thread::Builder::new().name("station".to_owned()).spawn(move || {
        // The station ends with its client.
        let _ = listener.accept().map(|(client, _)| serve(client, clock, &heard));
    })?;
    let (report, reports) = channel();
    let limits = Protocol::FotokitePro.rate_limits();
    let settings = GuardedLinkSettings {
        guard,
        protocol: ByteProtocol {
            protocol: ByteProtocolName::FotokitePro,
            framing: Framing::CarriageReturns,
            baud: url.baud(),
        },
        url,
        limits: VehicleRates { yaw: limits.pan, pitch: limits.tilt },
        clock,
    };
    let link = GuardedLink::open(settings, move |content| report.send(content).is_ok())?;
    wait_until_up(&reports)?;
    let mut bare = BareLoop::open()?;
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

/// When the line with this yaw rate arrived.
fn arrival(yaw_rates: &Receiver<(f64, Instant)>, wanted: f64) -> Result<Instant> {
    loop {
        let (rate, at) = yaw_rates.recv_timeout(PATIENCE).context("a command did not arrive")?;
        if (rate - wanted).abs() < 5e-5 {
            return Ok(at);
        }
    }
}

/// The emulated ground station: answers, and tells each yaw rate with the time of its bytes.
fn serve(mut client: TcpStream, clock: Clock, heard: &Sender<(f64, Instant)>) -> std::io::Result<()> {
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

/// The bare write: a connection, and a reader that tells when bytes arrive.
struct BareLoop {
    writer: TcpStream,
    arrivals: Receiver<Instant>,
}

impl BareLoop {
    fn open() -> Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let writer = TcpStream::connect(listener.local_addr()?)?;
        writer.set_nodelay(true)?;
        let (mut reader, _) = listener.accept()?;
        let (arrived, arrivals) = channel();
        std::thread::Builder::new().name("reader".to_owned()).spawn(move || {
            let mut buffer = [0; 1024];
            while reader.read(&mut buffer).is_ok_and(|read| read > 0) {
                if arrived.send(Instant::now()).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { writer, arrivals })
    }

    /// Writes a line. The time until it arrived.
    fn write(&mut self, yaw: f64) -> Result<Duration> {
        let sent = Instant::now();
        self.writer.write_all(format!("\rYaw {yaw:.6}\r").as_bytes())?;
        let arrived = self.arrivals.recv_timeout(PATIENCE).context("a line did not arrive")?;
        Ok(arrived.duration_since(sent))
    }
}
