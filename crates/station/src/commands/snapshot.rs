//! `barrelman snapshot`: writes one frame of a video as PNG, with a grid of pixel coordinates to read a
//! selection from.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use anyhow::{Context, Result};
use barrelman_host::output::OutputFile;
use barrelman_overlay::grid;
use barrelman_video::{VideoUrl, png_file};

use super::stored_frame::stored_frame;
use crate::cli::SnapshotArgs;

/// Runs the command.
///
/// # Errors
/// If the video has no such frame, or the picture cannot be written.
pub fn run(args: &SnapshotArgs) -> Result<ExitCode> {
    let url = VideoUrl::parse(&args.video)?;
    let file = OutputFile::open(&args.output, args.force)?;
    let frame = stored_frame(&url, args.frame)?;
    let mut picture = (*frame.picture).clone();
    let spacing = grid::draw(&mut picture);
    png_file::write(file, &picture)
        .with_context(|| format!("{} cannot be written", args.output.display()))?;
    writeln!(
        stdout(),
        "{}: frame {} of {url}, {} pixels, a labelled line every {spacing} pixels.\n\
         Read left, top, width and height of the whole boat: --select X,Y,W,H{}",
        args.output.display(),
        args.frame,
        picture.size(),
        if args.frame > 0 { format!(" --start-frame {}", args.frame) } else { String::new() },
    )?;
    Ok(ExitCode::SUCCESS)
}
