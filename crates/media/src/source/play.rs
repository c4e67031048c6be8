//! What all addresses share: the pipeline, and the messages of its bus.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::FromSource;
use gst::prelude::*;
use gstreamer as gst;

use super::failure::{self, missing_element, unlinked};
use super::outbox::Outbox;
use super::rtp_times::RtpTimes;

/// Longest time without a unit from a file whose reader waits.
const LONGEST_STALL: Duration = Duration::from_secs(5);

/// What the time stamps of the buffers mean.
#[derive(Debug, Clone)]
pub(super) enum Times {
    /// Extended RTP time stamps in nanoseconds.
    Rtp(Arc<Mutex<RtpTimes>>),
    /// The sender's clock.
    Sender,
    /// Time of capture, as running time of the pipeline.
    Captured,
    /// Time in a file.
    SinceStart,
    /// Arrival, as running time of the pipeline. The source has no times.
    Arrival,
    /// Nothing: a picture arrives when it is complete.
    Absent,
}

/// The way of the packets, for people, and what their times mean.
#[derive(Debug, Clone)]
pub(super) struct Way {
    /// "by RTP over UDP"
    pub name: String,
    pub times: Times,
}

/// A source that plays.
pub(super) struct Play {
    pub pipeline: gst::Pipeline,
    pub outbox: Arc<Outbox>,
    pub is_live: bool,
    has_video: AtomicBool,
    is_file: AtomicBool,
    is_endless: AtomicBool,
    /// What the failure of the pipeline really is, where an observer of the connection knows it better.
    reason: Mutex<Option<SourceFailure>>,
    /// What to do instead of failing, once.
    second_attempt: Mutex<Option<SecondAttempt>>,
}

/// Decides, knowing a failure, whether it has begun another attempt.
pub(super) type SecondAttempt = Box<dyn FnOnce(&Arc<Play>, &SourceFailure) -> bool + Send>;

impl Play {
    pub(super) fn new(pipeline: gst::Pipeline, outbox: Arc<Outbox>, is_live: bool) -> Arc<Self> {
        let (reason, second_attempt) = (Mutex::default(), Mutex::default());
        Arc::new(Self {
            pipeline,
            outbox,
            is_live,
            has_video: AtomicBool::new(false),
            is_file: AtomicBool::new(false),
            is_endless: AtomicBool::new(false),
            reason,
            second_attempt,
        })
    }

    /// Adds an element to the pipeline.
    pub(super) fn add(&self, name: &str) -> Result<gst::Element, SourceFailure> {
        let element = gst::ElementFactory::make(name).build().map_err(|_| missing_element(name))?;
        self.pipeline.add(&element).map_err(unlinked)?;
        Ok(element)
    }

    /// Starts the pipeline.
    pub(super) fn start(&self) {
        if self.pipeline.set_state(gst::State::Playing).is_err() {
            // The bus has the reason, if an element gave one; the failure that is queued first counts.
            self.follow_bus_until_empty();
            self.outbox.fail(failure::temporary("does not start", ""));
        }
    }

    /// Whether there is a video.
    pub(super) fn has_video(&self) -> bool {
        self.has_video.load(Ordering::Relaxed)
    }

    /// Whether there was a video already. From now on there is one.
    pub(super) fn takes_video(&self) -> bool {
        self.has_video.swap(true, Ordering::Relaxed)
    }

    /// What was said of the pipeline's failure holds no more.
    pub(super) fn forget_reason(&self) {
        *self.reason.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Says why the pipeline will fail. What is said last counts.
    pub(super) fn set_reason(&self, failure: SourceFailure) {
        *self.reason.lock().unwrap_or_else(PoisonError::into_inner) = Some(failure);
    }

    /// Sets what to do instead of failing.
    pub(super) fn set_second_attempt(&self, attempt: SecondAttempt) {
        *self.second_attempt.lock().unwrap_or_else(PoisonError::into_inner) = Some(attempt);
    }

    /// Forgets what is known of a failed attempt.
    pub(super) fn begin_anew(&self) {
        self.forget_reason();
        self.has_video.store(false, Ordering::Relaxed);
    }

    /// Ends with a failure where nothing comes out of a file for long: a demultiplexer may wait for a stream
    /// that a broken file has announced.
    pub(super) fn set_is_file(&self) {
        self.is_file.store(true, Ordering::Relaxed);
    }

    /// The stream has no end of its own: where a live stream ends, the connection is lost.
    pub(super) fn set_is_endless(&self) {
        self.is_endless.store(true, Ordering::Relaxed);
    }

    /// Whether the stream has no end of its own.
    pub(super) fn is_endless(&self) -> bool {
        self.is_endless.load(Ordering::Relaxed)
    }

    /// Handles the messages of the bus until the end.
    pub(super) fn follow_bus(self: &Arc<Self>) {
        let Some(bus) = self.pipeline.bus() else { return };
        let start = Instant::now();
        loop {
            match bus.timed_pop(gst::ClockTime::SECOND) {
                Some(message) if self.on_message(&message) => return,
                Some(_) => {}
                None if self.is_file.load(Ordering::Relaxed) && self.outbox.idle(start) > LONGEST_STALL => {
                    let what = "is broken: no video comes out of it any more";
                    self.outbox.fail(failure::permanent(what, "Repair or copy the file again"));
                    return;
                }
                None => {}
            }
        }
    }

    fn follow_bus_until_empty(&self) {
        let Some(bus) = self.pipeline.bus() else { return };
        for message in bus.iter() {
            if let gst::MessageView::Error(error) = message.view() {
                self.outbox.fail(self.failure(error));
            }
        }
    }

    /// Returns whether the source has ended.
    fn on_message(self: &Arc<Self>, message: &gst::Message) -> bool {
        match message.view() {
            gst::MessageView::Eos(_) if self.is_live && self.is_endless() => {
                self.outbox.fail(failure::temporary("ended its stream", ""));
            }
            gst::MessageView::Eos(_) => self.outbox.end(FromSource::Ended),
            gst::MessageView::Error(error) => {
                let failure = self.failure(error);
                let attempt = self.second_attempt.lock().unwrap_or_else(PoisonError::into_inner).take();
                if attempt.is_some_and(|attempt| attempt(self, &failure)) {
                    return false;
                }
                self.outbox.fail(failure);
            }
            gst::MessageView::Element(element) => {
                if let Some(missing) = element.structure().and_then(missing_plugin) {
                    self.set_reason(failure::missing_codec(&missing));
                }
                return false;
            }
            _ => return false,
        }
        true
    }

    fn failure(&self, error: &gst::message::Error) -> SourceFailure {
        let known = self.reason.lock().unwrap_or_else(PoisonError::into_inner).clone();
        known.unwrap_or_else(|| {
            let debug = error.debug().unwrap_or_default();
            failure::from_gst(&error.error(), &debug)
        })
    }
}

/// The name of a codec of video that is not installed.
fn missing_plugin(structure: &gst::StructureRef) -> Option<String> {
    if structure.name() != "missing-plugin" {
        return None;
    }
    let detail = structure.get::<gst::Caps>("detail").ok()?;
    let name = detail.structure(0)?.name();
    let is_video = ["video/", "image/"].iter().any(|prefix| name.starts_with(prefix));
    is_video.then(|| structure.get::<String>("name").ok()).flatten()
}
