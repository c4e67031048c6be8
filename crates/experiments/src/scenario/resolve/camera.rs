//! The camera: picture, optics, video link, first view and electronics.

use barrelman_sim::Optics;
use barrelman_sim::electronics::ElectronicsModel;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{CameraSetup, FirstView};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_sim::video_link::VideoLinkModel;
use barrelman_vocab::PictureSize;

use crate::scenario::file::CameraSection;
use crate::scenario::range::within;
use crate::scenario::{ScenarioError, ScenarioOverrides};

/// Sizes of the camera's picture and frame.
struct Sizes {
    picture: PictureSize,
    frame: PictureSize,
    /// Width of the picture over the width in the file.
    scale: f64,
}

pub(super) fn camera(
    section: &CameraSection,
    overrides: &ScenarioOverrides,
) -> Result<CameraSetup, ScenarioError> {
    let Sizes { picture, frame, scale } = sizes(section, overrides)?;
    let rate = section.pictures_per_second;
    if rate == 0 || !TICKS_PER_SECOND.is_multiple_of(rate) {
        return Err(ScenarioError::invalid(
            "camera.pictures_per_second",
            format!("{rate}: use a whole number that {TICKS_PER_SECOND} can be divided by, such as 30"),
        ));
    }
    let video = video_link(section)?;
    Ok(CameraSetup {
        height_m: within("camera.height_m", section.height_m, 0.2, 500.0, "metres")?,
        optics: Optics {
            picture,
            focal_px: scale * within("camera.focal_px", section.focal_px, 10.0, 100_000.0, "pixels")?,
            barrel: within("camera.barrel", section.barrel, 0.0, 1.0, "a number")?,
        },
        frame,
        pictures_per_second: rate,
        rolling_shutter_s: within(
            "camera.rolling_shutter_s",
            section.rolling_shutter_s,
            0.0,
            0.1,
            "seconds",
        )?,
        video,
        first_view: first_view(section)?,
        electronics: electronics(section)?,
        zoom: None,
    })
}

/// The sizes of picture and frame. A picture size in `overrides` shows the same view: the frame grows with
/// the width.
fn sizes(section: &CameraSection, overrides: &ScenarioOverrides) -> Result<Sizes, ScenarioError> {
    let written = size("camera.picture", section.picture)?;
    let written_frame = section.frame.map_or(Ok(written), |frame| size("camera.frame", frame))?;
    let picture = overrides.size.map_or(Ok(written), |to| size("camera.picture", [to.width, to.height]))?;
    let scale = f64::from(picture.width) / f64::from(written.width);
    let scaled = |side: u32| 2 * ((f64::from(side) * scale / 2.0).round() as u32);
    let frame = if overrides.size.is_some() && written_frame == written {
        picture
    } else {
        PictureSize::new(scaled(written_frame.width), scaled(written_frame.height))
    };
    if frame.width < picture.width || frame.height < picture.height {
        return Err(ScenarioError::invalid("camera.frame", "the frame is smaller than the picture in it"));
    }
    Ok(Sizes { picture, frame, scale })
}

fn size(key: &str, [width, height]: [u32; 2]) -> Result<PictureSize, ScenarioError> {
    let is_usable = |side: u32| (64..=4096).contains(&side) && side.is_multiple_of(2);
    if is_usable(width) && is_usable(height) {
        Ok(PictureSize::new(width, height))
    } else {
        Err(ScenarioError::invalid(
            key,
            format!("{width} x {height}: use even numbers of pixels from 64 to 4096"),
        ))
    }
}

fn video_link(section: &CameraSection) -> Result<VideoLinkModel, ScenarioError> {
    let share = |key: &str, value: f64| within(&format!("camera.loss.{key}"), value, 0.0, 1.0, "a share");
    let steady = VideoLinkModel {
        jitter_s: 0.5 * within("camera.latency_jitter_s", section.latency_jitter_s, 0.0, 1.0, "seconds")?,
        ..VideoLinkModel::steady(within("camera.latency_s", section.latency_s, 0.0, 5.0, "seconds")?)
    };
    let Some(loss) = &section.loss else { return Ok(steady) };
    Ok(VideoLinkModel {
        good_to_bad: share("to_bad", loss.to_bad)?,
        bad_to_good: share("to_good", loss.to_good)?,
        impaired_share: share("spoilt", loss.spoilt)?,
        frozen_share: share("frozen", loss.frozen)?,
        ..steady
    })
}

fn first_view(section: &CameraSection) -> Result<FirstView, ScenarioError> {
    let pan_tilt = |key: &str, [pan, tilt]: [f64; 2], min: f64| {
        let key = format!("camera.{key}");
        Ok::<_, ScenarioError>((
            within(&key, pan, min, 1.5, "radians")?,
            within(&key, tilt, min, 1.5, "radians")?,
        ))
    };
    Ok(FirstView {
        mean: pan_tilt("first_view_rad", section.first_view_rad, -1.5)?,
        std_dev: pan_tilt("first_view_deviation_rad", section.first_view_deviation_rad, 0.0)?,
    })
}

fn electronics(section: &CameraSection) -> Result<ElectronicsModel, ScenarioError> {
    let drift = |what: &str, std_dev: f64, time_s: f64| {
        Ok::<_, ScenarioError>(OrnsteinUhlenbeck {
            std_dev: within(&format!("camera.{what}_drift"), std_dev, 0.0, 0.5, "a share")?,
            time_constant_s: within(&format!("camera.{what}_time_s"), time_s, 0.01, 1000.0, "seconds")?,
        })
    };
    Ok(ElectronicsModel {
        brightness: drift("brightness", section.brightness_drift, section.brightness_time_s)?,
        white_balance: drift("white_balance", section.white_balance_drift, section.white_balance_time_s)?,
        exposure_s: within("camera.exposure_s", section.exposure_s, 0.0, 0.1, "seconds")?,
    })
}
