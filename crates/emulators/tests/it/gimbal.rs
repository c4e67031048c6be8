//! The link over UDP, TCP and a pseudo-terminal against the emulated gimbal, on a line that loses packets,
//! and signed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use barrelman_emulators::emulated_port::EmulatedPort;
use barrelman_emulators::emulation_loop::Emulator;
use barrelman_emulators::log::StationLog;
use barrelman_emulators::mavlink_gimbal::{GimbalManagerSettings, MavlinkGimbal};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::{LinkHandle, LinkReport, LinkUrl};
use barrelman_vocab::telemetry::{ControlState, LinkState, Report};
use barrelman_vocab::{Angle, AngularRate, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::{ByteProtocol, ByteProtocolName, Framing, Signing, SigningKey};

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(20);

/// The first report that fulfils the condition.
fn wait_for(reports: &Receiver<LinkReport>, condition: impl Fn(&Report) -> bool) {
    loop {
        let report = reports.recv_timeout(PATIENCE).expect("the report comes");
        if let LinkReport::Telemetry(telemetry) = report
            && condition(&telemetry.report)
        {
            return;
        }
    }
}

#[track_caller]
fn lowers_the_camera(port: EmulatedPort, loss_share: f64, signing: Option<Signing>) {
    let clock = Clock::start();
    let settings = GimbalManagerSettings { signing, ..GimbalManagerSettings::default() };
    let vehicle = MavlinkGimbal::new(settings, None, clock.now());
    let log = StationLog::new(None, clock);
    let mut emulator = Emulator::new(port, vehicle, log, FaultPlan::default(), clock).with_loss(loss_share);
    let url = LinkUrl::parse(&emulator.url()).unwrap();
    let ended = Arc::new(AtomicBool::new(false));
    let is_ended = Arc::clone(&ended);
    let emulation = std::thread::spawn(move || emulator.run(|| is_ended.load(Ordering::Relaxed)).unwrap());
    let protocol = ByteProtocolName::of(VehicleProfile::mavlink_gimbal().protocol).unwrap().signed(signing);
    let protocol = ByteProtocol { protocol, framing: Framing::CarriageReturns, baud: url.baud() };
    let (sender, reports) = sync_channel(4096);
    let report = move |report| sender.try_send(report).is_ok();
    let link = LinkHandle::open(&url, protocol, clock, report).unwrap();
    wait_for(&reports, |report| *report == Report::Link(LinkState::Up));
    wait_for(&reports, |report| matches!(report, Report::Control { control: ControlState::Ours, .. }));
    let down = AngularRate::from_radians_per_second(-0.3);
    let for_ever = Timestamp::from_nanos(u64::MAX / 2);
    link.send(VehicleRates::turning(AngularRate::ZERO, down), Some(for_ever));
    let lowered = Angle::from_degrees(-30.0).radians();
    wait_for(&reports, |report| matches!(report, Report::CameraTilt(tilt) if tilt.radians() < lowered));
    assert!(link.close(), "zeros and the release were sent");
    ended.store(true, Ordering::Relaxed);
    emulation.join().unwrap();
}

#[test]
fn the_link_takes_the_control_and_turns_the_emulated_gimbal() {
    let signing = Signing::new(SigningKey::parse("a passphrase").unwrap(), 1_800_000_000_000);
    let datagrams = || EmulatedPort::datagrams("127.0.0.1:0").unwrap();
    lowers_the_camera(datagrams(), 0.2, None);
    lowers_the_camera(datagrams(), 0.0, Some(signing));
    lowers_the_camera(EmulatedPort::listen("127.0.0.1:0").unwrap(), 0.0, None);
    let path = std::env::temp_dir().join(format!("barrelman-gimbal-{}", std::process::id()));
    lowers_the_camera(EmulatedPort::pty(&path, false).unwrap(), 0.0, None);
}
