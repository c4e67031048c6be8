//! A drive under way: world and pilot in lock step, one tick after the other.

use std::sync::mpsc::{Receiver, channel};

use anyhow::{Result, anyhow};
use barrelman_pilot::{Input, Outcome, Pilot, PilotSettings};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::{Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{FrameSource, RenderedCamera, Simulation, StepObserver};
use barrelman_video::encoder::EncoderSettings;
use barrelman_vocab::{EncodedUnit, Timestamp, VehicleRates};

use super::encoded_camera::EncodedCamera;
use super::input::DriveInput;
use super::setup::DriveSetup;
use crate::render_threads::RenderThreads;
use crate::tracker_choice::TrackerSettings;

/// A drive that is under way.
pub struct Drive<'a> {
    simulation: Simulation<'a>,
    camera: Box<dyn FrameSource + 'a>,
    units: Receiver<EncodedUnit>,
    helm: Option<HelmCommand>,
}

impl<'a> Drive<'a> {
    /// A drive that has not begun; its camera is not engaged yet.
    ///
    /// # Errors
    /// If the scenario's way-points make no path with this seed.
    pub fn new(cast: &'a DriveSetup, threads: &'a RenderThreads) -> Result<Self> {
        let (scenario, seed) = (&cast.loaded.scenario, cast.url.seed);
        let world = World::new(scenario, seed)
            .map_err(|_| anyhow!("the way-points of {} make no path with seed {seed}", scenario.name))?;
        let settings = PilotSettings { profile: cast.profile.clone(), law: cast.law.settings() };
        let pilot = Pilot::new(settings, TrackerSettings::of(cast.tracker).tracker()?);
        let simd = Simd::at_most(SimdLevel::Avx512);
        let drawn = RenderedCamera::new(&world, scenario.camera.clone(), seed, simd, threads);
        let (to_recorder, units) = channel();
        let camera: Box<dyn FrameSource + 'a> = if cast.coded {
            let fps = f64::from(scenario.camera.pictures_per_second);
            let settings = EncoderSettings::for_pictures(scenario.camera.frame, fps);
            Box::new(EncodedCamera::new(drawn, settings, to_recorder))
        } else {
            Box::new(drawn)
        };
        let simulation = Simulation::new(scenario, world, seed, pilot, &cast.profile);
        Ok(Self { simulation, camera, units, helm: None })
    }

    /// The world as it is now.
    pub const fn world(&self) -> &World {
        self.simulation.world()
    }

    /// Who steers, if it is not the helmsman.
    pub const fn helm(&self) -> Option<HelmCommand> {
        self.helm
    }

    /// Whether it is over.
    pub fn is_over(&self) -> bool {
        self.simulation.is_over()
    }

    /// Something is done, before the next tick.
    pub fn put(&mut self, input: DriveInput, observer: &mut dyn StepObserver) {
        self.helm = input.helm().unwrap_or(self.helm);
        input.act(&mut self.simulation, observer);
    }

    /// One tick.
    pub fn tick(&mut self, observer: &mut dyn DriveObserver) {
        let mut observer = UnitForwarder { units: &self.units, observer };
        self.simulation.tick(&mut Some(&mut *self.camera), &mut observer);
    }
}

/// Who is told what happens in a drive.
pub trait DriveObserver: StepObserver {
    /// A unit of video, ahead of the frame that it gives, where video is coded.
    fn unit(&mut self, _unit: EncodedUnit) {}
}

/// Hands units on before the frames that they give.
struct UnitForwarder<'a> {
    units: &'a Receiver<EncodedUnit>,
    observer: &'a mut dyn DriveObserver,
}

impl StepObserver for UnitForwarder<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.units.try_iter().for_each(|unit| self.observer.unit(unit));
        self.observer.on_step(now, input, outcome, rates);
    }

    fn on_truth(&mut self, truth: &Truth) {
        self.observer.on_truth(truth);
    }
}
