//! `barrelman demo`: a simulated boat to drive in the browser, and the camera that follows it.
//!
//! World and pilot go in lock step, one tick after the other, as in a trial; the clock says when the next tick is due.
//! That is why a drive that was stored runs again bit for bit.

use std::io::{Write as _, stdout};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use barrelman_pilot::{Input, Mode, Outcome};
use barrelman_sim::Truth;
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_trial::behaviour::VersionDifference;
use barrelman_trial::campaign::StepObserver;
use barrelman_vocab::{EncodedUnit, OperatorRequest, PictureSize, Timestamp, Track, VehicleRates};

use super::practice;
use crate::cli::DemoArgs;
use crate::config::{ConfigFile, Configuration};
use crate::demo::pacing::Pacing;
use crate::demo::page::{DriveStatus, PageState};
use crate::demo::page_pictures::{self, AnnotatedFrame};
use crate::demo::server::PageServer;
use crate::live::event::{Event, QuitCause};
use crate::live::terminal::Terminal;
use crate::live::threads::{self, FaultInjector};
use crate::progress::Progress;
use barrelman_experiments::campaign::recording::TrialRecorder;
use barrelman_experiments::drive::motor_schema_shadow::MotorSchemaShadow;
use barrelman_experiments::drive::{Drive, DriveInput, DriveSetup, DriveWriter, StoredDrive};
use barrelman_experiments::drive::{DriveHasher, DriveObserver};
use barrelman_experiments::law_choice::{LawChoice, LawName};
use barrelman_experiments::render_threads::RenderThreads;
use barrelman_experiments::scenario::{self, ScenarioOverrides};
use barrelman_experiments::tracker_choice::TrackerSettings;
use barrelman_experiments::world_url::WorldUrl;
use barrelman_host::clock::Clock;
use barrelman_host::latest::Latest;
use barrelman_host::output::OutputFile;

