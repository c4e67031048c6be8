//! `faults`: every fault, and every pair of faults, in virtual time.
//!
//! ```text
//!   program: Pilot on the truth --rates, time to live--> guard: Gate, LinkCore, Session --line--> ground station
//! ```
//! With a boat (`vessel`) the pilot's second actuator is at the other end, with a rule of its own. Without a
//! guard (Fotokite Sigma, ONVIF camera) the link is a thread of the program, and the line carries requests
//! and answers.
//!
//! One process: the pilot, the guard's gate, the link and the session are those of a live run; pipe, line,
//! clocks and the ground station are simulated, half of the ground stations being the worst of their kind: a
//! `stop` that leaves the rates in force (Fotokite Pro), a gimbal manager that obeys everybody and keeps a
//! rate for ever (MAVLink gimbal). An oracle that does not ask the pilot judges each millisecond
//! ([`oracle`]).

mod subject;

mod oracle;
mod permitted;

mod run;

mod run_result;

mod vessel;

mod program;

mod picture;
mod video_path;

mod machine;

mod link_end;
mod link_host;

mod vehicle;

mod fotokite_pro_station;
mod fotokite_sigma_station;
mod gimbal_station;
mod http_network;
mod onvif_station;
mod station;
mod without_first_zeros;

mod line;
mod link_plan;

mod fault;
mod mutant;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use anyhow::{Result, ensure};
use clap::{Args, ValueEnum as _};

use self::mutant::Mutant;
use self::run_result::RunResult;
use self::subject::Subject;
use self::vessel::run::HELD_MARK;
use crate::output::print_line;
use crate::parallel;

/// Least share of the runs in which each licence must move the vehicle.
const LEAST_MOVED: f64 = 0.05;
/// Number of violations that are printed.
const PRINTED: usize = 10;

/// `faults`.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The vehicle whose camera is moved, or the boat.
    #[arg(long, value_enum, default_value = "fotokite-pro")]
    vehicle: Subject,
    /// Number of runs: each fault, then each pair, over and over.
    #[arg(long, default_value_t = 10_000)]
    runs: u64,
    /// Seed of the runs.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Take something out; the campaign must then find violations.
    #[arg(long, value_enum, default_value = "none")]
    mutant: Mutant,
    /// Run this run alone, and print what the vehicle received.
    #[arg(long, value_name = "NUMBER")]
    trace: Option<u64>,
}

/// The results of a campaign.
struct Campaign {
    subject: Subject,
    results: Vec<(u64, Option<RunResult>)>,
}

/// Of one kind of fault: the runs with it, and for each figure the worst time to rest, alone and in pairs,
/// ms.
type Row = (usize, Vec<[u64; 2]>);

impl Campaign {
    fn run(subject: Subject, runs: u64, seed: u64, mutant: Mutant) -> Result<Self> {
        let numbers: Vec<u64> = (0..runs).collect();
        let results = parallel::map(&numbers, |number| {
            // A panic of the program under test is a result.
            let run = || subject.run(*number, seed, mutant, &mut |_| {});
            catch_unwind(AssertUnwindSafe(run)).ok().transpose()
        });
        let results: Vec<Option<RunResult>> = results.into_iter().collect::<Result<_>>()?;
        Ok(Self { subject, results: numbers.into_iter().zip(results).collect() })
    }

    fn panics(&self) -> usize {
        self.results.iter().filter(|(_, result)| result.is_none()).count()
    }

    /// The runs that violated the rule: the number, when, how, and their faults.
    fn violations(&self) -> Vec<String> {
        let text = |(number, result): &(u64, Option<RunResult>)| {
            let result = result.as_ref()?;
            let (at_ms, text) = result.violation.as_ref()?;
            let faults: Vec<String> = result
                .faults
                .iter()
                .map(|fault| format!("{} {}..{} ms", fault.kind.name(), fault.from_ms, fault.until_ms))
                .collect();
            Some(format!("run {number}, {at_ms} ms: {text} ({})", faults.join("; ")))
        };
        self.results.iter().filter_map(text).collect()
    }

    fn moved(&self, licence: &str) -> usize {
        let has_moved = |result: &&RunResult| result.moved.contains(&licence);
        self.results.iter().filter_map(|(_, result)| result.as_ref()).filter(has_moved).count()
    }

    fn excluded(&self) -> usize {
        let is_excluded = |result: &&RunResult| result.is_excluded;
        self.results.iter().filter_map(|(_, result)| result.as_ref()).filter(is_excluded).count()
    }

