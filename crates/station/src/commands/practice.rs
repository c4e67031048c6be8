//! `barrelman demo --clip`: the live loop with the real protocol, without a camera.
//!
//! The command renders a practice clip, starts an emulated ground station on a pseudo-terminal, and runs the
//! live loop between the two: the same video thread, pilot, link and recorder as with a vehicle. The camera
//! of the clip does not move, so commands show in the emulator's log and the annotated video, not in the
//! picture itself.

use std::io::{BufWriter, Write, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};
use barrelman_emulators::emulated_port::EmulatedPort;
use barrelman_emulators::emulation_loop::Emulator;
use barrelman_emulators::fotokite_pro::{FotokitePro, GroundStationSettings};
use barrelman_emulators::log::StationLog;
use barrelman_sim::practice::{FRAMES_PER_SECOND, PracticeClip};
use barrelman_vocab::{Picture, PictureSize, PixelBox, Timestamp};
use indicatif::ProgressBar;

use super::run;
use crate::cli::{ConnectionOptions, ConsoleOptions, DemoArgs, RunArgs};
use crate::live::session::Outputs;
use barrelman_experiments::law_choice::LawChoice;
use barrelman_host::clock::Clock;
use barrelman_host::fault::FaultPlan;
use barrelman_host::output::OutputFile;
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::writer::Mp4Writer;

/// The picture size of the practice clip: that of the UAV's video.
const SIZE: PictureSize = PictureSize::new(1280, 720);
/// Seed of the practice clip's water.
const SEED: u64 = 1;

/// Runs the command.
///
/// # Errors
/// If the folder cannot be written or the loop cannot start.
pub fn run(args: &DemoArgs, clock: Clock) -> Result<ExitCode> {
    let folder = &args.output;
    let files = ["practice.mp4", "truth.csv", "seen.mp4", "recording.mcap", "station.jsonl"]
        .map(|name| folder.join(name));
    let [clip, truth, film, recording, station_log] = &files;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("the folder {} cannot be created", folder.display()))?;
    let open = |path: &Path| OutputFile::open(path, args.force);
    let (clip_file, truth_file) = (open(clip)?, open(truth)?);
    let outputs =
        Outputs { overlay: Some(open(film)?), record: Some(open(recording)?), ..Outputs::default() };
    let mut log_file = open(station_log)?;
    let practice = PracticeClip::new(SIZE, SEED);
    let mut out = stdout();
    writeln!(out, "rendering a practice clip: a red boat crosses all four sectors of the picture ...")?;
    write_clip(&practice, clip_file)?;
    write_truth(&practice, truth_file)?;
    if args.draw_only {
        writeln!(out, "{}: the clip\n{}: its truth", clip.display(), truth.display())?;
        return Ok(ExitCode::SUCCESS);
    }

    let port = folder.join("fotokite");
    log_file.begin()?;
    let log = StationLog::new(Some(log_file), clock);
    let settings = GroundStationSettings::default();
    let vehicle = FotokitePro::new(settings, clock.now());
    let mut emulator =
        Emulator::new(EmulatedPort::pty(&port, args.force)?, vehicle, log, FaultPlan::default(), clock);
    writeln!(out, "an emulated Fotokite Pro answers at {}", emulator.url())?;
    let ended = Arc::new(AtomicBool::new(false));
    let end = Arc::clone(&ended);
    let station = std::thread::Builder::new()
        .name("emulator".to_owned())
        .spawn(move || emulator.run(|| end.load(Ordering::Relaxed)))?;

    writeln!(
        out,
        "running for {} s: space stops the camera, d disengages it, e engages it again, q quits",
        practice.frames() / FRAMES_PER_SECOND
    )?;
    out.flush()?;
    let code = run::run_with_outputs(
        &run_args(args, [clip, &port, recording, film], practice.truth(0).selection)?,
        |_, _| Ok(outputs),
        clock,
    );
    ended.store(true, Ordering::Relaxed);
    match station.join() {
        Ok(result) => result.context("the emulated ground station failed")?,
        Err(_) => tracing::error!("the emulated ground station panicked"),
    }
    let code = code?;
    list_files(&mut out, [film, station_log, recording])?;
    Ok(code)
}

/// Says what is in the files, and what to do with them.
fn list_files(out: &mut impl Write, [film, station_log, recording]: [&PathBuf; 3]) -> Result<()> {
    writeln!(
        out,
        "\n{}: the annotated video\n{}: every command that the ground station received\n{}: the recording; try\n  barrelman replay {} --compare\n  barrelman metrics {}",
        film.display(),
        station_log.display(),
        recording.display(),
        recording.display(),
        recording.display(),
    )?;
    Ok(())
}

/// The arguments of the run between clip and ground station.
fn run_args(
    args: &DemoArgs,
    [clip, port, recording, film]: [&PathBuf; 4],
    selection: PixelBox,
) -> Result<RunArgs> {
    Ok(RunArgs {
        connection: ConnectionOptions {
            video: vec![format!("file:{}", clip.display())],
            link: Some(format!("serial:{}", port.display())),
            ..ConnectionOptions::default()
        },
        guard: None,
        // The emulated ground station ends with this process.
        without_guard: true,
        profile: None,
        mavlink: None,
        vessel: None,
        vessel_profile: None,
        guidance: None,
        select: Some(selection),
        tracker: Some(args.tracker),
        law: args.law.resolve(LawChoice::MOTOR_SCHEMA)?.into(),
        engage: true,
        hands_on: false,
        console: ConsoleOptions::default(),
        links_file: None,
        headless: true,
        foxglove: None,
        tak: None,
        share: None,
        detector: None,
        no_record: false,
        record: Some(recording.clone()),
        overlay: Some(film.clone()),
        force: args.force,
        fault: Vec::new(),
        faults: None,
    })
}

/// Encodes the practice clip.
fn write_clip(practice: &PracticeClip, file: OutputFile) -> Result<()> {
    let fps = f64::from(FRAMES_PER_SECOND);
    let path = file.path().to_owned();
    let mut writer = Mp4Writer::new(file, &path, EncoderSettings::for_pictures(practice.size(), fps));
    let mut picture = Picture::black(practice.size(), practice.colour());
    let progress = ProgressBar::new(u64::from(practice.frames()));
    for frame in 0..practice.frames() {
        progress.inc(1);
        practice.render(frame, &mut picture);
        writer.write_picture(&picture, Timestamp::from_secs_f64(f64::from(frame) / fps))?;
    }
    progress.finish_and_clear();
    Ok(writer.finish()?)
}

/// Writes the boat's place in every frame, in the format of `truth.csv`. The clip has no scale, so the range
/// is empty.
fn write_truth(practice: &PracticeClip, file: OutputFile) -> Result<()> {
    let mut file = BufWriter::new(file);
    writeln!(file, "frame,time_s,x,y,w,h,cx,cy,visible,heading_deg,range_m")?;
    for frame in 0..practice.frames() {
        let truth = practice.truth(frame);
        let (bounds, centre) = (truth.bounds, truth.centre.in_pixels(practice.size()));
        writeln!(
            file,
            "{frame},{:.6},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},1,{:.3},",
            f64::from(frame) / f64::from(FRAMES_PER_SECOND),
            bounds.u,
            bounds.v,
            bounds.w,
            bounds.h,
            centre.u,
            centre.v,
            truth.heading.degrees().rem_euclid(360.0),
        )?;
    }
    Ok(file.flush()?)
}
