//! `barrelman check`: checks the configuration, the video source and the link, and suggests remedies.
//!
//! The check opens the port and takes its lock, as `run` does, but moves nothing: a ground station on a line
//! is sent nothing, other vehicles are asked what they have.

use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use anyhow::Result;
use barrelman_vocab::{EncodedUnit, VideoFrame};

use super::check_detector::check_detector;
use super::check_discover::check_discover;
use super::check_gimbal::check_gimbal;
use super::check_over_http::check_over_http;
use super::check_result::{CheckResult, Verdict, print};
use super::check_share::check_share;
use super::check_tak::check_tak;
use super::run::override_key;
use crate::cli::{CheckArgs, ConnectionOptions};
use crate::config::lens::misfit;
use crate::config::{ConfigFile, Configuration};
use crate::encrypted_video;
use crate::link::LinkUrl;
use crate::link::port::Port;
use crate::link::url::Endpoint;
use crate::secrets;
use crate::simulated_source;
use crate::source_url::SourceUrl;
use barrelman_host::clock::Clock;
use barrelman_link_http::Trust;
use barrelman_video::media::{self, CodedFormat, DecoderElement, MediaProgram};
use barrelman_video::{VideoFrames, VideoSink, VideoState, VideoUrl};

/// How long a live source may take to deliver its first picture: 5 s by the built-in engine, 5 s to connect
/// by GStreamer, and up to 5 s to the next key frame.
const FIRST_PICTURE_TIMEOUT: Duration = Duration::from_secs(15);
/// Where this project's udev rule is when it was installed by hand.
const UDEV_RULE: &str = "/etc/udev/rules.d/70-barrelman.rules";
/// Where the rule may be: installed by hand, or by the package.
pub(super) const UDEV_RULES: [&str; 2] = [UDEV_RULE, "/usr/lib/udev/rules.d/70-barrelman.rules"];

/// Whether the vehicle at this link is asked for its own video, whose check is part of the link's.
fn names_its_video(link: &str) -> bool {
    LinkUrl::parse(link).is_ok_and(|url| matches!(url.endpoint, Endpoint::Http(_)))
}

/// Runs the command.
///
/// # Errors
/// If the output cannot be written. A problem of the configuration, the video or the link is a result, not an
/// error.
pub fn run(args: &CheckArgs, clock: Clock) -> Result<ExitCode> {
    let mut results = Vec::new();
    let configuration = check_configuration(args, &mut results);
    let ConnectionOptions { video: given, link, .. } = &args.connection;
    let videos = match (given.as_slice(), &configuration) {
        ([], Some(found)) => found.video_urls(),
        _ => given.clone(),
    };
    let link = link.clone().or_else(|| configuration.as_ref().and_then(|found| found.link.clone()));
    results.push(check_decoders());
    results.extend(args.discover.into_iter().flat_map(check_discover));
    if videos.is_empty() && !link.as_deref().is_some_and(names_its_video) {
        let details = "none configured: give --video or video.url";
        results.push(CheckResult::new("video", Verdict::Warning, details));
    }
    results.extend(videos.iter().map(|url| check_video(url, configuration.as_ref(), clock)));
    match link {
        Some(url) => check_link(&url, configuration.as_ref(), clock, &mut results),
        None => {
            let details = "none configured: `run` would be a dry run";
            results.push(CheckResult::new("link", Verdict::Warning, details));
        }
    }
    if let Some(found) = configuration {
        results.extend(found.tak.address.as_ref().map(|address| check_tak(address, &found.tak)));
        results.extend(found.share.as_ref().map(check_share));
        results.extend(found.detector.as_ref().map(check_detector));
    }
    print(&results, args.json)
}

fn check_configuration(args: &CheckArgs, results: &mut Vec<CheckResult>) -> Option<Configuration> {
    let with_options = |mut file: ConfigFile| {
        override_key(&mut file.vehicle.profile, &args.profile);
        override_key(&mut file.tak.address, &args.tak);
        override_key(&mut file.share.address, &args.share);
        override_key(&mut file.detector.model, &args.detector);
        Configuration::resolve(&file)
    };
    match args.connection.config_file().and_then(with_options) {
        Ok(configuration) => {
            let details = format!("vehicle {}", configuration.profile.name);
            results.push(CheckResult::new("configuration", Verdict::Ok, details));
            Some(configuration)
        }
        Err(error) => {
            results.push(CheckResult::new("configuration", Verdict::Failed, format!("{error:#}")));
            None
        }
    }
}

