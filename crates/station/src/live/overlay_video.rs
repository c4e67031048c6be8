//! The annotated video of a run: drawn and encoded on a thread of its own.
//!
//! The loop never waits for it: where drawing is slower than the video, frames are left out of the annotated
//! one, and counted.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use anyhow::{Result, anyhow};
use barrelman_pilot::Outcome;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{VehicleRates, VideoFrame};

use super::event::Event;
use super::run_loop::FrameObserver;
use super::threads::{self, FaultInjector};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_overlay::film::Film;

/// Frames that may wait to be drawn.
const QUEUE: usize = 8;

struct Seen {
    frame: VideoFrame,
    outcome: Outcome,
    rates: VehicleRates,
}

/// An annotated video that is being written.
pub struct OverlayVideo {
    items: SyncSender<Option<Box<Seen>>>,
    thread: JoinHandle<()>,
    result: Receiver<Result<()>>,
}

/// The way into an annotated video.
pub struct OverlayInput {
    items: SyncSender<Option<Box<Seen>>>,
    left_out: u64,
}

impl OverlayVideo {
    /// Begins an annotated video.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn begin(
        file: OutputFile,
        shares: RegionShares,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
    ) -> Result<Self> {
        let (items, queue) = sync_channel::<Option<Box<Seen>>>(QUEUE);
        let (send_result, result) = sync_channel(1);
        let thread = threads::spawn("overlay", events, move || {
            let _ = send_result.send(write(Film::new(file, shares), &queue, || {
                fault_injector.apply_faults("overlay", clock.now())
            }));
        })?;
        Ok(Self { items, thread, result })
    }

    /// A way into the annotated video.
    pub fn input(&self) -> OverlayInput {
        OverlayInput { items: self.items.clone(), left_out: 0 }
    }

    /// Ends the annotated video.
    ///
    /// # Errors
    /// If it could not be written.
    pub fn finish(self) -> Result<()> {
        // Of a thread that has failed nobody listens at the other end; its result tells why.
        let _ = self.items.send(None);
        let _ = self.thread.join();
        self.result.try_recv().unwrap_or_else(|_| Err(anyhow!("the annotated video was not finished")))
    }
}

impl FrameObserver for OverlayInput {
    fn watch(&mut self, frame: &VideoFrame, outcome: &Outcome, rates: VehicleRates) {
        let seen = Seen { frame: frame.clone(), outcome: outcome.clone(), rates };
        self.left_out += u64::from(self.items.try_send(Some(Box::new(seen))).is_err());
    }
}

impl Drop for OverlayInput {
    fn drop(&mut self) {
        if self.left_out > 0 {
            tracing::warn!("{} frames were left out of the annotated video", self.left_out);
        }
    }
}

fn write(mut film: Film, queue: &Receiver<Option<Box<Seen>>>, apply_faults: impl Fn()) -> Result<()> {
    while let Ok(Some(seen)) = queue.recv() {
        apply_faults();
        film.add_outcome(&seen.frame, &seen.outcome, seen.rates)?;
    }
    film.finish()
}
