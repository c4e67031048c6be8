//! `barrelman law`: runs a camera law on recorded positions.

use std::io::{BufWriter, Write, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result};
use barrelman_trial::law::{LawRow, run_open_loop};
use barrelman_vocab::{AngularRate, LawId};

use super::trial_input;
use crate::cli::LawArgs;
use crate::config::resolve::profile_named;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_host::output;

/// The header of the output.
pub const HEADER: &str = "row,time_s,x,y,p,pitch_rate,yaw_rate";

/// Runs the command.
///
/// # Errors
/// If the log cannot be read or the output not be written.
pub fn run(args: &LawArgs) -> Result<ExitCode> {
    let law = args.law.resolve(LawChoice::MOTOR_SCHEMA)?;
    let mut profile = profile_named(&args.profile)?;
    if let Some(rate) = args.rate {
        profile = profile.with_motor_schema_rate(AngularRate::from_radians_per_second(rate));
    }
    let mut input = trial_input::read(&args.log)?;
    if let Some(frame) = args.region.frame_size {
        input.log.frame = frame;
    }
    let region = input.log.region(args.region.region.unwrap_or(profile.region));
    if law.law != LawId::Schema {
        tracing::warn!(
            "open loop: the recorded camera did not follow this law's commands, so they do not show how well the law keeps \
             a target in view; `barrelman trials` closes the loop"
        );
    }
    let rows = run_open_loop(&input.log, region, &profile, law.settings());
    match &args.output {
        Some(path) => {
            let file = output::create(path, args.force)?;
            write_rows(&rows, file).with_context(|| format!("{} cannot be written", path.display()))?;
        }
        None => write_rows(&rows, stdout().lock())?,
    }
    Ok(match input.cut {
        Some(cut) => {
            tracing::error!("{cut}");
            ExitCode::FAILURE
        }
        None => ExitCode::SUCCESS,
    })
}

fn write_rows(rows: &[LawRow], output: impl Write) -> Result<()> {
    let mut output = BufWriter::new(output);
    writeln!(output, "{HEADER}")?;
    for row in rows {
        let (pitch, yaw) = (row.rates.pitch.radians_per_second(), row.rates.yaw.radians_per_second());
        match row.target {
            Some((at, p)) => {
                writeln!(output, "{},{},{},{},{p},{pitch},{yaw}", row.row, row.time_s, at.x, at.y)?;
            }
            None => writeln!(output, "{},{},,,,{pitch},{yaw}", row.row, row.time_s)?,
        }
    }
    output.flush()?;
    Ok(())
}
