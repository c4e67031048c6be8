//! The thread of a guarded link with scripts in the place of the guard: a message is one write to its standard
//! input.

use std::fs;
use std::ops::Deref;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_vocab::VesselOrder;
use barrelman_wire::VesselProtocol;

use super::*;
use crate::guard::message::GuardedVehicle;
use crate::url::LinkUrl;

const OPENS_PORT: &str = "printf '\\015' >&0";
const OPENED: &str = "printf '\\001' >&0";
const HELD_UP: &str = "printf '\\006' >&0";
/// Says that it runs until its program is gone, and then notes that.
const SERVES: &str =
    "trap '' PIPE; while printf '\\012' >&0; do sleep 0.03; done 2>/dev/null; touch \"$0.ended\"";

/// A folder that is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("barrelman-link-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A link whose guard runs these commands. `report`: takes the name of each report.
fn open(guard: &Path, commands: &[&str], report: impl Fn(&str) + Send + 'static) -> GuardedLink<VesselOrder> {
    fs::write(guard, format!("#!/bin/sh\n{}\n", commands.join("\n"))).unwrap();
    fs::set_permissions(guard, fs::Permissions::from_mode(0o755)).unwrap();
    let vehicle = GuardedVehicle::Vessel {
        limits: barrelman_vocab::VesselCommand { throttle: 1.0, rudder: 1.0 },
        protocol: VesselProtocol::LabUdp,
    };
    let settings = GuardedLinkSettings {
        guard: guard.to_owned(),
        url: LinkUrl::parse("udp://127.0.0.1:9").unwrap(),
        protocol: VesselProtocol::LabUdp,
        vehicle,
        lock: None,
        clock: Clock::start(),
    };
    let report = move |made: LinkReport| {
        report(match made {
            LinkReport::GuardLost(_) => "guard lost",
            LinkReport::HeldUp => "held up",
            LinkReport::Panicked => "panicked",
            _ => "other",
        });
        true
    };
    GuardedLink::open(settings, report).unwrap()
}

fn holds_within(seconds: u64, condition: impl Fn() -> bool) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(seconds) {
        if condition() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    false
}

#[test]
fn a_panic_of_the_thread_is_reported_and_closes_the_pipe() {
    let folder = Folder::new("panic");
    let guard = folder.join("guard");
    let made = Arc::new(Mutex::new(Vec::new()));
    let reports = Arc::clone(&made);
    let link = open(&guard, &[OPENS_PORT, OPENED, HELD_UP, SERVES], move |report| {
        reports.lock().unwrap().push(report.to_owned());
        assert!(report != "held up", "a panic of the thread");
    });
    let has = |report: &str| {
        made.lock().unwrap_or_else(std::sync::PoisonError::into_inner).iter().any(|made| made == report)
    };
    assert!(holds_within(10, || has("panicked")));
    assert!(holds_within(10, || folder.join("guard.ended").exists()), "the guard is not steered on");
    assert!(!link.close(), "nobody knows what was sent");
}

#[test]
fn guards_that_come_to_nothing_are_started_twice_a_second_and_told_once() {
    let folder = Folder::new("nothing");
    let guard = folder.join("guard");
    let lost = Arc::new(Mutex::new(0));
    let count = Arc::clone(&lost);
    // The first guard has served for a while. Those after it say what cannot be read, end at once, and count
    // themselves.
    let first = "if [ -e \"$0.first\" ]; then echo >> \"$0.starts\"; printf '\\377' >&0; exit 2; fi; touch \"$0.first\"";
    let link = open(&guard, &[first, OPENS_PORT, OPENED, "sleep 0.1"], move |report| {
        *count.lock().unwrap() += usize::from(report == "guard lost");
    });
    std::thread::sleep(Duration::from_secs(3));
    drop(link);
    let starts = fs::read(folder.join("guard.starts")).unwrap().len();
    assert!((1..=7).contains(&starts), "{starts} starts");
    assert_eq!(*lost.lock().unwrap(), 2, "the first guard, and the first of those that came to nothing");
}
