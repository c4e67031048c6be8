//! The plan of a campaign: scenario, law, tracker, vehicle. Runs one trial of it for a seed.

use anyhow::{Context, Result, bail};
use barrelman_control::{CameraLaw, Law};
use barrelman_pilot::vessel::GuidanceLaw;
use barrelman_pilot::{Pilot, PilotSettings};
use barrelman_sim::render::Serial;
use barrelman_sim::scenario::TargetScript;
use barrelman_sim::snapshot::ObjectKind;
use barrelman_sim::{Scenario, World};
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{
    CampaignEntry, CampaignSettings, FrameSource, RenderedCamera, ReportErrors, Simulation, StepObserver,
};
use barrelman_trial::logs::TrialLog;
use barrelman_trial::metrics::{Arena, TrialEntry, measure};
use barrelman_trial::records::SimulatedTrial;
use barrelman_vocab::{AngularRate, Framed, Named as _, VehicleProfile};
use clap::ValueEnum;

use super::drive_requests::DriveRequests;
use super::recording::{RecordedRun, TrialRecorder, TrialRecording};
use super::simulated_time::SimulatedTime;
use crate::drive;
use crate::law_choice::LawChoice;
use crate::scenario::{self, LoadedScenario, ScenarioOverrides};
use crate::tracker_choice::{TrackerName, TrackerSettings};

/// The source of the pilot's localisations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Perception {
    /// Ground truth with noise.
    Truth,
    /// A tracker on rendered pictures.
    Pixels(TrackerName),
}

/// The name of a guidance law on the command line and in a campaign's file.
const fn guidance_name(guidance: GuidanceLaw) -> &'static str {
    match guidance {
        GuidanceLaw::LineOfSight => "los",
        GuidanceLaw::Laboratory => "lab",
        GuidanceLaw::ByHand => "hand",
    }
}

/// The plant (camera axes and optics) of simulated trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PlantName {
    /// The scenario's nominal plant.
    #[default]
    Nominal,
    /// Sampled for each trial from the scenario's intervals.
    #[value(name = "drawn")]
    Sampled,
}

impl PlantName {
    /// The name on the command line and in a campaign's file.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Sampled => "drawn",
        }
    }
}

/// The choices that define a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignRequest {
    /// Name or file of the scenario.
    pub scenario: String,
    /// Values that replace those of the scenario.
    pub overrides: ScenarioOverrides,
    /// The camera law.
    pub law: LawChoice,
    /// Rate of the motor schema, rad/s; `None` for the vehicle's.
    pub rate: Option<f64>,
    /// The law that guides the boat to a person; `None`: the scenario's helmsman steers.
    pub guidance: Option<GuidanceLaw>,
    /// The source of the pilot's localisations.
    pub perception: Perception,
    /// The plant of the trials.
    pub plant: PlantName,
    /// Highest level of vector instructions for rendering.
    pub simd: SimdLevel,
}

/// A campaign that can be run.
#[derive(Debug, Clone)]
pub struct CampaignPlan {
    loaded: LoadedScenario,
    settings: CampaignSettings,
    profile: VehicleProfile,
    law: LawChoice,
    guidance: Option<GuidanceLaw>,
    tracker: TrackerName,
    plant: PlantName,
    simd: Simd,
    /// The inputs of a drive that steer the boat; `None` where the scenario's helmsman steers.
    drive_requests: Option<DriveRequests>,
    /// Whether the gimbal reports the camera's tilt.
    reports_tilt: bool,
    report_errors: ReportErrors,
    /// Settings of the recordings; `None` where no trial is recorded.
    recordings: Option<TrialRecording>,
    /// Counts the simulated time of all trials.
    simulated: SimulatedTime,
}

impl CampaignPlan {
    /// Makes a plan from a request.
    ///
    /// # Errors
    /// The scenario does not exist or has a mistake.
    pub fn new(request: &CampaignRequest) -> Result<Self> {
        Self::of_scenario(scenario::load(&request.scenario, &request.overrides)?, request)
    }

