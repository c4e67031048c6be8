//! What a camera law would have done with the same boat in the same world.

use anyhow::{Result, anyhow};
use barrelman_pilot::{Pilot, PilotSettings};
use barrelman_sim::World;
use barrelman_sim::boat::HelmCommand;
use barrelman_trial::campaign::Simulation;
use barrelman_vocab::CameraRequest;

use super::figures::DrillFigures;
use crate::drive::DriveSetup;
use crate::law_choice::LawChoice;
use crate::tracker_choice::TrackerSettings;

/// The figures of a law that is engaged from the start of the world to a tick, while the boat is steered as
/// it was. The law sees where the boat is without pictures: the sensor of trials without pixels.
///
/// # Errors
/// The scenario's way-points make no path with the seed, or the tracker cannot be built.
pub(super) fn figures(
    setup: &DriveSetup,
    law: LawChoice,
    helm: &[(u64, Option<HelmCommand>)],
    last_tick: u64,
) -> Result<DrillFigures> {
    let (scenario, seed) = (&setup.loaded.scenario, setup.url.seed);
    let world = World::new(scenario, seed)
        .map_err(|_| anyhow!("the way-points of {} make no path with seed {seed}", scenario.name))?
        .without_end();
    let settings = PilotSettings { profile: setup.profile.clone(), law: law.settings() };
    let pilot = Pilot::new(settings, TrackerSettings::new(setup.tracker).build()?);
    let mut simulation = Simulation::new(scenario, world, seed, pilot, &setup.profile)
        .with_tilt_reports(true)
        .with_height_reports()
        .with_helm(helm.to_vec());
    simulation.request(CameraRequest::Engage.into(), &mut ());
    while simulation.world().tick() < last_tick {
        simulation.tick(&mut None, &mut ());
    }
    Ok(DrillFigures::of(simulation.log(), &setup.profile))
}
