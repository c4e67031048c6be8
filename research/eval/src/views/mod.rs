//! Renders sample views, for judging the renderer by eye: the same boat on lakes and on the sea, from the
//! heights and angles at which it will be followed, and the laboratory's floor.
//!
//! Each view is simulated for 20 s, so that the boat has a wake, and written as a PNG file. Nothing is
//! judged; the printed line of each view holds the rendering time and the truth of the target.

mod catalogue;
mod options;
mod scene;
mod sequence;
mod setting;

pub(crate) use options::Options;
pub(crate) use sequence::render_sequence;

use std::fs::File;
use std::io::BufWriter;
use std::time::Instant;

use anyhow::{Context, Result};
use barrelman_sim::render::Serial;
use barrelman_video::png_file;
use barrelman_vocab::{Picture, PictureSize};

use crate::output::print_line;
use catalogue::{View, views};
use scene::END_TICK;
use setting::{Setting, WAKE_STEP_TICKS};

/// Renders the chosen views.
///
/// # Errors
/// If the folder or a file cannot be written.
pub(crate) fn render(options: &Options) -> Result<()> {
    std::fs::create_dir_all(&options.output).with_context(|| options.output.display().to_string())?;
    for view in views().iter().filter(|view| view.name.contains(&options.only)) {
        render_view(view, options)?;
    }
    Ok(())
}

fn render_view(view: &View, options: &Options) -> Result<()> {
    let size = PictureSize::new(options.width, options.width * 9 / 16 / 2 * 2);
    let Setting { sea, mut renderer } = Setting::new(view, size)?;
    let mut picture = Picture::black(size, barrelman_sim::render::ENCODING);
    for tick in (0..END_TICK).step_by(WAKE_STEP_TICKS) {
        renderer.advance_wake(&scene::snapshot(view, &sea, tick));
    }
    let last = scene::snapshot(view, &sea, END_TICK);
    // The first picture allocates; the second is timed.
    renderer.render(&last, &mut picture, &Serial);
    let started = Instant::now();
    let truth = renderer.render(&last, &mut picture, &Serial);
    let elapsed = started.elapsed();
    let path = options.output.join(format!("{}.png", view.name));
    let write = || png_file::write(BufWriter::new(File::create(&path)?), &picture);
    write().with_context(|| path.display().to_string())?;
    print_line(&format!(
        "{:22} {:5.1} ms, target {:5} pixels, {:3.0} % visible, heading {}, range {:.1} m",
        view.name,
        1e3 * elapsed.as_secs_f64(),
        truth.mask.count(),
        100.0 * truth.visible_share,
        truth.heading.map_or("none".into(), |heading| format!("{:.0}", heading.degrees())),
        truth.range_m,
    ));
    Ok(())
}
