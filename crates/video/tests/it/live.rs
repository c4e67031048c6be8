//! Video sources in real time: a file paced by its times, and RTSP from a GStreamer server
//! (`scripts/rtsp_server.py`) that is killed and restarted.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{Duration, Instant};

use barrelman_host::clock::Clock;
use barrelman_video::decoder::UnitDecoder;
use barrelman_video::mode::DecodeMode;
use barrelman_video::{StopError, VideoError, VideoHandle, VideoSink, VideoState, VideoUrl, spawn};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::{CaptureQuality, VideoFrame};

use crate::clips;

/// The output of a source in its order; frames with their time of delivery.
pub(crate) enum Delivered {
    Unit(EncodedUnit),
    Frame(VideoFrame, Timestamp),
    State(VideoState),
}

struct Sink {
    clock: Clock,
    to: Sender<Delivered>,
}

impl VideoSink for Sink {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        let _ = self.to.send(Delivered::Unit(unit.clone()));
    }

    fn on_frame(&mut self, frame: VideoFrame) {
        let _ = self.to.send(Delivered::Frame(frame, self.clock.now()));
    }

    fn on_state(&mut self, state: VideoState) {
        let _ = self.to.send(Delivered::State(state));
    }
}

pub(crate) fn start(url: &str) -> (VideoHandle, Receiver<Delivered>, Clock) {
    let clock = Clock::start();
    let (to, from) = mpsc::channel();
    let handle = spawn(VideoUrl::parse(url).unwrap(), clock, Sink { clock, to }).unwrap();
    (handle, from, clock)
}

fn fixture(name: &str) -> String {
    clips::fixture(name).display().to_string()
}

/// Waits for an output for which `wanted` returns a value, and skips all others.
pub(crate) fn wait_for<T>(
    from: &Receiver<Delivered>,
    within: Duration,
    mut wanted: impl FnMut(Delivered) -> Option<T>,
) -> Option<T> {
    let deadline = Instant::now() + within;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if let Some(value) = wanted(from.recv_timeout(left).ok()?) {
            return Some(value);
        }
    }
}

pub(crate) const SOON: Duration = Duration::from_secs(10);

#[test]
fn a_file_is_played_in_its_own_time_and_ends() {
    let (handle, from, _) = start(&fixture("baseline.mp4"));
    let (mut units, mut frames) = (Vec::new(), Vec::new());
    let ended = wait_for(&from, SOON, |delivered| {
        match delivered {
            Delivered::Unit(unit) => units.push(unit),
            Delivered::Frame(frame, at) => frames.push((frame, at)),
            Delivered::State(VideoState::Ended) => return Some(()),
            Delivered::State(VideoState::Connecting | VideoState::Up) => {}
            Delivered::State(other) => panic!("{other:?}"),
        }
        None
    });
    assert!(ended.is_some());
    assert_eq!((units.len(), frames.len()), (20, 20));
    let first = frames[0].0.capture.at;
    for (index, (frame, at)) in frames.iter().enumerate() {
        assert_eq!(frame.capture.at.since(first), Duration::from_millis(40 * index as u64));
        assert_eq!(frame.capture.quality, CaptureQuality::Sender);
        assert!(*at >= frame.capture.at, "frame {index} came before its time");
    }
    assert_eq!(handle.stop(), Ok(()));
}

#[test]
fn a_file_that_cannot_be_shown_fails_by_name() {
    for (file, named) in [("hevc.mp4", "HEVC"), ("interlaced.mp4", "interlaced"), ("absent.mp4", "no file")] {
        let (handle, from, _) = start(&fixture(file));
        let error = wait_for(&from, SOON, |delivered| match delivered {
            Delivered::State(VideoState::Failed(error)) => Some(error.to_string()),
            _ => None,
        });
        assert!(error.as_ref().is_some_and(|error| error.contains(named)), "{file}: {error:?}");
        assert_eq!(handle.stop(), Ok(()));
    }
}

#[test]
fn a_source_stops_at_once_when_told_to() {
    // The second picture is 4 s away, and would be shown then.
    let (handle, from, _) = start(&format!("{}?fps=0.25", fixture("png")));
    let frame = |delivered| matches!(delivered, Delivered::Frame(..)).then_some(());
    assert!(wait_for(&from, SOON, frame).is_some());
    // `stop` waits at most 2 s, less than the 4 s to the next picture: a source that waits for it does not
    // end well.
    assert_eq!(handle.stop(), Ok(()));
}

#[test]
fn a_panic_of_the_thread_is_seen_when_it_is_stopped() {
    let (handle, from, _) = start(&format!("{}?fault=panic@0.1", fixture("baseline.mp4")));
    // The panic drops the sink with its channel.
    assert!(wait_for(&from, SOON, |_| None::<()>).is_none());
    assert_eq!(handle.stop(), Err(StopError::Panicked));
}

#[test]
fn dropped_units_are_not_shown_and_the_rest_is_intact() {
    let (_handle, from, _) = start(&format!("{}?fault=drop@0.1+0.1", fixture("baseline.mp4")));
    let mut frames = 0;
    let ended = wait_for(&from, SOON, |delivered| match delivered {
        Delivered::Frame(..) => {
            frames += 1;
            None
        }
        Delivered::State(VideoState::Ended) => Some(()),
        _ => None,
    });
    assert!(ended.is_some() && (10..20).contains(&frames), "{frames}");
}

/// A GStreamer RTSP server in a process of its own, which is killed when the value is dropped.
struct Server {
    process: Child,
    url: String,
}