/// What can be decoded, and by which part.
pub(super) fn check_decoders() -> CheckResult {
    let Some(program) = MediaProgram::installed() else {
        let installation = MediaProgram::INSTALLATION;
        let details = format!("H.264, JPEG, PNG: built in. barrelman-media decodes the rest: {installation}");
        return CheckResult::new("decoders", Verdict::Ok, details);
    };
    match media::decoders(&program) {
        Ok(list) => {
            let of = |(format, element): &(CodedFormat, Option<DecoderElement>)| match element {
                Some(DecoderElement { name, is_hardware: true }) => {
                    format!("{}: {name} (hardware)", format.name())
                }
                Some(DecoderElement { name, is_hardware: false }) => format!("{}: {name}", format.name()),
                None => format!("{}: none", format.name()),
            };
            let media: Vec<_> = list.decoders.iter().map(of).collect();
            let details =
                format!("H.264, JPEG, PNG: built in. GStreamer {}: {}", list.version, media.join(", "));
            CheckResult::new("decoders", Verdict::Ok, details)
        }
        Err(error) => CheckResult::new("decoders", Verdict::Warning, error.to_string()),
    }
}

fn check_video(url: &str, configuration: Option<&Configuration>, clock: Clock) -> CheckResult {
    let login = configuration.map(|configuration| configuration.video_login.clone()).unwrap_or_default();
    let is_second =
        configuration.and_then(|found| found.second_video.as_ref()).is_some_and(|second| second.url == url);
    let read = if is_second { secrets::second_source_url } else { secrets::source_url };
    let mut parsed = match read(url, &login) {
        Ok(parsed) => parsed,
        Err(error) => return CheckResult::new("video", Verdict::Failed, format!("{error:#}")),
    };
    if let (SourceUrl::Video(url), Some(configuration)) = (&mut parsed, configuration) {
        url.engine = configuration.video_engine;
    }
    let files = configuration.map(|configuration| configuration.video_trust.clone()).unwrap_or_default();
    let trust = match secrets::trust(&files) {
        Ok(trust) => trust,
        Err(error) => return CheckResult::new("video", Verdict::Failed, format!("{error:#}")),
    };
    let subject = format!("video {parsed}");
    let first = match &parsed {
        SourceUrl::Video(url) if !url.is_live() => first_stored_picture(url),
        SourceUrl::Video(_) | SourceUrl::Simulated(_) => first_live_picture(parsed, &trust, clock),
    };
    match first {
        Ok(frame) => {
            let picture = &frame.picture;
            let lens = configuration.and_then(|configuration| configuration.profile.camera.lens);
            if let Some(misfit) = lens.and_then(|lens| misfit(&lens, picture.size())) {
                return CheckResult::new(subject, Verdict::Failed, misfit);
            }
            let details = format!("{} pictures, colours as {}", picture.size(), picture.colour());
            CheckResult::new(subject, Verdict::Ok, details)
        }
        Err(reason) => CheckResult::new(subject, Verdict::Failed, reason),
    }
}

fn first_stored_picture(url: &VideoUrl) -> Result<VideoFrame, String> {
    let mut frames = VideoFrames::open(url).map_err(|error| error.to_string())?;
    frames
        .next_frame()
        .map_err(|error| error.to_string())?
        .ok_or_else(|| "the video has no picture".to_owned())
}

/// What a live source delivers.
enum Delivery {
    Frame(VideoFrame),
    State(VideoState),
}

/// Sends the first deliveries of a live source to a queue.
struct FirstDeliveries(SyncSender<Delivery>);

impl VideoSink for FirstDeliveries {
    fn on_unit(&mut self, _unit: &EncodedUnit) {}

    fn on_frame(&mut self, frame: VideoFrame) {
        // Only the first frame matters: a full queue holds it already.
        let _ = self.0.try_send(Delivery::Frame(frame));
    }

    fn on_state(&mut self, state: VideoState) {
        let _ = self.0.try_send(Delivery::State(state));
    }
}

