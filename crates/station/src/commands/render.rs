//! `barrelman render`: a clip of a scenario with its exact truth.
//!
//! The world is that of a trial in truth: the schema keeps the boat in view, so the camera moves as it does in a trial.
//! What is drawn is the picture; the frame that a letter-boxed one lies in is left away, so that the truth is in pixels
//! of what is seen.

use std::io::{BufWriter, Write as _, stdout};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use barrelman_pilot::{Input, Outcome};
use barrelman_sim::render::{RenderedTruth, Serial};
use barrelman_sim::scenario::CameraSetup;
use barrelman_sim::{Truth, World};
use barrelman_simd::Simd;
use barrelman_trial::campaign::{FrameSource as _, RenderedCamera, StepObserver};
use barrelman_vocab::{PictureSize, Timestamp, VehicleRates};

use crate::cli::RenderArgs;
use crate::progress::Progress;
use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::campaign::plan::CampaignRequest;
use barrelman_experiments::campaign::{CampaignPlan, Perception};
use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::scenario::ScenarioOverrides;
use barrelman_host::output::{self, OutputFile};
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::writer::Mp4Writer;

/// The header of a truth file.
pub const TRUTH_HEADER: &str = "frame,time_s,x,y,w,h,cx,cy,visible,heading_deg,range_m";

/// Runs the command.
///
/// # Errors
/// If the scenario cannot be used or an output not be written.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let plan = CampaignPlan::new(&CampaignRequest {
        scenario: args.scenario.clone(),
        overrides: ScenarioOverrides { size: args.size, ..ScenarioOverrides::default() },
        law: LawChoice::MOTOR_SCHEMA,
        rate: None,
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: args.simd,
    })?
    .with_max_duration(args.seconds);
    let mut film = TruthFilm::create(args, &plan.scenario().camera)?;
    plan.simulate(args.seed, &mut film)?;
    let (frames, asked) = film.finish()?;
    if frames < asked {
        tracing::warn!(
            "the scenario ends after {frames} of {asked} frames: the clip is shorter than asked for"
        );
    }
    writeln!(stdout(), "{}: {frames} frames\n{}: their truth", args.output.display(), args.truth.display())?;
    Ok(ExitCode::SUCCESS)
}

/// A clip that is being written, with its truth.
struct TruthFilm {
    camera: CameraSetup,
    seed: u64,
    simd: Simd,
    /// Made with the first picture: it needs the world.
    rendered: Option<RenderedCamera<'static>>,
    video: Mp4Writer<OutputFile>,
    truth: BufWriter<OutputFile>,
    truth_path: PathBuf,
    masks: Option<(PathBuf, bool)>,
    frames: u64,
    asked: u64,
    progress: Progress,
    /// The first thing that went wrong; nothing is drawn after it.
    failed: Option<anyhow::Error>,
}

impl TruthFilm {
    fn create(args: &RenderArgs, camera: &CameraSetup) -> Result<Self> {
        let video = OutputFile::open(&args.output, args.force)?;
        let truth = output::create(&args.truth, args.force)?;
        if let Some(folder) = &args.masks {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("the folder {} cannot be made", folder.display()))?;
        }
        let picture = camera.optics.picture;
        let fps = f64::from(camera.pictures_per_second);
        let mut film = Self {
            camera: CameraSetup { frame: picture, ..camera.clone() },
            seed: args.seed,
            simd: Simd::at_most(args.simd),
            rendered: None,
            video: Mp4Writer::new(video, &args.output, EncoderSettings::for_pictures(picture, fps)),
            truth: BufWriter::new(truth),
            truth_path: args.truth.clone(),
            masks: args.masks.clone().map(|folder| (folder, args.force)),
            frames: 0,
            asked: (args.seconds * fps).ceil() as u64,
            progress: Progress::new("frames", (args.seconds * fps).ceil() as u64),
            failed: None,
        };
        film.write_line(TRUTH_HEADER)?;
        Ok(film)
    }

    fn write_line(&mut self, line: &str) -> Result<()> {
        writeln!(self.truth, "{line}")
            .with_context(|| format!("{} cannot be written", self.truth_path.display()))
    }

    /// Draws the world as it is now.
    fn add(&mut self, world: &World) -> Result<()> {
        let rendered = self.rendered.get_or_insert_with(|| {
            RenderedCamera::new(world, self.camera.clone(), self.seed, self.simd, &Serial)
        });
        let view = rendered.capture(world);
        let truth = rendered.truth().clone();
        self.video.write_picture(&view.frame.picture, view.frame.capture.at)?;
        if let Some((folder, force)) = &self.masks {
            let path = folder.join(format!("{:06}.png", self.frames));
            let file = output::create(&path, *force)?;
            write_mask(file, &truth, self.camera.frame)
                .with_context(|| format!("{} cannot be written", path.display()))?;
        }
        self.write_line(&truth_row(self.frames, view.frame.capture.at, &truth))?;
        self.frames += 1;
        self.progress.at(self.frames);
        Ok(())
    }

    /// Ends all files. Returns how many frames there are, and how many were asked for.
    fn finish(mut self) -> Result<(u64, u64)> {
        self.progress.finish();
        if let Some(error) = self.failed {
            return Err(error);
        }
        self.truth.flush().with_context(|| format!("{} cannot be written", self.truth_path.display()))?;
        self.video.finish()?;
        Ok((self.frames, self.asked))
    }
}

impl StepObserver for TruthFilm {
    fn on_step(&mut self, _now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, _rates: VehicleRates) {}

    fn on_truth(&mut self, _truth: &Truth) {}

    fn on_world(&mut self, world: &World) {
        if self.failed.is_none() {
            self.failed = self.add(world).err();
        }
    }
}

/// A row of a truth file. A target of which no pixel is seen has visible 0 and a box of no size; where its waterline
/// would be stays known, but for one behind the camera.
pub fn truth_row(frame: u64, at: Timestamp, truth: &RenderedTruth) -> String {
    let (x, y, w, h) = truth.bounds.map_or((0.0, 0.0, 0.0, 0.0), |b| (b.u, b.v, b.w, b.h));
    let visible = if truth.bounds.is_some() { truth.visible_share } else { 0.0 };
    let (cx, cy) = truth
        .waterline
        .map_or_else(Default::default, |point| (format!("{:.3}", point.u), format!("{:.3}", point.v)));
    let heading = truth.heading.map_or_else(String::new, |heading| {
        // A heading of almost a whole turn must not be rounded to one.
        format!("{:.3}", (heading.degrees().rem_euclid(360.0) * 1000.0).round() % 360_000.0 / 1000.0)
    });
    format!(
        "{frame},{:.6},{x:.3},{y:.3},{w:.3},{h:.3},{cx},{cy},{visible:.4},{heading},{:.4}",
        at.as_secs_f64(),
        truth.range_m
    )
}

/// The pixels that show the target white, the others black.
fn write_mask(file: OutputFile, truth: &RenderedTruth, size: PictureSize) -> Result<()> {
    let (width, height) = (size.width as usize, size.height as usize);
    let mut encoder = png::Encoder::new(BufWriter::new(file), size.width, size.height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut samples = vec![0_u8; width * height];
    let mask = &truth.mask;
    for (index, shows) in mask.is_target.iter().enumerate() {
        if *shows && mask.width > 0 {
            let (row, column) = (mask.top + index / mask.width, mask.left + index % mask.width);
            samples[row * width + column] = 255;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&samples)?;
    writer.finish()?;
    Ok(())
}
