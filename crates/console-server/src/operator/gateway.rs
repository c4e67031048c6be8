//! The gateway: a bounded queue of requests, the stop latch, whether the controlling page is gone, and how
//! the loop is woken.

use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use barrelman_pilot::VesselMode;
use barrelman_vocab::{
    NoteRequest, OperatorRequest, StopCause, Timestamp, VesselRequest, VesselStopper, VideoRequest,
    WorldRequest,
};
use tokio::sync::oneshot;

use super::answer::{Answer, AnswerSlot};
use super::stop_latch::StopLatch;

/// Capacity of the queue of requests. The loop empties the queue before each event.
const CAPACITY: usize = 64;

/// What an operator can request of a session.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionRequest {
    /// A request to the pilot.
    Pilot(OperatorRequest),
    /// A request about the simulated world.
    World(WorldRequest),
    /// A request about the choice between two videos.
    Video(VideoRequest),
    /// A request about the recording.
    Note(NoteRequest),
}

/// A request that waits for the loop.
#[derive(Debug)]
pub struct Submitted {
    /// The request.
    pub request: SessionRequest,
    /// Where the answer goes.
    pub answer: AnswerSlot,
}

/// Takes requests from any thread.
pub struct Gateway {
    stop: StopLatch,
    queue: Mutex<VecDeque<Submitted>>,
    is_console_lost: AtomicBool,
    /// Until when a page watches over the boat, ns of the program's clock.
    vessel_watched_until: AtomicU64,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl fmt::Debug for Gateway {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Gateway")
            .field("stop", &self.stop)
            .field("queue", &self.queue)
            .finish_non_exhaustive()
    }
}

impl Gateway {
    /// A gateway that wakes the loop by `wake`, which must not block.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            stop: StopLatch::default(),
            queue: Mutex::default(),
            is_console_lost: AtomicBool::new(false),
            vessel_watched_until: AtomicU64::new(0),
            wake: Box::new(wake),
        }
    }

    /// Presses Stop. Cannot be refused. Returns the number of the press.
    pub fn stop(&self) -> u64 {
        let press = self.stop.press();
        (self.wake)();
        press
    }

    /// The stop latch.
    pub const fn stop_latch(&self) -> &StopLatch {
        &self.stop
    }

    /// The controlling page is gone, or a page controls again.
    pub fn set_console_lost(&self, is_lost: bool) {
        if self.is_console_lost.swap(is_lost, Ordering::Relaxed) != is_lost {
            (self.wake)();
        }
    }

    /// Whether the controlling page is gone.
    pub fn is_console_lost(&self) -> bool {
        self.is_console_lost.load(Ordering::Relaxed)
    }

    /// Until when a page watches over the boat, by the program's clock; `None`: no page does. It has to be
    /// said again before that time: where the thread of the pages hangs, the boat is left.
    pub(crate) fn watch_vessel_until(&self, until: Option<Timestamp>) {
        self.vessel_watched_until.store(until.unwrap_or(Timestamp::ZERO).as_nanos(), Ordering::Relaxed);
    }

    /// The request to stop a boat that moves by this program's command, while no page watches over it. `now`:
    /// of the program's clock.
    pub fn stop_for_left_vessel(&self, mode: VesselMode, now: Timestamp) -> Option<OperatorRequest> {
        let is_left = now.as_nanos() > self.vessel_watched_until.load(Ordering::Relaxed);
        (is_under_way(mode) && is_left)
            .then_some(OperatorRequest::Vessel(VesselRequest::StopVessel { by: VesselStopper::ConsoleLost }))
    }

    /// Lets the loop look at once at what has changed.
    pub(crate) fn wake(&self) {
        (self.wake)();
    }

    /// Submits a request. The receiver gets the answer; without one, the session has ended. A stop of the
    /// operator goes to the latch and is answered at once: it is taken before any request.
    pub fn submit(&self, request: SessionRequest) -> oneshot::Receiver<Answer> {
        let (answer, receiver) = AnswerSlot::new();
        self.submit_with(request, answer);
        receiver
    }

    /// Submits a request of the terminal or of the program itself; a refusal is logged.
    pub fn submit_logged(&self, request: OperatorRequest) {
        self.submit_with(SessionRequest::Pilot(request), AnswerSlot::logged());
    }

    fn submit_with(&self, request: SessionRequest, answer: AnswerSlot) {
        if let SessionRequest::Pilot(OperatorRequest::Stop(StopCause::Operator)) = request {
            self.stop();
            return answer.give(Answer::ACCEPTED);
        }
        let mut queue = self.queue();
        if queue.len() >= CAPACITY {
            drop(queue);
            return answer.give(Answer::Refused("too many requests are waiting; retry".to_owned()));
        }
        queue.push_back(Submitted { request, answer });
        drop(queue);
        (self.wake)();
    }

    /// The next request, oldest first.
    pub fn next_request(&self) -> Option<Submitted> {
        self.queue().pop_front()
    }

    /// Refuses all requests that wait, as they were made before a stop.
    pub fn refuse_waiting(&self) {
        let waiting = std::mem::take(&mut *self.queue());
        for submitted in waiting {
            submitted.answer.give(Answer::Superseded("stopped".to_owned()));
        }
    }

    fn queue(&self) -> MutexGuard<'_, VecDeque<Submitted>> {
        // Each change is one call: a panic elsewhere leaves the queue whole.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether a boat in this mode moves by this program's command.
