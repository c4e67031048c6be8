//! The thread: runs the model on the newest frame, and sends what it found to the run loop.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use barrelman_detector::{ModelError, Objects};
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_host::threads;
use barrelman_pilot::{Classification, Detection, Detections};
use barrelman_vocab::VideoFrame;

use super::input::DetectorInput;
use super::setup::DetectorSetup;
use crate::live::event::Event;

/// The nice value of the thread: where processors are busy, the run loop comes first.
const PRIORITY: i32 = 5;
/// Pictures whose mean time is logged.
const TIMED_PICTURES: u32 = 20;

/// The thread of a run. It ends after this is dropped. The drop does not wait: an inference may take long.
#[derive(Debug)]
pub struct DetectorThread {
    frames: Arc<Latest<VideoFrame>>,
}

impl DetectorThread {
    /// Starts the thread.
    ///
    /// # Errors
    /// If the system has no more threads.
    pub fn start(setup: DetectorSetup, clock: Clock, events: SyncSender<Event>) -> io::Result<Self> {
        let frames = Arc::new(Latest::default());
        let work =
            Work { frames: Arc::clone(&frames), clock, events, pictures: 0, busy: Duration::ZERO, setup };
        let on_panic = |_| tracing::error!("the detector panicked; the run goes on without detections");
        threads::spawn("detector", on_panic, move || work.run())?;
        Ok(Self { frames })
    }

    /// An observer that passes the frames of the run on.
    pub fn input(&self) -> DetectorInput {
        DetectorInput(Arc::clone(&self.frames))
    }
}

impl Drop for DetectorThread {
    fn drop(&mut self) {
        self.frames.close();
    }
}

struct Work {
    setup: DetectorSetup,
    frames: Arc<Latest<VideoFrame>>,
    clock: Clock,
    events: SyncSender<Event>,
    pictures: u32,
    /// Time of the inferences so far, until it is logged.
    busy: Duration,
}

impl Work {
    fn run(mut self) {
        // Without a lower priority it works all the same.
        let _ = rustix::process::setpriority_process(None, PRIORITY);
        let mut is_told = false;
        while let Some(frame) = self.frames.wait() {
            let objects = match self.detect(&frame) {
                Ok(objects) => objects,
                Err(error) => {
                    let model = self.setup.model.display();
                    tracing::error!("--detector {model}: {error}; the run goes on without detections");
                    return;
                }
            };
            if objects.not_finite > 0 && !is_told {
                is_told = true;
                let (model, boxes) = (self.setup.model.display(), objects.not_finite);
                tracing::warn!(
                    "--detector {model}: {boxes} boxes of a picture are left out, as a number of theirs is not finite; \
                     further ones are left out silently"
                );
            }
            let detections = self.detections(&frame, &objects);
            // A full queue means that the loop is held up: these detections are old when it goes on.
            let _ = self.events.try_send(Event::Detections(Box::new(detections)));
        }
    }

    fn detect(&mut self, frame: &VideoFrame) -> Result<Objects, ModelError> {
        let begun = self.clock.now();
        let objects = self.setup.detector.detect(&frame.picture)?;
        self.busy += self.clock.now().since(begun);
        self.pictures = self.pictures.saturating_add(1);
        if self.pictures == TIMED_PICTURES {
            let mean = 1e3 * self.busy.as_secs_f64() / f64::from(TIMED_PICTURES);
            tracing::info!("--detector {}: {mean:.1} ms for a picture", self.setup.model.display());
        }
        Ok(objects)
    }

    fn detections(&self, frame: &VideoFrame, objects: &Objects) -> Detections {
        let found = objects.found.iter().filter_map(|object| {
            let class = *self.setup.classes.get(object.class)?;
            let classification = Classification { class, score: f64::from(object.score) };
            Some(Detection { bounds: object.bounds, classification })
        });
        Detections { captured: frame.capture.at, picture: frame.picture.size(), found: found.collect() }
    }
}