    /// Makes a plan from a request whose scenario is loaded.
    ///
    /// # Errors
    /// The target's way-points make no path.
    pub(super) fn of_scenario(mut loaded: LoadedScenario, request: &CampaignRequest) -> Result<Self> {
        let mut profile = loaded.profile()?;
        if let Some(rate) = request.rate {
            // For a sweep over rates, the simulated mount gets the same limits.
            profile = profile.with_motor_schema_rate(AngularRate::from_radians_per_second(rate));
            let mount = &mut loaded.scenario.mount;
            (mount.pan.max_rate, mount.tilt.max_rate) = (profile.limits.pan, profile.limits.tilt);
        }
        let (perception, tracker) = match request.perception {
            Perception::Truth => ("truth", None),
            Perception::Pixels(tracker) => ("pixels", Some(tracker)),
        };
        if request.guidance.is_some() && !has_person(&loaded.scenario) {
            bail!(
                "there is nobody to go to in {}: --guidance is for scenarios with a boat and a swimmer (rescue, rescue-current, rescue-surf, rescue-four, two-boats)",
                loaded.scenario.name
            );
        }
        let settings = CampaignSettings {
            scenario: loaded.scenario.name.clone(),
            scenario_hash: format!("{:016x}", loaded.hash),
            law: request.law.law.name().key().to_owned(),
            mode: request.law.law.mode().map(|mode| mode.key().to_owned()),
            horizon_s: request.law.horizon_s,
            frame: (request.law.framed != Framed::Boat).then(|| request.law.framed.key().to_owned()),
            rate_rad_per_s: request.rate,
            perception: perception.to_owned(),
            setting: loaded.setting.clone(),
            plant: request.plant.as_str().to_owned(),
            sea_state: request.overrides.sea_state,
            wind_m_per_s: request.overrides.wind_m_per_s,
            boat_speed_m_per_s: request.overrides.boat_speed_m_per_s,
            size: request.overrides.size.map(|size| format!("{}x{}", size.width, size.height)),
            tracker: tracker.map(|tracker| tracker.as_str().to_owned()),
            guidance: request.guidance.map(|guidance| guidance_name(guidance).to_owned()),
            current_m_per_s: request.overrides.current_m_per_s,
            drive: None,
            program: barrelman_host::program::identity().to_owned(),
        };
        Ok(Self {
            loaded,
            settings,
            profile,
            law: request.law,
            guidance: request.guidance,
            tracker: tracker.unwrap_or(TrackerName::Camshift),
            plant: request.plant,
            simd: Simd::at_most(request.simd),
            drive_requests: None,
            reports_tilt: false,
            report_errors: ReportErrors::NONE,
            recordings: None,
            simulated: SimulatedTime::default(),
        })
    }

