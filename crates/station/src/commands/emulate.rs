//! `barrelman emulate`: a ground station to test against.

use std::io::{Write as _, stdout};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use barrelman_wire::fotokite_pro::ground_station::GroundStationSettings;

use crate::cli::{EmulateArgs, EmulateFotokiteProArgs, StationName};
use crate::clock::Clock;
use crate::emulator::fotokite_pro::FotokitePro;
use crate::emulator::host_port::HostPort;
use crate::emulator::log::StationLog;
use crate::fault::FaultPlan;
use crate::output;

/// Runs the command.
///
/// # Errors
/// If the port or the log cannot be made.
pub fn run(args: &EmulateArgs, clock: Clock) -> Result<ExitCode> {
    match &args.station {
        StationName::FotokitePro(args) => fotokite_pro(args, clock),
    }
}

fn fotokite_pro(args: &EmulateFotokiteProArgs, clock: Clock) -> Result<ExitCode> {
    let port = match (&args.pty, &args.listen) {
        (Some(path), _) => HostPort::pty(path)?,
        (None, Some(address)) => HostPort::listen(address)?,
        (None, None) => bail!("no port: give --pty PATH or --listen ADDR"),
    };
    let log = args.log.as_ref().map(|path| output::create(path, args.force)).transpose()?;
    let faults = FaultPlan::parse(args.fault.as_deref().unwrap_or_default())?;
    let settings = GroundStationSettings {
        echo: !args.no_echo,
        rate_timeout: args.rate_timeout.map(Duration::from_secs_f64),
    };
    let ended = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&ended))?;
    }
    let mut emulator = FotokitePro::new(port, settings, StationLog::new(log, clock), faults, clock);
    // A script waits for this line: it must be out before the first client can come.
    writeln!(stdout(), "an emulated Fotokite Pro answers at {}", emulator.place())?;
    stdout().flush()?;
    emulator.run(|| ended.load(Ordering::Relaxed))?;
    Ok(ExitCode::SUCCESS)
}