fn first_live_picture(url: SourceUrl, trust: &Trust, clock: Clock) -> Result<VideoFrame, String> {
    let (deliveries, queue) = sync_channel(16);
    let started = match url {
        SourceUrl::Video(url) => encrypted_video::spawn(url, trust, clock, FirstDeliveries(deliveries)),
        SourceUrl::Simulated(url) => {
            simulated_source::spawn(&url, clock, FirstDeliveries(deliveries)).map_err(Into::into)
        }
    };
    let source = started.map_err(|error| format!("{error:#}"))?;
    let result = wait_for_picture(&queue);
    if let Err(error) = source.stop() {
        tracing::warn!("{error}");
    }
    result
}

fn wait_for_picture(queue: &Receiver<Delivery>) -> Result<VideoFrame, String> {
    let deadline = Instant::now() + FIRST_PICTURE_TIMEOUT;
    let mut reason = "no answer".to_owned();
    while let Ok(delivery) = queue.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
        match delivery {
            Delivery::Frame(frame) => return Ok(frame),
            Delivery::State(VideoState::Lost { reason: newest }) => reason = newest,
            Delivery::State(VideoState::Failed(error)) => return Err(error.to_string()),
            Delivery::State(VideoState::Connecting | VideoState::Up | VideoState::Ended) => {}
        }
    }
    Err(format!("no picture within {} s: {reason}", FIRST_PICTURE_TIMEOUT.as_secs()))
}

fn check_link(
    url: &str,
    configuration: Option<&Configuration>,
    clock: Clock,
    results: &mut Vec<CheckResult>,
) {
    let parsed = match LinkUrl::parse(url) {
        Ok(parsed) => parsed,
        Err(error) => {
            results.push(CheckResult::new("link", Verdict::Failed, error.to_string()));
            return;
        }
    };
    if let Endpoint::Http(address) = &parsed.endpoint {
        check_over_http(address, configuration, results);
        return;
    }
    let subject = format!("link {parsed}");
    if parsed.endpoint == Endpoint::SimulatedCamera {
        let details = "moves the camera of the simulated world of --video sim:";
        results.push(CheckResult::new(subject, Verdict::Ok, details));
        return;
    }
    match Port::open(&parsed.endpoint) {
        Ok(port) => {
            results.push(CheckResult::new(subject, Verdict::Ok, "opens, and no other program uses the port"));
            if let Some(configuration) = configuration {
                check_gimbal(port, configuration, clock, results);
            }
        }
        Err(error) => {
            let details = format!("{:#}", anyhow::Error::from(error));
            results.push(CheckResult::new(subject, Verdict::Failed, details));
        }
    }
    if matches!(parsed.endpoint, Endpoint::Serial { .. }) {
        let rules = UDEV_RULES.map(Path::new);
        results.push(check_modem_manager(&rules));
        results.push(check_udev_rule(&rules));
    }
}

/// ModemManager opens new serial ports and sends modem commands to them. `rules`: where the udev rule may be.
pub(super) fn check_modem_manager(rules: &[&Path]) -> CheckResult {
    let is_running = std::fs::read_dir("/proc").into_iter().flatten().flatten().any(|entry| {
        std::fs::read_to_string(entry.path().join("comm")).is_ok_and(|name| name.trim() == "ModemManager")
    });
    let has_rule = rules.iter().any(|rule| rule.exists());
    let (verdict, details) = match (is_running, has_rule) {
        (true, false) => (
            Verdict::Warning,
            format!(
                "running: it opens new serial ports as modems; install config/udev/70-barrelman.rules as {UDEV_RULE}, \
                 or stop ModemManager with `sudo systemctl disable --now ModemManager`"
            ),
        ),
        (true, true) => (Verdict::Ok, "running, but the udev rule excludes the port".to_owned()),
        (false, _) => (Verdict::Ok, "not running".to_owned()),
    };
    CheckResult::new("ModemManager", verdict, details)
}

/// Whether one of these rules is installed.
pub(super) fn check_udev_rule(rules: &[&Path]) -> CheckResult {
    let (verdict, details) = if let Some(rule) = rules.iter().find(|rule| rule.exists()) {
        (Verdict::Ok, format!("{} is installed", rule.display()))
    } else {
        (
            Verdict::Warning,
            format!(
                "not installed: `sudo cp config/udev/70-barrelman.rules {UDEV_RULE} && sudo udevadm control --reload && \
                 sudo udevadm trigger` gives members of dialout access to the port"
            ),
        )
    };
    CheckResult::new("udev rule", verdict, details)
}
