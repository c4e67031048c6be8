//! `barrelman report`: writes an HTML page of trials.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result};
use barrelman_trial::campaign::CampaignSettings;
use barrelman_trial::metrics::{Arena, TrialEntry, measure};
use barrelman_trial::records::RecordingStart;
use barrelman_trial::report::{Report, ReportedTrial, SetKind, TrialSet, TrialTrace};
use barrelman_trial::shadow::simulate_motor_schema;
use barrelman_trial::sortie::Sortie;
use barrelman_vocab::{LawId, VehicleProfile};

use super::recorded_sortie;
use super::trial_input::{self, InputFile, LogKind, TrialInput};
use crate::cli::ReportArgs;
use crate::config::{self, Configuration};
use barrelman_experiments::campaign::plan::arena_of;
use barrelman_experiments::campaign::recorded_trial;
use barrelman_host::output::{self, OutputFile};

/// Runs the command.
///
/// # Errors
/// If a log cannot be read or an output cannot be written.
pub fn run(args: &ReportArgs) -> Result<ExitCode> {
    let page = OutputFile::open(&args.output, args.force)?;
    let mut trials = Vec::with_capacity(args.logs.len());
    let mut is_truncated = false;
    for path in &args.logs {
        match trial_input::read_any(path)? {
            InputFile::Trial(input) => {
                if let Some(message) = &input.cut {
                    tracing::error!("{message}");
                    is_truncated = true;
                }
                let is_sortie =
                    matches!(&input.kind, LogKind::Recording(Some(start)) if start.trial.is_none());
                let sortie = is_sortie.then(|| recorded_sortie::of_recording(path)).transpose()?;
                trials.push(reported_trial(*input, args, sortie.map(|(sortie, _)| sortie)));
            }
            InputFile::Campaign(campaign) => {
                args.region.refuse_for_campaign(path, false)?;
                is_truncated |= campaign.report_truncation(path);
                trials.extend(campaign.entries.into_iter().map(|(entry, _)| ReportedTrial {
                    entry: entry.trial,
                    set: TrialSet { kind: SetKind::Simulated, name: campaign_name(&entry.campaign) },
                    sortie: None,
                    trace: None,
                }));
            }
        }
    }
    let report = Report::new(trials, env!("CARGO_PKG_VERSION").to_owned());
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("the folder {} cannot be created", folder.display()))?;
        for figure in report.figures() {
            let path = folder.join(format!("{}.svg", figure.name));
            write(output::create(&path, args.force)?, &figure.svg())?;
        }
    }
    write(page, &report.page())?;
    writeln!(stdout(), "{}: {}", args.output.display(), report.contents())?;
    Ok(if is_truncated { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn write(mut file: OutputFile, text: &str) -> Result<()> {
    file.write_all(text.as_bytes()).with_context(|| format!("{} cannot be written", file.path().display()))
}

/// The trial of a log, with its metrics and its trace.
fn reported_trial(mut input: TrialInput, args: &ReportArgs, sortie: Option<Sortie>) -> ReportedTrial {
    if let Some(frame) = args.region.frame_size {
        input.log.frame = frame;
    }
    let shares = args.region.region.unwrap_or(VehicleProfile::fotokite_pro().region);
    let region = input.log.region(shares);
    let metrics = measure(&input.log, region, input.log.picture);
    let simulated = match &input.kind {
        LogKind::Recording(Some(start)) => SimulatedTrial::from_start(start),
        _ => None,
    };
    let vehicle = match &input.kind {
        LogKind::Recording(Some(start)) => shadowed_vehicle(start),
        _ => None,
    };
    let given_arena = args.arena.and_then(Arena::from_number);
    let recorded = |name: &str| TrialSet { kind: SetKind::Recorded, name: name.to_owned() };
    let (name, arena, set) = match (simulated, &input.kind) {
        (Some(run), _) => {
            let set = TrialSet { kind: SetKind::Simulated, name: run.set };
            (run.trial, given_arena.or_else(|| arena_of(&run.scenario)), set)
        }
        (None, kind) => {
            let set = match kind {
                LogKind::Laboratory => {
                    TrialSet { kind: SetKind::Laboratory, name: "laboratory logs".to_owned() }
                }
                LogKind::Exported => recorded("exported logs"),
                LogKind::Recording(Some(_)) => TrialSet { kind: SetKind::Sortie, name: "sorties".to_owned() },
                LogKind::Recording(None) => recorded("recordings"),
            };
            let arena = given_arena.or_else(|| Arena::from_name(&input.name));
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
    ReportedTrial { entry, set, sortie, trace: Some(TrialTrace { log: input.log, region, shadow }) }
}

/// The vehicle of a recording, if its law is not the motor schema: the motor schema's shadow is computed for
/// it.
fn shadowed_vehicle(start: &RecordingStart) -> Option<VehicleProfile> {
    let file = config::parse(&start.configuration).ok()?;
    let configuration = Configuration::resolve_recorded(&file).ok()?;
    (configuration.law.law != LawId::Schema).then_some(configuration.profile)
}

/// The simulated trial that a recording shows.
struct SimulatedTrial {
    scenario: String,
    /// `SCENARIO/SEED`.
    trial: String,
    set: String,
}

impl SimulatedTrial {
    /// `None` for a recording that is not of a simulated trial, but of a run or a drive.
    fn from_start(start: &RecordingStart) -> Option<Self> {
        let settings = recorded_trial::settings_of(start.trial.as_ref()?).ok()?;
        let world = start.videos.first.address.strip_prefix("sim:")?;
        let (scenario, seed) = world.split_once("?seed=")?;
        let set = format!("{}, recorded", campaign_name(&settings));
        Some(Self { scenario: scenario.to_owned(), trial: format!("{scenario}/{seed}"), set })
    }
}

/// The name of a campaign: the settings that distinguish it from other campaigns.
fn campaign_name(settings: &CampaignSettings) -> String {
    let mut words = vec![settings.scenario.clone(), settings.law.clone(), settings.perception.clone()];
    words.extend(settings.mode.clone());
    words.extend(settings.horizon_s.map(|horizon| format!("horizon {horizon} s")));
    words.extend(settings.frame.as_ref().map(|frame| format!("frame {frame}")));
    words.extend(settings.rate_rad_per_s.map(|rate| format!("{rate} rad/s")));
    words.extend((settings.plant != "nominal").then(|| format!("plant {}", settings.plant)));
    words.extend(settings.sea_state.map(|state| format!("sea state {state}")));
    words.extend(settings.wind_m_per_s.map(|wind| format!("wind {wind} m/s")));
    words.extend(settings.guidance.as_ref().map(|law| format!("guidance {law}")));
    words.extend(settings.current_m_per_s.map(|current| format!("current {current} m/s")));
    words.extend(settings.boat_speed_m_per_s.map(|speed| format!("boat {speed} m/s")));
    words.extend(settings.size.clone());
    words.extend(settings.tracker.clone());
    words.push(settings.setting.clone());
    words.join(", ")
}
