//! Progress of long work: a bar on a terminal, a plain line now and then elsewhere.

use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Progress of one piece of work.
#[derive(Debug)]
pub struct Progress {
    what: &'static str,
    all: u64,
    bar: Option<ProgressBar>,
    said: Mutex<Instant>,
}

/// Lines elsewhere come so far apart.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

impl Progress {
    /// Of work with so many parts.
    pub fn new(what: &'static str, all: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(all);
            let style = "{msg} {wide_bar} {pos}/{len} {eta}";
            if let Ok(style) = ProgressStyle::with_template(style) {
                bar.set_style(style);
            }
            bar.with_message(what)
        });
        Self { what, all, bar, said: Mutex::new(Instant::now()) }
    }

    /// So many parts are done.
    pub fn at(&self, done: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None => {
                let mut said = self.said.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                if said.elapsed() >= LINE_INTERVAL {
                    *said = Instant::now();
                    tracing::info!("{}: {done} of {}", self.what, self.all);
                }
            }
        }
    }

    /// All is done.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
