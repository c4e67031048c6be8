//! The options `--region` and `--frame-size`, which several commands share.

use std::path::Path;

use anyhow::{Result, bail};
use barrelman_vocab::PictureSize;
use barrelman_vocab::profile::RegionShares;
use clap::Args;

use super::values::{parse_region, parse_size};

/// The options that determine the region, and with it P.
#[derive(Debug, Args, Default)]
pub struct RegionArgs {
    /// Size of the frame that the region is a share of; default: the log's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub frame_size: Option<PictureSize>,
    /// Semi-axes of the region as shares of half the frame's width and height; default: the vehicle's.
    #[arg(long, value_name = "A,B", value_parser = parse_region)]
    pub region: Option<RegionShares>,
}

impl RegionArgs {
    /// Refuses a region for a campaign file, which holds metrics of a fixed region. `has_picture`:
    /// `--picture` is given.
    ///
    /// # Errors
    /// If a region, a frame size or a picture size is given.
    pub fn refuse_for_campaign(&self, path: &Path, has_picture: bool) -> Result<()> {
        if self.region.is_some() || self.frame_size.is_some() || has_picture {
            bail!(
                "{} holds the metrics of a campaign, whose region and picture are fixed: omit --region, --frame-size \
                 and --picture, or give the recordings of its trials",
                path.display()
            );
        }
        Ok(())
    }
}
