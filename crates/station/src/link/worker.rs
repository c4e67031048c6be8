//! The link thread: one session after the other, on one port.

use std::io;
use std::os::fd::OwnedFd;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use barrelman_vocab::telemetry::{LinkState, Report};
use barrelman_vocab::{Telemetry, Timestamp, VehicleRates};
use barrelman_wire::fotokite_pro::session::{NextAction, STOP_DELAY};
use barrelman_wire::fotokite_pro::{Framing, Session, SessionSettings};
use rustix::event::{EventfdFlags, PollFd, PollFlags, poll};

use super::port::{Port, PortError};
use super::url::LinkUrl;
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultKind;

/// From one attempt to open a lost port to the next.
const REOPEN_PAUSE: Duration = Duration::from_millis(250);
/// How long rates may stay in force after the time by which they were to be renewed: the pilot has then been held
/// up, and the link rests the camera in its place.
pub(crate) const RENEWAL_GRACE: Duration = Duration::from_millis(50);
/// How long the last words may take before the program ends without them.
const CLOSING_TIMEOUT: Duration = Duration::from_secs(3);

/// What the link thread tells the rest of the program.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkReport {
    /// A report of the vehicle, or of the link itself.
    Telemetry(Telemetry),
    /// The port was lost; it is being opened anew.
    Lost(String),
    /// The link thread panicked; zeros and stop were sent by its last will.
    Panicked,
}

/// What the pilot wants of the link, newest first.
#[derive(Debug, Default)]
struct Mailbox {
    rates: VehicleRates,
    /// When rates that move must have been renewed.
    renew_by: Option<Timestamp>,
    close: bool,
    /// Set by the thread once the last words are out, or cannot be said.
    ended: Option<bool>,
}

#[derive(Debug)]
struct Shared {
    mailbox: Mutex<Mailbox>,
    waker: OwnedFd,
}

