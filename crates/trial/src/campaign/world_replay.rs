//! The pictures of a recorded trial in pixels, rendered again.
//!
//! A recording of a trial in pixels holds no pictures: scenario, seed and the recorded commands determine
//! them, to the bit. The world is run again with the commands as they were recorded, whatever the replaying
//! pilot would command, so a recording is replayed through another law or tracker on the pictures that it was
//! made with.

use std::collections::VecDeque;

use barrelman_sim::boat::HelmCommand;
use barrelman_sim::video_link::{Delivery, VideoLink};
use barrelman_sim::{Scenario, World};
use barrelman_vocab::{Timestamp, VehicleProfile, VehicleRates, VesselOrder, VideoFrame};

use super::frame_source::FrameSource as _;
use super::rendered_camera::RenderedCamera;

/// A world that is run again, with its camera.
pub struct WorldReplay<'a> {
    world: World,
    camera: RenderedCamera<'a>,
    video: VideoLink,
    profile: VehicleProfile,
    /// Recorded rates that are not in force yet.
    commands: VecDeque<(Timestamp, VehicleRates, VesselOrder)>,
    /// The last frame that was not frozen: a frozen one repeats its picture.
    last_live: Option<VideoFrame>,
    /// Frames on their way to the pilot.
    in_flight: VecDeque<VideoFrame>,
}

impl<'a> WorldReplay<'a> {
    /// The world of a trial at its start. World and camera must belong to the scenario and the seed.
    pub fn new(
        scenario: &Scenario,
        seed: u64,
        world: World,
        camera: RenderedCamera<'a>,
        profile: VehicleProfile,
    ) -> Self {
        Self {
            world,
            camera,
            video: VideoLink::new(scenario.camera.video, seed),
            profile,
            commands: VecDeque::new(),
            last_live: None,
            in_flight: VecDeque::new(),
        }
    }

    /// Adds the recorded rates of the next step, and what was asked of the boat.
    pub fn command(&mut self, at: Timestamp, rates: VehicleRates, order: VesselOrder) {
        self.commands.push_back((at, rates, order));
    }

    /// The frame with this sequence number, captured at `at`; `None` where the world has no such frame. All
    /// rates up to `at` must have been added.
    pub fn frame(&mut self, sequence: u64, at: Timestamp) -> Option<VideoFrame> {
        while self.world.now() <= at {
            self.tick();
        }
        while let Some(frame) = self.in_flight.pop_front() {
            if frame.sequence >= sequence {
                return (frame.sequence == sequence).then_some(frame);
            }
        }
        None
    }

    /// One tick, in the order of a simulated trial: capture, commands, motion.
    fn tick(&mut self) {
        if self.world.is_frame_due() {
            let frame = self.camera.capture(&self.world).frame;
            match (self.video.send(self.world.tick()), &self.last_live) {
                (Delivery::Arrives { .. }, _) => {
                    self.last_live = Some(frame.clone());
                    self.in_flight.push_back(frame);
                }
                (Delivery::Frozen { .. }, Some(live)) => {
                    self.in_flight.push_back(VideoFrame { picture: live.picture.clone(), ..frame });
                }
                (Delivery::Frozen { .. } | Delivery::Lost, _) => {}
            }
        }
        while let Some((_, rates, order)) = self.commands.pop_front_if(|(at, ..)| *at <= self.world.now()) {
            self.world.command(self.profile.from_vehicle(rates));
            self.world.override_helm(match order {
                VesselOrder::Released => None,
                VesselOrder::Commanded(command) => Some(HelmCommand::of(command)),
            });
        }
        self.world.advance();
    }
}
