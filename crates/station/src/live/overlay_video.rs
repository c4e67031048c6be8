//! The annotated video of a run: rendered and encoded on a thread of its own.
//!
//! The loop never waits for this thread. Where rendering is slower than the video, frames are dropped from
//! the annotated video, and counted.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use anyhow::{Result, anyhow};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_overlay::film::Film;
use barrelman_pilot::{Input, Outcome};
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{VehicleRates, VideoFrame};

use super::event::Event;
use super::faults::{FaultInjector, OVERLAY};
use super::inbox::{FOREVER, Inbox};
use super::run_loop::{LiveStep, LiveStepObserver};
use super::threads;

/// Capacity of the queue of frames to render.
const QUEUE_CAPACITY: usize = 8;

/// A video frame with what is drawn on it.
struct OverlayFrame {
    frame: VideoFrame,
    outcome: Outcome,
    rates: VehicleRates,
}

/// An annotated video that is being written.
pub struct OverlayVideo {
    frames: SyncSender<Option<Box<OverlayFrame>>>,
    thread: JoinHandle<()>,
    result: Receiver<Result<()>>,
}

/// Adds the frames of a run to an annotated video.
pub struct OverlayInput {
    frames: SyncSender<Option<Box<OverlayFrame>>>,
    dropped: u64,
}

impl OverlayVideo {
    /// Begins an annotated video.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn begin(
        file: OutputFile,
        shares: RegionShares,
        clock: Clock,
        fault_injector: FaultInjector,
        events: SyncSender<Event>,
    ) -> Result<Self> {
        let (frames, queue) = sync_channel::<Option<Box<OverlayFrame>>>(QUEUE_CAPACITY);
        let (send_result, result) = sync_channel(1);
        let thread = threads::spawn("overlay", events, move || {
            let mut queue = fault_injector.inbox(OVERLAY, clock, queue);
            let _ = send_result.send(write(Film::new(file, shares), &mut *queue));
        })?;
        Ok(Self { frames, thread, result })
    }

    /// An observer that adds frames to the annotated video.
    pub fn input(&self) -> OverlayInput {
        OverlayInput { frames: self.frames.clone(), dropped: 0 }
    }

    /// Ends the annotated video.
    ///
    /// # Errors
    /// If the annotated video could not be written.
    pub fn finish(self) -> Result<()> {
        // A thread that has failed no longer receives; its result contains the error.
        let _ = self.frames.send(None);
        let _ = self.thread.join();
        self.result.try_recv().unwrap_or_else(|_| Err(anyhow!("the annotated video was not finished")))
    }
}

impl LiveStepObserver for OverlayInput {
    fn on_step(&mut self, step: &LiveStep<'_>) {
        let Input::Frame(frame) = step.input else { return };
        let (frame, outcome) = (frame.clone(), step.outcome.clone());
        let frame = OverlayFrame { frame, outcome, rates: step.rates };
        self.dropped += u64::from(self.frames.try_send(Some(Box::new(frame))).is_err());
    }
}

impl Drop for OverlayInput {
    fn drop(&mut self) {
        if self.dropped > 0 {
            tracing::warn!("{} frames were left out of the annotated video", self.dropped);
        }
    }
}

fn write(mut film: Film, queue: &mut dyn Inbox<Option<Box<OverlayFrame>>>) -> Result<()> {
    while let Ok(Some(step)) = queue.next(FOREVER) {
        film.add_outcome(&step.frame, &step.outcome, step.rates)?;
    }
    film.finish()
}
