//! The arguments of `scenarios` and `render`.

use std::path::PathBuf;

use barrelman_simd::SimdLevel;
use barrelman_vocab::PictureSize;
use clap::Args;

use super::values::{parse_clip_length, parse_mp4_path, parse_world_size};

/// `scenarios`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman scenarios\n  barrelman scenarios lab1 > mine.toml\n  barrelman scenarios mine.toml"
)]
pub struct ScenariosArgs {
    /// The scenario to print, or the path of a .toml file to check.
    pub name: Option<String>,
}

/// `render`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman render arena1 --seed 7 --seconds 10 --size 640x360 \\
    --output clip.mp4 --truth truth.csv --masks masks")]
pub struct RenderArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of a .toml file.
    pub scenario: String,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Length of the clip, seconds; a shorter scenario ends the clip.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_clip_length)]
    pub seconds: f64,
    /// Write the clip to this file.
    #[arg(long, value_name = "CLIP.mp4", value_parser = parse_mp4_path)]
    pub output: PathBuf,
    /// Write the target's place in every frame to this file.
    #[arg(long, value_name = "TRUTH.csv")]
    pub truth: PathBuf,
    /// Write masks of the target into this folder: one PNG a frame, white on black.
    #[arg(long, value_name = "DIR")]
    pub masks: Option<PathBuf>,
    /// Size of the picture; the field of view stays the same. Default: the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_world_size)]
    pub size: Option<PictureSize>,
    /// Widest vector instructions of the renderer: scalar, sse2, avx2 or avx512. The pictures are the same
    /// with each.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
}
