//! `barrelman-eval detector-scenes`: pictures to train a detector on, with the boxes of all people and boats.
//!
//! A PNG file for each picture, and `boxes.csv`: picture, class (`person` or `boat`), x, y, w, h in pixels. A
//! picture without a row shows neither.

use std::fmt::Write as _;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use anyhow::{Context, Result};
use barrelman_video::png_file;

use super::scene::{Kind, PICTURES_OF_SEA, render_sea};
use crate::parallel;

/// Options of `detector-scenes`.
#[derive(Debug, clap::Args)]
pub(crate) struct ScenesOptions {
    /// Folder for the pictures; created if it does not exist
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    /// Number of pictures
    #[arg(long, value_name = "COUNT", default_value_t = 4000)]
    count: u64,
    /// Seed of the scenes
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    seed: u64,
}

/// Renders the pictures, and writes them with their boxes.
///
/// # Errors
/// If the folder or a file cannot be written.
pub(crate) fn write_scenes(options: &ScenesOptions) -> Result<()> {
    let folder = &options.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let seas: Vec<u64> = (0..options.count.div_ceil(PICTURES_OF_SEA)).collect();
    let rows = parallel::map(&seas, |sea| {
        let mut rows = String::new();
        render_sea(options.seed, *sea, |number, picture, labelled| {
            if number >= options.count {
                return Ok(());
            }
            let path = folder.join(format!("{number:06}.png"));
            let write = || png_file::write(BufWriter::new(File::create(&path)?), picture);
            write().with_context(|| path.display().to_string())?;
            for object in labelled {
                let class = if object.kind == Kind::Person { "person" } else { "boat" };
                let bounds = object.bounds;
                let _ =
                    writeln!(rows, "{number:06},{class},{},{},{},{}", bounds.u, bounds.v, bounds.w, bounds.h);
            }
            Ok(())
        })?;
        Ok(rows)
    });
    let rows = rows.into_iter().collect::<Result<Vec<String>>>()?.concat();
    let path = folder.join("boxes.csv");
    std::fs::write(&path, format!("picture,class,x,y,w,h\n{rows}"))
        .with_context(|| path.display().to_string())
}
