//! Texts from people and programs: configuration, scenarios, drives, messages of the console, addresses.

use barrelman_console_server::api::{ClientMessage, RequestBody};
use barrelman_experiments::drive::StoredDrive;
use barrelman_experiments::scenario::{ScenarioOverrides, complete, resolve};
use barrelman_link::LinkUrl;
use barrelman_sim::World;
use barrelman_station::config::{self, Configuration};
use barrelman_station::source_url::SourceUrl;
use barrelman_video::url::VideoUrl;

/// A configuration that is accepted is written as it is read.
pub fn configuration(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let Ok(file) = config::parse(&text) else { return };
    let Ok(configuration) = Configuration::resolve(&file) else { return };
    let written = configuration.to_toml().expect("a configuration can be written");
    let again = config::parse(&written).expect("what was written can be read");
    let again = Configuration::resolve(&again).expect("what was written is accepted");
    assert_eq!(again.to_toml().expect("a configuration can be written"), written);
}

/// Steps of a world of an accepted scenario.
const TICKS: u32 = 24;

/// A scenario is read or refused with a reason. The world of an accepted one runs, and is printed so that it
/// is read again.
pub fn scenario(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match resolve::read(&text, &ScenarioOverrides::default()) {
        Err(error) => assert!(!error.located_in("input", &text).to_string().is_empty()),
        Ok(loaded) => {
            let again = resolve::read(&complete(&text), &ScenarioOverrides::default());
            assert_eq!(again.map(|again| again.scenario), Ok(loaded.scenario.clone()));
            let mut world = World::new(&loaded.scenario, 1).expect("an accepted scenario has a world");
            for _ in 0..TICKS {
                world.advance();
            }
        }
    }
}

/// A stored drive is read or refused.
pub fn drive(bytes: &[u8]) {
    if let Ok(drive) = StoredDrive::parse(&String::from_utf8_lossy(bytes)) {
        assert!(drive.requests.is_sorted_by_key(|(tick, _)| *tick));
        let _ = drive.last_tick();
    }
}

/// A message of a page, or a request of a program, that is accepted is written as it is read.
pub fn console(bytes: &[u8]) {
    if let Ok(message) = serde_json::from_slice::<ClientMessage>(bytes) {
        let written = serde_json::to_vec(&message).expect("a message can be written");
        let again: ClientMessage = serde_json::from_slice(&written).expect("what was written can be read");
        assert_eq!(again, message);
    }
    let _ = serde_json::from_slice::<RequestBody>(bytes);
}

/// An address is read or refused; the refusal repeats no login.
pub fn urls(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(url) = LinkUrl::parse(&text) {
        assert_eq!(LinkUrl::parse(&url.with_faults()), Ok(url));
    }
    let _ = SourceUrl::parse(&text);
    for scheme in ["rtsp", "tcp", "udp"] {
        let with_login = format!("{scheme}://operator:n0t-th1s@{text}");
        let shown = match scheme {
            "rtsp" => {
                VideoUrl::parse(&with_login).map_or_else(|error| error.to_string(), |url| url.to_string())
            }
            _ => LinkUrl::parse(&with_login).map_or_else(|error| error.to_string(), |url| url.to_string()),
        };
        assert!(!shown.contains("n0t-th1s"), "{shown}");
    }
}
