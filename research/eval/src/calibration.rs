//! Calibrations of drawn cameras: sign, gain, dead times and lag as measured from the rendered picture,
//! beside the truth.

use anyhow::Result;
use barrelman_control::LawSettings;
use barrelman_control::view::View;
use barrelman_experiments::calibration::{
    CalibrationRecorder, CalibrationResult, CannotTell, MeasuredAxis, MeasuredSpeeds,
};
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};
use barrelman_pilot::{Input, Mode, NUDGE_RATE_RAD_PER_S, Outcome, Pilot, PilotSettings};
use barrelman_sim::camera_axis::AxisPlant;
use barrelman_sim::pose::CameraPose;
use barrelman_sim::random::{CounterRng, Stream};
use barrelman_sim::render::Serial;
use barrelman_sim::{Scenario, Truth, World};
use barrelman_simd::Simd;
use barrelman_trial::campaign::{FrameSource, RenderedCamera, Simulation, StepObserver};
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vision::{PATCH_CENTRES, PATCHES, PatchShift};
use barrelman_vocab::{
    CameraRequest, OperatorRequest, PictureSize, PixelPoint, TestMotions, Timestamp, VehicleRates,
};
use clap::Args;

use crate::output::print_line;
use crate::parallel;

/// Requirements: gain, as a share of the true one, and dead times, seconds.
const MAX_GAIN_ERROR: f64 = 0.05;
const MAX_DEAD_TIME_ERROR_S: f64 = 0.06;
/// Requirement on a rate that short motions tell, as a share of the true one.
const MAX_RATE_ERROR: f64 = 0.1;
/// A calibration takes less than this, seconds.
const MAX_S: f64 = 110.0;

/// Options of `calibration`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// The scenario.
    #[arg(long, value_name = "NAME", default_value = "lab1")]
    scenario: String,
    /// Its setting.
    #[arg(long, value_name = "NAME", default_value = "still")]
    setting: String,
    /// Number of drawn cameras.
    #[arg(long, value_name = "N", default_value_t = 50)]
    seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "SEED", default_value_t = 40_000)]
    first_seed: u64,
    /// Measure in rendered pictures; otherwise the patches move as the camera does over flat water, with
    /// noise.
    #[arg(long)]
    pixels: bool,
    /// Make the short motions that tell how fast an axis turns at one speed, and compare the rates alone.
    #[arg(long)]
    speeds: bool,
    /// Width of the picture.
    #[arg(long, value_name = "WIDTH", default_value_t = 640)]
    width: u32,
}

/// An axis as drawn.
#[derive(Debug, Clone, Copy)]
struct TrueAxis {
    gain: f64,
    plant: AxisPlant,
}

/// A camera whose test motions told `M`.
struct Calibrated<M> {
    seed: u64,
    pan: TrueAxis,
    tilt: TrueAxis,
    measured: M,
}

/// The patches of a picture of flat water, as the true camera sees them.
struct FlatWater {
    focal_px: f64,
    size: PictureSize,
    before: Option<CameraPose>,
    noise: CounterRng,
    index: u64,
}

impl FlatWater {
    /// Standard deviation of a measured shift, pixels.
    const NOISE_PX: f64 = 0.3;

    fn new(scenario: &Scenario, seed: u64) -> Self {
        Self {
            focal_px: scenario.camera.optics.focal_px,
            size: scenario.camera.frame,
            before: None,
            noise: CounterRng::new(seed, Stream::Sensor),
            index: 0,
        }
    }

    fn shifts(&mut self, truth: &Truth) -> [Option<PatchShift>; PATCHES] {
        let now = truth.camera;
        let before = self.before.replace(now);
        PATCH_CENTRES.map(|(u, v)| {
            let before = before?;
            let (width, height) = (f64::from(self.size.width), f64::from(self.size.height));
            let centre = PixelPoint { u: u * width, v: v * height };
            let view = |pose: &CameraPose| View::new(self.focal_px, pose.pan.radians(), pose.tilt.radians());
            let point = centre.in_image(self.size);
            let [right, ahead, up] = view(&before).unproject(point);
            // Above the horizon there is no water; what is there is far away.
            let range_m = if up < -0.02 { before.position.z / -up } else { 1e4 };
            let moved = [
                right * range_m + before.position.x - now.position.x,
                ahead * range_m + before.position.y - now.position.y,
                up * range_m + before.position.z - now.position.z,
            ];
            let length = moved.iter().map(|part| part * part).sum::<f64>().sqrt();
            let seen = view(&now).project(moved.map(|part| part / length));
            self.index += 2;
            let noise = |index| Self::NOISE_PX * self.noise.normal(index);
            Some(PatchShift {
                centre,
                u_px: seen.x - point.x + noise(self.index),
                v_px: point.y - seen.y + noise(self.index + 1),
            })
        })
    }
}

