//! What a campaign is: scenario, law, seeds; and one trial of it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use barrelman_control::{CameraLaw, Law};
use barrelman_pilot::{Pilot, PilotSettings};
use barrelman_sim::render::Serial;
use barrelman_sim::{Scenario, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{CampaignEntry, CampaignSettings, DrawnEye, Eye, Simulation, Witness};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::{Arena, TrialEntry, measure};
use barrelman_vocab::{AngularRate, VehicleProfile};

use super::driven::Driven;
use super::recording::TrialRecorder;
use crate::cli::PlantName;
use crate::config::{ConfigFile, Configuration};
use crate::law_choice::LawChoice;
use crate::scenario::{self, Changes, Loaded};
use crate::tracker::{TrackerName, TrackerSettings};
use crate::world::drive;

/// How the pilot comes to know where the target is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Perception {
    /// From truth, with noise.
    Truth,
    /// From pictures, with a tracker.
    Pixels(TrackerName),
}

/// What is asked of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Name or file of the scenario.
    pub scenario: String,
    /// What differs from it.
    pub changes: Changes,
    /// The law.
    pub law: LawChoice,
    /// Rate of the schema, rad/s.
    pub rate: Option<f64>,
    /// How the pilot comes to know where the target is.
    pub perception: Perception,
    /// Nominal or drawn.
    pub plant: PlantName,
    /// Bounds the vector instructions that pictures are drawn with.
    pub simd: SimdLevel,
}

/// A campaign that can be run.
#[derive(Debug, Clone)]
pub struct Plan {
    loaded: Loaded,
    settings: CampaignSettings,
    profile: VehicleProfile,
    law: LawChoice,
    tracker: TrackerName,
    plant: PlantName,
    simd: Simd,
    /// How the boat is steered, where that is not the scenario's helmsman's affair.
    driven: Option<Driven>,
    /// Whether the gimbal reports the camera's tilt.
    reports_tilt: bool,
    /// Where trials are recorded, and whether files there may be overwritten.
    record: Option<(PathBuf, bool)>,
}

impl Plan {
    /// Makes a plan of what is asked for.
    ///
    /// # Errors
    /// If the scenario cannot be used.
    pub fn new(request: &Request) -> Result<Self> {
        let mut loaded = scenario::load(&request.scenario, &request.changes)?;
        let mut profile = loaded.profile()?;
        if let Some(rate) = request.rate {
            // The sweep over rates is about the rate: the simulated vehicle, too, is made able to turn so fast.
            profile = profile.with_schema_rate(AngularRate::from_radians_per_second(rate));
            let mount = &mut loaded.scenario.mount;
            (mount.pan.max_rate, mount.tilt.max_rate) = (profile.limits.pan, profile.limits.tilt);
        }
        let (perception, tracker) = match request.perception {
            Perception::Truth => ("truth", None),
            Perception::Pixels(tracker) => ("pixels", Some(tracker)),
        };
        let settings = CampaignSettings {
            scenario: loaded.scenario.name.clone(),
            scenario_hash: format!("{:016x}", loaded.hash),
            law: request.law.word().to_owned(),
            mode: request.law.mode_word().map(str::to_owned),
            horizon_s: request.law.horizon_s,
            rate_rad_per_s: request.rate,
            perception: perception.to_owned(),
            setting: loaded.setting.clone(),
            plant: request.plant.word().to_owned(),
            sea_state: request.changes.sea_state,
            wind_m_per_s: request.changes.wind_m_per_s,
            boat_speed_m_per_s: request.changes.boat_speed_m_per_s,
            size: request.changes.size.map(|size| format!("{}x{}", size.width, size.height)),
            tracker: tracker.map(|tracker| tracker.word().to_owned()),
            drive: None,
            program: env!("CARGO_PKG_VERSION").to_owned(),
        };
        Ok(Self {
            loaded,
            settings,
            profile,
            law: request.law,
            tracker: tracker.unwrap_or(TrackerName::Camshift),
            plant: request.plant,
            simd: Simd::at_most(request.simd),
            driven: None,
            reports_tilt: false,
            record: None,
        })
    }

