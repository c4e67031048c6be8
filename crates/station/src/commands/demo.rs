//! `barrelman demo`: a simulated boat to drive in the browser, and the camera that follows it.
//!
//! World and pilot go in lock step, one tick after the other, as in a trial; the clock says when the next tick is due.
//! That is why a drive that was stored runs again bit for bit.

use std::io::{Write as _, stdout};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use barrelman_pilot::{Input, Mode, Outcome};
use barrelman_sim::Truth;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_trial::campaign::Witness;
use barrelman_vocab::{EncodedUnit, OperatorRequest, PictureSize, Timestamp, Track, VehicleRates};

use super::practice;
use crate::campaign::recording::TrialRecorder;
use crate::cli::DemoArgs;
use crate::clock::Clock;
use crate::law_choice::{LawChoice, LawName};
use crate::live::event::{Event, QuitCause};
use crate::live::terminal::Terminal;
use crate::live::threads::{self, Saboteur};
use crate::output;
use crate::progress::Progress;
use crate::scenario::{self, Changes};
use crate::world::drive::{DriveHash, DriveWitness};
use crate::world::drive_shadow::DriveShadow;
use crate::world::pacing::Pacing;
use crate::world::page::{DriveStatus, Stage};
use crate::world::painter::{self, Easel, Seen};
use crate::world::render_threads::RenderThreads;
use crate::world::server::PageServer;
use crate::world::{Cast, Drive, DriveInput, DriveReader, DriveWriter, WorldUrl};

/// Where the page is served unless something else is asked for: the first of these ports that is free.
const PORTS: std::ops::Range<u16> = 8480..8490;
/// Larger pictures are made smaller, unless their size is asked for: they are drawn on the CPU.
const WIDEST: u32 = 960;
/// Helm that nobody renews goes back to neutral after this.
const HELM_LASTS: Duration = Duration::from_millis(500);
/// From one look at the inputs to the next while the time stands still.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Events that may wait.
const EVENTS: usize = 64;

/// Runs the command.
///
/// # Errors
/// If the scenario cannot be used, the page not be served, or an output not be written.
pub fn run(args: &DemoArgs, clock: Clock) -> Result<ExitCode> {
    if args.clip || args.draw_only {
        return practice::run(args, clock);
    }
    for path in [&args.record, &args.store].into_iter().flatten() {
        output::check_free(path, args.force)?;
    }
    match &args.replay {
        Some(path) => replay(args, path),
        None => drive(args, clock),
    }
}

/// How a drive ended.
enum End {
    Asked(QuitCause),
    TimeIsUp,
    Over,
    Failed(String),
}

