//! A drive: a trial in lock step that people take part in.
//!
//! It is made of its cast (scenario, seed, size, tracker, law) and of inputs, each put in before a tick, and of nothing
//! else: the clock only says when the next tick is run. The same cast and the same inputs at the same ticks give the
//! same drive, bit for bit.

use std::sync::mpsc::{Receiver, channel};

use anyhow::{Result, anyhow};
use barrelman_pilot::{Input, Outcome, Pilot, PilotSettings};
use barrelman_sim::boat::HelmCommand;
use barrelman_sim::{Truth, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{DrawnEye, Eye, Simulation, Witness};
use barrelman_vocab::{EncodedUnit, OperatorRequest, StopCause, Timestamp, VehicleProfile, VehicleRates};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use super::coded_eye::CodedEye;
use super::render_threads::RenderThreads;
use super::url::WorldUrl;
use crate::config::{ConfigFile, Configuration};
use crate::law_choice::LawChoice;
use crate::scenario::{self, Changes, Loaded};
use crate::tracker::{TrackerName, TrackerSettings};
use crate::video::encoder::EncoderSettings;

/// A drive lasts an hour at most, whatever its scenario says of trials: somebody may steer.
pub const MOST_S: f64 = 3600.0;

/// What a drive is made of, but for its inputs.
#[derive(Debug, Clone)]
pub struct Cast {
    /// The world.
    pub url: WorldUrl,
    /// The scenario that it was loaded from.
    pub loaded: Loaded,
    /// The vehicle.
    pub profile: VehicleProfile,
    /// The tracker.
    pub tracker: TrackerName,
    /// The camera law.
    pub law: LawChoice,
    /// Whether pictures travel as H.264.
    pub coded: bool,
}

/// What somebody does in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "kebab-case")]
pub enum DriveInput {
    /// Steers: percent of the throttle (astern below 0) and of the rudder (to the left above 0).
    Helm {
        /// -100 to 100.
        thrust: i8,
        /// -100 to 100.
        rudder: i8,
    },
    /// Leaves the boat to the scenario's helmsman again.
    Helmsman,
    /// Lets the camera be moved.
    Engage,
    /// Stops the camera.
    Stop,
    /// Stops the time. Nothing in the world knows of it.
    Pause,
    /// Lets it go on.
    Resume,
}

impl DriveInput {
    /// What it does to the helm: somebody steers so, or nobody but the helmsman; `None` where it stays as it is.
    fn helm(self) -> Option<Option<HelmCommand>> {
        let share = |percent: i8| f64::from(percent.clamp(-100, 100)) / 100.0;
        match self {
            Self::Helm { thrust, rudder } => {
                Some(Some(HelmCommand { throttle: share(thrust), rudder: share(rudder) }))
            }
            Self::Helmsman => Some(None),
            Self::Engage | Self::Stop | Self::Pause | Self::Resume => None,
        }
    }

    /// Does it in a trial, before its next tick.
    pub fn act(self, simulation: &mut Simulation<'_>, witness: &mut dyn Witness) {
        if let Some(helm) = self.helm() {
            simulation.steer(helm);
        }
        match self {
            Self::Engage => simulation.request(OperatorRequest::Engage, witness),
            Self::Stop => simulation.request(OperatorRequest::Stop(StopCause::Operator), witness),
            // Of time that stands still nothing in the world knows.
            Self::Pause | Self::Resume | Self::Helm { .. } | Self::Helmsman => {}
        }
    }
}

impl Cast {
    /// The cast of a drive.
    ///
    /// # Errors
    /// If there is no such scenario, or it has a mistake.
    pub fn new(url: WorldUrl, tracker: TrackerName, law: LawChoice, coded: bool) -> Result<Self> {
        let changes = Changes { size: url.size, ..Changes::default() };
        let mut loaded = scenario::load(&url.scenario, &changes)?;
        loaded.scenario.max_s = MOST_S;
        let profile = loaded.profile()?;
        Ok(Self { url, loaded, profile, tracker, law, coded })
    }

    /// The configuration that a recording of it begins with.
    ///
    /// # Errors
    /// Never in practice: plain data can be written.
    pub fn configuration(&self) -> Result<String> {
        Configuration {
            profile: self.profile.clone(),
            law: self.law,
            tracker: TrackerSettings::of(self.tracker),
            ..Configuration::resolve(&ConfigFile::default())?
        }
        .to_toml()
    }
}

/// A drive that is under way.
pub struct Drive<'a> {
    simulation: Simulation<'a>,
    eye: Box<dyn Eye + 'a>,
    units: Receiver<EncodedUnit>,
    helm: Option<HelmCommand>,
}

