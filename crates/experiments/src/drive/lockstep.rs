//! A running drive: world and pilot in lock step, one tick after the other.

use std::sync::mpsc::{Receiver, channel};

use anyhow::{Result, anyhow};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{CommandPath, Input, Outcome, Pilot, PilotSettings, VesselSettings};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::{Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{FrameSource, RenderedCamera, Simulation, StepObserver};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_video::encoder::EncoderSettings;
use barrelman_vocab::{EncodedUnit, LawId, OperatorRequest, Timestamp, VehicleRates, VesselProfile};

use super::encoded_camera::EncodedCamera;
use super::setup::DriveSetup;
use crate::render_threads::RenderThreads;
use crate::tracker_choice::TrackerSettings;

/// A running drive.
pub struct Drive<'a> {
    simulation: Simulation<'a>,
    camera: Box<dyn FrameSource + 'a>,
    units: Receiver<EncodedUnit>,
}

/// The simulated boat as a vessel.
pub(crate) const fn simulated_vessel(guidance: GuidanceLaw) -> VesselSettings {
    VesselSettings { profile: VesselProfile::SIMULATOR, guidance, path: CommandPath::Simulated }
}

impl<'a> Drive<'a> {
    /// A drive before its first tick, with the camera disengaged.
    ///
    /// # Errors
    /// The scenario's way-points make no path with this seed.
    pub fn new(setup: &'a DriveSetup, threads: &'a RenderThreads) -> Result<Self> {
        let (scenario, seed) = (&setup.loaded.scenario, setup.url.seed);
        let world = World::new(scenario, seed)
            .map_err(|_| anyhow!("the way-points of {} make no path with seed {seed}", scenario.name))?
            .without_end();
        let settings = PilotSettings { profile: setup.profile.clone(), law: setup.law.settings() };
        let pilot = Pilot::new(settings, TrackerSettings::new(setup.tracker).build()?).keeping_frames();
        let simd = Simd::at_most(SimdLevel::Avx512);
        let rendered = RenderedCamera::new(&world, scenario.camera.clone(), seed, simd, threads);
        let (to_recorder, units) = channel();
        let camera: Box<dyn FrameSource + 'a> = if setup.encoded {
            let fps = f64::from(scenario.camera.pictures_per_second);
            let settings = EncoderSettings::for_pictures(scenario.camera.frame, fps);
            Box::new(EncodedCamera::new(rendered, settings, to_recorder))
        } else {
            Box::new(rendered)
        };
        let pilot = if setup.commands_vessel() {
            pilot.with_vessel(simulated_vessel(GuidanceLaw::LineOfSight))
        } else {
            pilot
        };
        let simulation = Simulation::new(scenario, world, seed, pilot, &setup.profile).with_log(false);
        let simulation = simulation.with_tilt_reports(true).with_height_reports();
        let simulation = if setup.hands_on { simulation.without_selection() } else { simulation };
        Ok(Self { simulation, camera, units })
    }

    /// The same drive, of which a log is kept.
    #[must_use]
    pub fn with_log(self) -> Self {
        Self { simulation: self.simulation.with_log(true), ..self }
    }

    /// The log so far; empty unless one is kept ([`Self::with_log`]).
    pub const fn log(&self) -> &TrialLog {
        self.simulation.log()
    }

    /// The world after the last tick.
    pub const fn world(&self) -> &World {
        self.simulation.world()
    }

    /// The law; `None`: a law that an operator cannot choose.
    pub const fn law_id(&self) -> LawId {
        self.simulation.law_id()
    }

    /// Whether a further stop would change nothing.
    pub fn is_at_rest_by_stop(&self) -> bool {
        self.simulation.is_at_rest_by_stop()
    }

    /// The outcome of the pilot's newest step.
    pub const fn outcome(&self) -> Option<&Outcome> {
        self.simulation.outcome()
    }

    /// The helm of the operator or of the guidance; `None` while the helmsman steers.
    pub fn helm(&self) -> Option<HelmCommand> {
        let vessel = self.outcome().map(|outcome| &outcome.vessel).filter(|vessel| vessel.is_commanded());
        vessel.map(|vessel| HelmCommand::of(vessel.command))
    }

    /// Passes a request to the pilot, before the next tick.
    pub fn request(&mut self, request: OperatorRequest, observer: &mut dyn StepObserver) {
        self.simulation.request(request, observer);
    }

    /// Runs one tick.
    pub fn tick(&mut self, observer: &mut dyn DriveObserver) {
        let mut observer = UnitForwarder { units: &self.units, observer };
        self.simulation.tick(&mut Some(&mut *self.camera), &mut observer);
    }
}

/// Observes the steps of a drive, and its encoded video.
pub trait DriveObserver: StepObserver {
    /// An encoded unit, before the step of its video frame. Not called for a drive without encoding.
    fn on_unit(&mut self, _unit: EncodedUnit) {}
}

/// Passes each unit to the observer before the step of its video frame.
struct UnitForwarder<'a> {
    units: &'a Receiver<EncodedUnit>,
    observer: &'a mut dyn DriveObserver,
}

impl StepObserver for UnitForwarder<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.units.try_iter().for_each(|unit| self.observer.on_unit(unit));
        self.observer.on_step(now, input, outcome, rates);
    }

    fn on_truth(&mut self, truth: &Truth, target: Option<&TargetInPicture>) {
        self.observer.on_truth(truth, target);
    }
}
