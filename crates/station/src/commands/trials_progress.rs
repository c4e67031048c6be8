//! The progress of a campaign: trials done, speed, and the time left.
//!
//! A trial in pixels takes a minute or so, and its result comes at its end. The progress counts the simulated
//! time of the running trials, too, and says from it how fast the machine simulates and how long the rest
//! takes.

use std::io::IsTerminal as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use barrelman_experiments::campaign::simulated_time::SimulatedTime;
use indicatif::{ProgressBar, ProgressStyle};

/// Shortest time from one log line to the next.
const LINE_INTERVAL: Duration = Duration::from_secs(10);
/// How often the state is looked at.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// A shorter time left is not told: it is an estimate.
const NEARLY_DONE_S: f64 = 5.0;

/// What is known of a campaign under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    /// Trials done in this run, and trials to do in this run.
    done: u64,
    wanted: u64,
    /// Length of the trials done, and the longest that a trial can last, simulated seconds.
    done_s: f64,
    max_trial_s: f64,
    /// Time that all trials have simulated, finished and running ones, s.
    simulated_s: f64,
    /// Time since the campaign's start, s.
    elapsed_s: f64,
}

impl State {
    /// Simulated seconds per second.
    fn speed(&self) -> Option<f64> {
        (self.elapsed_s > 1.0 && self.simulated_s > 0.0).then(|| self.simulated_s / self.elapsed_s)
    }

    /// The time left in words: an upper bound before the first trial is done.
    fn left(&self) -> Option<String> {
        let (trial_s, word) = if self.done > 0 {
            (self.done_s / self.done as f64, "about")
        } else {
            (self.max_trial_s, "at most")
        };
        let left_s = (self.wanted as f64 * trial_s - self.simulated_s) / self.speed()?;
        // The running trials may be longer than those before.
        if left_s < NEARLY_DONE_S {
            return Some("nearly done".to_owned());
        }
        Some(format!("{word} {} left", duration_in_words(left_s)))
    }

    /// Speed and time left: `3.1 times real time, about 4 min left`.
    fn pace(&self) -> String {
        let speed = self.speed().map(|speed| format!("{speed:.1} times real time"));
        [speed, self.left()].into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

fn duration_in_words(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// What the thread of the progress and the campaign share.
#[derive(Debug)]
struct Shared {
    done: AtomicU64,
    done_ms: AtomicU64,
    is_ending: AtomicBool,
}

/// The progress of a campaign, shown by a thread of its own.
#[derive(Debug)]
pub(super) struct TrialsProgress {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The campaign whose progress is shown.
#[derive(Debug, Clone)]
pub(super) struct Campaign {
    /// Trials that a file held before.
    pub(super) done_before: u64,
    /// All trials of the campaign.
    pub(super) trials: u64,
    /// The longest that a trial can last, s.
    pub(super) max_trial_s: f64,
    /// The simulated time so far.
    pub(super) simulated: SimulatedTime,
    /// Whether a signal has asked to end.
    pub(super) stop: Arc<AtomicBool>,
}

impl TrialsProgress {
    /// Begins to show the progress of a campaign.
    pub(super) fn start(campaign: Campaign) -> Self {
        let shared = Arc::new(Shared {
            done: AtomicU64::new(0),
            done_ms: AtomicU64::new(0),
            is_ending: AtomicBool::new(false),
        });
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("progress".to_owned());
        // Without a thread there is no progress to see, but the campaign runs.
        let thread = thread.spawn(move || show(&campaign, &of_thread)).ok();
        Self { shared, thread }
    }

    /// Adds a trial that is done, and its length.
    pub(super) fn add(&self, duration_s: f64) {
        self.shared.done_ms.fetch_add((duration_s * 1e3) as u64, Ordering::Relaxed);
        self.shared.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Removes the bar at the end of the campaign.
    pub(super) fn finish(mut self) {
        self.shared.is_ending.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn show(campaign: &Campaign, shared: &Shared) {
    let started = Instant::now();
    let bar = std::io::stderr().is_terminal().then(|| {
        let bar = ProgressBar::new(campaign.trials);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} trials  {msg}") {
            bar.set_style(style);
        }
        bar
    });
    let mut line_at = started + LINE_INTERVAL;
    let mut is_stop_told = false;
    while !shared.is_ending.load(Ordering::Relaxed) {
        std::thread::sleep(POLL_INTERVAL);
        if campaign.stop.load(Ordering::Relaxed) && !std::mem::replace(&mut is_stop_told, true) {
            tracing::warn!(
                "ending after the trials that are running; a second Ctrl-C ends at once, without them"
            );
        }
        let state = State {
            done: shared.done.load(Ordering::Relaxed),
            wanted: campaign.trials - campaign.done_before,
            done_s: shared.done_ms.load(Ordering::Relaxed) as f64 / 1e3,
            max_trial_s: campaign.max_trial_s,
            simulated_s: campaign.simulated.total().as_secs_f64(),
            elapsed_s: started.elapsed().as_secs_f64(),
        };
        let done = campaign.done_before + state.done;
        match &bar {
            Some(bar) => {
                bar.set_position(done);
                bar.set_message(state.pace());
            }
            None if Instant::now() >= line_at => {
                line_at = Instant::now() + LINE_INTERVAL;
                tracing::info!("{done} of {} trials; {}", campaign.trials, state.pace());
            }
            None => {}
        }
    }
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_the_speed() {
        let start =
            State { done: 0, wanted: 20, done_s: 0.0, max_trial_s: 300.0, simulated_s: 0.0, elapsed_s: 0.5 };
        for (state, expected) in [
            (start, ""),
            (
                State { simulated_s: 30.0, elapsed_s: 10.0, ..start },
                "3.0 times real time, at most 33 min left",
            ),
            (
                State { done: 5, done_s: 350.0, simulated_s: 400.0, elapsed_s: 200.0, ..start },
                "2.0 times real time, about 8 min left",
            ),
            (
                State { done: 20, done_s: 1400.0, simulated_s: 1400.0, elapsed_s: 350.0, ..start },
                "4.0 times real time, nearly done",
            ),
        ] {
            assert_eq!(state.pace(), expected, "{state:?}");
        }
        assert_eq!(duration_in_words(7200.0), "2.0 h");
    }
}
