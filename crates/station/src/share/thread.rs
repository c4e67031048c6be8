//! The thread: draws and encodes the newest frame while somebody reads, and starts `barrelman-media` again
//! where it ends.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use barrelman_console_server::SessionTime;
use barrelman_host::clock::Clock;
use barrelman_video::media::share::{Demand, MAX_READERS, SHARE_USER, Share};

use super::ShareSetup;
use super::annotator::Annotator;
use super::failures::Failures;
use super::slot::{ShareInput, ShareSlot};
use crate::live::event::Event;
use crate::live::threads::spawn;

/// Longest wait for a first reader before a look whether the run has ended.
const IDLE_WAIT: Duration = Duration::from_millis(100);
/// Longest wait for a frame before a look what the readers need.
const FRAME_WAIT: Duration = Duration::from_millis(20);
/// The nice value of this thread and of `barrelman-media`: where processors are busy, the run loop comes
/// first.
const PRIORITY: i32 = 5;

/// The thread of a run. It ends after this is dropped. The drop does not wait: `barrelman-media` ends with
/// the program.
#[derive(Debug)]
pub struct ShareThread {
    slot: Arc<ShareSlot>,
}

impl ShareThread {
    /// Starts the thread. `time`: that of the frames.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn start(
        setup: ShareSetup,
        clock: Clock,
        time: SessionTime,
        events: SyncSender<Event>,
    ) -> io::Result<Self> {
        let login = match setup.password().is_some() {
            true => format!("user {SHARE_USER}, password: the console's watch token"),
            false => "no password".to_owned(),
        };
        tracing::info!(
            "--share {}: the annotated video for at most {MAX_READERS} readers, not encrypted; {login}",
            setup.address
        );
        let slot = Arc::new(ShareSlot::default());
        let work = Work { setup, slot: Arc::clone(&slot), clock, time };
        spawn("share", events, move || work.run())?;
        Ok(Self { slot })
    }

    /// An observer that passes the frames of the run on.
    pub fn input(&self) -> ShareInput {
        ShareInput(Arc::clone(&self.slot))
    }
}

impl Drop for ShareThread {
    fn drop(&mut self) {
        self.slot.frames.close();
    }
}

struct Work {
    setup: ShareSetup,
    slot: Arc<ShareSlot>,
    clock: Clock,
    time: SessionTime,
}

impl Work {
    fn run(self) {
        // Without a lower priority the video is shared all the same.
        let _ = rustix::process::setpriority_process(None, PRIORITY);
        let mut failures = Failures::new();
        while !self.slot.frames.is_closed() {
            let begun = self.clock.now();
            let password = self.setup.password();
            let share = Share::start(&self.setup.program, &self.setup.socket, password.clone());
            let served = share.and_then(|share| self.serve(share, password));
            self.slot.set_wanted(false);
            let Err(reason) = served else { continue };
            let (pause, is_new) = failures.on_end(self.clock.now().since(begun), &reason);
            if is_new {
                tracing::warn!("--share {}: {reason}; it is started again", self.setup.address);
            }
            // A frame that is still there is too old for the next one.
            drop(self.slot.frames.take());
            let _ = self.slot.frames.wait_for(pause);
        }
    }

    /// Serves until the slot is closed, or the password is no longer in force: its readers go with the
    /// process.
    ///
    /// # Errors
    /// Why `barrelman-media` does not serve any more.
    fn serve(&self, mut share: Share, password: Option<String>) -> Result<(), String> {
        let (mut annotator, mut demand) = (Annotator::new(), Demand::Nothing);
        let mut is_failure_told = false;
        while !self.slot.frames.is_closed() && self.setup.is_password(password.as_deref()) {
            let mut wait = if demand == Demand::Nothing { IDLE_WAIT } else { Duration::ZERO };
            while let Some(next) = share.next_demand(wait)? {
                (demand, wait) = (next, Duration::ZERO);
                annotator.on_demand(next);
            }
            self.slot.set_wanted(demand != Demand::Nothing);
            if demand == Demand::Nothing {
                // A frame that was put meanwhile is too old for the next reader.
                drop(self.slot.frames.take());
                continue;
            }
            let Some(shown) = self.slot.frames.wait_for(FRAME_WAIT) else { continue };
            let time_of_day = self.time.time_of_day(shown.frame.capture.at);
            match annotator.encode(&shown, time_of_day.as_deref()) {
                Ok(picture) => share.send(&picture)?,
                Err(error) if !is_failure_told => {
                    is_failure_told = true;
                    tracing::error!("--share {}: {error}", self.setup.address);
                }
                Err(_) => {}
            }
        }
        Ok(())
    }
}
