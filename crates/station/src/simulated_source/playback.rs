//! The threads of a simulated source: ticks, rendering, delivery.

use std::sync::mpsc::sync_channel;
use std::thread;

use barrelman_emulators::camera_link::{CameraLink, Pointing};
use barrelman_emulators::simulated_boat::SimulatedBoat;
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
use super::moments::{Moment, Moments};
use super::rendering::{Rendering, RenderingSettings};

/// Largest number of pictures between rendering and arrival.
const MAX_IN_TRANSIT: usize = 128;

/// Runs a world. Returns when the world is over or when the signal is raised.
pub(super) fn play<S: VideoSink>(live: LiveWorld, mut feed: Feed<S>, stop: &StopSignal) {
    let LiveWorld { scenario, world, seed, link, boat, profile, encoded, threads } = live;
    feed.sink.on_state(VideoState::Up);
    let clock = feed.clock;
    let start = clock.now();
    let moments = Moments::default();
    let rendering = RenderingSettings {
        first: world.clone(),
        camera: scenario.camera.clone(),
        seed,
        start,
        encoded,
        threads: &threads,
    };
    let ticking = Ticking {
        world,
        camera: &scenario.camera,
        seed,
        link: &link,
        boat: &boat,
        profile: &profile,
        clock,
        start,
    };
    let (units, arriving) = sync_channel(MAX_IN_TRANSIT);
    // The feed lives outside the scope: a panic in a thread of the scope drops its sink, which reports the panic.
    thread::scope(|scope| {
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        let moments = &moments;
        let started = named("world").spawn_scoped(scope, || ticking.run(moments, stop)).and_then(|_| {
            named("render").spawn_scoped(scope, move || Rendering::new(rendering).run(moments, &units))
        });
        if let Err(error) = started {
            moments.close(true);
            feed.fail(VideoError::Thread(error));
        } else {
            deliver(&arriving, &mut feed, stop);
        }
        // Releases a thread that waits for a moment or for room in the channel.
        moments.close(false);
        drop(arriving);
    });
}

/// Reports the end of the world when the thread `world` ends, also by a panic.
struct EndGuard<'a> {
    moments: &'a Moments,
    link: &'a CameraLink,
}

impl Drop for EndGuard<'_> {
    fn drop(&mut self) {
        self.moments.close(thread::panicking());
        self.link.end_world();
    }
}

/// The work of the thread `world`.
struct Ticking<'a> {
    world: World,
    camera: &'a CameraSetup,
    seed: u64,
    link: &'a CameraLink,
    boat: &'a SimulatedBoat,
    /// The vehicle, whose signs the rates on the link have.
    profile: &'a VehicleProfile,
    clock: Clock,
    start: Timestamp,
}

impl Ticking<'_> {
    fn run(self, moments: &Moments, stop: &StopSignal) {
        let Self { mut world, camera, seed, link, boat, profile, clock, start } = self;
        let _end = EndGuard { moments, link };
        let mut video = VideoLink::new(camera.video, seed);
        let mut commanded = VehicleRates::REST;
        let mut ordered = VesselOrder::Released;
        loop {
            let due = start.plus(World::time_of(world.tick()).since(Timestamp::ZERO));
            if stop.wait_until(clock.instant(due)) || world.is_over() || moments.newest.is_closed() {
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
            link.set_pointing(Pointing { pan: pose.pan, tilt: pose.tilt, height_m: pose.position.z });
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
