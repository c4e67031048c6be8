//! Measures the zoom that keeps the boat's size: trials with it beside the same trials at a fixed zoom.
//!
//! The conditions of the laws (without pixels), scenarios in rendered pictures, and a boat that goes away
//! until it is a few pixels long and comes back. The camera zooms up to eight times, and reports its field of
//! view.

use anyhow::Result;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::{CampaignPlan, CampaignRequest, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::Truth;
use barrelman_sim::scenario::TargetScript;
use barrelman_simd::SimdLevel;
use barrelman_trial::campaign::{ReportErrors, StepObserver};
use barrelman_trial::target_in_picture::TargetInPicture;
use barrelman_vocab::{Timestamp, Track, VehicleRates, ZoomDynamics, ZoomRate};
use clap::Args;

use crate::law::conditions::CONDITIONS;
use crate::output::print_line;
use crate::parallel;

/// The zoom of the simulated camera.
const ZOOM: ZoomDynamics = ZoomDynamics::usual(8.0);
/// The same that is slower than its profile, which is that of [`ZOOM`].
const SLOW_ZOOM: ZoomDynamics = ZoomDynamics { max_rate: ZoomRate::from_per_second(0.1), ..ZOOM };
const UNREPORTED: ReportErrors = ReportErrors { has_field_of_view: false, ..ReportErrors::NONE };
/// Frames after which a camera that was told to rest has rested.
const RESTED_FRAMES: u32 = 60;
/// Length of the boat, metres.
const LENGTH_M: f64 = 1.2;
/// Scenarios in rendered pictures.
const RENDERED: [&str; 6] = ["open", "sea3", "glint", "distractors", "gusts", "exit"];
/// Largest excess of the time outside of the ellipse over that at a fixed zoom, a share of the time.
const MAX_EXCESS: f64 = 0.005;
/// A boat of fewer pixels is not recognised for sure.
const LEAST_PX: f64 = 12.0;

/// Options of `zoom`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Options {
    /// Trials of each condition without pixels; 0 leaves these out.
    #[arg(long, value_name = "N", default_value_t = 20)]
    seeds: u64,
    /// Trials of each scenario in pixels; 0 leaves these out.
    #[arg(long, value_name = "N", default_value_t = 6)]
    rendered_seeds: u64,
    /// The first seed.
    #[arg(long, value_name = "SEED", default_value_t = 70_000)]
    first_seed: u64,
    /// Only the conditions whose name begins so.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

/// Prints the table. Returns whether every requirement holds.
///
/// # Errors
/// If a scenario cannot be loaded or simulated.
pub(crate) fn run(options: &Options) -> Result<bool> {
    print_line("                     at a fixed zoom                     with the size kept");
    print_line(
        "                     outside  lost    in range  least px  outside  lost    in range  least px  zooms/min  largest  focal error",
    );
    let mut is_met = true;
    let is_chosen = |row: &Row| {
        let is_named = options.only.as_ref().is_none_or(|only| row.name.starts_with(only.as_str()));
        is_named && !row.seeds(options).is_empty()
    };
    for row in rows()?.into_iter().filter(is_chosen) {
        is_met &= run_row(&row, options)?;
    }
    print_line(if is_met { "\nevery requirement holds" } else { "\nrequirements are MISSED" });
    Ok(is_met)
}

/// Trials under one condition.
struct Row {
    name: String,
    plan: CampaignPlan,
    is_rendered: bool,
    /// Whether the boat becomes too small to be recognised at a fixed zoom.
    goes_away: bool,
    /// Whether the zoom is slower than its profile says, and reports nothing.
    is_unknown: bool,
}

impl Row {
    fn seeds(&self, options: &Options) -> Vec<u64> {
        let count = if self.is_rendered { options.rendered_seeds } else { options.seeds };
        (options.first_seed..options.first_seed + count).collect()
    }
}

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for condition in CONDITIONS {
        let request = request(condition.scenario, Some(condition.setting), false);
        let plan = CampaignPlan::new(&request)?;
        rows.push(Row {
            name: condition.name(),
            plan,
            is_rendered: false,
            goes_away: false,
            is_unknown: false,
        });
    }
    for scenario in RENDERED {
        let plan = CampaignPlan::new(&request(scenario, None, true))?;
        rows.push(Row {
            name: scenario.to_owned(),
            plan,
            is_rendered: true,
            goes_away: false,
            is_unknown: false,
        });
    }
    for (is_rendered, is_unknown) in [(false, false), (true, false), (false, true), (true, true)] {
        let plan = CampaignPlan::new(&request("open", None, is_rendered))?;
        let plan = plan.with_changed_scenario(|scenario| {
            if let TargetScript::Boat(boat) = &mut scenario.target {
                let far = [(0.0, 120.0), (-20.0, 190.0), (10.0, 120.0)];
                boat.way_points = vec![(0.0, 22.0), (12.0, 60.0)];
                boat.way_points.extend(far.iter().filter(|_| !is_unknown));
                boat.way_points.extend([(-12.0, 70.0), (0.0, 24.0)]);
                (boat.speed_m_per_s, boat.max_throttle) = (3.0, 1.0);
            }
            scenario.max_s = if is_unknown { 60.0 } else { 180.0 };
        });
        let (plan, name) = match is_unknown {
            false => (plan, "away"),
            true => (plan.with_report_errors(UNREPORTED), "unknown"),
        };
        let name = format!("{name}{}", if is_rendered { ", in pixels" } else { "" });
        rows.push(Row { name, plan, is_rendered, goes_away: !is_unknown, is_unknown });
    }
    Ok(rows)
}