/// Drives on in a world, and in further ones, until it is asked to end.
fn drive(args: &DemoArgs, clock: Clock) -> Result<ExitCode> {
    let mut url = WorldUrl {
        scenario: args.scenario.clone().unwrap_or_else(|| "open".to_owned()),
        seed: args.seed,
        size: args.size,
    };
    url.size = Some(size_of(&url)?);
    let mut cast = Cast::new(url, args.tracker, args.law.over(LawChoice::OPTIMAL)?, args.record.is_some())?;
    let threads = RenderThreads::two()?;
    let listener = listen(args.listen)?;

    let (events, queue) = sync_channel(EVENTS);
    let terminal = Terminal::watch(events.clone(), clock, Saboteur::default())?;
    let (stage, inputs) = Stage::new();
    let (stage, easel) = (Arc::new(stage), Arc::new(Easel::default()));
    let painter = {
        let (easel, stage, shares) = (Arc::clone(&easel), Arc::clone(&stage), cast.profile.region);
        threads::spawn("painter", events.clone(), move || painter::paint(&easel, &stage, shares))?
    };
    let server = PageServer::start(listener, Arc::clone(&stage), events.clone())?;
    drop(events);
    let mut out = stdout();
    let address = server.address();
    // A script waits for this line.
    writeln!(out, "the boat of {} is yours at http://{address}/", cast.url.scenario)?;
    writeln!(out, "arrow keys steer, p pauses, space stops the camera, e engages it; Ctrl-C ends")?;
    out.flush()?;
    if !address.ip().is_loopback() {
        tracing::warn!("everybody who can reach {address} can steer this simulated boat");
    }

    let until = args.seconds.map(|seconds| clock.now().plus(Duration::from_secs_f64(seconds)));
    let end = loop {
        let mut live = LiveDrive {
            drive: Drive::new(&cast, &threads)?,
            crew: Crew {
                recorder: recorder(args, &cast)?,
                easel: Some(&easel),
                shadow: (cast.law.name != LawName::Schema).then(|| DriveShadow::new(&cast.profile)),
                ..Crew::default()
            },
            store: args
                .store
                .as_deref()
                .map(|path| DriveWriter::begin(path, args.force, &cast))
                .transpose()?,
            stage: &stage,
            cast: &cast,
            clock,
            helm: None,
            paused: false,
        };
        let end = live.run(&queue, &inputs, until)?;
        live.finish(matches!(end, End::Over))?;
        if !matches!(end, End::Over) || args.record.is_some() || args.store.is_some() {
            break end;
        }
        cast.url.seed = cast.url.seed.wrapping_add(1);
        tracing::info!("the drive is over: the next one begins, with seed {}", cast.url.seed);
    };
    easel.close();
    let _ = painter.join();
    drop(server);
    drop(terminal);
    for path in args.record.iter() {
        writeln!(
            out,
            "{}: the recording; try\n  barrelman replay {} --compare",
            path.display(),
            path.display()
        )?;
    }
    for path in args.store.iter() {
        let path = path.display();
        writeln!(
            out,
            "{path}: the drive; try\n  barrelman demo --replay {path}\n  barrelman trials --drive {path} --record recordings"
        )?;
    }
    Ok(match end {
        End::Asked(cause) => {
            tracing::info!("stopped: {cause}");
            ExitCode::SUCCESS
        }
        End::TimeIsUp | End::Over => ExitCode::SUCCESS,
        End::Failed(why) => {
            tracing::error!("{why}");
            ExitCode::FAILURE
        }
    })
}

/// The size of the pictures: what is asked for, else the scenario's, made smaller where that is large.
fn size_of(url: &WorldUrl) -> Result<PictureSize> {
    if let Some(size) = url.size {
        return Ok(size);
    }
    let own = scenario::load(&url.scenario, &Changes::default())?.scenario.camera.optics.picture;
    let height = (own.height * WIDEST / own.width.max(1)) & !1;
    Ok(if own.width > WIDEST { PictureSize::new(WIDEST, height) } else { own })
}

fn listen(asked: Option<SocketAddr>) -> Result<TcpListener> {
    if let Some(address) = asked {
        return TcpListener::bind(address).with_context(|| {
            format!(
                "{address} cannot be listened on: is another program there? --listen takes another address"
            )
        });
    }
    let loopback = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    match PORTS.map(loopback).find_map(|address| TcpListener::bind(address).ok()) {
        Some(listener) => Ok(listener),
        None => {
            bail!("ports {} to {} of this machine are taken: use --listen ADDR", PORTS.start, PORTS.end - 1)
        }
    }
}

fn recorder(args: &DemoArgs, cast: &Cast) -> Result<Option<TrialRecorder>> {
    let begin = |path: &std::path::PathBuf| {
        TrialRecorder::bare(path, args.force, cast.configuration()?, cast.url.to_string())
    };
    args.record.as_ref().map(begin).transpose()
}

/// A stored drive again, as fast as it goes.
fn replay(args: &DemoArgs, path: &Path) -> Result<ExitCode> {
    let stored = DriveReader::read(path)?;
    let last = stored.last_tick();
    let DriveReader { cast, inputs, end } = stored;
    if args.record.is_some() && !cast.coded {
        bail!(
            "{} was driven without --record, by pictures that were not coded: a recording of it would be of another drive",
            path.display()
        );
    }
    let threads = RenderThreads::two()?;
    let mut drive = Drive::new(&cast, &threads)?;
    let mut crew = Crew { recorder: recorder(args, &cast)?, ..Crew::default() };
    let progress = Progress::new("ticks", last);
    let mut inputs = inputs.into_iter().peekable();
    loop {
        let tick = drive.world().tick();
        while let Some((_, input)) = inputs.next_if(|(at, _)| *at <= tick) {
            drive.put(input, &mut crew);
        }
        if tick >= last || drive.is_over() {
            break;
        }
        if tick.is_multiple_of(u64::from(TICKS_PER_SECOND)) {
            progress.at(tick);
        }
        drive.tick(&mut crew);
    }
    progress.finish();
    let hash = crew.hash.hex();
    if let Some(recorder) = crew.recorder {
        recorder.finish()?;
    }
    let mut out = stdout();
    writeln!(out, "{last} ticks of {}, seed {}: {hash}", cast.url.scenario, cast.url.seed)?;
    match end {
        None => {
            writeln!(out, "the file is cut off: everything before the cut was driven again")?;
            Ok(ExitCode::SUCCESS)
        }
        Some((_, then)) if then == hash => {
            writeln!(out, "the drive is the same, bit for bit")?;
            Ok(ExitCode::SUCCESS)
        }
        Some((_, then)) => {
            tracing::error!("the drive differs: it was {then}");
            Ok(ExitCode::FAILURE)
        }
    }
}

