//! `barrelman check`: what is reachable, what is missing, and how to mend it.
//!
//! It opens the port and asks for its lock, as `run` would, but sends nothing.

use std::io::{Write as _, stdout};
use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use anyhow::Result;
use barrelman_vocab::{EncodedUnit, VideoFrame};
use serde::Serialize;

use crate::cli::CheckArgs;
use crate::config::{self, ConfigFile, Configuration};
use crate::link::LinkUrl;
use crate::link::port::Port;
use crate::link::url::Endpoint;
use crate::secrets;
use crate::simulated_source;
use crate::source_url::SourceUrl;
use barrelman_host::clock::Clock;
use barrelman_video::{FileFrames, VideoSink, VideoState, VideoUrl};

/// How long a live source may take to show its first picture.
const FIRST_PICTURE_TIMEOUT: Duration = Duration::from_secs(5);
/// Where the udev rule of this project is installed.
const UDEV_RULE: &str = "/etc/udev/rules.d/70-barrelman.rules";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Verdict {
    Ok,
    Warning,
    Failed,
}

#[derive(Debug, Serialize)]
struct Finding {
    what: String,
    verdict: Verdict,
    details: String,
}

/// Runs the command.
///
/// # Errors
/// If the output cannot be written; what is wrong with the configuration, the video or the link is a finding.
pub fn run(args: &CheckArgs, clock: Clock) -> Result<ExitCode> {
    let mut findings = Vec::new();
    let configuration = configuration(args, &mut findings);
    let video = args.video.clone().or_else(|| configuration.as_ref().and_then(|found| found.video.clone()));
    let link = args.link.clone().or_else(|| configuration.as_ref().and_then(|found| found.link.clone()));
    match video {
        Some(url) => findings.push(check_video(&url, configuration.as_ref(), clock)),
        None => {
            findings.push(finding("video", Verdict::Warning, "none configured: give --video or video.url"))
        }
    }
    match link {
        Some(url) => check_link(&url, &mut findings),
        None => findings.push(finding("link", Verdict::Warning, "none configured: `run` would be a dry run")),
    }
    let mut out = stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&findings)?)?;
    } else {
        for finding in &findings {
            let mark = match finding.verdict {
                Verdict::Ok => "ok     ",
                Verdict::Warning => "warning",
                Verdict::Failed => "FAILED ",
            };
            writeln!(out, "{mark}  {}: {}", finding.what, finding.details)?;
        }
    }
    let failed = findings.iter().any(|finding| finding.verdict == Verdict::Failed);
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn finding(what: impl Into<String>, verdict: Verdict, details: impl Into<String>) -> Finding {
    Finding { what: what.into(), verdict, details: details.into() }
}

fn configuration(args: &CheckArgs, findings: &mut Vec<Finding>) -> Option<Configuration> {
    let file = match &args.config {
        Some(path) => config::read(path),
        None => Ok(ConfigFile::default()),
    };
    let with_login = |mut file: ConfigFile| {
        if let Some(path) = &args.video_login_file {
            (file.video.login_file, file.video.login_env) = (Some(path.clone()), None);
        }
        Configuration::resolve(&file)
    };
    match file.and_then(with_login) {
        Ok(configuration) => {
            findings.push(finding(
                "configuration",
                Verdict::Ok,
                format!("vehicle {}", configuration.profile.name),
            ));
            Some(configuration)
        }
        Err(error) => {
            findings.push(finding("configuration", Verdict::Failed, format!("{error:#}")));
            None
        }
    }
}

fn check_video(url: &str, configuration: Option<&Configuration>, clock: Clock) -> Finding {
    let login = configuration.and_then(|configuration| configuration.video_login.as_ref());
    let parsed = match secrets::source_url(url, login) {
        Ok(parsed) => parsed,
        Err(error) => return finding("video", Verdict::Failed, format!("{error:#}")),
    };
    let shown = format!("video {parsed}");
    let first = match &parsed {
        SourceUrl::Video(url) if !url.is_live() => first_stored_picture(url),
        SourceUrl::Video(_) | SourceUrl::Simulated(_) => first_live_picture(parsed, clock),
    };
    match first {
        Ok(frame) => {
            let picture = &frame.picture;
            finding(shown, Verdict::Ok, format!("{} pictures, {:?}", picture.size(), picture.colour()))
        }
        Err(why) => finding(shown, Verdict::Failed, why),
    }
}