fn request(scenario: &str, setting: Option<&str>, is_rendered: bool) -> CampaignRequest {
    CampaignRequest {
        scenario: scenario.to_owned(),
        overrides: ScenarioOverrides { setting: setting.map(str::to_owned), ..ScenarioOverrides::default() },
        law: LawChoice::OPTIMAL,
        rate: None,
        guidance: None,
        perception: if is_rendered { Perception::Pixels(TrackerName::Fused) } else { Perception::Truth },
        plant: PlantName::Nominal,
        simd: SimdLevel::Avx512,
    }
}

fn run_row(row: &Row, options: &Options) -> Result<bool> {
    let seeds = row.seeds(options);
    let with = |keeps_size: bool| {
        let zoom = if row.is_unknown { SLOW_ZOOM } else { ZOOM };
        let plan = row.plan.clone().with_changed_scenario(|scenario| scenario.mount.zoom = Some(zoom));
        plan.with_changed_profile(|profile| {
            profile.zoom = Some(ZOOM);
            profile.size.is_on_at_start = keeps_size;
        })
    };
    let (fixed, kept) = (measure(&with(false), &seeds)?, measure(&with(true), &seeds)?);
    print_line(&format!(
        "{:20} {}  {}  {:>9.2}  {:>6.1}x  {:>9.1} %",
        row.name,
        fixed.cells(),
        kept.cells(),
        60.0 * kept.zooms as f64 / kept.seconds,
        kept.largest_zoom,
        100.0 * kept.focal_error,
    ));
    let is_recognised = !row.goes_away || kept.least_px >= LEAST_PX;
    Ok(is_recognised
        && kept.outside_share() <= fixed.outside_share() + MAX_EXCESS
        && kept.lost_share() <= fixed.lost_share() + MAX_EXCESS)
}

fn measure(plan: &CampaignPlan, seeds: &[u64]) -> Result<Figures> {
    let height_px = f64::from(plan.scenario().camera.optics.picture.height);
    let sizes = (plan.profile().size.smallest, plan.profile().size.largest);
    let none = || Figures::new(sizes, height_px);
    let trials = parallel::map(seeds, |seed| {
        let mut figures = none();
        let log = plan.simulate(*seed, &mut figures)?;
        let metrics = plan.entry(*seed, &log).metrics;
        figures.seconds = metrics.duration_s;
        figures.outside_s = metrics.time_outside_s;
        Ok(figures)
    });
    trials.into_iter().try_fold(none(), |sum, figures: Result<Figures>| Ok(sum.plus(&figures?)))
}

