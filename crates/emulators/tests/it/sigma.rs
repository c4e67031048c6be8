//! The link over HTTP against the emulated Sigma, on the loopback interface.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use barrelman_emulators::fotokite_sigma::{EmulatedSigma, EmulatedSigmaSettings, SigmaSettings};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::url::Endpoint;
use barrelman_link::{LinkReport, LinkUrl};
use barrelman_link_http::fotokite_sigma::Sigma;
use barrelman_link_http::{
    Credential, HttpProtocol, HttpSettings, SigmaAccess, Trust, VehicleVideo, open_link,
};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{FlightState, LinkState, Report};
use barrelman_vocab::{Angle, AngularRate, Timestamp, VehicleRates, ZoomRate};

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(20);

fn emulated(faults: &str, has_websocket: bool) -> EmulatedSigma {
    let settings = EmulatedSigmaSettings {
        sigma: SigmaSettings::example(),
        has_websocket,
        world: None,
        faults: FaultPlan::parse(faults).unwrap(),
        log: None,
        clock: Clock::start(),
    };
    EmulatedSigma::start("127.0.0.1:0".parse().unwrap(), settings).unwrap()
}

fn settings(sigma: &EmulatedSigma, credential: Credential) -> HttpSettings {
    let Endpoint::Http(address) = LinkUrl::parse(&sigma.url()).unwrap().endpoint else {
        panic!("{}", sigma.url());
    };
    HttpSettings {
        address,
        trust: Trust::WellKnown,
        protocol: HttpProtocol::FotokiteSigma(SigmaAccess {
            credential,
            stream: None,
            full_zoom: ZoomRate::from_per_second(0.3),
        }),
    }
}

/// The first report that fulfils the condition.
fn wait_for(reports: &Receiver<LinkReport>, condition: impl Fn(&Report) -> bool) -> Report {
    loop {
        let report = reports.recv_timeout(PATIENCE).expect("the report comes");
        if let LinkReport::Telemetry(telemetry) = report
            && condition(&telemetry.report)
        {
            return telemetry.report;
        }
    }
}

#[test]
fn the_link_takes_the_control_and_turns_the_emulated_camera() {
    for (has_websocket, credential) in
        [(true, Credential::Token("token".to_owned())), (false, Credential::ApiKey("key".to_owned()))]
    {
        let sigma = emulated("", has_websocket);
        let settings = settings(&sigma, credential);
        let ended = Arc::new(AtomicBool::new(false));
        let is_ended = Arc::clone(&ended);
        let emulator = std::thread::spawn(move || sigma.run(|| is_ended.load(Ordering::Relaxed)).unwrap());
        let (sender, reports) = sync_channel(4096);
        let report = move |report| sender.try_send(report).is_ok();
        let link = open_link(settings, FaultPlan::default(), Clock::start(), report).unwrap();
        wait_for(&reports, |report| *report == Report::Acceptance(Acceptance::Accepted));
        wait_for(&reports, |report| *report == Report::Link(LinkState::Up));
        wait_for(&reports, |report| matches!(report, Report::FieldOfView(_)));
        wait_for(&reports, |report| {
            *report == Report::FlightState { state: FlightState::Flying, is_battery_low: false }
        });
        let down = AngularRate::from_radians_per_second(0.3);
        let for_ever = Timestamp::from_nanos(u64::MAX / 2);
        link.send(VehicleRates::turning(AngularRate::ZERO, down), Some(for_ever));
        let lowered = Angle::from_degrees(-30.0);
        wait_for(
            &reports,
            |report| matches!(report, Report::CameraTilt(tilt) if tilt.radians() < lowered.radians()),
        );
        assert!(link.close(), "zeros and the release were sent");
        ended.store(true, Ordering::Relaxed);
        emulator.join().unwrap();
    }
}

#[test]
fn a_vehicle_says_what_check_asks() {
    let sigma = emulated("", true);
    let reach = |credential: Credential| Sigma::reach(&settings(&sigma, credential.clone()), &credential);
    let vehicle = reach(Credential::Token("token".to_owned())).unwrap();
    assert_eq!(vehicle.camera_info().map(|info| info.pan_speed_min), Ok(2.0));
    assert_eq!(vehicle.is_camera_online(), Ok(true));
    assert_eq!(vehicle.controller(), Ok(None));
    let name = |video: Option<VehicleVideo>| video.map(|video| video.name);
    assert_eq!(vehicle.video(None).map(name), Ok(Some("zoom".to_owned())));
    assert_eq!(vehicle.video(Some("thermal")).map(name), Ok(Some("thermal".to_owned())));
    let unknown = vehicle.video(Some("overview")).unwrap_err().to_string();
    assert!(unknown.contains("video.stream be one of zoom, thermal"), "{unknown}");
    let wrong = reach(Credential::Token("wrong".to_owned())).unwrap();
    assert_eq!(wrong.camera_info(), Err(Acceptance::TokenRefused));
    let refused = reach(Credential::ApiKey("wrong".to_owned()));
    assert!(refused.map(drop).unwrap_err().to_string().contains("API key is not known"));
}