impl Server {
    fn script() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/rtsp_server.py")
    }

    /// Whether the server's dependencies are installed. In CI they must be.
    fn is_available() -> bool {
        let check = Command::new("/usr/bin/python3").arg(Self::script()).arg("--check").output();
        let reason = match check {
            Ok(check) if check.status.success() => return true,
            Ok(check) => String::from_utf8_lossy(&check.stderr).trim().to_owned(),
            Err(error) => error.to_string(),
        };
        clips::skip(&format!("GStreamer's RTSP server is not there: {reason}"));
        false
    }

    fn start(port: &str, more: &[&str]) -> Self {
        let mut process = Command::new("/usr/bin/python3")
            .arg(Self::script())
            .args(["--port", port, "--size", "160x120", "--fps", "25"])
            .args(more)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut url).unwrap();
        Self { process, url: url.trim().to_owned() }
    }

    fn port(&self) -> String {
        let (_, rest) = self.url.rsplit_once(':').unwrap();
        rest.split('/').next().unwrap().to_owned()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Waits for `count` frames. The panic message lists the states that came instead.
fn frames(from: &Receiver<Delivered>, count: usize, within: Duration) -> Vec<(VideoFrame, Timestamp)> {
    let mut frames = Vec::new();
    let mut states = Vec::new();
    let all = wait_for(from, within, |delivered| {
        match delivered {
            Delivered::Frame(frame, at) => frames.push((frame, at)),
            Delivered::State(state) => states.push(state),
            Delivered::Unit(_) => {}
        }
        (frames.len() >= count).then_some(())
    });
    assert!(all.is_some(), "{} of {count} frames within {within:?}; {states:?}", frames.len());
    frames
}

#[test]
fn rtsp_frames_flow_and_flow_again_when_the_server_comes_back() {
    if !Server::is_available() {
        return;
    }
    let mut server = Server::start("0", &[]);
    let port = server.port();
    let (handle, from, _) = start(&server.url);
    let shown = frames(&from, 30, SOON);
    assert_eq!(shown[0].0.picture.size(), PictureSize::new(160, 120));
    let (last, at) = shown.last().unwrap();
    assert_eq!(last.capture.quality, CaptureQuality::Sender);
    assert!(last.capture.at <= *at);
    let mut sequence = last.sequence;
    for _ in 0..2 {
        drop(server);
        let lost = wait_for(&from, SOON, |delivered| match delivered {
            Delivered::Frame(frame, _) => {
                sequence = frame.sequence;
                None
            }
            Delivered::State(VideoState::Lost { .. }) => Some(()),
            _ => None,
        });
        assert!(lost.is_some());
        server = Server::start(&port, &[]);
        let again = frames(&from, 10, Duration::from_secs(3));
        assert_eq!(again[0].0.sequence, sequence + 1, "the count goes on");
        sequence = again.last().unwrap().0.sequence;
    }
    assert_eq!(handle.stop(), Ok(()));
}

#[test]
fn units_received_decode_again_to_the_same_frames() {
    if !Server::is_available() {
        return;
    }
    let server = Server::start("0", &[]);
    let (handle, from, _) = start(&server.url);
    let (mut units, mut live) = (Vec::new(), Vec::new());
    wait_for(&from, SOON, |delivered| {
        match delivered {
            Delivered::Unit(unit) => units.push(unit),
            Delivered::Frame(frame, _) => live.push(frame),
            Delivered::State(_) => {}
        }
        (live.len() >= 30).then_some(())
    });
    assert_eq!(handle.stop(), Ok(()));
    let mut again = Vec::new();
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    for unit in &units {
        decoder.decode(unit, &mut |frame| again.push(frame)).unwrap();
    }
    assert_eq!(again.len(), live.len());
    for (again, live) in again.iter().zip(&live) {
        assert_eq!((again.sequence, again.capture), (live.sequence, live.capture));
        assert_eq!(again.picture, live.picture);
    }
}

#[test]
fn an_rtsp_stream_of_another_codec_is_refused_by_name() {
    if !Server::is_available() {
        return;
    }
    let server = Server::start("0", &["--codec", "h265"]);
    let (_handle, from, _) = start(&server.url);
    let error = wait_for(&from, SOON, |delivered| match delivered {
        Delivered::State(VideoState::Failed(error)) => Some(error),
        _ => None,
    });
    assert!(matches!(&error, Some(VideoError::Stream { what, .. }) if what.contains("H265")), "{error:?}");
}

#[test]
fn a_server_that_is_not_there_is_tried_again_and_can_be_given_up() {
    // No server listens on a port that was free a moment ago.
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (handle, from, _) = start(&format!("rtsp://user:secret@{free}/video"));
    let mut attempts = 0;
    let again = wait_for(&from, SOON, |delivered| {
        if let Delivered::State(VideoState::Lost { reason }) = delivered {
            assert!(!reason.contains("secret"), "{reason}");
            attempts += 1;
        }
        (attempts >= 3).then_some(())
    });
    assert!(again.is_some());
    assert_eq!(handle.stop(), Ok(()));
}

#[test]
fn silence_without_an_end_or_an_error_counts_as_lost() {
    if !Server::is_available() {
        return;
    }
    let server = Server::start("0", &[]);
    let (handle, from, _) = start(&format!("{}?fault=stall@1+2.5", server.url));
    frames(&from, 5, SOON);
    let mut last = None;
    let lost = wait_for(&from, SOON, |delivered| match delivered {
        Delivered::Frame(_, at) => {
            last = Some(at);
            None
        }
        Delivered::State(VideoState::Lost { reason }) => Some(reason),
        _ => None,
    });
    assert!(lost.as_ref().is_some_and(|reason| reason.contains("nothing comes")), "{lost:?}");
    let again = frames(&from, 1, SOON);
    let silence = again[0].1.since(last.unwrap());
    assert!(silence > Duration::from_secs(2), "{silence:?}");
    assert_eq!(handle.stop(), Ok(()));
}
