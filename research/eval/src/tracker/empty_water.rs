//! Empty water: whatever is found there is false. A pilot that follows nothing watches rendered seas without
//! boat, people and buoys, through the swaying camera of a scenario, at sea states 0 to 3.

use std::sync::Arc;

use anyhow::{Result, anyhow};
use barrelman_control::LawSettings;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{Input, Pilot, PilotSettings};
use barrelman_sim::render::{ENCODING, RenderSettings, Renderer, Serial, WaveGrid};
use barrelman_sim::snapshot::Target;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::{World, WorldPoint};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{Picture, VehicleProfile, VideoFrame};

use crate::output::print_line;
use crate::parallel;

/// A scenario of the kite's camera above open water.
const SCENARIO: &str = "first-drive";
pub(crate) const SEA_STATES: u8 = 4;
/// Pictures a second.
const PICTURES: u32 = 30;
pub(crate) const SECONDS: u32 = 20;
/// Out of sight of the camera: the renderer wants a boat.
const FAR_M: f64 = -20_000.0;

/// What was shown on one sea.
#[derive(Debug, Clone, Copy, Default)]
struct Shown {
    pictures: usize,
    /// Candidates, in all pictures.
    candidates: usize,
    /// Candidates that appeared.
    appeared: usize,
}

/// Prints a row for each sea state, from so many seas each.
///
/// # Errors
/// If the scenario cannot be loaded or simulated.
pub(super) fn run(seas: usize) -> Result<bool> {
    print_line(&format!(
        "{seas} seas a state, {SECONDS} s each, camera of {SCENARIO}; every candidate is false"
    ));
    for state in 0..SEA_STATES {
        let seeds: Vec<u64> = (0..seas as u64).map(|seed| 70_000 + seed).collect();
        let shown =
            parallel::map(&seeds, |seed| watch(state, *seed)).into_iter().collect::<Result<Vec<_>>>()?;
        let sum = |count: fn(&Shown) -> usize| shown.iter().map(count).sum::<usize>() as f64;
        let pictures = sum(|sea| sea.pictures);
        print_line(&format!(
            "sea state {state}: {:>5.2} candidates a picture, {:>5.2} new ones a second",
            sum(|sea| sea.candidates) / pictures,
            sum(|sea| sea.appeared) / (pictures / f64::from(PICTURES)),
        ));
    }
    Ok(true)
}

fn watch(sea_state: u8, seed: u64) -> Result<Shown> {
    let settings = PilotSettings { profile: VehicleProfile::fotokite_pro(), law: LawSettings::MotorSchema };
    let mut pilot = Pilot::new(settings, TrackerSettings::new(TrackerName::Fused).build()?).keeping_frames();
    let (mut shown, mut before) = (Shown::default(), Vec::new());
    for_frames(sea_state, seed, PICTURES, |frame| {
        let outcome = pilot.step(Input::Frame(frame), frame.capture.at);
        let numbers: Vec<u32> =
            outcome.candidates.iter().flatten().map(|candidate| candidate.number).collect();
        shown.pictures += 1;
        shown.candidates += numbers.len();
        shown.appeared += numbers.iter().filter(|number| !before.contains(*number)).count();
        before = numbers;
        Ok(())
    })?;
    Ok(shown)
}

/// Shows [`SECONDS`] of an empty sea, so many pictures a second.
///
/// # Errors
/// If the scenario cannot be loaded or simulated, or `show` fails.
pub(crate) fn for_frames(
    sea_state: u8,
    seed: u64,
    pictures: u32,
    mut show: impl FnMut(&VideoFrame) -> Result<()>,
) -> Result<()> {
    let overrides = ScenarioOverrides { sea_state: Some(sea_state), ..ScenarioOverrides::default() };
    let scenario = scenario::load(SCENARIO, &overrides)?.scenario;
    let mut world = World::new(&scenario, seed)
        .map_err(|_| anyhow!("the path of {SCENARIO} is not usable"))?
        .without_end();
    let optics = scenario.camera.optics;
    let mut renderer = Renderer::new(RenderSettings {
        grid: WaveGrid::Coarse,
        readout_s: scenario.camera.rolling_shutter_s,
        ..RenderSettings::new(optics, world.sea().cloned(), seed)
    });
    let mut snapshot = world.snapshot();
    for sequence in 0..u64::from(pictures * SECONDS) {
        world.write_snapshot(&mut snapshot);
        snapshot.objects.clear();
        if let Target::Boat(boat) = &mut snapshot.target {
            boat.pose.position = WorldPoint { y: FAR_M, ..boat.pose.position };
        }
        let mut picture = Picture::black(optics.picture, ENCODING);
        renderer.render(&snapshot, &mut picture, &Serial);
        let capture = Capture { at: world.now(), quality: CaptureQuality::Sensor };
        show(&VideoFrame { sequence, capture, picture: Arc::new(picture) })?;
        for _ in 0..TICKS_PER_SECOND / pictures {
            world.advance();
        }
    }
    Ok(())
}
