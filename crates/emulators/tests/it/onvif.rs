//! The link over HTTP against the emulated ONVIF camera, on the loopback interface.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use barrelman_emulators::onvif::{
    CameraFaults, CameraSettings, EmulatedCamera, EmulatedCameraSettings, example_speeds,
};
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_link::url::Endpoint;
use barrelman_link::{LinkReport, LinkUrl};
use barrelman_link_http::onvif::Camera;
use barrelman_link_http::{HttpProtocol, HttpSettings, Trust, VehicleVideo, open_link, vehicle_video};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{AngularRate, Timestamp, VehicleRates};
use barrelman_wire::RestEvidence;
use barrelman_wire::onvif::{Login, OnvifSettings};

/// Nothing that is waited for takes so long.
const PATIENCE: Duration = Duration::from_secs(20);

fn login(password: &str) -> Login {
    Login::new("admin".to_owned(), password.to_owned())
}

fn emulated(wants_http_digest: bool) -> EmulatedCamera {
    let camera = CameraSettings { login: Some(login("right")), ..CameraSettings::example() };
    let settings = EmulatedCameraSettings {
        camera,
        habits: CameraFaults::default(),
        speeds: example_speeds(),
        wants_http_digest,
        world: None,
        faults: FaultPlan::default(),
        log: None,
        clock: Clock::start(),
    };
    EmulatedCamera::start("127.0.0.1:0".parse().unwrap(), settings).unwrap()
}

fn settings(camera: &EmulatedCamera, login: Option<Login>) -> HttpSettings {
    let Endpoint::Http(address) = LinkUrl::parse(&camera.url()).unwrap().endpoint else {
        panic!("{}", camera.url());
    };
    let onvif = OnvifSettings { login, speeds: Some(example_speeds()), profile: None };
    HttpSettings { address, trust: Trust::WellKnown, protocol: HttpProtocol::Onvif(onvif) }
}

/// The first report that fulfils the condition.
fn wait_for(reports: &Receiver<LinkReport>, condition: impl Fn(&LinkReport) -> bool) -> LinkReport {
    loop {
        let report = reports.recv_timeout(PATIENCE).expect("the report comes");
        if condition(&report) {
            return report;
        }
    }
}

fn is_telemetry(report: &LinkReport, content: &Report) -> bool {
    matches!(report, LinkReport::Telemetry(telemetry) if telemetry.report == *content)
}

#[test]
fn the_link_turns_the_emulated_camera_and_rests_it() {
    for wants_http_digest in [false, true] {
        let camera = emulated(wants_http_digest);
        let settings = settings(&camera, Some(login("right")));
        let ended = Arc::new(AtomicBool::new(false));
        let is_ended = Arc::clone(&ended);
        let emulator = std::thread::spawn(move || camera.run(|| is_ended.load(Ordering::Relaxed)).unwrap());
        let (sender, reports) = sync_channel(4096);
        let report = move |report| sender.try_send(report).is_ok();
        let link = open_link(settings, FaultPlan::default(), Clock::start(), report).unwrap();
        wait_for(&reports, |report| is_telemetry(report, &Report::Acceptance(Acceptance::Accepted)));
        wait_for(&reports, |report| is_telemetry(report, &Report::Link(LinkState::Up)));
        let right = AngularRate::from_radians_per_second(0.3);
        let for_ever = Timestamp::from_nanos(u64::MAX / 2);
        link.send(VehicleRates::turning(right, AngularRate::ZERO), Some(for_ever));
        std::thread::sleep(Duration::from_millis(500));
        assert!(link.close(), "zeros were sent");
        wait_for(&reports, |report| matches!(report, LinkReport::Stopped(RestEvidence::AtRest)));
        ended.store(true, Ordering::Relaxed);
        emulator.join().unwrap();
    }
}

#[test]
fn a_camera_says_what_check_asks_to_the_right_login_alone() {
    for wants_http_digest in [false, true] {
        let camera = emulated(wants_http_digest);
        let reach = |login| {
            let settings = settings(&camera, login);
            let HttpProtocol::Onvif(onvif) = settings.protocol.clone() else { panic!() };
            Camera::reach(&settings, &onvif).map(|camera| camera.joined().clone())
        };
        let joined = reach(Some(login("right"))).unwrap();
        assert_eq!((joined.profile.as_str(), joined.full.zoom), ("Profile_1", Some(1.0)));
        let video = vehicle_video(&settings(&camera, Some(login("right")))).unwrap();
        let address = Some("rtsp://127.0.0.1/stream1".to_owned());
        let choices = ["Profile_1", "Profile_2"].map(str::to_owned).to_vec();
        assert_eq!(video, Some(VehicleVideo { name: "Profile_1".to_owned(), address, choices }));
        for wrong in [None, Some(login("wrong"))] {
            let refused = reach(wrong).unwrap_err().to_string();
            assert!(refused.contains("--link-login-file"), "{refused}");
        }
    }
}