    /// The same plan with every trial recorded in a folder, which is made.
    ///
    /// # Errors
    /// If the folder cannot be made.
    pub fn recorded_in(mut self, folder: &Path, force: bool) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("the folder {} cannot be made", folder.display()))?;
        self.record = Some((folder.to_owned(), force));
        Ok(self)
    }

    /// The same plan with a gimbal that reports the camera's tilt.
    #[must_use]
    pub fn reporting_tilt(mut self, reports_tilt: bool) -> Self {
        self.reports_tilt = reports_tilt;
        self
    }

    /// The same plan with the boat steered as in a drive, for as long as that was.
    #[must_use]
    pub fn driven_by(mut self, driven: Driven) -> Self {
        self.settings.drive = Some(driven.hash());
        self.driven = Some(driven);
        self.lasting(drive::MOST_S)
    }

    /// The same plan with trials that last so long, unless the target is at the end of its path before.
    #[must_use]
    pub fn lasting(mut self, seconds: f64) -> Self {
        self.loaded.scenario.max_s = seconds;
        self
    }

    /// The same plan in a world that differs from the scenario, of which law and pilot know nothing.
    #[must_use]
    pub fn in_changed_world(mut self, change: impl FnOnce(&mut Scenario)) -> Self {
        change(&mut self.loaded.scenario);
        self
    }

    /// The same plan with a vehicle that is said to be otherwise than it is.
    #[must_use]
    pub fn with_profile(mut self, change: impl FnOnce(&mut VehicleProfile)) -> Self {
        change(&mut self.profile);
        self
    }

    /// The vehicle as law and pilot know it.
    pub const fn profile(&self) -> &VehicleProfile {
        &self.profile
    }

    /// The scenario, with what was changed about it.
    pub const fn scenario(&self) -> &Scenario {
        &self.loaded.scenario
    }

    /// What the campaign's settings are.
    pub const fn settings(&self) -> &CampaignSettings {
        &self.settings
    }

    /// Runs one trial and says how the target moved in the picture.
    ///
    /// # Errors
    /// If it cannot be set up.
    pub fn log(&self, seed: u64, witness: &mut dyn Witness) -> Result<TrialLog> {
        self.log_by(None, seed, witness)
    }

    /// The same with a law of one's own in place of the one that was asked for.
    ///
    /// # Errors
    /// If it cannot be set up.
    pub fn log_by(
        &self,
        law: Option<Box<dyn Law>>,
        seed: u64,
        witness: &mut dyn Witness,
    ) -> Result<TrialLog> {
        let scenario = match self.plant {
            PlantName::Nominal => self.loaded.scenario.clone(),
            PlantName::Drawn => self.loaded.scenario.with_sampled_plant(seed),
        };
        let Ok(world) = World::new(&scenario, seed) else {
            bail!("the way-points of {} make no path in trial {seed}", scenario.name);
        };
        let settings = PilotSettings { profile: self.profile.clone(), law: self.law.settings() };
        let tracker = TrackerSettings::of(self.tracker).tracker()?;
        let pilot = match law {
            Some(law) => Pilot::with_law(settings, CameraLaw::of(law, &self.profile), tracker),
            None => Pilot::new(settings, tracker),
        };
        // Trials run beside each other, each on one thread.
        let in_pixels = self.settings.tracker.is_some();
        let mut eye =
            in_pixels.then(|| DrawnEye::new(&world, scenario.camera.clone(), seed, self.simd, &Serial));
        let eye = eye.as_mut().map(|eye| eye as &mut dyn Eye);
        let simulation =
            Simulation::new(&scenario, world, seed, pilot, &self.profile).reporting_tilt(self.reports_tilt);
        Ok(match &self.driven {
            Some(driven) => driven.run(simulation, eye, witness),
            None => simulation.run(eye, witness),
        })
    }

    /// Runs one trial, and records it where that was asked for.
    ///
    /// # Errors
    /// If it cannot be set up, or its recording not be written.
    fn watched(&self, seed: u64) -> Result<TrialLog> {
        let Some((folder, force)) = &self.record else {
            return self.log(seed, &mut ());
        };
        let configuration = Configuration {
            profile: self.profile.clone(),
            law: self.law,
            tracker: TrackerSettings::of(self.tracker),
            ..Configuration::resolve(&ConfigFile::default())?
        };
        let name = format!("{}-{seed}", self.settings.scenario);
        let video = format!("sim:{}?seed={seed}", self.settings.scenario);
        let configuration = configuration.to_toml()?;
        let mut recorder = TrialRecorder::begin(folder, &name, *force, configuration, video, &self.profile)?;
        let log = self.log(seed, &mut recorder)?;
        recorder.finish()?;
        Ok(log)
    }

    /// Runs one trial.
    ///
    /// # Errors
    /// If it cannot be set up.
    pub fn run(&self, seed: u64) -> Result<CampaignEntry> {
        let log = self.watched(seed).with_context(|| format!("trial {seed}"))?;
        Ok(CampaignEntry { seed, trial: self.entry(seed, &log), campaign: self.settings.clone() })
    }

    /// A trial's name and metrics.
    pub fn entry(&self, seed: u64, log: &TrialLog) -> TrialEntry {
        let metrics = measure(log, log.region(self.profile.region), log.picture);
        let name = format!("{}/{seed}", self.settings.scenario);
        TrialEntry { name, arena: arena_of(&self.settings.scenario), metrics }
    }
}

/// The paper's arena that a built-in scenario is about; `None` for the others.
pub fn arena_of(scenario: &str) -> Option<Arena> {
    match scenario {
        "lab1" | "arena1" => Arena::numbered(1),
        "lab2" | "arena2" => Arena::numbered(2),
        _ => None,
    }
}
