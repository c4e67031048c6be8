//! How fast a camera turns and zooms, and how long a motion lasts that is not renewed, as the camera states.

use core::time::Duration;

use super::answers::{MoveOptions, MoveOptionsBody, Timeouts};
use super::ask::MOVE_TIMEOUT;
use super::duration::duration_of;
use super::joining_error::{JoiningError, LATEST_TIMEOUT, answer};
use super::refusal::Refusal;
use super::velocity::FullSpeeds;

/// The limits of the motion, of an answer or of one that the camera does not know.
pub(super) fn limits_of(
    refused: Option<Refusal>,
    body: &[u8],
) -> Result<(FullSpeeds, Duration), JoiningError> {
    match refused {
        Some(refusal) if refusal.is_unknown => Ok((FullSpeeds::GENERIC, MOVE_TIMEOUT)),
        refused => {
            let found: MoveOptionsBody = answer("GetConfigurationOptions", refused, body)?;
            limits(&found.answer.options)
        }
    }
}

/// Of several spaces the generic one, which a camera uses where none is named; otherwise the first.
fn usual<T>(spaces: &[T], uri: fn(&T) -> &String) -> Option<&T> {
    spaces.iter().find(|space| uri(space).ends_with("/VelocityGenericSpace")).or(spaces.first())
}

/// The ends of the ranges, and the time-out nearest to [`MOVE_TIMEOUT`] that the camera takes.
fn limits(options: &MoveOptions) -> Result<(FullSpeeds, Duration), JoiningError> {
    let spaces = &options.spaces;
    let space = usual(&spaces.velocities, |space| &space.uri).ok_or(JoiningError::NoVelocity)?;
    let is_usable = |max: f64| (1e-3..=1e3).contains(&max);
    if !is_usable(space.pan.max) || !is_usable(space.tilt.max) {
        return Err(JoiningError::NoVelocity);
    }
    let (least, largest) = match &options.timeouts {
        None => (Duration::ZERO, MOVE_TIMEOUT),
        // A least one that cannot be read may be a long one.
        Some(Timeouts { min, max }) => (
            duration_of(min).ok_or(JoiningError::Unreadable("GetConfigurationOptions"))?,
            duration_of(max).filter(|most| !most.is_zero()).unwrap_or(MOVE_TIMEOUT),
        ),
    };
    if least > LATEST_TIMEOUT {
        return Err(JoiningError::LateTimeout(least));
    }
    let zoom = usual(&spaces.zoom_velocities, |space| &space.uri);
    let zoom = zoom.map(|space| space.zoom.max).filter(|max| is_usable(*max));
    let full = FullSpeeds { pan: space.pan.max, tilt: space.tilt.max, zoom };
    Ok((full, MOVE_TIMEOUT.min(largest).max(least)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn space(name: &str, most: f64) -> String {
        format!(
            "<ContinuousPanTiltVelocitySpace><URI>http://www.onvif.org/ver10/tptz/PanTiltSpaces/{name}</URI>\
             <XRange><Min>-{most}</Min><Max>{most}</Max></XRange><YRange><Min>-{most}</Min><Max>{most}</Max>\
             </YRange></ContinuousPanTiltVelocitySpace>"
        )
    }

    fn limits_by(spaces: &str, least: &str) -> Result<(FullSpeeds, Duration), JoiningError> {
        let body = format!(
            "<Envelope><Body><GetConfigurationOptionsResponse><PTZConfigurationOptions><Spaces>{spaces}</Spaces>\
             <PTZTimeout><Min>{least}</Min><Max>PT1M</Max></PTZTimeout></PTZConfigurationOptions>\
             </GetConfigurationOptionsResponse></Body></Envelope>"
        );
        limits_of(None, body.as_bytes())
    }

    #[test]
    fn the_speeds_are_those_of_the_space_that_is_used_where_none_is_named() {
        let (generic, degrees) = (space("VelocityGenericSpace", 1.0), space("VelocitySpaceDegrees", 60.0));
        for spaces in [format!("{degrees}{generic}"), format!("{generic}{degrees}"), generic] {
            assert_eq!(limits_by(&spaces, "PT1S").expect("read").0.pan, 1.0, "{spaces}");
        }
        assert_eq!(limits_by(&degrees, "PT1S").expect("read").0.tilt, 60.0);
    }

    #[test]
    fn a_least_time_out_is_read_however_it_is_stated_or_refused() {
        let generic = space("VelocityGenericSpace", 1.0);
        for (least, expected_ms) in
            [("PT1.5S", 1500), ("P0Y0M0DT0H0M1.5S", 1500), ("P0DT2S", 2000), ("", 1000), ("PT0S", 1000)]
        {
            let (_, timeout) = limits_by(&generic, least).expect(least);
            assert_eq!(timeout, Duration::from_millis(expected_ms), "{least}");
        }
        for least in ["PT10S", "P0Y0M0DT0H0M10S", "P1D", "P1Y", "ten seconds", "-PT1S"] {
            assert!(limits_by(&generic, least).is_err(), "{least}");
        }
    }
}
