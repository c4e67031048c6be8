//! The thread of a tracking camera: one port, the newest snapshot, and the answers of the gateway.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::thread::JoinHandle;
use std::time::Duration;

use barrelman_console_server::operator::{Answer, Gateway, SessionRequest};
use barrelman_console_server::snapshot::SharedSnapshot;
use barrelman_host::clock::Clock;
use barrelman_link::Waker;
use barrelman_link::port_io::poll_for;
use barrelman_vocab::{CameraRequest, DrawnSelection, OperatorRequest, Tap, Timestamp, VideoNumber};
use barrelman_wire::mavlink::TrackingCamera;
use barrelman_wire::mavlink::tracking_camera::{RequestNumber, TrackingAnswer, TrackingRequest};
use rustix::event::{PollFd, PollFlags};
use tokio::sync::oneshot::{self, error::TryRecvError};
use tokio::sync::watch;

use super::TrackingCameraSetup;
use super::view::view;
use crate::link::port::Port;
use crate::live::event::Event;
use crate::live::threads::spawn;

/// Pause before a port is opened again.
const REOPEN_PAUSE: Duration = Duration::from_secs(1);
/// Answers of the gateway are looked for at this interval while some are due.
const ANSWER_INTERVAL: Duration = Duration::from_millis(20);
/// Largest part of a stream, and largest datagram, that is read at once, bytes.
const MAX_READ_BYTES: usize = 2048;

/// The parts of a run that a tracking camera uses.
pub struct CameraParts {
    /// Takes the requests.
    pub gateway: Arc<Gateway>,
    /// The state after each step.
    pub snapshots: watch::Receiver<SharedSnapshot>,
    /// The clock.
    pub clock: Clock,
}

/// A running tracking camera. Dropping it closes the port.
#[derive(Debug)]
pub struct TrackingCameraThread {
    waker: Arc<Waker>,
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl TrackingCameraThread {
    /// Starts the thread. A port that cannot be opened is tried again.
    ///
    /// # Errors
    /// If the system has no more threads or descriptors.
    pub fn start(
        setup: TrackingCameraSetup,
        parts: CameraParts,
        events: SyncSender<Event>,
    ) -> io::Result<Self> {
        let waker = Arc::new(Waker::new()?);
        let is_ended = Arc::new(AtomicBool::new(false));
        let work = Work { setup, parts, waker: Arc::clone(&waker), is_ended: Arc::clone(&is_ended) };
        let thread = spawn("mavlink", events, move || work.run())?;
        Ok(Self { waker, is_ended, thread: Some(thread) })
    }
}

impl Drop for TrackingCameraThread {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Relaxed);
        self.waker.wake();
        if let Some(thread) = self.thread.take() {
            // A panic was reported as an event.
            let _ = thread.join();
        }
    }
}

/// A request that the gateway has not answered yet.
type Waiting = (RequestNumber, oneshot::Receiver<Answer>);

struct Work {
    setup: TrackingCameraSetup,
    parts: CameraParts,
    waker: Arc<Waker>,
    is_ended: Arc<AtomicBool>,
}

impl Work {
    fn run(self) {
        let TrackingCameraSetup { settings, description, signing, .. } = &self.setup;
        let mut camera = TrackingCamera::new(*settings, description.clone(), *signing);
        let mut waiting = Vec::new();
        // A ground station that is not there yet is told once.
        let mut is_told = false;
        while !self.is_ended.load(Ordering::Relaxed) {
            let served =
                Port::open(&self.setup.endpoint).map_err(|error| error.to_string()).and_then(|mut port| {
                    self.serve(&mut port, &mut camera, &mut waiting, &mut is_told)
                        .map_err(|error| error.to_string())
                });
            if let Err(error) = served {
                if !is_told {
                    tracing::warn!("no ground station on --mavlink yet ({error}): trying again every second");
                    is_told = true;
                }
                self.wait(None, REOPEN_PAUSE);
            }
        }
    }