/// What was measured in some trials.
#[derive(Debug, Clone)]
struct Figures {
    /// Range in which the size is kept.
    sizes: (f64, f64),
    /// Height of the picture.
    height_px: f64,
    seconds: f64,
    outside_s: f64,
    pictures: u32,
    in_range: u32,
    lost: u32,
    steps: u32,
    least_px: f64,
    zooms: u32,
    largest_zoom: f64,
    is_zooming: bool,
    rested_frames: u32,
    /// The largest error of the focal length of a camera that has rested, a share.
    focal_error: f64,
    /// The focal length that the pilot knows, over the widest one, and the widest one, pixels.
    ratio: f64,
    widest_px: f64,
}

impl Figures {
    const fn new(sizes: (f64, f64), height_px: f64) -> Self {
        Self {
            sizes,
            height_px,
            seconds: 0.0,
            outside_s: 0.0,
            pictures: 0,
            in_range: 0,
            lost: 0,
            steps: 0,
            least_px: f64::INFINITY,
            zooms: 0,
            largest_zoom: 1.0,
            is_zooming: false,
            rested_frames: 0,
            focal_error: 0.0,
            ratio: 1.0,
            widest_px: f64::INFINITY,
        }
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            seconds: self.seconds + other.seconds,
            outside_s: self.outside_s + other.outside_s,
            pictures: self.pictures + other.pictures,
            in_range: self.in_range + other.in_range,
            lost: self.lost + other.lost,
            steps: self.steps + other.steps,
            least_px: self.least_px.min(other.least_px),
            zooms: self.zooms + other.zooms,
            largest_zoom: self.largest_zoom.max(other.largest_zoom),
            focal_error: self.focal_error.max(other.focal_error),
            ..self
        }
    }

    fn outside_share(&self) -> f64 {
        self.outside_s / self.seconds
    }

    fn lost_share(&self) -> f64 {
        f64::from(self.lost) / f64::from(self.steps.max(1))
    }

    fn cells(&self) -> String {
        format!(
            "{:>6.2} % {:>5.2} %  {:>6.1} %  {:>8.1}",
            100.0 * self.outside_share(),
            100.0 * self.lost_share(),
            100.0 * f64::from(self.in_range) / f64::from(self.pictures.max(1)),
            self.least_px,
        )
    }
}

impl StepObserver for Figures {
    fn on_step(&mut self, _: Timestamp, input: &Input<'_>, outcome: &Outcome, _: VehicleRates) {
        let is_zooming = !outcome.command.zoom.is_zero();
        self.zooms += u32::from(is_zooming && !self.is_zooming);
        self.is_zooming = is_zooming;
        self.ratio = outcome.zoom.map_or(1.0, |zoom| zoom.ratio);
        self.largest_zoom = self.ratio.max(self.largest_zoom);
        if matches!(input, Input::Frame(_) | Input::Localisation(_)) {
            self.steps += 1;
            self.lost += u32::from(matches!(outcome.track, Track::Lost { .. }));
        }
    }

    fn on_truth(&mut self, truth: &Truth, _: Option<&TargetInPicture>) {
        // The first picture is that of the widest view.
        self.widest_px = self.widest_px.min(truth.focal_px);
        self.rested_frames = if self.is_zooming { 0 } else { self.rested_frames + 1 };
        if self.rested_frames > RESTED_FRAMES {
            let error = self.ratio * self.widest_px / truth.focal_px - 1.0;
            self.focal_error = self.focal_error.max(error.abs());
        }
        let length_px = LENGTH_M * truth.focal_px / truth.range_m;
        self.least_px = self.least_px.min(length_px);
        self.pictures += 1;
        let size = length_px / self.height_px;
        self.in_range += u32::from((self.sizes.0..=self.sizes.1).contains(&size));
    }
}