impl Shared {
    fn with<T>(&self, change: impl FnOnce(&mut Mailbox) -> T) -> T {
        // A panic elsewhere must not silence the link: the mailbox is plain data and always whole.
        change(&mut self.mailbox.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn wake(&self) {
        // The counter only fills up if the thread never wakes, and then another count would not help.
        let _ = rustix::io::write(&self.waker, &1_u64.to_ne_bytes());
    }
}

/// The link, as the rest of the program holds it. Dropping it ends it: zeros, stop, and the port is closed.
#[derive(Debug)]
pub struct LinkHandle {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl LinkHandle {
    /// Opens the port and starts the thread.
    ///
    /// # Errors
    /// If the port cannot be opened now; later losses are mended by the thread.
    pub fn open(
        url: &LinkUrl,
        framing: Framing,
        clock: Clock,
        report: impl Fn(LinkReport) + Send + 'static,
    ) -> anyhow::Result<Self> {
        let port = Port::open(&url.endpoint)?;
        let waker = rustix::event::eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        let shared = Arc::new(Shared { mailbox: Mutex::default(), waker });
        let settings = SessionSettings::for_baud(framing, url.baud());
        let worker = Worker { url: url.clone(), settings, clock, shared: Arc::clone(&shared), report };
        let thread = std::thread::Builder::new().name("link".to_owned()).spawn(move || worker.run(port))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Asks for rates, in the vehicle's own signs; what was asked for before and is not out yet is forgotten.
    /// Rates that move are in force until `renew_by`: where nothing comes by then, the link rests the camera by
    /// itself.
    pub fn send(&self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        let changed = self.shared.with(|mailbox| {
            mailbox.renew_by = renew_by;
            std::mem::replace(&mut mailbox.rates, rates) != rates
        });
        if changed {
            self.shared.wake();
        }
    }

    /// Ends the link: zeros, half a second, stop. Returns whether they were sent.
    pub fn close(mut self) -> bool {
        self.end()
    }

    fn end(&mut self) -> bool {
        let Some(thread) = self.thread.take() else { return true };
        self.shared.with(|mailbox| {
            mailbox.rates = VehicleRates::REST;
            mailbox.close = true;
        });
        self.shared.wake();
        // The thread bounds its own closing; a panic in it has run its last will.
        let joined = thread.join().is_ok();
        joined && self.shared.with(|mailbox| mailbox.ended).unwrap_or(false)
    }
}

impl Drop for LinkHandle {
    fn drop(&mut self) {
        self.end();
    }
}

struct Worker<R> {
    url: LinkUrl,
    settings: SessionSettings,
    clock: Clock,
    shared: Arc<Shared>,
    report: R,
}

impl<R: Fn(LinkReport)> Worker<R> {
    fn run(self, port: Port) {
        let mut port = Some(port);
        let framing = self.settings.framing;
        // The port lives outside of what may panic, so that the last will can still be spoken on it.
        let ended = catch_unwind(AssertUnwindSafe(|| self.serve(&mut port)));
        let said = ended.unwrap_or_else(|_| {
            let said = port.as_mut().is_some_and(|port| send_last_will(port, framing).is_ok());
            (self.report)(LinkReport::Panicked);
            said
        });
        self.shared.with(|mailbox| mailbox.ended = Some(said));
    }

    /// Serves the port until the link is closed. Returns whether the last words were said.
    fn serve(&self, port: &mut Option<Port>) -> bool {
        let mut shown = None;
        let mut first_loss = true;
        loop {
            let Some(open) = port else {
                self.show(LinkState::Opening, &mut shown);
                if self.shared.with(|mailbox| mailbox.close) {
                    // The vehicle keeps its last rate: one more try to reach it.
                    let said = |mut port| send_last_will(&mut port, self.settings.framing).is_ok();
                    return self.reopen().is_ok_and(said);
                }
                match self.reopen() {
                    Ok(reopened) => *port = Some(reopened),
                    Err(_) => self.wait(REOPEN_PAUSE),
                }
                continue;
            };
            match self.session(open, &mut shown) {
                Ok(Ended::Closed) => return true,
                Ok(Ended::Unanswered) => {
                    if std::mem::take(&mut first_loss) {
                        (self.report)(LinkReport::Lost("the ground station does not answer".to_owned()));
                    }
                }
                Err(error) => (self.report)(LinkReport::Lost(error.to_string())),
            }
            *port = None;
        }
    }

    fn reopen(&self) -> Result<Port, PortError> {
        if self.url.faults.is_active(FaultKind::Disconnect, self.clock.now()) {
            let source = io::Error::new(io::ErrorKind::NotConnected, "disconnected on purpose");
            return Err(PortError::Unreachable { address: self.url.to_string(), source });
        }
        Port::open(&self.url.endpoint)
    }

    /// One session, to its end.
    fn session(&self, port: &mut Port, shown: &mut Option<LinkState>) -> io::Result<Ended> {
        let mut session = Session::open(self.settings, self.clock.now());
        let mut out = Vec::new();
        let mut buffer = [0; 1024];
        let mut closing_since: Option<Timestamp> = None;
        let mut overdue = false;
        loop {
            let now = self.clock.now();
            self.apply_faults(now)?;
            let (rates, expires, close) = self.wanted();
            let expired = !rates.is_rest() && expires <= now;
            if expired && !std::mem::replace(&mut overdue, true) {
                tracing::error!("the pilot is held up: the link rests the camera");
            }
            overdue &= expired;
            session.set_rates(if expired { VehicleRates::REST } else { rates });
            if close && closing_since.is_none() {
                closing_since = Some(now);
                session.close(now);
            }
            if closing_since.is_some_and(|since| now.since(since) > CLOSING_TIMEOUT) {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "the last words could not be sent"));
            }
            out.clear();
            let next = session.poll(now, &mut out);
            if !out.is_empty() && !self.url.faults.is_active(FaultKind::Drop, now) {
                port.write_all(&out)?;
            }
            self.show(session.link_state(), shown);
            match next {
                NextAction::Closed => return Ok(Ended::Closed),
                NextAction::Reopen => return Ok(Ended::Unanswered),
                NextAction::WaitUntil(wake_at) => {
                    // At least ten looks a second, so that a fault on purpose begins in time.
                    let moves_until = if rates.is_rest() || expired { wake_at } else { expires };
                    let wake_at = wake_at.min(moves_until);
                    let wait = wake_at.since(self.clock.now()).min(Duration::from_millis(100));
                    if self.wait_for(port, wait) {
                        let read = port.read(&mut buffer)?;
                        session.receive(&buffer[..read], self.clock.now(), |telemetry| {
                            (self.report)(LinkReport::Telemetry(telemetry));
                        });
                    }
                }
            }
        }
    }

    /// The rates wanted, when they expire, and whether the link is to be closed. Rates without a time by which
    /// they are renewed have expired already.
    fn wanted(&self) -> (VehicleRates, Timestamp, bool) {
        self.shared.with(|mailbox| {
            let expires = mailbox.renew_by.map_or(Timestamp::ZERO, |at| at.plus(RENEWAL_GRACE));
            (mailbox.rates, expires, mailbox.close)
        })
    }

    fn apply_faults(&self, now: Timestamp) -> io::Result<()> {
        let faults = &self.url.faults;
        #[allow(clippy::panic, reason = "asked for on the command line, to test the last will")]
        if faults.is_active(FaultKind::Panic, now) {
            panic!("the link thread panics on purpose");
        }
        if faults.is_active(FaultKind::Disconnect, now) {
            return Err(io::Error::new(io::ErrorKind::NotConnected, "disconnected on purpose"));
        }
        Ok(())
    }

    fn show(&self, state: LinkState, shown: &mut Option<LinkState>) {
        if *shown != Some(state) {
            *shown = Some(state);
            let telemetry = Telemetry { at: self.clock.now(), report: Report::Link(state) };
            (self.report)(LinkReport::Telemetry(telemetry));
        }
    }

    fn wait_for(&self, port: &Port, wait: Duration) -> bool {
        let mut fds = [PollFd::new(&self.shared.waker, PollFlags::IN), PollFd::new(port, PollFlags::IN)];
        self.poll(&mut fds, wait);
        !fds[1].revents().is_empty()
    }

    fn wait(&self, wait: Duration) {
        self.poll(&mut [PollFd::new(&self.shared.waker, PollFlags::IN)], wait);
    }

    fn poll(&self, fds: &mut [PollFd<'_>], wait: Duration) {
        // Both ends of the conversion are small: `wait` is at most a second.
        let timeout = rustix::event::Timespec::try_from(wait).ok();
        // An interrupted wait is a short wait.
        let _ = poll(fds, timeout.as_ref());
        let mut counted = [0; 8];
        let _ = rustix::io::read(&self.shared.waker, &mut counted);
    }
}

enum Ended {
    Closed,
    Unanswered,
}

/// The last words of a link whose thread panicked.
fn send_last_will(port: &mut Port, framing: Framing) -> io::Result<()> {
    let (zeros, stop) = Session::emergency_stop(framing);
    for _ in 0..3 {
        port.write_all(&zeros)?;
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(STOP_DELAY);
    port.write_all(&stop)
}