    /// Serves an open port until the run ends.
    ///
    /// # Errors
    /// If the port is lost.
    fn serve(
        &self,
        port: &mut Port,
        camera: &mut TrackingCamera,
        waiting: &mut Vec<Waiting>,
        is_told: &mut bool,
    ) -> io::Result<()> {
        let mut out = Vec::new();
        let mut buffer = [0; MAX_READ_BYTES];
        while !self.is_ended.load(Ordering::Relaxed) {
            let now = self.parts.clock.now();
            camera.show(view(&self.parts.snapshots.borrow(), now));
            give_answers(camera, waiting, now);
            let next = camera.poll(now, &mut out);
            for packet in out.drain(..) {
                port.write_all(&packet)?;
            }
            let wait = next.since(self.parts.clock.now());
            let wait = if waiting.is_empty() { wait } else { wait.min(ANSWER_INTERVAL) };
            if !self.wait(Some(port), wait) {
                continue;
            }
            let read = port.read(&mut buffer)?;
            if read > 0 && std::mem::take(is_told) {
                tracing::info!("a ground station answers on --mavlink");
            }
            let now = self.parts.clock.now();
            camera.received(&buffer[..read], now, &mut |number, request| {
                waiting.push((number, self.submit(request)));
            });
        }
        Ok(())
    }

    /// Submits a request. Ground stations show the first video: a selection is refused while the other one is
    /// followed.
    fn submit(&self, request: TrackingRequest) -> oneshot::Receiver<Answer> {
        let is_shown = self.parts.snapshots.borrow().video.number == VideoNumber::First;
        if is_shown || matches!(request, TrackingRequest::Forget) {
            return self.parts.gateway.submit(self.request(request));
        }
        let (answer, receiver) = oneshot::channel();
        let _ = answer.send(Answer::Refused("the boat is followed in the other video".to_owned()));
        receiver
    }

    /// The request to the pilot. A selection names the video frame that the ground station shows.
    fn request(&self, request: TrackingRequest) -> SessionRequest {
        let newest = self.parts.snapshots.borrow().video.frame;
        let captured = newest.map_or(Timestamp::ZERO, |(captured, _)| captured);
        let captured_ns = captured.minus(self.setup.display_delay);
        SessionRequest::Pilot(OperatorRequest::Camera(match request {
            TrackingRequest::Forget => CameraRequest::Deselect,
            TrackingRequest::Select(bounds) => CameraRequest::Select(DrawnSelection { bounds, captured_ns }),
            TrackingRequest::SelectAt(at) => CameraRequest::Propose(Tap { at, captured_ns, take: true }),
        }))
    }

    /// Waits until something arrives at `port`, or the run ends, at most for `wait`. Returns whether the port
    /// is readable.
    fn wait(&self, port: Option<&Port>, wait: Duration) -> bool {
        let waker = PollFd::new(&*self.waker, PollFlags::IN);
        let Some(port) = port else {
            poll_for(&mut [waker], wait);
            return false;
        };
        let mut fds = [waker, PollFd::new(port, PollFlags::IN)];
        poll_for(&mut fds, wait);
        !fds[1].revents().is_empty()
    }
}

/// Passes the answers that the gateway has given to the camera.
fn give_answers(camera: &mut TrackingCamera, waiting: &mut Vec<Waiting>, now: Timestamp) {
    waiting.retain_mut(|(number, receiver)| {
        let answer = match receiver.try_recv() {
            Ok(Answer::Accepted(_)) => TrackingAnswer::Accepted,
            Ok(Answer::Refused(reason)) => TrackingAnswer::Refused(reason),
            Ok(Answer::Superseded(_)) => TrackingAnswer::Superseded,
            Err(TryRecvError::Closed) => TrackingAnswer::Refused("the run has ended".to_owned()),
            Err(TryRecvError::Empty) => return true,
        };
        camera.answered(*number, &answer, now);
        false
    });
}