    fn table(&self) -> BTreeMap<fault::FaultKind, Row> {
        let mut table = BTreeMap::new();
        for result in self.results.iter().filter_map(|(_, result)| result.as_ref()) {
            let is_pair = usize::from(result.faults.len() > 1);
            for fault in &result.faults {
                let empty = || (0, vec![[0; 2]; self.subject.figures().len()]);
                let (runs, worst): &mut Row = table.entry(fault.kind).or_insert_with(empty);
                *runs += 1;
                for (worst, of_run) in worst.iter_mut().zip(&result.worst_ms) {
                    worst[is_pair] = worst[is_pair].max(*of_run);
                }
            }
        }
        table
    }

    fn print_table(&self) {
        let names: String = self
            .subject
            .figures()
            .iter()
            .map(|name| format!(" {:>14} {:>14}", format!("{name} alone"), format!("{name} in pairs")))
            .collect();
        print_line(&format!("{:<22} {:>6}{names}, ms", "fault", "runs"));
        for (kind, (runs, worst)) in self.table() {
            let worst: String =
                worst.iter().map(|[alone, paired]| format!(" {alone:>14} {paired:>14}")).collect();
            print_line(&format!("{:<22} {runs:>6}{worst}", kind.name()));
        }
    }
}

/// The mutant as it is named on the command line.
fn name_of(mutant: Mutant) -> String {
    mutant.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

/// Runs the campaign. Returns whether the requirements hold.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let began = Instant::now();
    ensure!(
        options.mutant == Mutant::None || options.vehicle.mutants().contains(&options.mutant),
        "--mutant {}: this vehicle has none; it has {}",
        name_of(options.mutant),
        options.vehicle.mutants().iter().map(|mutant| name_of(*mutant)).collect::<Vec<_>>().join(", ")
    );
    if let Some(number) = options.trace {
        let trace = &mut |line: &str| print_line(line);
        let result = options.vehicle.run(number, options.seed, options.mutant, trace)?;
        print_line(&format!("{result:?}"));
        return Ok(result.violation.is_none());
    }
    let campaign = Campaign::run(options.vehicle, options.runs, options.seed, options.mutant)?;
    campaign.print_table();
    let (violations, panics) = (campaign.violations(), campaign.panics());
    for text in violations.iter().take(PRINTED) {
        print_line(text);
    }
    let least = (options.runs as f64 * LEAST_MOVED) as usize;
    let mut holds = violations.is_empty() && panics == 0;
    for licence in options.vehicle.licences() {
        let moved = campaign.moved(licence);
        holds &= moved >= least;
        print_line(&format!("moved with the licence {licence}: {moved} runs (at least {least})"));
    }
    let held = campaign.moved(HELD_MARK);
    if held > 0 {
        print_line(&format!("{HELD_MARK}: {held} runs"));
    }
    print_line(&format!(
        "{} runs in {:.0} s: {} later than {} ms or without a licence, {panics} panics; {} with guard and \
         program gone together are not judged",
        options.runs,
        began.elapsed().as_secs_f64(),
        violations.len(),
        options.vehicle.rest_limit_ms(),
        campaign.excluded(),
    ));
    Ok(holds)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each fault once, and each pair.
    fn round(subject: Subject) -> u64 {
        let count = subject.faults().len() as u64;
        count + count * (count + 1) / 2
    }

    #[test]
    fn every_fault_and_pair_of_faults_ends_in_rest() {
        for subject in Subject::value_variants().iter().copied() {
            let campaign = Campaign::run(subject, 2 * round(subject), 7, Mutant::None).unwrap();
            assert_eq!(campaign.violations(), Vec::<String>::new(), "{subject:?}");
            assert_eq!(campaign.panics(), 0);
            assert!(campaign.table().len() == subject.faults().len());
            for licence in subject.licences() {
                assert!(campaign.moved(licence) >= 25, "{subject:?}: {licence}");
            }
        }
    }

    /// Whether what is taken out of each of these is found.
    fn check_mutants(is_checked: impl Fn(Subject) -> bool) {
        for subject in Subject::value_variants().iter().copied().filter(|subject| is_checked(*subject)) {
            for mutant in subject.mutants() {
                let is_found = |seed| {
                    let campaign = Campaign::run(subject, round(subject), seed, *mutant).unwrap();
                    !campaign.violations().is_empty()
                };
                // Some of what is taken out shows in one run of hundreds.
                assert!((7..11).any(is_found), "{subject:?}: {mutant:?}");
            }
        }
    }

    #[test]
    fn what_is_taken_out_of_a_camera_is_found() {
        check_mutants(|subject| matches!(subject, Subject::Camera(_)));
    }

    #[test]
    fn what_is_taken_out_of_a_boat_is_found() {
        check_mutants(|subject| matches!(subject, Subject::Boat(_)));
    }
}
