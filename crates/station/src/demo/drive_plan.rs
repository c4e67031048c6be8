//! What the drives of a session have in common, and the setup of each of them.

use anyhow::{Result, anyhow};
use barrelman_experiments::drill::{DrillJudge, DrillPlan};
use barrelman_experiments::drive::DriveSetup;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::{self, ScenarioChoice, ScenarioOverrides};
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_sim::World;
use barrelman_vocab::{NewDrill, NewDrive, PictureSize};

/// Default limit of the picture's width, pixels: pictures are rendered on the CPU.
const MAX_WIDTH: u32 = 960;

/// What a drive is for.
#[derive(Debug, Clone)]
pub enum Purpose {
    /// A drive in a world.
    Drive(NewDrive),
    /// A drill.
    Drill(NewDrill),
}

impl Purpose {
    /// The world.
    pub fn world(&self) -> NewDrive {
        match self {
            Self::Drive(drive) => drive.clone(),
            Self::Drill(NewDrill { drill, seed }) => {
                NewDrive { scenario: DrillPlan::of(*drill).scenario.to_owned(), seed: *seed }
            }
        }
    }

    /// The judge of the drill, if the drive is one.
    pub fn judge(&self) -> Option<DrillJudge> {
        match self {
            Self::Drive(_) => None,
            Self::Drill(NewDrill { drill, seed }) => Some(DrillJudge::new(*drill, *seed)),
        }
    }
}

/// What the drives of a session have in common.
#[derive(Debug, Clone)]
pub struct DrivePlan {
    /// The first drive.
    pub first: Purpose,
    /// Size of the pictures; `None`: the scenario's, limited in its width.
    pub size: Option<PictureSize>,
    /// The tracker.
    pub tracker: TrackerName,
    /// The camera law at the start of each drive.
    pub law: LawChoice,
    /// Whether pictures are encoded as H.264.
    pub encoded: bool,
    /// Whether the person selects the boat.
    pub hands_on: bool,
}

impl DrivePlan {
    /// The scenarios that a new drive can have.
    ///
    /// # Errors
    /// The scenario of the first drive cannot be read.
    pub fn choices(&self) -> Result<Vec<ScenarioChoice>> {
        scenario::choices(&self.first.world().scenario)
    }

    /// The setup of a drive.
    ///
    /// # Errors
    /// The scenario does not exist or has a mistake, or its way-points make no path with the seed.
    pub fn setup(&self, purpose: &Purpose) -> Result<DriveSetup> {
        let NewDrive { scenario, seed } = purpose.world();
        let size = Some(self.picture_size(&scenario)?);
        let setup = DriveSetup::new(WorldUrl { scenario, seed, size }, self.tracker, self.law, self.encoded)?;
        World::new(&setup.loaded.scenario, seed)
            .map_err(|_| anyhow!("the way-points of {} make no path with seed {seed}", setup.url.scenario))?;
        let hands_on = match purpose {
            Purpose::Drive(_) => self.hands_on,
            Purpose::Drill(NewDrill { drill, .. }) => !DrillPlan::of(*drill).begins_engaged,
        };
        Ok(DriveSetup { hands_on, ..setup })
    }

    /// The size of the pictures: the given size, else the scenario's, limited to `MAX_WIDTH`.
    fn picture_size(&self, scenario: &str) -> Result<PictureSize> {
        if let Some(size) = self.size {
            return Ok(size);
        }
        let own = scenario::load(scenario, &ScenarioOverrides::default())?.scenario.camera.optics.picture;
        let height = (own.height * MAX_WIDTH / own.width.max(1)) & !1;
        Ok(if own.width > MAX_WIDTH { PictureSize::new(MAX_WIDTH, height) } else { own })
    }
}
