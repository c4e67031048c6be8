//! The world of a recorded trial in pixels, from what its recording says of it.

use anyhow::{Context, Result, anyhow, bail};
use barrelman_sim::render::Serial;
use barrelman_simd::{Simd, SimdLevel};
use barrelman_trial::campaign::{CampaignSettings, RenderedCamera, WorldReplay};
use barrelman_trial::records::SimulatedTrial;
use barrelman_vocab::PictureSize;
use clap::ValueEnum as _;

use super::plan::{CampaignPlan, CampaignRequest, Perception, PlantName};
use crate::law_choice::LawChoice;
use crate::scenario::{ScenarioOverrides, resolve};

/// The settings of a recorded trial.
///
/// # Errors
/// The recording's settings are not those of a campaign.
pub fn settings_of(trial: &SimulatedTrial) -> Result<CampaignSettings> {
    serde_json::from_str(&trial.settings).context("the settings of the recorded trial are unreadable")
}

/// The world and the camera of a recorded trial, which render its pictures again.
///
/// # Errors
/// The boat was steered by a stored drive, which the recording does not hold, or the recorded scenario is
/// unusable.
pub fn world_of(trial: &SimulatedTrial) -> Result<WorldReplay<'static>> {
    let settings = settings_of(trial)?;
    if settings.drive.is_some() {
        bail!(
            "a recording of a trial in pixels holds no pictures, and those of a drive depend on its helm, which is stored in \
             the drive's file alone: run `barrelman trials --drive FILE --record DIR` again, or `barrelman demo --replay FILE`"
        );
    }
    let request = request_of(&settings)?;
    let loaded = resolve::read(&trial.scenario, &request.overrides)
        .map_err(|error| error.located_in("the recorded scenario", &trial.scenario))?;
    let plan = CampaignPlan::of_scenario(loaded, &request)?;
    let (scenario, world) = plan.world(trial.seed)?;
    let simd = Simd::at_most(request.simd);
    let camera = RenderedCamera::new(&world, scenario.camera.clone(), trial.seed, simd, &Serial);
    Ok(WorldReplay::new(&scenario, trial.seed, world, camera, plan.profile().clone()))
}

/// The request whose world is that of the settings. Law and tracker do not matter to the world.
fn request_of(settings: &CampaignSettings) -> Result<CampaignRequest> {
    let size = settings.size.as_deref().map(size_from).transpose()?;
    let plant = PlantName::from_str(&settings.plant, false)
        .map_err(|_| anyhow!("this program knows no plant {:?}", settings.plant))?;
    Ok(CampaignRequest {
        scenario: settings.scenario.clone(),
        overrides: ScenarioOverrides {
            setting: Some(settings.setting.clone()),
            boat_speed_m_per_s: settings.boat_speed_m_per_s,
            sea_state: settings.sea_state,
            wind_m_per_s: settings.wind_m_per_s,
            current_m_per_s: settings.current_m_per_s,
            size,
        },
        law: LawChoice::MOTOR_SCHEMA,
        rate: settings.rate_rad_per_s,
        // The recording has the commands to the boat.
        guidance: None,
        perception: Perception::Truth,
        plant,
        simd: SimdLevel::Avx512,
    })
}

fn size_from(text: &str) -> Result<PictureSize> {
    let size = text
        .split_once('x')
        .and_then(|(width, height)| Some(PictureSize::new(width.parse().ok()?, height.parse().ok()?)));
    size.ok_or_else(|| anyhow!("the recorded size of the picture is {text:?}, expected WIDTHxHEIGHT"))
}
