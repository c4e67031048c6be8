//! Other values of the gains of our law, for tuning.

use anyhow::{Context, Result, bail};
use barrelman_control::guidance::{LineOfSightTuning, VesselModel};

/// The default gains and the default vessel with changes of the form NAME=VALUE.
///
/// # Errors
/// If a change has another form, or names no gain.
pub(super) fn changed(changes: &[String]) -> Result<(LineOfSightTuning, VesselModel)> {
    let mut tuning = LineOfSightTuning::DEFAULT;
    let mut model = VesselModel::JET;
    for change in changes {
        let (name, value) = change.split_once('=').with_context(|| format!("{change}: use NAME=VALUE"))?;
        let value: f64 = value.parse().with_context(|| format!("{change}: the value is no number"))?;
        *gain(&mut tuning, &mut model, name)? = value;
    }
    Ok((tuning, model))
}

fn gain<'t>(
    tuning: &'t mut LineOfSightTuning,
    model: &'t mut VesselModel,
    name: &str,
) -> Result<&'t mut f64> {
    Ok(match name {
        "acceleration-noise" => &mut tuning.acceleration_noise,
        "min-fix" => &mut tuning.min_fix_std_dev_m,
        "course-gain" => &mut tuning.course_gain_per_s,
        "turn-damping" => &mut tuning.turn_damping,
        "rudder-step" => &mut tuning.rudder_step,
        "look-ahead-share" => &mut tuning.look_ahead_share,
        "look-ahead-min" => &mut tuning.look_ahead_m.0,
        "look-ahead-max" => &mut tuning.look_ahead_m.1,
        "integral-gain" => &mut tuning.integral_gain,
        "pursuit" => &mut tuning.pursuit_m,
        "way-throttle" => &mut tuning.way_throttle,
        "way-speed" => &mut tuning.way_speed_m_per_s,
        "course-speed" => &mut tuning.course_speed_m_per_s,
        "arrival" => &mut tuning.arrival_m,
        "hold" => &mut tuning.hold_m,
        "stand-off-margin" => &mut tuning.stand_off_margin_m,
        "keep-out-margin" => &mut tuning.keep_out_margin_m,
        "reaction" => &mut tuning.reaction_s,
        "turn-per-throttle" => &mut model.turn_per_throttle,
        "yaw-lag" => &mut model.yaw_lag_s,
        "drift-lag" => &mut model.drift_lag_s,
        "thrust-lag" => &mut model.thrust_lag_s,
        "speed-per-throttle" => &mut model.speed_per_throttle,
        "coasting" => &mut model.coasting_m_per_s2,
        "astern" => &mut model.astern_m_per_s2,
        _ => bail!("there is no gain {name:?}"),
    })
}
