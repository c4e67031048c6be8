//! `barrelman report`: trials as a page to look at.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result};
use barrelman_trial::behaviour::FIRST;
use barrelman_trial::campaign::CampaignSettings;
use barrelman_trial::metrics::{Arena, TrialEntry, measure};
use barrelman_trial::records::RecordingStart;
use barrelman_trial::report::{Report, ReportedTrial, SetKind, TrialSet, TrialTrace};
use barrelman_trial::shadow::simulate_motor_schema;
use barrelman_vocab::VehicleProfile;

use super::trial_input::{self, Input, LogKind, TrialInput};
use crate::cli::ReportArgs;
use crate::config::{self, Configuration};
use barrelman_experiments::campaign::plan::arena_of;
use barrelman_experiments::law_choice::LawName;
use barrelman_host::output::{self, OutputFile};

/// Runs the command.
///
/// # Errors
/// If a log cannot be read or an output not be written.
pub fn run(args: &ReportArgs) -> Result<ExitCode> {
    let page = OutputFile::open(&args.output, args.force)?;
    let mut trials = Vec::with_capacity(args.logs.len());
    let mut cut = false;
    for path in &args.logs {
        match trial_input::read_any(path)? {
            Input::Trial(input) => {
                if let Some(message) = &input.cut {
                    tracing::error!("{message}");
                    cut = true;
                }
                trials.push(of_log(*input, args));
            }
            Input::Campaign(campaign) => {
                args.region.refuse_for_campaign(path, false)?;
                cut |= campaign.report_truncation(path);
                trials.extend(campaign.entries.into_iter().map(|(entry, _)| ReportedTrial {
                    entry: entry.trial,
                    set: TrialSet { kind: SetKind::Simulated, name: in_words(&entry.campaign) },
                    trace: None,
                }));
            }
        }
    }
    let report = Report { trials, version: env!("CARGO_PKG_VERSION").to_owned() };
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("the folder {} cannot be made", folder.display()))?;
        for figure in report.figures() {
            let path = folder.join(format!("{}.svg", figure.name));
            write(output::create(&path, args.force)?, &figure.svg())?;
        }
    }
    write(page, &report.page())?;
    writeln!(stdout(), "{}: {} trials", args.output.display(), report.trials.len())?;
    Ok(if cut { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn write(mut file: OutputFile, text: &str) -> Result<()> {
    file.write_all(text.as_bytes()).with_context(|| format!("{} cannot be written", file.path().display()))
}

fn of_log(mut input: TrialInput, args: &ReportArgs) -> ReportedTrial {
    if let Some(frame) = args.region.frame_size {
        input.log.frame = frame;
    }
    let shares = args.region.region.unwrap_or(VehicleProfile::fotokite_pro().region);
    let region = input.log.region(shares);
    let metrics = measure(&input.log, region, input.log.picture);
    let simulated = match &input.kind {
        LogKind::Recording(Some(start)) => SimulatedRun::of(start),
        _ => None,
    };
    let vehicle = match &input.kind {
        LogKind::Recording(Some(start)) => vehicle_of_another_law(start),
        _ => None,
    };
    let asked = args.arena.and_then(Arena::from_number);
    let recorded = |name: &str| TrialSet { kind: SetKind::Recorded, name: name.to_owned() };
    let (name, arena, set) = match (simulated, &input.kind) {
        (Some(run), _) => {
            let set = TrialSet { kind: SetKind::Simulated, name: run.set };
            (run.trial, asked.or_else(|| arena_of(&run.scenario)), set)
        }
        (None, kind) => {
            let set = match kind {
                LogKind::Laboratory => {
                    TrialSet { kind: SetKind::Laboratory, name: "laboratory logs".to_owned() }
                }
                LogKind::Exported => recorded("exported logs"),
                LogKind::Recording(_) => recorded("recordings"),
            };
            let arena = asked.or_else(|| Arena::from_name(&input.name));
            (input.name, arena, set)
        }
    };
    let shadow = vehicle.map(|profile| {
        simulate_motor_schema(&input.log, region, &profile)
            .into_iter()
            .map(|step| step.map(|step| step.p))
            .collect()
    });
    let entry = TrialEntry { name, arena, metrics };
    ReportedTrial { entry, set, trace: Some(TrialTrace { log: input.log, region, shadow }) }
}

/// The vehicle of a recording that another law than the schema servoed.
fn vehicle_of_another_law(start: &RecordingStart) -> Option<VehicleProfile> {
    let file = config::parse_recorded(&start.configuration).ok()?;
    let all = Configuration::resolve_recorded(&file).ok()?;
    (all.law.name != LawName::MotorSchema).then_some(all.profile)
}

/// What a recording of a simulated trial is of.
struct SimulatedRun {
    scenario: String,
    /// `SCENARIO/SEED`.
    trial: String,
    set: String,
}

impl SimulatedRun {
    /// `None` of another recording.
    fn of(start: &RecordingStart) -> Option<Self> {
        let world = start.video.strip_prefix("sim:")?;
        let (scenario, seed) = world.split_once("?seed=")?;
        let configuration = config::parse_recorded(&start.configuration).ok();
        let law = configuration
            .and_then(|file| Configuration::resolve_recorded(&file).ok())
            .map(|all| all.law.name_str());
        Some(Self {
            scenario: scenario.to_owned(),
            trial: format!("{scenario}/{seed}"),
            set: law.map_or_else(
                || format!("{scenario}, recorded"),
                |law| format!("{scenario}, {law}, recorded"),
            ),
        })
    }
}

/// A campaign's settings, as far as they tell it from others.
fn in_words(settings: &CampaignSettings) -> String {
    let mut words = vec![settings.scenario.clone(), settings.law.clone(), settings.perception.clone()];
    words.extend(settings.mode.clone());
    words.extend(settings.horizon_s.map(|horizon| format!("horizon {horizon} s")));
    words.extend(settings.rate_rad_per_s.map(|rate| format!("{rate} rad/s")));
    words.extend((settings.plant != "nominal").then(|| format!("plant {}", settings.plant)));
    words.extend(settings.sea_state.map(|state| format!("sea state {state}")));
    words.extend(settings.wind_m_per_s.map(|wind| format!("wind {wind} m/s")));
    words.extend(settings.boat_speed_m_per_s.map(|speed| format!("boat {speed} m/s")));
    words.extend(settings.size.clone());
    words.extend(settings.tracker.clone());
    let versions = settings.behaviour();
    words.extend((versions.tracker != FIRST).then(|| format!("tracker's behaviour {}", versions.tracker)));
    words.extend((versions.law != FIRST).then(|| format!("law's behaviour {}", versions.law)));
    words.push(settings.setting.clone());
    words.join(", ")
}