/// Where the page is served unless something else is asked for: the first of these ports that is free.
const PORTS: std::ops::Range<u16> = 8480..8490;
/// Larger pictures are made smaller, unless their size is asked for: they are drawn on the CPU.
const MAX_WIDTH: u32 = 960;
/// Helm that nobody renews goes back to neutral after this.
const HELM_TIMEOUT: Duration = Duration::from_millis(500);
/// From one look at the inputs to the next while the time stands still.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
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
    let open =
        |path: &Option<PathBuf>| path.as_deref().map(|path| OutputFile::open(path, args.force)).transpose();
    let (record, store) = (open(&args.record)?, open(&args.store)?);
    match &args.replay {
        Some(path) => replay(record, path),
        None => drive(args, record, store, clock),
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
fn drive(
    args: &DemoArgs,
    mut record: Option<OutputFile>,
    mut store: Option<OutputFile>,
    clock: Clock,
) -> Result<ExitCode> {
    let mut url = WorldUrl {
        scenario: args.scenario.clone().unwrap_or_else(|| "open".to_owned()),
        seed: args.seed,
        size: args.size,
    };
    url.size = Some(size_of(&url)?);
    let mut setup =
        DriveSetup::new(url, args.tracker, args.law.over(LawChoice::OPTIMAL)?, args.record.is_some())?;
    let threads = RenderThreads::new()?;
    let listener = listen(args.listen)?;

    let (events, queue) = sync_channel(EVENTS);
    let terminal = Terminal::watch(events.clone(), clock, FaultInjector::default())?;
    let (page, inputs) = PageState::new();
    let (page, frames) = (Arc::new(page), Arc::new(Latest::default()));
    let renderer = {
        let (frames, page) = (Arc::clone(&frames), Arc::clone(&page));
        let render = move || page_pictures::render_page_pictures(&frames, &page);
        threads::spawn("page-pictures", events.clone(), render)?
    };
    let server = PageServer::start(listener, Arc::clone(&page), events.clone())?;
    drop(events);
    let mut out = stdout();
    let address = server.address();
    // A script waits for this line.
    writeln!(out, "the boat of {} is yours at http://{address}/", setup.url.scenario)?;
    writeln!(out, "arrow keys steer, p pauses, space stops the camera, e engages it; Ctrl-C ends")?;
    out.flush()?;
    if !address.ip().is_loopback() {
        tracing::warn!("everybody who can reach {address} can steer this simulated boat");
    }

    let until = args.seconds.map(|seconds| clock.now().plus(Duration::from_secs_f64(seconds)));
    let end = loop {
        let mut live = LiveDrive {
            drive: Drive::new(&setup, &threads)?,
            observers: DriveObservers {
                recorder: recorder(record.take(), &setup)?,
                frames: Some(&frames),
                shadow: (setup.law.name != LawName::MotorSchema)
                    .then(|| MotorSchemaShadow::new(&setup.profile)),
                ..DriveObservers::default()
            },
            store: store.take().map(|file| DriveWriter::begin(file, &setup)).transpose()?,
            page: &page,
            setup: &setup,
            clock,
            helm: None,
            paused: false,
        };
        let end = live.run(&queue, &inputs, until)?;
        live.finish(matches!(end, End::Over))?;
        if !matches!(end, End::Over) || args.record.is_some() || args.store.is_some() {
            break end;
        }
        setup.url.seed = setup.url.seed.wrapping_add(1);
        tracing::info!("the drive is over: the next one begins, with seed {}", setup.url.seed);
    };
    frames.close();
    let _ = renderer.join();
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
    let own = scenario::load(&url.scenario, &ScenarioOverrides::default())?.scenario.camera.optics.picture;
    let height = (own.height * MAX_WIDTH / own.width.max(1)) & !1;
    Ok(if own.width > MAX_WIDTH { PictureSize::new(MAX_WIDTH, height) } else { own })
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

fn recorder(file: Option<OutputFile>, setup: &DriveSetup) -> Result<Option<TrialRecorder>> {
    let begin = |file| {
        let behaviour = setup.law.behaviour_with(setup.tracker);
        TrialRecorder::without_film(file, configuration_of(setup)?, setup.url.to_string(), behaviour)
    };
    file.map(begin).transpose()
}

/// The effective configuration (TOML) of a drive.
fn configuration_of(setup: &DriveSetup) -> Result<String> {
    Configuration {
        profile: setup.profile.clone(),
        law: setup.law,
        tracker: TrackerSettings::new(setup.tracker),
        ..Configuration::resolve(&ConfigFile::default())?
    }
    .to_toml()
}

/// A stored drive again, as fast as it goes.
fn replay(record: Option<OutputFile>, path: &Path) -> Result<ExitCode> {
    let stored = StoredDrive::read(path)?;
    let last = stored.last_tick();
    let StoredDrive { setup, behaviour, inputs, end } = stored;
    let current = setup.law.behaviour_with(setup.tracker);
    let difference = behaviour.difference(current, setup.tracker.as_str(), setup.law.name_str());
    if record.is_some() && !setup.encoded {
        bail!(
            "{} was driven without --record, by pictures that were not coded: a recording of it would be of another drive",
            path.display()
        );
    }
    let threads = RenderThreads::new()?;
    let mut drive = Drive::new(&setup, &threads)?;
    let mut observers = DriveObservers { recorder: recorder(record, &setup)?, ..DriveObservers::default() };
    let progress = Progress::new("ticks", last);
    let mut inputs = inputs.into_iter().peekable();
    loop {
        let tick = drive.world().tick();
        while let Some((_, input)) = inputs.next_if(|(at, _)| *at <= tick) {
            drive.apply(input, &mut observers);
        }
        if tick >= last || drive.is_over() {
            break;
        }
        if tick.is_multiple_of(u64::from(TICKS_PER_SECOND)) {
            progress.at(tick);
        }
        drive.tick(&mut observers);
    }
    progress.finish();
    let hash = observers.hash.hex();
    if let Some(recorder) = observers.recorder {
        recorder.finish()?;
    }
    let mut out = stdout();
    writeln!(out, "{last} ticks of {}, seed {}: {hash}", setup.url.scenario, setup.url.seed)?;
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
            match difference {
                Some(VersionDifference { first, second }) => tracing::error!(
                    "the drive was driven with {first}, this program has {second}: that it differs ({then} then) is no fault"
                ),
                None => tracing::error!("the drive differs: it was {then}"),
            }
            Ok(ExitCode::FAILURE)
        }
    }
}

