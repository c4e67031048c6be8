//! `barrelman render`: renders a clip of a scenario, with the exact truth.
//!
//! The world is that of a trial with `--perception truth`: the motor schema keeps the boat in view, so the
//! camera moves as in a trial. The clip shows the picture without the bars of a letter-boxed frame, so the
//! truth is in pixels of the clip.

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
use barrelman_trial::target_in_picture::TargetInPicture;
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
/// If the scenario cannot be used or an output cannot be written.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let plan = CampaignPlan::new(&CampaignRequest {
        scenario: args.scenario.clone(),
        overrides: ScenarioOverrides { size: args.size, ..ScenarioOverrides::default() },
        law: LawChoice::MOTOR_SCHEMA,
        rate: None,
        guidance: None,
        perception: Perception::Truth,
        plant: PlantName::Nominal,
        simd: args.simd,
    })?
    .with_max_duration(args.seconds);
    let mut clip = ClipWriter::create(args, &plan.scenario().camera)?;
    plan.simulate(args.seed, &mut clip)?;
    let (frames, requested) = clip.finish()?;
    if frames < requested {
        tracing::warn!(
            "the scenario ends after {frames} of {requested} frames: the clip is shorter than --seconds"
        );
    }
    writeln!(stdout(), "{}: {frames} frames\n{}: their truth", args.output.display(), args.truth.display())?;
    Ok(ExitCode::SUCCESS)
}

/// Renders the world at each picture and writes clip, truth and masks.
struct ClipWriter {
    camera: CameraSetup,
    seed: u64,
    simd: Simd,
    /// The renderer, created with the first picture, because it needs the world.
    renderer: Option<RenderedCamera<'static>>,
    video: Mp4Writer<OutputFile>,
    truth: BufWriter<OutputFile>,
    truth_path: PathBuf,
    /// The folder of the masks, and whether existing files are overwritten.
    masks: Option<(PathBuf, bool)>,
    frames: u64,
    requested: u64,
    progress: Progress,
    /// The first error; after it nothing is written.
    failure: Option<anyhow::Error>,
}

impl ClipWriter {
    fn create(args: &RenderArgs, camera: &CameraSetup) -> Result<Self> {
        let video = OutputFile::open(&args.output, args.force)?;
        let truth = output::create(&args.truth, args.force)?;
        if let Some(folder) = &args.masks {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("the folder {} cannot be created", folder.display()))?;
        }
        let picture = camera.optics.picture;
        let fps = f64::from(camera.pictures_per_second);
        let requested = (args.seconds * fps).ceil() as u64;
        let mut writer = Self {
            camera: CameraSetup { frame: picture, ..camera.clone() },
            seed: args.seed,
            simd: Simd::at_most(args.simd),
            renderer: None,
            video: Mp4Writer::new(video, &args.output, EncoderSettings::for_pictures(picture, fps)),
            truth: BufWriter::new(truth),
            truth_path: args.truth.clone(),
            masks: args.masks.clone().map(|folder| (folder, args.force)),
            frames: 0,
            requested,
            progress: Progress::new("frames", requested),
            failure: None,
        };
        writer.write_line(TRUTH_HEADER)?;
        Ok(writer)
    }

    fn write_line(&mut self, line: &str) -> Result<()> {
        writeln!(self.truth, "{line}")
            .with_context(|| format!("{} cannot be written", self.truth_path.display()))
    }

    /// Renders the world at the current tick and writes the picture and its truth.
    fn add(&mut self, world: &World) -> Result<()> {
        let renderer = self.renderer.get_or_insert_with(|| {
            RenderedCamera::new(world, self.camera.clone(), self.seed, self.simd, &Serial)
        });
        let view = renderer.capture(world);
        let truth = renderer.truth().clone();
        self.video.write_picture(&view.frame.picture, view.frame.capture.at)?;
        if let Some((folder, force)) = &self.masks {
            let path = folder.join(format!("{:06}.png", self.frames));
            let file = output::create(&path, *force)?;
            write_mask(file, &truth, self.camera.frame)
                .with_context(|| format!("{} cannot be written", path.display()))?;
        }
        self.write_line(&truth_row(self.frames, view.frame.capture.at, &truth))?;
        self.frames += 1;
        self.progress.set(self.frames);
        Ok(())
    }

    /// Completes all files. Returns the number of frames, and the number that was requested.
    fn finish(mut self) -> Result<(u64, u64)> {
        self.progress.finish();
        if let Some(error) = self.failure {
            return Err(error);
        }
        self.truth.flush().with_context(|| format!("{} cannot be written", self.truth_path.display()))?;
        self.video.finish()?;
        Ok((self.frames, self.requested))
    }
}

impl StepObserver for ClipWriter {
    fn on_step(&mut self, _now: Timestamp, _input: &Input<'_>, _outcome: &Outcome, _rates: VehicleRates) {}

    fn on_truth(&mut self, _truth: &Truth, _target: Option<&TargetInPicture>) {}

    fn on_world(&mut self, world: &World) {
        if self.failure.is_none() {
            self.failure = self.add(world).err();
        }
    }
}

/// A row of a truth file. A target without a visible pixel has `visible` 0 and an empty box; its waterline is
/// still given, unless the target is behind the camera.
pub fn truth_row(frame: u64, at: Timestamp, truth: &RenderedTruth) -> String {
    let (x, y, w, h) = truth.bounds.map_or((0.0, 0.0, 0.0, 0.0), |b| (b.u, b.v, b.w, b.h));
    let visible = if truth.bounds.is_some() { truth.visible_share } else { 0.0 };
    let (cx, cy) = truth
        .waterline
        .map_or_else(Default::default, |point| (format!("{:.3}", point.u), format!("{:.3}", point.v)));
    let heading = truth.heading.map_or_else(String::new, |heading| {
        // A heading just below 360 degrees must not be rounded up to 360.
        format!("{:.3}", (heading.degrees().rem_euclid(360.0) * 1000.0).round() % 360_000.0 / 1000.0)
    });
    format!(
        "{frame},{:.6},{x:.3},{y:.3},{w:.3},{h:.3},{cx},{cy},{visible:.4},{heading},{:.4}",
        at.as_secs_f64(),
        truth.range_m
    )
}

/// Writes a mask as PNG: pixels of the target white, all others black.
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
