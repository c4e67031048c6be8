//! The state as diagnostics. Messages and values are the keys of the API.

use crate::console::api::Snapshot;
use crate::messages::{DiagnosticArray, DiagnosticStatus, Header, KeyValue, Level, Time};

/// What is known of the console.
#[derive(Debug, Clone, PartialEq)]
pub enum ConsoleState {
    /// The console is not reached.
    Away {
        /// Why.
        reason: String,
    },
    /// The console is connected; there is no state yet.
    Connected,
    /// The newest state.
    Known {
        /// The vehicle profile.
        vehicle: String,
        /// The state.
        snapshot: Box<Snapshot>,
    },
}

/// The diagnostics of a node with this name.
pub fn diagnostics(node: &str, console: &ConsoleState, stamp: Time) -> DiagnosticArray {
    let header = Header { stamp, frame_id: String::new() };
    let (level, message) = match console {
        ConsoleState::Away { reason } => (Level::Stale, reason.clone()),
        ConsoleState::Connected | ConsoleState::Known { .. } => (Level::Ok, "connected".to_owned()),
    };
    let mut states = vec![State { of: "console", level, message, values: Vec::new() }];
    let mut hardware = "";
    if let ConsoleState::Known { vehicle, snapshot } = console {
        states.extend([mode(snapshot), video(snapshot), track(snapshot), link(snapshot), alarms(snapshot)]);
        hardware = vehicle;
    }
    let status = states.into_iter().map(|state| state.status(node, hardware)).collect();
    DiagnosticArray { header, status }
}