/// Everybody who is told what happens.
#[derive(Default)]
struct Crew<'a> {
    hash: DriveHash,
    recorder: Option<TrialRecorder>,
    easel: Option<&'a Arc<Easel>>,
    /// What the schema would have done, where another law servoes.
    shadow: Option<DriveShadow>,
    last: Option<(Outcome, VehicleRates)>,
    in_picture: Option<bool>,
}

impl Witness for Crew<'_> {
    fn step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.hash.step(now, input, outcome, rates);
        if let Some(recorder) = &mut self.recorder {
            recorder.step(now, input, outcome, rates);
        }
        if let (Some(easel), Input::Frame(frame)) = (self.easel, input) {
            easel.put(Seen { frame: (*frame).clone(), outcome: outcome.clone(), rates });
        }
        if let Some(shadow) = &mut self.shadow {
            shadow.step(now, outcome);
        }
        self.last = Some((outcome.clone(), rates));
    }

    fn truth(&mut self, truth: &Truth) {
        self.hash.truth(truth);
        self.in_picture = Some(truth.in_picture);
    }
}

impl DriveWitness for Crew<'_> {
    fn unit(&mut self, unit: EncodedUnit) {
        if let Some(recorder) = &mut self.recorder {
            recorder.unit(unit);
        }
    }
}

/// A drive by the clock.
struct LiveDrive<'a> {
    drive: Drive<'a>,
    crew: Crew<'a>,
    store: Option<DriveWriter>,
    stage: &'a Stage,
    cast: &'a Cast,
    clock: Clock,
    /// What the page steers, and since when.
    helm: Option<(DriveInput, Timestamp)>,
    paused: bool,
}