pub(crate) const fn is_under_way(mode: VesselMode) -> bool {
    matches!(
        mode,
        VesselMode::ByHand | VesselMode::Guided | VesselMode::Holding(_) | VesselMode::KeepingWay(_)
    )
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use barrelman_vocab::CameraRequest;

    use super::*;

    const ENGAGE: SessionRequest = SessionRequest::Pilot(OperatorRequest::Camera(CameraRequest::Engage));

    #[test]
    fn a_full_queue_refuses_requests_but_never_a_stop() {
        let gateway = Gateway::new(|| {});
        for _ in 0..CAPACITY {
            gateway.submit(ENGAGE);
        }
        let mut refused = gateway.submit(ENGAGE);
        assert!(matches!(refused.try_recv(), Ok(Answer::Refused(_))));
        assert_eq!(gateway.stop(), 1);
        assert_eq!(gateway.stop_latch().pending(), Some(1));
    }

    #[test]
    fn requests_come_out_in_their_order_and_a_stop_supersedes_them() {
        let gateway = Gateway::new(|| {});
        gateway.submit(ENGAGE);
        let mut second =
            gateway.submit(SessionRequest::Pilot(OperatorRequest::Camera(CameraRequest::Disengage)));
        assert_eq!(gateway.next_request().map(|submitted| submitted.request), Some(ENGAGE));
        gateway.refuse_waiting();
        assert!(matches!(second.try_recv(), Ok(Answer::Superseded(_))));
        assert!(gateway.next_request().is_none());
    }

    const STOP: SessionRequest = SessionRequest::Pilot(OperatorRequest::Stop(StopCause::Operator));

    #[test]
    fn a_stop_is_never_queued_and_is_accepted_at_once() {
        let gateway = Gateway::new(|| {});
        for _ in 0..CAPACITY + 1 {
            gateway.submit(ENGAGE);
        }
        let mut answer = gateway.submit(STOP);
        assert_eq!(answer.try_recv(), Ok(Answer::ACCEPTED));
        assert_eq!(gateway.stop_latch().pending(), Some(1));
        let queued = std::iter::from_fn(|| gateway.next_request()).map(|submitted| submitted.request);
        assert_eq!(queued.collect::<Vec<_>>(), [ENGAGE; CAPACITY]);
    }

    #[test]
    fn a_full_queue_has_room_again_after_a_request_was_taken() {
        let gateway = Gateway::new(|| {});
        let mut waiting: Vec<_> = (0..CAPACITY).map(|_| gateway.submit(ENGAGE)).collect();
        assert!(waiting.iter_mut().all(|answer| answer.try_recv().is_err()), "none is answered yet");
        let refused = gateway.submit(ENGAGE).try_recv();
        assert_eq!(refused, Ok(Answer::Refused("too many requests are waiting; retry".to_owned())));
        gateway.next_request();
        assert!(gateway.submit(ENGAGE).try_recv().is_err(), "it waits");
    }

    #[test]
    fn each_request_wakes_the_loop() {
        let (wakes, woken) = channel();
        let gateway = Gateway::new(move || wakes.send(()).unwrap());
        gateway.submit(ENGAGE);
        gateway.stop();
        gateway.set_console_lost(true);
        gateway.set_console_lost(true);
        assert_eq!(woken.try_iter().count(), 3);
    }

    #[test]
    fn a_boat_under_way_is_stopped_at_the_time_until_which_a_page_watches() {
        let gateway = Gateway::new(|| {});
        let at = |ms: u64| Timestamp::from_nanos(ms * 1_000_000);
        let stops = |mode, ms| gateway.stop_for_left_vessel(mode, at(ms)).is_some();
        assert!(stops(VesselMode::Guided, 1), "no page has come");
        gateway.watch_vessel_until(Some(at(1000)));
        assert!(!stops(VesselMode::Guided, 1000));
        assert!(stops(VesselMode::Guided, 1001) && stops(VesselMode::ByHand, 1001), "nobody has to say so");
        assert!(!stops(VesselMode::Neutral, 1001) && !stops(VesselMode::Released, 1001));
        gateway.watch_vessel_until(Some(at(2000)));
        assert!(!stops(VesselMode::Guided, 1001));
        gateway.watch_vessel_until(None);
        assert!(stops(VesselMode::Guided, 1001));
    }

    #[test]
    fn a_request_whose_reader_is_gone_is_still_taken() {
        let gateway = Gateway::new(|| {});
        drop(gateway.submit(ENGAGE));
        let submitted = gateway.next_request().unwrap();
        assert_eq!(submitted.request, ENGAGE);
        submitted.answer.give(Answer::ACCEPTED);
    }

    #[test]
    fn the_end_of_the_session_ends_every_wait() {
        let gateway = Gateway::new(|| {});
        let mut waiting = gateway.submit(ENGAGE);
        gateway.submit_logged(OperatorRequest::Camera(CameraRequest::Disengage));
        drop(gateway);
        assert_eq!(waiting.try_recv(), Err(oneshot::error::TryRecvError::Closed));
    }

    #[test]
    fn stops_that_the_program_makes_itself_keep_their_place_and_cause() {
        let gateway = Gateway::new(|| {});
        for cause in [StopCause::Ending, StopCause::VideoEnded, StopCause::Fault] {
            gateway.submit_logged(OperatorRequest::Stop(cause));
            let request = gateway.next_request().map(|submitted| submitted.request);
            assert_eq!(request, Some(SessionRequest::Pilot(OperatorRequest::Stop(cause))));
        }
        assert_eq!(gateway.stop_latch().pending(), None);
        gateway.submit_logged(OperatorRequest::Stop(StopCause::Operator));
        assert_eq!(gateway.stop_latch().pending(), Some(1));
    }
}
