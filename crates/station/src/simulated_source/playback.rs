//! The threads of a simulated source: ticks, rendering, delivery.

use std::sync::mpsc::sync_channel;
use std::thread;

use barrelman_emulators::camera_link::{CameraLink, Pointing};
use barrelman_emulators::simulated_boat::SimulatedBoat;
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_host::clock::Clock;
use barrelman_sim::World;
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::video_link::{Delivery, VideoLink};
use barrelman_video::feed::{Feed, StopSignal};
use barrelman_video::{VideoError, VideoSink, VideoState};
use barrelman_vocab::{Timestamp, VehicleProfile, VehicleRates, VesselOrder};

use super::delivery::deliver;
use super::live_world::LiveWorld;
use super::loaded_world::LoadedWorld;
use super::moments::{Moment, Moments};
use super::next_world::NextWorld;
use super::rendering::{Rendering, RenderingSettings};

/// Largest number of pictures between rendering and arrival.
const MAX_IN_TRANSIT: usize = 128;

/// Runs a world, and those that take its place. Returns when a world is over or when the signal is raised.
pub(super) fn play<S: VideoSink>(live: LiveWorld, mut feed: Feed<S>, stop: &StopSignal) {
    let LiveWorld { url: _, first, next, link, boat, profile, encoded, threads } = live;
    feed.sink.on_state(VideoState::Up);
    let _end = EndGuard { link: &link };
    let devices = Devices { next: &next, link: &link, boat: &boat, profile: &profile };
    let (mut world, mut epoch) = (first, 0);
    while play_one(world, epoch, (encoded, &threads), devices, (&mut feed, stop)) {
        let Some(following) = next.take() else { return feed.sink.on_state(VideoState::Ended) };
        (world, epoch) = (following, epoch + 1);
    }
}

/// Runs one world. Returns whether the world is over.
fn play_one<S: VideoSink>(
    LoadedWorld { scenario, world, seed }: LoadedWorld,
    epoch: u32,
    (encoded, threads): (bool, &RenderThreads),
    devices: Devices<'_>,
    (feed, stop): (&mut Feed<S>, &StopSignal),
) -> bool {
    let clock = feed.clock;
    let start = clock.now();
    let moments = Moments::default();
    let rendering = RenderingSettings {
        first: world.clone(),
        camera: scenario.camera.clone(),
        seed,
        start,
        epoch,
        encoded,
        threads,
    };
    let ticking = Ticking { world, camera: &scenario.camera, seed, devices, clock, start };
    let (units, arriving) = sync_channel(MAX_IN_TRANSIT);
    // The feed lives outside the scope: a panic in a thread of the scope drops its sink, which reports the
    // panic.
    thread::scope(|scope| {
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        let moments = &moments;
        let started = named("world").spawn_scoped(scope, || ticking.run(moments, stop)).and_then(|_| {
            named("render").spawn_scoped(scope, move || Rendering::new(rendering).run(moments, &units))
        });
        let is_over = if let Err(error) = started {
            moments.close(true);
            feed.fail(VideoError::Thread(error));
            false
        } else {
            deliver(&arriving, feed, stop)
        };
        // Releases a thread that waits for a moment or for room in the channel.
        moments.close(false);
        drop(arriving);
        is_over
    })
}

/// What outlasts a world.
#[derive(Clone, Copy)]
struct Devices<'a> {
    next: &'a NextWorld,
    link: &'a CameraLink,
    boat: &'a SimulatedBoat,
    /// The vehicle, whose signs the rates on the link have.
    profile: &'a VehicleProfile,
}

/// Tells the link that no further world follows, also after a panic.
struct EndGuard<'a> {
    link: &'a CameraLink,
}

impl Drop for EndGuard<'_> {
    fn drop(&mut self) {
        self.link.end_world();
    }
}

/// Takes no further picture when the thread `world` ends, also by a panic.
struct CloseGuard<'a> {
    moments: &'a Moments,
}

impl Drop for CloseGuard<'_> {
    fn drop(&mut self) {
        self.moments.close(thread::panicking());
    }
}

/// The work of the thread `world`.
struct Ticking<'a> {
    world: World,
    camera: &'a CameraSetup,
    seed: u64,
    devices: Devices<'a>,
    clock: Clock,
    start: Timestamp,
}

impl Ticking<'_> {
    fn run(self, moments: &Moments, stop: &StopSignal) {
        let Self { mut world, camera, seed, devices, clock, start } = self;
        let Devices { next, link, boat, profile } = devices;
        let _end = CloseGuard { moments };
        let mut video = VideoLink::new(camera.video, seed);
        let mut commanded = VehicleRates::REST;
        let mut ordered = VesselOrder::Released;
        loop {
            let due = start.plus(World::time_of(world.tick()).since(Timestamp::ZERO));
            if stop.wait_until(clock.instant(due)) || world.is_over() || moments.newest.is_closed() {
                return;
            }
            if next.is_waiting() {
                return;
            }
            let rates = link.read_rates(clock.now());
            if std::mem::replace(&mut commanded, rates) != rates {
                world.command(profile.from_vehicle(rates));
            }
            let order = boat.order(clock.now());
            if std::mem::replace(&mut ordered, order) != order {
                let helm = match order {
                    VesselOrder::Released => None,
                    VesselOrder::Commanded(command) => Some(HelmCommand::of(command)),
                };
                world.override_helm(helm);
            }
            let pose = world.camera_pose();
            link.set_pointing(Pointing {
                pan: pose.pan,
                tilt: pose.tilt,
                height_m: pose.position.z,
                field_of_view: world.zoomed_field_of_view(),
            });
            if world.is_frame_due() {
                match video.send(world.tick()) {
                    Delivery::Lost => {}
                    delivery => drop(moments.newest.put(Moment { world: world.clone(), delivery })),
                }
            }
            world.advance();
        }
    }
}
