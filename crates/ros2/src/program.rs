//! The tasks of the program, on one thread.

use std::future::pending;
use std::time::{Duration, SystemTime};

use anyhow::{Context as _, Result};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep};

use crate::calls;
use crate::cli::Cli;
use crate::console::backoff::Backoff;
use crate::console::line::Line;
use crate::console::socket::{self, TokenRefused};
use crate::convert::diagnostics::{ConsoleState, diagnostics};
use crate::convert::fixes;
use crate::convert::frames::Frames;
use crate::feed::Feed;
use crate::messages::Time;
use crate::node::{RosNode, serve};
use crate::notice::say;
use crate::settings::Settings;
use crate::stops::{self, Stops};

/// How often the program looks whether somebody subscribes to the pictures.
const LOOK_INTERVAL: Duration = Duration::from_millis(250);
/// Looks between two diagnostics: they come once a second.
const LOOKS_PER_DIAGNOSTICS: u32 = 4;

/// Runs until a signal ends the program.
///
/// # Errors
/// If a setting is not usable, DDS cannot be set up, or the console refuses the token.
pub fn run(cli: &Cli) -> Result<()> {
    let settings = Settings::read(cli)?;
    let line = Line::new(&settings)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(async {
        let (node, spinner) = RosNode::open(&settings, cli.domain, cli.rmw.service_mapping())?;
        let frames = Frames { node: settings.node.relative() };
        let (pictures, wants_pictures) = watch::channel(false);
        let away = ConsoleState::Away { reason: "not connected yet".to_owned() };
        let (state, states) = watch::channel(away);
        let stops = Stops::default();
        tokio::select! {
            ended = follow(&line, &stops, wants_pictures, &state, (&node, &frames)) => ended,
            spun = spinner.spin() => spun.context("DDS has ended"),
            () = stops::repeat(&line, &stops) => Ok(()),
            () = serve(&node.stop, || {
                let number = stops.press();
                calls::stop(&line, &stops, number)
            }) => Ok(()),
            () = serve(&node.engage, || calls::engage(&line, &stops)) => Ok(()),
            () = tick(&node, &frames, &pictures, &states) => Ok(()),
            signalled = signal_to_end() => signalled,
        }
    })
}

/// Stays connected to the console. Says once when the console goes, and once when it is back.
///
/// # Errors
/// If the console refuses the token.
async fn follow(
    line: &Line,
    stops: &Stops,
    wants_pictures: watch::Receiver<bool>,
    state: &watch::Sender<ConsoleState>,
    (node, frames): (&RosNode, &Frames),
) -> Result<()> {
    let mut backoff = Backoff::default();
    let mut is_said = false;
    loop {
        let mut feed = Feed::new(&node.topics, frames, state, wall_ns);
        let mut is_open = false;
        let mut on_event = |event| {
            if !is_open {
                is_open = true;
                say(&format!("connected to the console at {}", line.url()));
            }
            feed.on_event(event);
        };
        let ended = socket::serve(line, stops, wants_pictures.clone(), wall_ms, &mut on_event).await;
        let Err(error) = ended else { return Ok(()) };
        if error.is::<TokenRefused>() {
            return Err(error);
        }
        if is_open || !is_said {
            say(&format!("no console at {}: {error:#}; connecting until there is one", line.url()));
            is_said = true;
        }
        if is_open {
            backoff.succeeded();
        }
        state.send_replace(ConsoleState::Away { reason: format!("{error:#}") });
        sleep(backoff.pause()).await;
    }
}

/// What comes at fixed intervals: diagnostics, marks, and a look at the subscribers to the pictures.
async fn tick(
    node: &RosNode,
    frames: &Frames,
    pictures: &watch::Sender<bool>,
    states: &watch::Receiver<ConsoleState>,
) {
    let mut looks = interval(LOOK_INTERVAL);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    for look in 0_u32.. {
        looks.tick().await;
        let wanted = node.wants_pictures();
        pictures.send_if_modified(|is_wanted| std::mem::replace(is_wanted, wanted) != wanted);
        if look % LOOKS_PER_DIAGNOSTICS == 0 {
            let (state, now) = (states.borrow().clone(), Time::from_nanos(wall_ns()));
            node.topics.diagnostics.publish(diagnostics(&frames.node, &state, now));
            if let ConsoleState::Known { snapshot, .. } = &state {
                fixes::marks(snapshot, now, frames)
                    .into_iter()
                    .for_each(|fix| node.topics.marks.publish(fix));
            }
        }
    }
    pending().await
}

async fn signal_to_end() -> Result<()> {
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    tokio::select! {
        _ = interrupt.recv() => {}
        _ = terminate.recv() => {}
    }
    Ok(())
}

/// The time of the wall, nanoseconds since 1970.
fn wall_ns() -> i128 {
    match SystemTime::now().duration_since(SystemTime::UNIX_EPOCH) {
        Ok(since) => since.as_nanos() as i128,
        Err(before) => -(before.duration().as_nanos() as i128),
    }
}

fn wall_ms() -> f64 {
    wall_ns() as f64 / 1e6
}