/// Records what the pilot's steps show.
struct Recording {
    recorder: CalibrationRecorder,
    is_calibrating: bool,
    /// Of trials without pixels.
    flat_water: Option<FlatWater>,
}

impl StepObserver for Recording {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, _: VehicleRates) {
        self.is_calibrating = outcome.mode == Mode::Calibrating;
        if let (Input::Frame(frame), None) = (input, &self.flat_water) {
            self.recorder.on_frame(frame);
        }
        self.recorder.on_command(outcome.command, now);
    }
    fn on_truth(&mut self, truth: &Truth, _: Option<&TargetInPicture>) {
        if let Some(water) = &mut self.flat_water {
            let shifts = water.shifts(truth);
            self.recorder.on_shifts(&shifts, water.size, truth.at);
        }
    }
}

/// Prints the table. Returns whether the requirements hold.
///
/// # Errors
/// If the scenario cannot be loaded.
pub(crate) fn run(options: &Options) -> Result<bool> {
    if options.speeds {
        let calibrated = calibrate_all(options, TestMotions::Speed, CalibrationRecorder::speeds)?;
        return Ok(print_rates(&calibrated));
    }
    let calibrated = calibrate_all(options, TestMotions::Axes, CalibrationRecorder::result)?;
    Ok(print_axes(&calibrated))
}

/// Makes the test motions with every drawn camera.
fn calibrate_all<M: Send>(
    options: &Options,
    motions: TestMotions,
    read: impl Fn(&CalibrationRecorder) -> M + Sync,
) -> Result<Vec<Calibrated<M>>> {
    let seeds: Vec<u64> = (options.first_seed..options.first_seed + options.seeds).collect();
    let calibrated = parallel::map(&seeds, |seed| calibrate(options, *seed, motions, &read));
    print_line(&format!(
        "{} drawn cameras of {} ({}), pictures {} px wide; errors of what was measured",
        seeds.len(),
        options.scenario,
        options.setting,
        options.width
    ));
    calibrated.into_iter().collect()
}

/// Prints what long motions have told. Returns whether it is right.
fn print_axes(calibrated: &[Calibrated<CalibrationResult>]) -> bool {
    print_line("  seed axis   true gain  measured   error   start ms  stop ms    lag ms");
    let mut counts = Counts::default();
    for camera in calibrated {
        for (name, truth, measured) in
            [("pan", camera.pan, &camera.measured.pan), ("tilt", camera.tilt, &camera.measured.tilt)]
        {
            print_line(&format!("{:6} {name:5} {}", camera.seed, row(truth, measured, &mut counts)));
        }
    }
    print_line(&format!(
        "{} axes: {} told, {} cannot be told; of those told: wrong sign {}, gain off by more than 5 % {}, dead time off by more than 60 ms {}",
        2 * calibrated.len(),
        counts.told,
        counts.untold,
        counts.wrong_sign,
        counts.wrong_gain,
        counts.wrong_dead_time
    ));
    let wrong = counts.wrong_sign + counts.wrong_gain + counts.wrong_dead_time;
    wrong == 0 && 2 * counts.told >= counts.untold
}

/// Prints the rates that short motions have told. Returns whether they are right.
fn print_rates(calibrated: &[Calibrated<MeasuredSpeeds>]) -> bool {
    let (mut errors, mut untold) = (Vec::new(), 0);
    print_line("  seed axis   true gain   rate/gain");
    for camera in calibrated {
        for (name, truth, rate) in
            [("pan", camera.pan, camera.measured.pan), ("tilt", camera.tilt, camera.measured.tilt)]
        {
            let told = match rate {
                Ok(rate) => {
                    let share = rate / (NUDGE_RATE_RAD_PER_S * truth.gain.abs());
                    errors.push((share - 1.0).abs());
                    format!("{share:.3}")
                }
                Err(reason) => {
                    untold += 1;
                    format!("cannot tell: {reason}")
                }
            };
            print_line(&format!("{:6} {name:5} {:+9.3}   {told}", camera.seed, truth.gain));
        }
    }
    errors.sort_by(f64::total_cmp);
    let wrong = errors.iter().filter(|error| **error > MAX_RATE_ERROR).count();
    let at = |share: f64| 100.0 * errors.get((share * errors.len() as f64) as usize).unwrap_or(&f64::NAN);
    print_line(&format!(
        "{} axes: {} told, {untold} cannot be told; error: median {:.1} %, 95 % of them {:.1} %; {wrong} above {:.0} %",
        2 * calibrated.len(),
        errors.len(),
        at(0.5),
        at(0.95),
        100.0 * MAX_RATE_ERROR
    ));
    wrong == 0 && errors.len() >= untold
}

