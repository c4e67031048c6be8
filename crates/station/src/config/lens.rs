//! The table `[camera.lens]`, or a file with the same keys: the lens as OpenCV's calibration gives it.
//!
//! The model is that of Brown and Conrady with five coefficients, and it is used as it is. The principal
//! point counts as in OpenCV, where the centre of the first pixel is (0, 0); inside of the program it is
//! (0.5, 0.5).

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use barrelman_control::water::lens_fault::{LensFault, fault_of};
use barrelman_experiments::toml_message::message_of;
use barrelman_host::input;
use barrelman_vocab::{BrownConrady, Distortion, Lens, PictureSize, PixelPoint};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::declared;

/// Offset of our pixel coordinates from those of OpenCV.
const HALF_PIXEL: f64 = 0.5;

/// A calibrated lens: the results of OpenCV's `calibrateCamera` for pictures of one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LensSection {
    /// Width of the pictures of the calibration, pixels.
    #[schemars(range(min = 16, max = 32_768), extend("unit" = "pixels"))]
    #[schemars(example = 1280)]
    pub width: u32,
    /// Height of the pictures of the calibration, pixels.
    #[schemars(range(min = 16, max = 32_768), extend("unit" = "pixels"))]
    #[schemars(example = 720)]
    pub height: u32,
    /// Horizontal focal length, pixels, 0.1 to 20 widths.
    #[schemars(example = 760.2)]
    pub fx: f64,
    /// Vertical focal length, pixels, 0.1 to 20 widths.
    #[schemars(example = 759.8)]
    pub fy: f64,
    /// Principal point from the left, pixels; the centre of the first pixel is 0.
    #[schemars(example = 641.3)]
    pub cx: f64,
    /// Principal point from the top, pixels; the centre of the first pixel is 0.
    #[schemars(example = 355.9)]
    pub cy: f64,
    /// Radial distortion, second order.
    #[schemars(example = -0.09)]
    #[serde(default)]
    pub k1: f64,
    /// Radial distortion, fourth order.
    #[schemars(example = 0.012)]
    #[serde(default)]
    pub k2: f64,
    /// Tangential distortion along y.
    #[schemars(example = 0.0011)]
    #[serde(default)]
    pub p1: f64,
    /// Tangential distortion along x.
    #[schemars(example = -0.0007)]
    #[serde(default)]
    pub p2: f64,
    /// Radial distortion, sixth order.
    #[schemars(example = -0.001)]
    #[serde(default)]
    pub k3: f64,
}

/// Reads a lens file.
///
/// # Errors
/// If the file cannot be read or parsed, or its lens cannot be used; the message names the file and the key.
pub(super) fn read(path: &Path) -> Result<LensSection> {
    let text = String::from_utf8(input::read(path)?).context("it is not UTF-8 text");
    let parsed = text.and_then(|text| {
        let section: LensSection =
            toml::from_str(&text).map_err(|error| anyhow!("{}", message_of(&error)))?;
        declared::check(&section, "camera.lens")?;
        section.to_lens()?;
        Ok(section)
    });
    parsed.with_context(|| format!("the lens file {} is not usable", path.display()))
}

/// Why a lens does not fit pictures of this size, and what to do; `None`: it fits.
pub fn misfit(lens: &Lens, picture: PictureSize) -> Option<String> {
    if lens.scaled_to(picture).is_some() {
        return None;
    }
    Some(format!(
        "camera.lens is calibrated for {} pictures, and the video has {picture}, of another aspect ratio: set the camera to the aspect ratio of the calibration, calibrate it for {picture}, or omit the lens",
        lens.picture
    ))
}

impl LensSection {
    /// The lens.
    ///
    /// # Errors
    /// If the lens cannot be used; the message names the key.
    pub(super) fn to_lens(&self) -> Result<Lens> {
        let Self { width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3 } = *self;
        for (key, value) in [("fx", fx), ("fy", fy)] {
            let (min, max) = (0.1 * f64::from(width), 20.0 * f64::from(width));
            ensure!(
                (min..=max).contains(&value),
                "camera.lens.{key} = {value}: use pixels from {min} to {max}"
            );
        }
        let lens = Lens {
            picture: PictureSize::new(width, height),
            focal_px: (fx, fy),
            principal: PixelPoint { u: cx + HALF_PIXEL, v: cy + HALF_PIXEL },
            distortion: Distortion::BrownConrady(BrownConrady { k1, k2, p1, p2, k3 }),
        };
        match fault_of(&lens) {
            None => Ok(lens),
            Some(LensFault::NotFinite) => {
                bail!("camera.lens: cx, cy, k1, k2, p1, p2 or k3 is not a finite number: correct it")
            }
            Some(LensFault::FocalLength) => {
                bail!("camera.lens: fx or fy is not above zero: take both from the camera matrix")
            }
            Some(LensFault::PrincipalPoint) => bail!(
                "camera.lens: the principal point cx = {cx}, cy = {cy} is outside of the {} picture: take cx and cy from the camera matrix, and width and height from the pictures of the calibration",
                lens.picture
            ),
            Some(LensFault::Fold(at)) => bail!(
                "camera.lens: the distortion folds over inside of the picture, at pixel {:.0}, {:.0}: check the order k1, k2, p1, p2, k3, or calibrate with the pattern near the corners of the picture, too",
                at.u,
                at.v
            ),
        }
    }

    /// The table of a lens; `None`: the lens is not one of OpenCV's.
    pub(super) fn from_lens(lens: &Lens) -> Option<Self> {
        let Distortion::BrownConrady(BrownConrady { k1, k2, p1, p2, k3 }) = lens.distortion else {
            return None;
        };
        Some(Self {
            width: lens.picture.width,
            height: lens.picture.height,
            fx: lens.focal_px.0,
            fy: lens.focal_px.1,
            cx: lens.principal.u - HALF_PIXEL,
            cy: lens.principal.v - HALF_PIXEL,
            k1,
            k2,
            p1,
            p2,
            k3,
        })
    }
}
