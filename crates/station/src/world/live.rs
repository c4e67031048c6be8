//! A world that goes on by the clock, as a video source.
//!
//! | thread | does |
//! |---|---|
//! | `world` | one tick every 1/120 s by the clock, none left out; takes the camera's rates from the link at each |
//! | `eye` | draws (with the render threads) and encodes the newest picture that was taken |
//! | `video` | hands each picture on when it arrives: the scenario's latency after it was taken |
//!
//! Where drawing is slower than the scenario's pictures come, the newest moment wins and the others are counted; the
//! world never waits. Pictures are stamped with the program's time of the tick at which they were taken. They travel as
//! encoded units like any other video: H.264 where they are recorded or served, so that a replay sees what the pilot
//! saw, and otherwise plain samples.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use anyhow::{Result, anyhow};
use barrelman_sim::video_link::{Delivery, VideoLink};
use barrelman_sim::{Scenario, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{DrawnEye, Eye as _, View};
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{EncodedUnit, PixelBox, Timestamp, VehicleProfile, VehicleRates};
use bytes::Bytes;

use super::camera_link::{CameraLink, Pointing};
use super::render_threads::RenderThreads;
use super::url::WorldUrl;
use crate::scenario::{self, Changes};
use crate::video::encoder::{EncoderSettings, H264Encoder};
use crate::video::feed::{Feed, StopSignal};
use crate::video::{VideoError, VideoSink, VideoState};

/// Pictures that may be on their way.
const ON_THE_WAY: usize = 128;

/// A world that has not begun.
#[derive(Debug)]
pub struct LiveWorld {
    scenario: Scenario,
    world: World,
    seed: u64,
    link: CameraLink,
    profile: VehicleProfile,
    /// Whether pictures travel as H.264.
    coded: bool,
    threads: RenderThreads,
}

impl LiveWorld {
    /// Loads a world.
    ///
    /// # Errors
    /// If there is no such scenario, or it has a mistake.
    pub fn load(url: &WorldUrl) -> Result<Self> {
        let changes = Changes { size: url.size, ..Changes::default() };
        let scenario = scenario::load(&url.scenario, &changes)?.scenario;
        let world = World::new(&scenario, url.seed).map_err(|_| {
            anyhow!("the way-points of {} make no path with seed {}", scenario.name, url.seed)
        })?;
        Ok(Self {
            scenario,
            world,
            seed: url.seed,
            link: CameraLink::default(),
            profile: VehicleProfile::fotokite_pro(),
            coded: false,
            threads: RenderThreads::two()?,
        })
    }

    /// The scenario.
    pub const fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The link to its camera.
    pub fn link(&self) -> CameraLink {
        self.link.clone()
    }

    /// The vehicle, whose signs the rates on the link have.
    #[must_use]
    pub fn on(self, profile: &VehicleProfile) -> Self {
        Self { profile: profile.clone(), ..self }
    }

    /// Lets its pictures travel as H.264.
    #[must_use]
    pub fn coded(self, coded: bool) -> Self {
        Self { coded, ..self }
    }
}

/// Plays a world whose camera nobody moves.
pub(crate) fn run_alone<S: VideoSink>(url: &WorldUrl, mut feed: Feed<S>, stop: &StopSignal) {
    match LiveWorld::load(url) {
        Ok(world) => run(world, feed, stop),
        Err(error) => feed.fail(VideoError::World { reason: format!("{error:#}") }),
    }
}

/// Plays a world to its end.
pub(crate) fn run<S: VideoSink>(live: LiveWorld, mut feed: Feed<S>, stop: &StopSignal) {
    let LiveWorld { scenario, world, seed, link, profile, coded, threads } = live;
    feed.sink.state(VideoState::Up);
    let clock = feed.clock;
    let start = clock.now();
    let (newest, first) = (Newest::default(), world.clone());
    let (units, arriving) = sync_channel(ON_THE_WAY);
    // The feed is outside: where a thread of the scope panics, its sink goes down with the panic and says so.
    thread::scope(|scope| {
        let ticking = || {
            let _end = Ending { newest: &newest, link: &link };
            let mut video = VideoLink::new(scenario.camera.video, seed);
            let mut world = world;
            let mut told = VehicleRates::REST;
            loop {
                let due = start.plus(World::time_of(world.tick()).since(Timestamp::ZERO));
                if stop.wait_until(clock.instant(due)) || world.is_over() || newest.is_closed() {
                    return;
                }
                let rates = link.take(clock.now());
                if std::mem::replace(&mut told, rates) != rates {
                    world.command(profile.incoming(rates));
                }
                let pose = world.camera_pose();
                link.tell(Pointing { pan: pose.pan, tilt: pose.tilt });
                if world.is_frame_due() {
                    match video.send(world.tick()) {
                        Delivery::Lost => {}
                        passage => newest.put(Taken { world: world.clone(), passage }),
                    }
                }
                world.advance();
            }
        };
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        let started = named("world").spawn_scoped(scope, ticking).and_then(|_| {
            let (newest, threads, camera) = (&newest, &threads, scenario.camera.clone());
            named("eye").spawn_scoped(scope, move || {
                let fps = f64::from(camera.pictures_per_second);
                let settings = EncoderSettings::for_pictures(camera.frame, fps);
                let simd = Simd::at_most(SimdLevel::Avx512);
                Drawing {
                    eye: DrawnEye::new(&first, camera, seed, simd, threads),
                    start,
                    encoder: coded.then(|| H264Encoder::new(settings)),
                    shown: None,
                    index: 0,
                }
                .run(newest, &units);
            })
        });
        if let Err(error) = started {
            newest.close(true);
            feed.fail(VideoError::Thread(error));
        } else {
            deliver(&arriving, &mut feed, stop);
        }
        // Whoever still waits for a picture, or to hand one on, is let go.
        newest.close(false);
        drop(arriving);
    });
}

/// Says that the world is over when its thread ends, in whatever way.
struct Ending<'a> {
    newest: &'a Newest,
    link: &'a CameraLink,
}

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.newest.close(thread::panicking());
        self.link.world_ended();
    }
}