#[derive(Debug, Default)]
struct Counts {
    told: u32,
    untold: u32,
    wrong_sign: u32,
    wrong_gain: u32,
    wrong_dead_time: u32,
}

fn row(truth: TrueAxis, measured: &Result<MeasuredAxis, CannotTell>, counts: &mut Counts) -> String {
    let measured = match measured {
        Ok(measured) => measured,
        Err(reason) => {
            counts.untold += 1;
            return format!("{:+9.3}  cannot tell: {reason}", truth.gain);
        }
    };
    counts.told += 1;
    let gain_error = measured.gain / truth.gain - 1.0;
    let start = measured.start_dead_time_s - truth.plant.start_dead_time_s;
    let stop = measured.stop_dead_time_s - truth.plant.stop_dead_time_s;
    counts.wrong_sign += u32::from(measured.gain * truth.gain < 0.0);
    counts.wrong_gain += u32::from(gain_error.abs() > MAX_GAIN_ERROR);
    counts.wrong_dead_time += u32::from(start.abs().max(stop.abs()) > MAX_DEAD_TIME_ERROR_S);
    format!(
        "{:+9.3} {:+9.3} {:+6.1} % {:+9.0} {:+8.0} {:+9.0}",
        truth.gain,
        measured.gain,
        100.0 * gain_error,
        1e3 * start,
        1e3 * stop,
        1e3 * (measured.lag_s - truth.plant.lag_s)
    )
}

fn calibrate<M>(
    options: &Options,
    seed: u64,
    motions: TestMotions,
    read: impl Fn(&CalibrationRecorder) -> M,
) -> Result<Calibrated<M>> {
    let overrides = ScenarioOverrides {
        setting: Some(options.setting.clone()),
        size: Some(PictureSize::new(options.width, options.width * 9 / 16)),
        ..ScenarioOverrides::default()
    };
    let loaded = scenario::load(&options.scenario, &overrides)?;
    let profile = loaded.profile()?;
    let mut scenario = loaded.scenario.with_sampled_plant(seed);
    // The ranges of the focal length belong to the scenario's own size of the picture.
    let full =
        scenario::load(&options.scenario, &ScenarioOverrides::default())?.scenario.camera.optics.focal_px;
    let lens = scenario.camera.optics.focal_px / full;
    scenario.camera.optics.focal_px = lens * loaded.scenario.camera.optics.focal_px;
    scenario.max_s = MAX_S;
    // A wrong sign of the profile is a plant that turns the other way: every fourth camera has each.
    let flips = |bit: u64| if (seed >> bit) & 1 == 1 { -1.0 } else { 1.0 };
    scenario.mount.pan.imperfections.gain *= flips(0);
    scenario.mount.tilt.imperfections.gain *= flips(1);
    // The picture shows a turn times the focal length: a longer lens than that of the profile counts as gain.
    let truth = |plant: AxisPlant| TrueAxis { gain: plant.imperfections.gain * lens, plant };
    let world = World::new(&scenario, seed).map_err(|_| anyhow::anyhow!("the way-points make no path"))?;
    let tracker = TrackerSettings::new(TrackerName::Fused).build()?;
    let settings = PilotSettings { profile: profile.clone(), law: LawSettings::default() };
    let pilot = Pilot::new(settings, tracker);
    let mut camera = RenderedCamera::new(&world, scenario.camera.clone(), seed, Simd::widest(), &Serial);
    let mut frames = options.pixels.then_some(&mut camera as &mut dyn FrameSource);
    let mut simulation = Simulation::new(&scenario, world, seed, pilot, &profile).without_selection();
    let mut recording = Recording {
        recorder: CalibrationRecorder::new(profile.camera.focal_share),
        is_calibrating: false,
        flat_water: (!options.pixels).then(|| FlatWater::new(&scenario, seed)),
    };
    while simulation.world().now().as_secs_f64() < 1.0 {
        simulation.tick(&mut frames, &mut recording);
    }
    simulation.request(OperatorRequest::Camera(CameraRequest::Calibrate { motions }), &mut recording);
    while recording.is_calibrating && !simulation.is_over() {
        simulation.tick(&mut frames, &mut recording);
    }
    let measured = read(&recording.recorder);
    Ok(Calibrated { seed, pan: truth(scenario.mount.pan), tilt: truth(scenario.mount.tilt), measured })
}
