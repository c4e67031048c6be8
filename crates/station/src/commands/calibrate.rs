//! `barrelman calibrate axes`: measures the camera's axes by slow test motions.
//!
//! A run without a tracker's selection makes the motions under the licence to calibrate, with every stop of a
//! run. The file of the configuration is not changed: the keys that change are printed, and the complete
//! configuration is written where that was asked for.

use std::io::{BufRead as _, Write as _, stdin, stdout};
use std::process::ExitCode;

use anyhow::{Context as _, Result, bail};
use barrelman_experiments::calibration::{CalibrationResult, CannotTell, MeasuredAxis};
use barrelman_host::clock::Clock;
use barrelman_host::output::OutputFile;
use barrelman_vocab::profile::{AxisDynamics, Sign, VehicleProfile};
use barrelman_vocab::speed_curve::{SpeedCurve, SpeedPoint};

use super::calibration_run::{CalibrationRun, calibrate};
use crate::cli::{CalibrateArgs, CalibrateCommand, UsageError};
use crate::config::Configuration;

/// Runs the command.
///
/// # Errors
/// If there is no consent, the run cannot be made, or an output cannot be written.
pub fn run(args: &CalibrateArgs, clock: Clock) -> Result<ExitCode> {
    let CalibrateCommand::Axes(args) = &args.what;
    if !args.turn_the_camera {
        return Err(UsageError(
            "the calibration turns the camera by itself: give --turn-the-camera if it may".to_owned(),
        )
        .into());
    }
    if !args.yes && !is_confirmed()? {
        bail!("not confirmed: nothing was moved");
    }
    let output = args.output.as_deref().map(|path| OutputFile::open(path, args.force)).transpose()?;
    let record = args.record.as_deref().map(|path| OutputFile::open(path, args.force)).transpose()?;
    let CalibrationRun { configuration, result } = calibrate(args, record, clock)?;
    let Some(result) = result else {
        bail!("the test motions were not all made: nothing was measured");
    };
    let profile = result.applied_to(&configuration.profile);
    print_result(&result, &configuration.profile, &profile)?;
    if let Some(mut file) = output {
        let text = Configuration { profile, ..configuration }.to_toml()?;
        let path = file.path().display().to_string();
        file.write_all(text.as_bytes())
            .and_then(|()| file.flush())
            .with_context(|| format!("{path} cannot be written"))?;
        writeln!(stdout(), "the complete configuration is in {path}")?;
    }
    Ok(if result.is_complete() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn is_confirmed() -> Result<bool> {
    let mut out = stdout().lock();
    writeln!(
        out,
        "The camera will turn by itself, at 0.1 rad/s, 15 degrees to each side, for a minute and a half.\n\
         A camera whose speeds are not known (ONVIF) turns at each of them before: up to 80 degrees, for eight minutes."
    )?;
    write!(out, "Nobody touches the vehicle, and the tether is free? Type yes: ")?;
    out.flush()?;
    let mut answer = String::new();
    stdin().lock().read_line(&mut answer).context("no answer can be read: give --yes")?;
    Ok(answer.trim() == "yes")
}

fn print_result(result: &CalibrationResult, before: &VehicleProfile, after: &VehicleProfile) -> Result<()> {
    let mut out = stdout().lock();
    for (name, axis) in [("pan", &result.pan), ("tilt", &result.tilt)] {
        writeln!(out, "{name}: {}", axis_text(axis))?;
    }
    match (result.elevation, result.gimbal_tilt) {
        (Some(elevation), Some(tilt)) => writeln!(
            out,
            "elevation {:.0} degrees; the gimbal reports the tilt as its {:?} angle",
            elevation.degrees(),
            tilt.axis
        )?,
        (Some(elevation), None) => writeln!(
            out,
            "elevation {:.0} degrees; no report of the gimbal follows the tilt: the law does not use them",
            elevation.degrees()
        )?,
        (None, _) => {}
    }
    writeln!(
        out,
        "\n# What the calibration changes in the configuration:\n{}",
        snippet(result, before, after)
    )?;
    Ok(())
}

fn axis_text(axis: &Result<MeasuredAxis, CannotTell>) -> String {
    match axis {
        Err(reason) => format!("cannot tell: {reason}"),
        Ok(axis) => format!(
            "{}, gain {:.3} of the profile's, dead times {:.0} ms (start) and {:.0} ms (stop), lag {:.0} ms",
            if axis.gain < 0.0 { "WRONG SIGN in the profile" } else { "sign right" },
            axis.gain.abs(),
            1e3 * axis.start_dead_time_s,
            1e3 * axis.stop_dead_time_s,
            1e3 * axis.lag_s
        ),
    }
}

/// The keys that change, as TOML.
fn snippet(result: &CalibrationResult, before: &VehicleProfile, after: &VehicleProfile) -> String {
    let sign = |sign| if sign == Sign::Same { "same" } else { "opposite" };
    let mut text = String::new();
    if let Some(speeds) = &after.speeds {
        let points = |curve: &SpeedCurve| {
            let pair =
                |point: &SpeedPoint| format!("[{}, {:.4}]", point.speed, point.rate.radians_per_second());
            curve.points().iter().map(pair).collect::<Vec<_>>().join(", ")
        };
        text += &format!(
            "[vehicle.speeds]\npan = [{}]\ntilt = [{}]\n",
            points(&speeds.pan),
            points(&speeds.tilt)
        );
    }
    if before.signs != after.signs {
        text += &format!(
            "[vehicle]\nyaw_sign = \"{}\"\npitch_sign = \"{}\"\n",
            sign(after.signs.yaw),
            sign(after.signs.pitch)
        );
    }
    if let Some(tilt) = result.gimbal_tilt {
        let axis = ["roll", "pitch", "yaw"][tilt.axis as usize];
        text += &format!(
            "[vehicle.gimbal_tilt]\naxis = \"{axis}\"\nsign = \"{}\"\nzero_rad = {:.4}\n",
            sign(tilt.sign),
            tilt.zero.radians()
        );
    }
    if result.elevation.is_some() {
        text += &format!("[camera]\nfirst_tilt_rad = {:.4}\n", after.camera.initial_tilt.radians());
    }
    let axis = |name: &str, axis: &AxisDynamics| {
        format!(
            "[camera.{name}]\nstart_dead_time_s = {}\nstop_dead_time_s = {}\nlag_s = {}\ngain = {}\n",
            axis.start_dead_time.as_secs_f64(),
            axis.stop_dead_time.as_secs_f64(),
            axis.lag.as_secs_f64(),
            axis.gain
        )
    };
    if result.pan.is_ok() {
        text += &axis("pan", &after.camera.pan);
    }
    if result.tilt.is_ok() {
        text += &axis("tilt", &after.camera.tilt);
    }
    text
}