impl<'a> Drive<'a> {
    /// A drive that has not begun; its camera is not engaged yet.
    ///
    /// # Errors
    /// If the scenario's way-points make no path with this seed.
    pub fn new(cast: &'a Cast, threads: &'a RenderThreads) -> Result<Self> {
        let (scenario, seed) = (&cast.loaded.scenario, cast.url.seed);
        let world = World::new(scenario, seed)
            .map_err(|_| anyhow!("the way-points of {} make no path with seed {seed}", scenario.name))?;
        let settings = PilotSettings { profile: cast.profile.clone(), law: cast.law.settings() };
        let pilot = Pilot::new(settings, TrackerSettings::of(cast.tracker).tracker()?);
        let simd = Simd::at_most(SimdLevel::Avx512);
        let drawn = DrawnEye::new(&world, scenario.camera.clone(), seed, simd, threads);
        let (to_recorder, units) = channel();
        let eye: Box<dyn Eye + 'a> = if cast.coded {
            let fps = f64::from(scenario.camera.pictures_per_second);
            let settings = EncoderSettings::for_pictures(scenario.camera.frame, fps);
            Box::new(CodedEye::new(drawn, settings, to_recorder))
        } else {
            Box::new(drawn)
        };
        let simulation = Simulation::new(scenario, world, seed, pilot, &cast.profile);
        Ok(Self { simulation, eye, units, helm: None })
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
    pub fn put(&mut self, input: DriveInput, witness: &mut dyn Witness) {
        self.helm = input.helm().unwrap_or(self.helm);
        input.act(&mut self.simulation, witness);
    }

    /// One tick.
    pub fn tick(&mut self, witness: &mut dyn DriveWitness) {
        let mut witness = Unpacking { units: &self.units, witness };
        self.simulation.tick(&mut Some(&mut *self.eye), &mut witness);
    }
}

/// Who is told what happens in a drive.
pub trait DriveWitness: Witness {
    /// A unit of video, ahead of the frame that it gives, where video is coded.
    fn unit(&mut self, _unit: EncodedUnit) {}
}

/// Hands units on before the frames that they give.
struct Unpacking<'a> {
    units: &'a Receiver<EncodedUnit>,
    witness: &'a mut dyn DriveWitness,
}

impl Witness for Unpacking<'_> {
    fn step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.units.try_iter().for_each(|unit| self.witness.unit(unit));
        self.witness.step(now, input, outcome, rates);
    }

    fn truth(&mut self, truth: &Truth) {
        self.witness.truth(truth);
    }
}

/// A hash of everything that happens in a drive: every step with its time, the picture that it saw, what it came to
/// and what was sent; and of every picture's truth.
#[derive(Default)]
pub struct DriveHash(Xxh3);

impl DriveHash {
    /// The hash so far, as it is written.
    pub fn hex(&self) -> String {
        format!("{:016x}", self.0.digest())
    }
}

impl DriveWitness for DriveHash {}

impl Witness for DriveHash {
    fn step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.0.update(&now.as_nanos().to_le_bytes());
        match input {
            Input::Frame(frame) => {
                self.0.update(b"frame");
                self.0.update(&frame.capture.at.as_nanos().to_le_bytes());
                self.0.update(frame.picture.samples());
            }
            Input::Localisation(_) => self.0.update(b"localisation"),
            Input::Telemetry(_) => self.0.update(b"telemetry"),
            Input::Request(_) => self.0.update(b"request"),
            Input::Tick => self.0.update(b"tick"),
        }
        if let Some(percept) = outcome.percept {
            for value in [percept.position.x, percept.position.y, percept.p] {
                self.0.update(&value.to_bits().to_le_bytes());
            }
        }
        for rate in [rates.yaw, rates.pitch] {
            self.0.update(&rate.radians_per_second().to_bits().to_le_bytes());
        }
    }

    fn truth(&mut self, truth: &Truth) {
        let place = truth.target.position;
        for value in [truth.image.x, truth.image.y, place.x, place.y, place.z, truth.rates.0, truth.rates.1] {
            self.0.update(&value.to_bits().to_le_bytes());
        }
    }
}
