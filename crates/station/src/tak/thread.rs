//! The thread: once a second, the events of the newest snapshot.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use barrelman_console_server::snapshot::SharedSnapshot;
use barrelman_host::clock::Clock;
use barrelman_host::random::random_bytes;
use barrelman_vocab::Timestamp;
use tokio::sync::watch;

use super::TakSetup;
use super::cot::{Origin, Times, event};
use super::scene::{Located, located};
use super::send_log::SendLog;
use super::sender::Sender;
use crate::live::event::Event;
use crate::live::threads::spawn;

/// Time from the events of one turn to those of the next.
const INTERVAL: Duration = Duration::from_secs(1);

/// The thread of a run. It ends after this is dropped. The drop does not wait: the thread may just be
/// connecting.
#[derive(Debug)]
pub struct TakThread {
    _runs: SyncSender<()>,
}

impl TakThread {
    /// Starts the thread.
    ///
    /// # Errors
    /// If the system has no more threads, sockets or random numbers.
    pub fn start(
        setup: TakSetup,
        snapshots: watch::Receiver<SharedSnapshot>,
        clock: Clock,
        events: SyncSender<Event>,
    ) -> io::Result<Self> {
        let sender = Sender::open(setup.route.clone())?;
        let origin =
            Origin { run: run_name()?, callsign: setup.callsign.clone(), vehicle: setup.vehicle.clone() };
        let (runs, ended) = sync_channel(0);
        tracing::info!(
            "--tak {}: sending the places of boat, camera and marks that are known",
            setup.address
        );
        let work = Work { setup, origin, sender, log: SendLog::default(), snapshots, clock };
        spawn("tak", events, move || work.run(&ended))?;
        Ok(Self { _runs: runs })
    }
}

/// A name that no other run has.
fn run_name() -> io::Result<String> {
    let mut bytes = [0; 8];
    random_bytes(&mut bytes)?;
    Ok(format!("{:016x}", u64::from_be_bytes(bytes)))
}

struct Work {
    setup: TakSetup,
    origin: Origin,
    sender: Sender,
    log: SendLog,
    snapshots: watch::Receiver<SharedSnapshot>,
    clock: Clock,
}

impl Work {
    /// Sends until the other end of `ended` is dropped.
    fn run(mut self, ended: &Receiver<()>) {
        let mut wait = INTERVAL;
        while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            let now = self.clock.now();
            let snapshot = SharedSnapshot::clone(&self.snapshots.borrow());
            let events = events(&located(&snapshot, now), &self.origin, (now, jiff::Timestamp::now()));
            if !events.is_empty() {
                let sent = self.sender.send(&events, now);
                if let Some(line) = self.log.on_sent(sent, &self.setup.address) {
                    line.write();
                }
            }
            wait = INTERVAL.saturating_sub(self.clock.now().since(now));
        }
    }
}

/// The events of what is known at a moment, which is given as a time of the run's clock and of the machine's.
fn events(all: &[Located], origin: &Origin, (now, sent): (Timestamp, jiff::Timestamp)) -> Vec<Vec<u8>> {
    let of =
        |located: &Located| event(located, origin, Times { sent, known: sent - now.since(located.at) }).ok();
    all.iter().filter_map(of).collect()
}
