//! The options `--region` and `--frame-size`, which several commands share.

use std::path::Path;

use anyhow::{Result, bail};
use barrelman_vocab::PictureSize;
use barrelman_vocab::profile::RegionShares;
use clap::Args;

use super::values::{parse_region, parse_size};

/// How P is to be computed.
#[derive(Debug, Args)]
pub struct RegionArgs {
    /// The frame that the region is a share of; without it the log's own.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub frame_size: Option<PictureSize>,
    /// Semi-axes of the region as shares of half the frame's width and height; without it the vehicle's.
    #[arg(long, value_name = "A,B", value_parser = parse_region)]
    pub region: Option<RegionShares>,
}

impl RegionArgs {
    /// A campaign's file holds figures of its own region: another one cannot be had from it.
    ///
    /// # Errors
    /// If another one was asked for.
    pub fn refuse_for_campaign(&self, path: &Path, picture: bool) -> Result<()> {
        if self.region.is_some() || self.frame_size.is_some() || picture {
            bail!(
                "{} holds the metrics of a campaign, whose region and picture are fixed: leave --region, --frame-size \
                 and --picture away, or give the recordings of its trials",
                path.display()
            );
        }
        Ok(())
    }
}