impl LiveDrive<'_> {
    fn run(
        &mut self,
        events: &Receiver<Event>,
        inputs: &Receiver<DriveInput>,
        until: Option<Timestamp>,
    ) -> Result<End> {
        self.put(DriveInput::Engage)?;
        let mut pacing = Pacing::from(0, self.clock.now());
        loop {
            let (tick, now) = (self.drive.world().tick(), self.clock.now());
            if until.is_some_and(|until| until <= now) {
                return Ok(End::TimeIsUp);
            }
            if self.drive.is_over() {
                return Ok(End::Over);
            }
            let due = if self.paused { now.plus(LOOK_EVERY) } else { pacing.due(tick, now) };
            match events.recv_timeout(due.since(now)) {
                Ok(event) => {
                    if let Some(end) = self.take(event)? {
                        return Ok(end);
                    }
                    continue;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Ok(End::Failed("every thread has gone".to_owned()));
                }
            }
            let was_paused = self.paused;
            for input in inputs.try_iter() {
                self.ask(input)?;
            }
            self.let_go()?;
            if self.paused {
                self.tell(pacing.pace(), false);
                continue;
            }
            if was_paused {
                pacing.resume(tick, self.clock.now());
            }
            self.drive.tick(&mut self.crew);
            if tick.is_multiple_of(4) {
                self.tell(pacing.pace(), false);
            }
        }
    }

    fn take(&mut self, event: Event) -> Result<Option<End>> {
        match event {
            Event::Quit(cause) => return Ok(Some(End::Asked(cause))),
            Event::ThreadPanicked { thread } => {
                return Ok(Some(End::Failed(format!("the {thread} thread panicked"))));
            }
            Event::Request(OperatorRequest::Engage) => self.put(DriveInput::Engage)?,
            Event::Request(OperatorRequest::Stop(_) | OperatorRequest::Disengage) => {
                self.put(DriveInput::Stop)?
            }
            Event::Request(OperatorRequest::Select(_))
            | Event::Frame
            | Event::Video(_)
            | Event::Link(_)
            | Event::RecordingFailed { .. } => {}
        }
        Ok(None)
    }

    /// The page asks for something. A helm that stays as it is is only renewed.
    fn ask(&mut self, input: DriveInput) -> Result<()> {
        match input {
            DriveInput::Helm { .. } => {
                let is_new = self.helm.is_none_or(|(before, _)| before != input);
                self.helm = Some((input, self.clock.now()));
                if !is_new {
                    return Ok(());
                }
            }
            DriveInput::Helmsman => self.helm = None,
            DriveInput::Pause => self.paused = true,
            DriveInput::Resume => self.paused = false,
            DriveInput::Engage | DriveInput::Stop => {}
        }
        self.put(input)
    }

    /// A helm that nobody holds any more goes back to neutral.
    fn let_go(&mut self) -> Result<()> {
        const NEUTRAL: DriveInput = DriveInput::Helm { thrust: 0, rudder: 0 };
        match self.helm {
            Some((helm, since)) if helm != NEUTRAL && self.clock.now().since(since) > HELM_LASTS => {
                self.helm = Some((NEUTRAL, since));
                self.put(NEUTRAL)
            }
            _ => Ok(()),
        }
    }

    fn put(&mut self, input: DriveInput) -> Result<()> {
        if let Some(store) = &mut self.store {
            store.add(self.drive.world().tick(), input)?;
        }
        self.drive.put(input, &mut self.crew);
        Ok(())
    }

    fn tell(&self, pace: f64, over: bool) {
        let world = self.drive.world();
        let (outcome, rates) = match &self.crew.last {
            Some((outcome, rates)) => (Some(outcome), *rates),
            None => (None, VehicleRates::REST),
        };
        let track = outcome.map_or(Track::Unseeded, |outcome| outcome.track);
        let (word, confidence) = match track {
            Track::Unseeded => ("unseeded", None),
            Track::Tracking(seen) => ("tracking", Some(seen.confidence)),
            Track::Coasting(seen) => ("coasting", Some(seen.confidence)),
            Track::Lost { confidence, .. } => ("lost", Some(confidence)),
        };
        let helm = self.drive.helm();
        let command = outcome.map(|outcome| outcome.command).unwrap_or_default();
        self.stage.tell(&DriveStatus {
            scenario: self.cast.url.scenario.clone(),
            seed: self.cast.url.seed,
            tick: world.tick(),
            time_s: world.now().as_secs_f64(),
            paused: self.paused,
            pace,
            law: self.cast.law.word(),
            mode: outcome.map_or_else(String::new, |outcome| outcome.mode.to_string()),
            engaged: outcome.is_some_and(|outcome| matches!(outcome.mode, Mode::Servoing | Mode::Holding(_))),
            track: word,
            confidence,
            p: outcome.and_then(|outcome| outcome.percept).map(|percept| percept.p),
            schema_p: self.crew.shadow.as_ref().and_then(DriveShadow::p),
            pan: command.pan.radians_per_second(),
            tilt: command.tilt.radians_per_second(),
            yaw_rate: rates.yaw.radians_per_second(),
            pitch_rate: rates.pitch.radians_per_second(),
            achieved: world.camera_rates(),
            speed_m_per_s: world.target_speed_m_per_s(),
            helm: match helm {
                _ if !world.is_steerable() => "nobody",
                Some(_) => "page",
                None => "helmsman",
            },
            thrust: helm.map_or(0.0, |helm| helm.throttle),
            rudder: helm.map_or(0.0, |helm| helm.rudder),
            in_picture: self.crew.in_picture,
            over,
        });
    }

    fn finish(self, over: bool) -> Result<()> {
        self.tell(1.0, over);
        let (tick, hash) = (self.drive.world().tick(), self.crew.hash.hex());
        if let Some(recorder) = self.crew.recorder {
            recorder.finish()?;
        }
        self.store.map_or(Ok(()), |store| store.end(tick, hash))
    }
}
