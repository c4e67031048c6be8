//! The arguments of `scenarios` and `render`.

use std::path::PathBuf;

use barrelman_simd::SimdLevel;
use barrelman_vocab::PictureSize;
use clap::Args;

use super::values::{parse_clip_length, parse_size};

/// `scenarios`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman scenarios\n  barrelman scenarios lab1 > mine.toml\n  barrelman scenarios mine.toml"
)]
pub struct ScenariosArgs {
    /// The scenario to print, or the path of your own .toml file to check.
    pub name: Option<String>,
}

/// `render`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman render arena1 --seed 7 --seconds 20 --output clip.mp4 --truth truth.csv --masks masks")]
pub struct RenderArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file.
    pub scenario: String,
    /// Seed of everything random.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Length of the clip; it ends before, where the scenario does.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_clip_length)]
    pub seconds: f64,
    /// The clip.
    #[arg(long, value_name = "CLIP.mp4")]
    pub output: PathBuf,
    /// Where the target is in every frame.
    #[arg(long, value_name = "TRUTH.csv")]
    pub truth: PathBuf,
    /// Write which pixels show the target here: one PNG for each frame, white on black.
    #[arg(long, value_name = "DIR")]
    pub masks: Option<PathBuf>,
    /// Size of the picture; the view stays the same. Without it the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// The widest vector instructions that pictures are drawn with: scalar, sse2, avx2 or avx512. The pictures are the
    /// same with all.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}