/// The state of one part.
struct State {
    of: &'static str,
    level: Level,
    message: String,
    /// Values that are not known are left out.
    values: Vec<(&'static str, Option<String>)>,
}

impl State {
    fn status(self, node: &str, hardware: &str) -> DiagnosticStatus {
        let known = self.values.into_iter().filter_map(|(key, value)| Some((key, value?)));
        DiagnosticStatus {
            level: self.level,
            name: format!("{node}: {}", self.of),
            message: self.message,
            hardware_id: hardware.to_owned(),
            values: known.map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect(),
        }
    }
}

fn text(value: impl ToString) -> Option<String> {
    Some(value.to_string())
}

fn mode(Snapshot { mode, command, .. }: &Snapshot) -> State {
    let level = match mode.name.as_str() {
        "holding" | "stopped" => Level::Warn,
        _ => Level::Ok,
    };
    let message =
        mode.cause.as_ref().map_or_else(|| mode.name.clone(), |cause| format!("{}: {cause}", mode.name));
    let values = vec![
        ("mode", text(&mode.name)),
        ("cause", mode.cause.clone()),
        ("engaged", text(mode.engaged)),
        ("pan_rad_per_s", text(command.pan)),
        ("tilt_rad_per_s", text(command.tilt)),
    ];
    State { of: "mode", level, message, values }
}

fn video(Snapshot { video, .. }: &Snapshot) -> State {
    let level = match (video.state.as_str(), &video.reason) {
        ("up", None) => Level::Ok,
        ("up", Some(_)) | ("connecting", _) => Level::Warn,
        _ => Level::Error,
    };
    let values = vec![
        ("state", text(&video.state)),
        ("frames_per_s", text(video.fps)),
        ("age_ms", video.age_ms.and_then(text)),
    ];
    State { of: "video", level, message: video.reason.clone().unwrap_or_else(|| video.state.clone()), values }
}

fn track(Snapshot { track, .. }: &Snapshot) -> State {
    let level = match track.state.as_str() {
        "tracking" | "unseeded" => Level::Ok,
        _ => Level::Warn,
    };
    let values = vec![
        ("state", text(&track.state)),
        ("confirming", text(track.confirming)),
        ("doubted", text(track.doubted)),
        ("confidence", track.confidence.and_then(text)),
        ("lost_s", track.lost_s.and_then(text)),
    ];
    State { of: "track", level, message: track.state.clone(), values }
}

fn link(Snapshot { link, earth, .. }: &Snapshot) -> State {
    let level = match (link.state.as_str(), link.in_control) {
        ("up", Some(false)) | ("dry-run" | "opening" | "starting", _) => Level::Warn,
        ("up" | "simulated", _) => Level::Ok,
        _ => Level::Error,
    };
    let values = vec![
        ("state", text(&link.state)),
        ("in_control", link.in_control.and_then(text)),
        ("battery_v", link.battery_v.and_then(text)),
        ("earth", text(earth)),
    ];
    State { of: "link", level, message: link.state.clone(), values }
}

fn alarms(Snapshot { alarms, .. }: &Snapshot) -> State {
    let (level, message) = match &alarms[..] {
        [] => (Level::Ok, "none".to_owned()),
        some => (Level::Error, some.join(", ")),
    };
    State { of: "alarms", level, message, values: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_states::{snapshot, tracking};

    /// After a change of the state, the part has this level and message.
    #[track_caller]
    fn check(change: impl FnOnce(&mut Snapshot), part: &str, level: Level, message: &str) {
        let mut state = snapshot(tracking([0.0; 4], 0.5));
        change(&mut state);
        let console = ConsoleState::Known { vehicle: "fotokite-pro".to_owned(), snapshot: Box::new(state) };
        let array = diagnostics("barrelman", &console, Time::default());
        let found = array.status.iter().find(|status| status.name == format!("barrelman: {part}")).unwrap();
        assert_eq!((found.level, found.message.as_str()), (level, message), "{part}");
        assert_eq!(found.hardware_id, "fotokite-pro");
    }

    #[test]
    fn each_part_has_its_level() {
        check(|_| {}, "console", Level::Ok, "connected");
        check(|_| {}, "mode", Level::Ok, "servoing");
        let stopped = |state: &mut Snapshot| {
            (state.mode.name, state.mode.cause) = ("stopped".to_owned(), Some("operator".to_owned()));
        };
        check(stopped, "mode", Level::Warn, "stopped: operator");
        check(|_| {}, "video", Level::Ok, "up");
        check(|state| state.video.reason = Some("late".to_owned()), "video", Level::Warn, "late");
        check(|state| state.video.state = "lost".to_owned(), "video", Level::Error, "lost");
        check(|_| {}, "track", Level::Ok, "tracking");
        check(|state| state.track.state = "lost".to_owned(), "track", Level::Warn, "lost");
        check(|_| {}, "link", Level::Ok, "up");
        check(|state| state.link.in_control = Some(false), "link", Level::Warn, "up");
        check(|state| state.link.state = "silent".to_owned(), "link", Level::Error, "silent");
        check(|_| {}, "alarms", Level::Ok, "none");
        let alarms =
            |state: &mut Snapshot| state.alarms = vec!["no-video".to_owned(), "link-down".to_owned()];
        check(alarms, "alarms", Level::Error, "no-video, link-down");
    }

    #[test]
    fn a_console_that_is_away_is_stale_and_nothing_else_is_claimed() {
        let away = ConsoleState::Away { reason: "connection refused".to_owned() };
        let array = diagnostics("barrelman", &away, Time::default());
        let [console] = &array.status[..] else { panic!("{array:?}") };
        assert_eq!((console.level, console.message.as_str()), (Level::Stale, "connection refused"));
    }

    #[test]
    fn values_that_are_not_known_are_left_out() {
        let mut state = snapshot(tracking([0.0; 4], 0.5));
        state.link.battery_v = Some(14.5);
        let keys = |state: &Snapshot| {
            let values = link(state).status("barrelman", "").values;
            values.into_iter().map(|pair| pair.key).collect::<Vec<_>>()
        };
        assert_eq!(keys(&state), ["state", "battery_v", "earth"]);
        state.link.battery_v = None;
        assert_eq!(keys(&state), ["state", "earth"]);
    }
}
