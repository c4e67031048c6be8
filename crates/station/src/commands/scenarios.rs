//! `barrelman scenarios`: lists the scenarios, prints the file of one, or checks a file.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::Result;

use crate::cli::ScenariosArgs;
use barrelman_experiments::scenario::{self, BUILT_IN, ScenarioOverrides, file::ScenarioFile};

/// Runs the command.
///
/// # Errors
/// If there is no such scenario, or the file has a mistake.
pub fn run(args: &ScenariosArgs) -> Result<ExitCode> {
    let mut out = stdout().lock();
    let Some(name) = &args.name else {
        let width = BUILT_IN.iter().map(|built_in| built_in.name.len()).max().unwrap_or(0);
        for built_in in BUILT_IN {
            let file: ScenarioFile = toml::from_str(built_in.text)?;
            writeln!(out, "{:width$}  {}", built_in.name, file.summary)?;
        }
        return Ok(ExitCode::SUCCESS);
    };
    if let Some(built_in) = BUILT_IN.iter().find(|built_in| built_in.name == name) {
        write!(out, "{}", scenario::complete(built_in.text))?;
        return Ok(ExitCode::SUCCESS);
    }
    let loaded = scenario::load(name, &ScenarioOverrides::default())?;
    writeln!(out, "{name} is a scenario: {}", loaded.scenario.name)?;
    Ok(ExitCode::SUCCESS)
}
