//! What a campaign is: scenario, law, seeds; and one trial of it.

use anyhow::{Context, Result, bail};
use barrelman_control::{CameraLaw, Law};
use barrelman_pilot::{Pilot, PilotSettings};
use barrelman_sim::render::Serial;
use barrelman_sim::{Scenario, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{
    CampaignEntry, CampaignSettings, FrameSource, RenderedCamera, Simulation, StepObserver,
};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::{Arena, TrialEntry, measure};
use barrelman_vocab::{AngularRate, VehicleProfile};
use clap::ValueEnum;

use super::drive_inputs::DriveInputs;
use super::recording::{TrialRecorder, TrialRecording};
use crate::drive;
use crate::law_choice::LawChoice;
use crate::scenario::{self, LoadedScenario, ScenarioOverrides};
use crate::tracker_choice::{TrackerName, TrackerSettings};

/// How the pilot comes to know where the target is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Perception {
    /// From truth, with noise.
    Truth,
    /// From pictures, with a tracker.
    Pixels(TrackerName),
}

/// Which plant simulated trials have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PlantName {
    /// The scenario's.
    #[default]
    Nominal,
    /// Drawn for each trial.
    Drawn,
}

impl PlantName {
    /// As it is written on the command line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Drawn => "drawn",
        }
    }
}

/// What is asked of a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignRequest {
    /// Name or file of the scenario.
    pub scenario: String,
    /// What differs from it.
    pub changes: ScenarioOverrides,
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
pub struct CampaignPlan {
    loaded: LoadedScenario,
    settings: CampaignSettings,
    profile: VehicleProfile,
    law: LawChoice,
    tracker: TrackerName,
    plant: PlantName,
    simd: Simd,
    /// How the boat is steered, where that is not the scenario's helmsman's affair.
    drive_inputs: Option<DriveInputs>,
    /// Whether the gimbal reports the camera's tilt.
    reports_tilt: bool,
    /// How trials are recorded.
    record: Option<TrialRecording>,
}

impl CampaignPlan {
    /// Makes a plan of what is asked for.
    ///
    /// # Errors
    /// If the scenario cannot be used.
    pub fn new(request: &CampaignRequest) -> Result<Self> {
        let mut loaded = scenario::load(&request.scenario, &request.changes)?;
        let mut profile = loaded.profile()?;
        if let Some(rate) = request.rate {
            // The sweep over rates is about the rate: the simulated vehicle, too, is made able to turn so fast.
            profile = profile.with_motor_schema_rate(AngularRate::from_radians_per_second(rate));
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
            law_behaviour: request.law.behaviour_version(),
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
            tracker_behaviour: tracker.map(TrackerName::behaviour_version),
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
            drive_inputs: None,
            reports_tilt: false,
            record: None,
        })
    }

    /// The same plan with every trial recorded in a folder, which is made.
    ///
    /// # Errors
    /// If the folder cannot be made.
    pub fn recorded(mut self, recording: TrialRecording) -> Result<Self> {
        std::fs::create_dir_all(&recording.folder)
            .with_context(|| format!("the folder {} cannot be made", recording.folder.display()))?;
        self.record = Some(recording);
        Ok(self)
    }

    /// The camera law.
    pub const fn law(&self) -> LawChoice {
        self.law
    }

    /// The tracker.
    pub const fn tracker(&self) -> TrackerName {
        self.tracker
    }

    /// The same plan with a gimbal that reports the camera's tilt.
    #[must_use]
    pub fn with_tilt_reports(mut self, reports_tilt: bool) -> Self {
        self.reports_tilt = reports_tilt;
        self
    }

    /// The same plan with the boat steered as in a drive, for as long as that was.
    #[must_use]
    pub fn with_drive(mut self, drive_inputs: DriveInputs) -> Self {
        self.settings.drive = Some(drive_inputs.hash());
        self.drive_inputs = Some(drive_inputs);
        self.with_max_duration(drive::MAX_S)
    }

    /// The same plan with trials that last so long, unless the target is at the end of its path before.
    #[must_use]
    pub fn with_max_duration(mut self, seconds: f64) -> Self {
        self.loaded.scenario.max_s = seconds;
        self
    }

    /// The same plan in a world that differs from the scenario, of which law and pilot know nothing.
    #[must_use]
    pub fn with_changed_scenario(mut self, change: impl FnOnce(&mut Scenario)) -> Self {
        change(&mut self.loaded.scenario);
        self
    }

    /// The same plan with a vehicle that is said to be otherwise than it is.
    #[must_use]
    pub fn with_changed_profile(mut self, change: impl FnOnce(&mut VehicleProfile)) -> Self {
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
    pub fn log(&self, seed: u64, observer: &mut dyn StepObserver) -> Result<TrialLog> {
        self.simulate_with_law(None, seed, observer)
    }

    /// The same with a law of one's own in place of the one that was asked for.
    ///
    /// # Errors
    /// If it cannot be set up.
    pub fn simulate_with_law(
        &self,
        law: Option<Box<dyn Law>>,
        seed: u64,
        observer: &mut dyn StepObserver,
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
            Some(law) => Pilot::with_law(settings, CameraLaw::from_law(law, &self.profile), tracker),
            None => Pilot::new(settings, tracker),
        };
        // Trials run beside each other, each on one thread.
        let in_pixels = self.settings.tracker.is_some();
        let mut camera =
            in_pixels.then(|| RenderedCamera::new(&world, scenario.camera.clone(), seed, self.simd, &Serial));
        let camera = camera.as_mut().map(|camera| camera as &mut dyn FrameSource);
        let simulation = Simulation::new(&scenario, world, seed, pilot, &self.profile)
            .with_tilt_reports(self.reports_tilt);
        Ok(match &self.drive_inputs {
            Some(drive_inputs) => drive_inputs.run(simulation, camera, observer),
            None => simulation.run(camera, observer),
        })
    }

    /// Runs one trial, and records it where that was asked for.
    ///
    /// # Errors
    /// If it cannot be set up, or its recording not be written.
    fn simulate_recorded(&self, seed: u64) -> Result<TrialLog> {
        let Some(recording) = &self.record else {
            return self.log(seed, &mut ());
        };
        let name = format!("{}-{seed}", self.settings.scenario);
        let video = format!("sim:{}?seed={seed}", self.settings.scenario);
        let behaviour = self.law.behaviour_with(self.tracker);
        let mut recorder = TrialRecorder::begin(recording, &name, video, behaviour, &self.profile)?;
        let log = self.log(seed, &mut recorder)?;
        recorder.finish()?;
        Ok(log)
    }

    /// Runs one trial.
    ///
    /// # Errors
    /// If it cannot be set up.
    pub fn run(&self, seed: u64) -> Result<CampaignEntry> {
        let log = self.simulate_recorded(seed).with_context(|| format!("trial {seed}"))?;
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
        "lab1" | "arena1" => Arena::from_number(1),
        "lab2" | "arena2" => Arena::from_number(2),
        _ => None,
    }
}