    /// The plan with every trial recorded. Creates the folder of the recordings.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn with_recordings(mut self, recordings: TrialRecording) -> Result<Self> {
        std::fs::create_dir_all(&recordings.folder)
            .with_context(|| format!("the folder {} cannot be made", recordings.folder.display()))?;
        self.recordings = Some(recordings);
        Ok(self)
    }

    /// How much time the trials have simulated so far, finished ones and running ones together.
    pub fn simulated_time(&self) -> SimulatedTime {
        self.simulated.clone()
    }

    /// The camera law.
    pub const fn law(&self) -> LawChoice {
        self.law
    }

    /// The tracker.
    pub const fn tracker(&self) -> TrackerName {
        self.tracker
    }

    /// The plan with a gimbal that reports the camera's tilt.
    #[must_use]
    pub fn with_tilt_reports(mut self, reports_tilt: bool) -> Self {
        self.reports_tilt = reports_tilt;
        self
    }

    /// The plan with a vehicle whose reports are off.
    #[must_use]
    pub const fn with_report_errors(mut self, report_errors: ReportErrors) -> Self {
        self.report_errors = report_errors;
        self
    }

    /// The plan with the boat steered by the inputs of a drive, for the duration of the drive.
    #[must_use]
    pub fn with_drive(mut self, drive_requests: DriveRequests) -> Self {
        self.settings.drive = Some(drive_requests.hash());
        let duration_s = drive_requests.duration_s();
        self.drive_requests = Some(drive_requests);
        self.with_max_duration(duration_s)
    }

    /// The plan with another maximum duration of a trial. A trial ends earlier where the target reaches the
    /// end of its path.
    #[must_use]
    pub fn with_max_duration(mut self, seconds: f64) -> Self {
        self.loaded.scenario.max_s = seconds;
        self
    }

    /// The plan with a changed world. Law and pilot keep the vehicle profile of the unchanged scenario.
    #[must_use]
    pub fn with_changed_scenario(mut self, change: impl FnOnce(&mut Scenario)) -> Self {
        change(&mut self.loaded.scenario);
        self
    }

    /// The plan with a changed vehicle profile, in an unchanged world.
    #[must_use]
    pub fn with_changed_profile(mut self, change: impl FnOnce(&mut VehicleProfile)) -> Self {
        change(&mut self.profile);
        self
    }

    /// The vehicle profile that law and pilot use.
    pub const fn profile(&self) -> &VehicleProfile {
        &self.profile
    }

    /// The scenario, with all overrides and changes.
    pub const fn scenario(&self) -> &Scenario {
        &self.loaded.scenario
    }

    /// The settings in the campaign's file.
    pub const fn settings(&self) -> &CampaignSettings {
        &self.settings
    }

    /// Runs one trial and returns the log of the target's positions and the commands.
    ///
    /// # Errors
    /// The way-points make no path with this seed, or a tracker setting lies out of its range.
    pub fn simulate(&self, seed: u64, observer: &mut dyn StepObserver) -> Result<TrialLog> {
        self.simulate_with_law(None, seed, observer)
    }

    /// Runs one trial with `law` instead of the plan's law; `None` for the plan's law.
    ///
    /// # Errors
    /// As [`Self::simulate`].
    pub fn simulate_with_law(
        &self,
        law: Option<Box<dyn Law>>,
        seed: u64,
        observer: &mut dyn StepObserver,
    ) -> Result<TrialLog> {
        let (scenario, world) = self.world(seed)?;
        let settings = PilotSettings { profile: self.profile.clone(), law: self.law.settings() };
        let tracker = TrackerSettings::new(self.tracker).build()?;
        let pilot = match law {
            Some(law) => Pilot::with_law(settings, CameraLaw::from_law(law, &self.profile), tracker),
            None => Pilot::new(settings, tracker),
        };
        // A person who drove may have selected on an earlier picture.
        let pilot = match &self.drive_requests {
            Some(drive) if drive.commands_vessel => {
                pilot.keeping_frames().with_vessel(drive::simulated_vessel(GuidanceLaw::LineOfSight))
            }
            Some(_) => pilot.keeping_frames(),
            None => match self.guidance {
                Some(guidance) => pilot.keeping_frames().with_vessel(drive::simulated_vessel(guidance)),
                None => pilot,
            },
        };
        // Trials run in parallel, each on one thread.
        let in_pixels = self.settings.tracker.is_some();
        let mut camera =
            in_pixels.then(|| RenderedCamera::new(&world, scenario.camera.clone(), seed, self.simd, &Serial));
        let camera = camera.as_mut().map(|camera| camera as &mut dyn FrameSource);
        let simulation = Simulation::new(&scenario, world, seed, pilot, &self.profile)
            .with_tilt_reports(self.reports_tilt || self.guidance.is_some());
        let simulation = simulation.with_report_errors(self.report_errors);
        let simulation = match self.guidance {
            Some(_) => simulation.with_height_reports().with_rescue(scenario.camera.optics, seed),
            None => simulation,
        };
        Ok(match &self.drive_requests {
            // In a drive, a person selected, or the demo by the exact box.
            Some(drive_requests) => drive_requests.run(simulation, camera, observer),
            None => simulation.with_selection_by_hand(seed).run(camera, observer),
        })
    }

    /// The scenario and the world of one trial, at its start.
    pub(super) fn world(&self, seed: u64) -> Result<(Scenario, World)> {
        let scenario = match self.plant {
            PlantName::Nominal => self.loaded.scenario.clone(),
            PlantName::Sampled => self.loaded.scenario.with_sampled_plant(seed),
        };
        let Ok(world) = World::new(&scenario, seed) else {
            bail!("the way-points of {} make no path in trial {seed}", scenario.name);
        };
        // A drive ends where its file says so.
        let world = if self.drive_requests.is_some() { world.without_end() } else { world };
        Ok((scenario, world))
    }

    /// Runs one trial, and records it if the plan has recordings.
    ///
    /// # Errors
    /// As [`Self::simulate`], and a recording that cannot be written.
    fn simulate_recorded(&self, seed: u64) -> Result<TrialLog> {
        let Some(recording) = &self.recordings else {
            return self.simulate(seed, &mut self.simulated.counting(&mut ()));
        };
        let name = format!("{}-{seed}", self.settings.scenario);
        let run = RecordedRun {
            video: format!("sim:{}?seed={seed}", self.settings.scenario),
            trial: Some(SimulatedTrial {
                seed,
                settings: serde_json::to_string(&self.settings)?,
                scenario: self.loaded.text.clone(),
            }),
        };
        let mut recorder = TrialRecorder::begin(recording, &name, run, &self.profile)?;
        let log = self.simulate(seed, &mut self.simulated.counting(&mut recorder))?;
        recorder.finish()?;
        Ok(log)
    }

    /// Runs one trial and returns its entry in the campaign's file.
    ///
    /// # Errors
    /// As [`Self::simulate`], and a recording that cannot be written.
    pub fn run(&self, seed: u64) -> Result<CampaignEntry> {
        let log = self.simulate_recorded(seed).with_context(|| format!("trial {seed}"))?;
        Ok(CampaignEntry { seed, trial: self.entry(seed, &log), campaign: self.settings.clone() })
    }

    /// The name and the metrics of a trial.
    pub fn entry(&self, seed: u64, log: &TrialLog) -> TrialEntry {
        let metrics = measure(log, log.region(self.profile.region), log.picture);
        let name = format!("{}/{seed}", self.settings.scenario);
        TrialEntry { name, arena: arena_of(&self.settings.scenario), metrics }
    }
}

/// Whether the scenario has a boat, and a person that it can go to.
fn has_person(scenario: &Scenario) -> bool {
    matches!(scenario.target, TargetScript::Boat(_))
        && scenario.objects.iter().any(|object| object.kind == ObjectKind::Swimmer)
}

/// The arena of the paper that a built-in scenario models; `None` for other scenarios.
pub fn arena_of(scenario: &str) -> Option<Arena> {
    match scenario {
        "lab1" | "arena1" => Arena::from_number(1),
        "lab2" | "arena2" => Arena::from_number(2),
        _ => None,
    }
}