/// A picture that was taken and is to be drawn: the world as it was.
struct Taken {
    world: World,
    passage: Delivery,
}

/// A place for the newest picture that was taken.
#[derive(Default)]
struct Newest {
    slot: Mutex<Slot>,
    changed: Condvar,
}

#[derive(Default)]
struct Slot {
    taken: Option<Taken>,
    left_out: u64,
    closed: bool,
    /// Closed because a thread broke.
    broken: bool,
}

impl Newest {
    fn put(&self, taken: Taken) {
        let mut slot = self.slot();
        slot.left_out += u64::from(slot.taken.replace(taken).is_some());
        self.changed.notify_all();
    }

    fn close(&self, broken: bool) {
        let mut slot = self.slot();
        (slot.closed, slot.broken) = (true, slot.broken | broken);
        self.changed.notify_all();
    }

    fn is_closed(&self) -> bool {
        self.slot().closed
    }

    fn slot(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a picture; `None` when no more will come.
    fn take(&self) -> Option<Taken> {
        let wait = |slot: &mut Slot| slot.taken.is_none() && !slot.closed;
        self.changed.wait_while(self.slot(), wait).unwrap_or_else(PoisonError::into_inner).taken.take()
    }
}

/// What is on its way.
enum Arriving {
    /// A picture, which arrives at a time.
    Picture { at: Timestamp, unit: EncodedUnit, target: Option<PixelBox> },
    /// No picture can be encoded.
    Failed(VideoError),
    /// The world is over.
    End,
}

/// The thread that draws.
struct Drawing<'a> {
    eye: DrawnEye<'a>,
    start: Timestamp,
    encoder: Option<H264Encoder>,
    /// What the last picture showed, for one that comes frozen.
    shown: Option<View>,
    index: u64,
}

impl Drawing<'_> {
    fn run(mut self, newest: &Newest, units: &SyncSender<Arriving>) {
        while let Some(taken) = newest.take() {
            let (Delivery::Arrives { at } | Delivery::Frozen { at }) = taken.passage else { continue };
            let is_frozen = matches!(taken.passage, Delivery::Frozen { .. });
            let view = match self.shown.take() {
                Some(shown) if is_frozen => shown,
                _ => self.eye.look(&taken.world),
            };
            let unit = self.unit(&view, self.on_the_clock(taken.world.tick()));
            let target = view.target;
            self.shown = Some(view);
            let arriving = match unit {
                Ok(unit) => Arriving::Picture { at: self.on_the_clock(at), unit, target },
                Err(error) => Arriving::Failed(error),
            };
            if units.send(arriving).is_err() {
                return;
            }
        }
        let (left_out, broken) = {
            let slot = newest.slot();
            (slot.left_out, slot.broken)
        };
        if left_out > 0 {
            tracing::warn!("{left_out} pictures were not drawn in time: smaller ones (?size=WxH) are faster");
        }
        if !broken {
            let _ = units.send(Arriving::End);
        }
    }

    fn on_the_clock(&self, tick: u64) -> Timestamp {
        self.start.plus(World::time_of(tick).since(Timestamp::ZERO))
    }

    fn unit(&mut self, view: &View, taken_at: Timestamp) -> Result<EncodedUnit, VideoError> {
        let picture = &view.frame.picture;
        let (key, codec, payload) = match &mut self.encoder {
            Some(encoder) => {
                let encoded = encoder.encode(picture, taken_at)?;
                (encoded.key, UnitCodec::H264AnnexB, Bytes::from(encoded.bytes))
            }
            None => {
                let codec = UnitCodec::RawYuv420 { size: picture.size(), colour: picture.colour() };
                (true, codec, Bytes::copy_from_slice(picture.samples()))
            }
        };
        let index = self.index;
        self.index += 1;
        let capture = Capture { at: taken_at, quality: CaptureQuality::Sensor };
        Ok(EncodedUnit {
            epoch: 0,
            index,
            capture,
            key,
            shown: true,
            rotation: Rotation::None,
            codec,
            payload,
        })
    }
}

/// Hands pictures on as they arrive, through the faults that were asked for.
fn deliver<S: VideoSink>(arriving: &Receiver<Arriving>, feed: &mut Feed<S>, stop: &StopSignal) {
    let mut targets: VecDeque<(Timestamp, PixelBox)> = VecDeque::new();
    let mut told = false;
    // A channel that closes without an end belongs to a thread that panics.
    while let Ok(arriving) = arriving.recv() {
        let (at, unit, target) = match arriving {
            Arriving::Picture { at, unit, target } => (at, unit, target),
            Arriving::Failed(error) => return feed.fail(error),
            Arriving::End if stop.is_raised() => return,
            Arriving::End => return feed.sink.state(VideoState::Ended),
        };
        if stop.wait_until(feed.clock.instant(at)) {
            return;
        }
        if let Some(target) = target.filter(|_| !told) {
            targets.push_back((unit.capture.at, target));
        }
        let (units, fed) = feed.put(Some(unit));
        units.iter().for_each(|unit| feed.sink.unit(unit));
        for frame in fed.frames {
            while targets.front().is_some_and(|(at, _)| *at < frame.capture.at) {
                targets.pop_front();
            }
            if let Some((_, target)) = targets.pop_front_if(|(at, _)| *at == frame.capture.at && !told) {
                told = true;
                feed.sink.target(target);
            }
            feed.sink.frame(frame);
        }
    }
}