fn first_stored_picture(url: &VideoUrl) -> Result<VideoFrame, String> {
    let mut frames = FileFrames::open(url).map_err(|error| error.to_string())?;
    frames.next_frame().map_err(|error| error.to_string())?.ok_or_else(|| "it holds no picture".to_owned())
}

enum Seen {
    Frame(VideoFrame),
    State(VideoState),
}

struct FirstPicture(SyncSender<Seen>);

impl VideoSink for FirstPicture {
    fn on_unit(&mut self, _unit: &EncodedUnit) {}

    fn on_frame(&mut self, frame: VideoFrame) {
        // Only the first is waited for.
        let _ = self.0.try_send(Seen::Frame(frame));
    }

    fn on_state(&mut self, state: VideoState) {
        let _ = self.0.try_send(Seen::State(state));
    }
}

fn first_live_picture(url: SourceUrl, clock: Clock) -> Result<VideoFrame, String> {
    let (seen, queue) = sync_channel(16);
    let started = match url {
        SourceUrl::Video(url) => barrelman_video::spawn(url, clock, FirstPicture(seen)),
        SourceUrl::Simulated(url) => simulated_source::spawn(&url, clock, FirstPicture(seen)),
    };
    let source = started.map_err(|error| error.to_string())?;
    let result = wait_for_picture(&queue);
    if let Err(error) = source.stop() {
        tracing::warn!("{error}");
    }
    result
}

fn wait_for_picture(queue: &Receiver<Seen>) -> Result<VideoFrame, String> {
    let deadline = Instant::now() + FIRST_PICTURE_TIMEOUT;
    let mut last = "nothing answered".to_owned();
    while let Ok(seen) = queue.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
        match seen {
            Seen::Frame(frame) => return Ok(frame),
            Seen::State(VideoState::Lost { reason }) => last = reason,
            Seen::State(VideoState::Failed(error)) => return Err(error.to_string()),
            Seen::State(VideoState::Connecting | VideoState::Up | VideoState::Ended) => {}
        }
    }
    Err(format!("no picture within {} s: {last}", FIRST_PICTURE_TIMEOUT.as_secs()))
}

fn check_link(url: &str, findings: &mut Vec<Finding>) {
    let parsed = match LinkUrl::parse(url) {
        Ok(parsed) => parsed,
        Err(error) => {
            findings.push(finding("link", Verdict::Failed, error.to_string()));
            return;
        }
    };
    let shown = format!("link {parsed}");
    if parsed.endpoint == Endpoint::SimulatedCamera {
        findings.push(finding(
            shown,
            Verdict::Ok,
            "it moves the camera of the world that --video sim: shows",
        ));
        return;
    }
    findings.push(match Port::open(&parsed.endpoint) {
        Ok(_) => finding(shown, Verdict::Ok, "it opens, and nobody else has it"),
        Err(error) => finding(shown, Verdict::Failed, format!("{:#}", anyhow::Error::from(error))),
    });
    if matches!(parsed.endpoint, Endpoint::Serial { .. }) {
        findings.push(modem_manager());
        findings.push(udev_rule());
    }
}

/// ModemManager opens new serial ports and talks to them as if they were modems.
fn modem_manager() -> Finding {
    let running = std::fs::read_dir("/proc").into_iter().flatten().flatten().any(|entry| {
        std::fs::read_to_string(entry.path().join("comm")).is_ok_and(|name| name.trim() == "ModemManager")
    });
    let guarded = Path::new(UDEV_RULE).exists();
    match (running, guarded) {
        (true, false) => finding(
            "ModemManager",
            Verdict::Warning,
            format!(
                "it runs, and takes new serial ports for modems: install config/udev/70-barrelman.rules as {UDEV_RULE}, \
                 or stop it with `sudo systemctl disable --now ModemManager`"
            ),
        ),
        (true, true) => finding("ModemManager", Verdict::Ok, "it runs, and the udev rule keeps it away"),
        (false, _) => finding("ModemManager", Verdict::Ok, "not running"),
    }
}

fn udev_rule() -> Finding {
    if Path::new(UDEV_RULE).exists() {
        finding("udev rule", Verdict::Ok, format!("{UDEV_RULE} is installed"))
    } else {
        finding(
            "udev rule",
            Verdict::Warning,
            format!(
                "not installed: `sudo cp config/udev/70-barrelman.rules {UDEV_RULE} && sudo udevadm control --reload && \
                 sudo udevadm trigger` gives members of dialout the right to the port"
            ),
        )
    }
}