/// Everybody who is told what happens.
#[derive(Default)]
struct DriveObservers<'a> {
    hash: DriveHasher,
    recorder: Option<TrialRecorder>,
    /// The slot of the page's pictures.
    frames: Option<&'a Latest<AnnotatedFrame>>,
    /// What the schema would have done, where another law servoes.
    shadow: Option<MotorSchemaShadow>,
    last: Option<(Outcome, VehicleRates)>,
    in_picture: Option<bool>,
}

impl StepObserver for DriveObservers<'_> {
    fn on_step(&mut self, now: Timestamp, input: &Input<'_>, outcome: &Outcome, rates: VehicleRates) {
        self.hash.on_step(now, input, outcome, rates);
        if let Some(recorder) = &mut self.recorder {
            recorder.on_step(now, input, outcome, rates);
        }
        if let (Some(frames), Input::Frame(frame)) = (self.frames, input) {
            frames.put(AnnotatedFrame { frame: (*frame).clone(), outcome: outcome.clone(), rates });
        }
        if let Some(shadow) = &mut self.shadow {
            shadow.step(now, outcome);
        }
        self.last = Some((outcome.clone(), rates));
    }

    fn on_truth(&mut self, truth: &Truth) {
        self.hash.on_truth(truth);
        self.in_picture = Some(truth.in_picture);
    }
}

impl DriveObserver for DriveObservers<'_> {
    fn on_unit(&mut self, unit: EncodedUnit) {
        if let Some(recorder) = &mut self.recorder {
            recorder.add_unit(unit);
        }
    }
}

/// A drive by the clock.
struct LiveDrive<'a> {
    drive: Drive<'a>,
    observers: DriveObservers<'a>,
    store: Option<DriveWriter>,
    page: &'a PageState,
    setup: &'a DriveSetup,
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
            let due = if self.paused { now.plus(POLL_INTERVAL) } else { pacing.due(tick, now) };
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
            self.release_helm()?;
            if self.paused {
                self.tell(pacing.pace(), false);
                continue;
            }
            if was_paused {
                pacing.resume(tick, self.clock.now());
            }
            self.drive.tick(&mut self.observers);
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
    fn release_helm(&mut self) -> Result<()> {
        const NEUTRAL: DriveInput = DriveInput::Helm { thrust: 0, rudder: 0 };
        match self.helm {
            Some((helm, since)) if helm != NEUTRAL && self.clock.now().since(since) > HELM_TIMEOUT => {
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
        self.drive.apply(input, &mut self.observers);
        Ok(())
    }

    fn tell(&self, pace: f64, over: bool) {
        let world = self.drive.world();
        let (outcome, rates) = match &self.observers.last {
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
        self.page.set_status(&DriveStatus {
            scenario: self.setup.url.scenario.clone(),
            seed: self.setup.url.seed,
            tick: world.tick(),
            time_s: world.now().as_secs_f64(),
            paused: self.paused,
            pace,
            law: self.setup.law.name_str(),
            mode: outcome.map_or_else(String::new, |outcome| outcome.mode.to_string()),
            engaged: outcome.is_some_and(|outcome| matches!(outcome.mode, Mode::Servoing | Mode::Holding(_))),
            track: word,
            confidence,
            p: outcome.and_then(|outcome| outcome.percept).map(|percept| percept.p),
            schema_p: self.observers.shadow.as_ref().and_then(MotorSchemaShadow::p),
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
            in_picture: self.observers.in_picture,
            over,
        });
    }

    fn finish(self, over: bool) -> Result<()> {
        self.tell(1.0, over);
        let (tick, hash) = (self.drive.world().tick(), self.observers.hash.hex());
        if let Some(recorder) = self.observers.recorder {
            recorder.finish()?;
        }
        self.store.map_or(Ok(()), |store| store.finish(tick, hash))
    }
}
