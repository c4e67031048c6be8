//! The command line: every command, its options, and an example of each.
//!
//! Values are checked while they are parsed; what is wrong with one is said in clap's words and ends with exit
//! code 2. What a command does lives in `commands`.

mod law_options;

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use barrelman_simd::SimdLevel;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{PictureSize, PixelBox};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};

use barrelman_experiments::campaign::PlantName;
use barrelman_experiments::tracker_choice::TrackerName;
pub use law_options::LawOptions;

/// Keeps an unmanned surface vehicle in a small tethered UAV's view, moving the camera as little as possible.
#[derive(Debug, Parser)]
#[command(
    name = "barrelman",
    version,
    max_term_width = 100,
    after_help = "Examples:
  barrelman
  barrelman check --video rtsp://192.168.2.100/live
  barrelman run --video sim:arena1 --link sim: --engage

Without a command it does what demo does."
)]
pub struct Cli {
    /// What to do; without a command: demo.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// How much is logged on stderr.
    #[arg(long, global = true, value_enum, default_value_t = LogLevel::Info, help_heading = "Logging")]
    pub log_level: LogLevel,
    /// How log lines look.
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, help_heading = "Logging")]
    pub log_format: LogFormat,
}

/// Options that make no sense together, or one that is missing: exit code 2, as for what clap refuses.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WrongUse(pub String);

/// How much is logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogLevel {
    /// Failures only.
    Error,
    /// What an operator should look into.
    Warn,
    /// What happens, once each.
    Info,
    /// What developers look at.
    Debug,
    /// Everything.
    Trace,
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Lines for people.
    Text,
    /// One JSON object per line.
    Json,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Drive a simulated boat in the browser, while the camera follows it.
    Demo(DemoArgs),
    /// Track the boat in live video and move the vehicle's camera.
    Run(RunArgs),
    /// Run the tracker alone on a recording.
    Track(TrackArgs),
    /// Put recorded positions through a camera law.
    Law(LawArgs),
    /// Measure trials: sensitivity, excursions, movement, energy.
    Metrics(MetricsArgs),
    /// Make an HTML page of trials, with figures.
    Report(ReportArgs),
    /// Run simulated trials, one for each seed.
    Trials(TrialsArgs),
    /// Join the shards of a campaign of trials.
    Merge(MergeArgs),
    /// Compare two campaigns of trials, paired by seed.
    Compare(CompareArgs),
    /// List the scenarios that can be simulated, or print one scenario's file, documented.
    Scenarios(ScenariosArgs),
    /// Draw a clip of a scenario, with its exact truth.
    Render(RenderArgs),
    /// Run a recording through the pilot again.
    Replay(ReplayArgs),
    /// Turn a recording into CSV files and an MP4.
    Export(ExportArgs),
    /// Emulate a ground station to test against.
    Emulate(EmulateArgs),
    /// Say what is reachable, what is missing, and how to mend it.
    Check(CheckArgs),
    /// Print the configuration, documented.
    Config(ConfigArgs),
}

/// `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman demo
  barrelman demo arena1 --store drive.jsonl
  barrelman demo --replay drive.jsonl
  barrelman demo --clip --output demo-output

The page takes keys: arrows steer the boat, p pauses, space stops the camera, e engages it, h leaves the boat to
the scenario's helmsman again. A terminal takes keys, too: e engages, space and d stop the camera, q quits. --clip is the loop on a practice clip that the program draws, against an emulated
ground station.")]
pub struct DemoArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file; without it: open.
    pub scenario: Option<String>,
    /// Where the page is served; without it: 127.0.0.1:8480, or the next port that is free.
    #[arg(long, value_name = "ADDR")]
    pub listen: Option<SocketAddr>,
    /// Size of the picture; the view stays the same. Without it the scenario's, at most 960 wide.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// Everything that is left to chance comes from this.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// End after so many seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_seconds)]
    pub seconds: Option<f64>,
    /// Record everything here; the pilot then sees the pictures as they are recorded, in H.264.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Store the drive here: the scenario, and each input with its tick.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with = "replay")]
    pub store: Option<PathBuf>,
    /// Drive a stored drive again, without a page and as fast as it goes; exit 1 unless it
    /// is the same, bit for bit.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "listen", "size", "seed", "seconds", "law", "mode", "horizon"])]
    pub replay: Option<PathBuf>,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t, conflicts_with = "replay")]
    pub tracker: TrackerName,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// The loop on a practice clip instead, against an emulated ground station.
    #[arg(long, conflicts_with_all = ["scenario", "listen", "size", "seed", "seconds", "record", "store", "replay"])]
    pub clip: bool,
    /// With --clip: where the clip, the annotated video and the recording go.
    #[arg(long, default_value = "demo-output", requires = "clip")]
    pub output: PathBuf,
    /// With --clip: draw the practice clip and its truth, and run nothing.
    #[arg(long, requires = "clip")]
    pub draw_only: bool,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

impl Default for DemoArgs {
    fn default() -> Self {
        Self {
            scenario: None,
            listen: None,
            size: None,
            seed: 1,
            seconds: None,
            record: None,
            store: None,
            replay: None,
            tracker: TrackerName::default(),
            law: LawOptions::default(),
            clip: false,
            output: PathBuf::from("demo-output"),
            draw_only: false,
            force: false,
        }
    }
}

/// `run`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman run --video rtsp://192.168.2.100/live --link serial:/dev/ttyACM0 --select 600,300,80,60 --record sortie.mcap
  barrelman run --video file:clip.mp4 --select 600,300,80,60 --engage --link tcp://127.0.0.1:5000
  barrelman run --video sim:arena1 --link sim: --engage
  barrelman run barrelman.toml --select 600,300,80,60

It starts disengaged. On a terminal: e engages, d disengages, space stops, q quits.")]
pub struct RunArgs {
    /// Configuration file (TOML). Options on the command line override it.
    pub config: Option<PathBuf>,
    /// Where the video comes from: rtsp://..., file:clip.mp4, a folder of pictures, or a simulated world
    /// (sim:SCENARIO?seed=1&size=WxH).
    #[arg(long, value_name = "URL")]
    pub video: Option<String>,
    /// File whose first line is user:password of the camera at rtsp://..., so that neither stands on the command line.
    #[arg(long, value_name = "FILE")]
    pub video_login_file: Option<PathBuf>,
    /// Where the commands go: serial:/dev/ttyACM0?baud=115200, tcp://host:port, or sim: to the simulated world's
    /// camera. Without it: a dry run.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// The vehicle's profile; without it the configuration's, or fotokite-pro, the only one in this build.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Follow what is in this box of the first picture: left, top, width, height in pixels. Nothing is followed
    /// without it, but in a simulated world, which says by itself where its boat is.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = parse_box)]
    pub select: Option<PixelBox>,
    /// The tracker; without it the configuration's, which is fused unless something else is said.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Move the camera from the start.
    #[arg(long)]
    pub engage: bool,
    /// Accepted for scripts: `run` has no page in the browser in this build.
    #[arg(long)]
    pub headless: bool,
    /// Record everything here.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Write the annotated video here.
    #[arg(long, value_name = "OUT.mp4")]
    pub overlay: Option<PathBuf>,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
    /// Break a thread on purpose, to test that everything stops: THREAD:panic@SECONDS or
    /// THREAD:stall@SECONDS+DURATION, with THREAD one of
    /// pilot, recorder, overlay, terminal, status. The times count from the program's start.
    #[arg(long, hide = true, value_name = "THREAD:FAULT")]
    pub fault: Vec<String>,
}

/// `track`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  barrelman track clip.mp4 --select 600,300,80,60 --output track.csv --overlay seen.mp4"
)]
pub struct TrackArgs {
    /// The recording: an MP4 or MOV with H.264, a Y4M, or a folder of pictures.
    pub video: String,
    /// Follow what is in this box of the start frame: left, top, width, height in pixels.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = parse_box)]
    pub select: PixelBox,
    /// Frame that the selection is made on, from 0.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub start_frame: u64,
    /// Where the track goes; without it: stdout.
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub tracker: TrackerName,
    /// Write the annotated video here.
    #[arg(long, value_name = "OUT.mp4")]
    pub overlay: Option<PathBuf>,
    /// Draw what each answer rests on into the annotated video.
    #[arg(long)]
    pub explain: bool,
    /// Print figures as JSON; the track is then written with --output alone.
    #[arg(long)]
    pub json: bool,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

/// How P is to be computed.
#[derive(Debug, Args)]
pub struct RegionArgs {
    /// The frame that the region is a share of; without it the log's own.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub frame_size: Option<PictureSize>,
    /// Semi-axes of the region as shares of half the frame's width and height; without it the vehicle's.
    #[arg(long, value_name = "A,B", value_parser = parse_region)]
    pub region: Option<RegionShares>,
}

/// `law`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman law arena1_01.csv --law schema --output commands.csv\n  barrelman law arena1_01.csv --law optimal --mode eco --output commands.csv"
)]
pub struct LawArgs {
    /// The log: the laboratory's CSV, an exported one, or a recording.
    pub log: PathBuf,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Rate of the schema on both axes, rad/s; without it the vehicle's.
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true, value_parser = parse_rate)]
    pub rate: Option<f64>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// The vehicle whose signs the rates are in.
    #[arg(long, value_name = "NAME", default_value = "fotokite-pro")]
    pub profile: String,
    /// Where the rows go; without it: stdout.
    #[arg(long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
    /// Overwrite an output file that exists.
    #[arg(long)]
    pub force: bool,
}

/// `metrics`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman metrics arena1_*.csv arena2_*.csv")]
pub struct MetricsArgs {
    /// The logs: the laboratory's CSV, exported ones, recordings, or files of campaigns.
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The arena, where the files' names do not say.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub arena: Option<u8>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// The picture within the frame, for the time at its border; without it the log's own.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub picture: Option<PictureSize>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

impl RegionArgs {
    /// A campaign's file holds figures of its own region: another one cannot be had from it.
    ///
    /// # Errors
    /// If another one was asked for.
    pub fn refuse_for_campaign(&self, path: &Path, picture: bool) -> Result<()> {
        if self.region.is_some() || self.frame_size.is_some() || picture {
            bail!(
                "{} holds the metrics of a campaign, whose region and picture are fixed: leave --region, --frame-size \
                 and --picture away, or give the recordings of its trials",
                path.display()
            );
        }
        Ok(())
    }
}

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman report arena1_*.csv arena2_*.csv --output report.html
  barrelman trials lab1 --perception truth --trials 5 --record recordings
  barrelman report arena1_*.csv recordings/*.mcap --output report.html --svg figures")]
pub struct ReportArgs {
    /// The logs: the laboratory's CSV, exported ones, recordings, or files of campaigns (their metrics alone).
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The page.
    #[arg(long, value_name = "REPORT.html")]
    pub output: PathBuf,
    /// Write each figure here as SVG, too.
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// The arena, where the files do not say.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub arena: Option<u8>,
    /// The region.
    #[command(flatten)]
    pub region: RegionArgs,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

/// `render`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman render arena1 --seed 7 --seconds 20 --output clip.mp4 --truth truth.csv --masks masks")]
pub struct RenderArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file.
    pub scenario: String,
    /// Seed of everything random.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Length of the clip; it ends before, where the scenario does.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_clip_length)]
    pub seconds: f64,
    /// The clip.
    #[arg(long, value_name = "CLIP.mp4")]
    pub output: PathBuf,
    /// Where the target is in every frame.
    #[arg(long, value_name = "TRUTH.csv")]
    pub truth: PathBuf,
    /// Write which pixels show the target here: one PNG for each frame, white on black.
    #[arg(long, value_name = "DIR")]
    pub masks: Option<PathBuf>,
    /// Size of the picture; the view stays the same. Without it the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// The widest vector instructions that pictures are drawn with: scalar, sse2, avx2 or avx512. The pictures are the
    /// same with all.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

/// `trials`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman trials lab1 --perception truth --trials 200 --seed 10000 --output lab1.jsonl
  barrelman trials arena1 --trials 20 --record recordings
  barrelman trials lab1 --perception truth --trials 1000 --shard 3/10 --output shard-3.jsonl
  barrelman trials --drive drive.jsonl --law optimal --record recordings

Nothing is written without --output or --record.")]
pub struct TrialsArgs {
    /// The scenario: one of `barrelman scenarios`, or the path of your own .toml file.
    #[arg(required_unless_present = "drive")]
    pub scenario: Option<String>,
    /// One trial in which the boat is steered as in this drive, which `demo --store` wrote: its scenario, its seed, the
    /// size of its pictures, its tracker and its camera law, where no other is asked for.
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["scenario", "trials", "seed", "shard", "boat_speed"])]
    pub drive: Option<PathBuf>,
    /// How many trials.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Seed of the first trial; each further one has the next.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Rate of the schema on both axes, rad/s; without it the vehicle's. The simulated vehicle is able to turn so fast.
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true, value_parser = parse_rate)]
    pub rate: Option<f64>,
    /// Where localisations come from.
    #[arg(long, value_enum, default_value_t)]
    pub perception: PerceptionName,
    /// The tracker, in pixels; without it `fused`.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// How the kite moves by itself: a setting of the scenario (of `lab1` still, indoor or windy, of `arena1` calm or
    /// tether); without it the scenario's own.
    #[arg(long, value_name = "NAME")]
    pub setting: Option<String>,
    /// The plant: as the scenario has it, or drawn for each trial from the scenario's intervals.
    #[arg(long, value_enum, default_value_t)]
    pub plant: PlantName,
    /// The target's speed; without it the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub boat_speed: Option<f64>,
    /// Sea state, 0 (glassy) to 4 (moderate); without it the scenario's.
    #[arg(long, value_name = "0..4", allow_negative_numbers = true, value_parser = parse_sea_state)]
    pub sea_state: Option<u8>,
    /// Mean wind; without it the scenario's.
    #[arg(long, value_name = "M_PER_S", allow_negative_numbers = true, value_parser = parse_not_negative)]
    pub wind: Option<f64>,
    /// Size of the picture; the view stays the same. Without it the scenario's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<PictureSize>,
    /// Trials at the same time; without it as many as there are cores. The results are the same for any number.
    #[arg(long, value_name = "N", value_parser = parse_count)]
    pub threads: Option<usize>,
    /// Only every Nth trial, from the Ith on: one of N parts that `merge` joins.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// The widest vector instructions that pictures are drawn with: scalar, sse2, avx2 or avx512. The results are the
    /// same with all.
    #[arg(long, value_name = "LEVEL", default_value_t = SimdLevel::Avx512)]
    pub simd: SimdLevel,
    /// Record every trial here: SCENARIO-SEED.mcap, and in pixels the annotated video SCENARIO-SEED.mp4.
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Go on with the file that --output names: trials that are in it are not run again.
    #[arg(long)]
    pub resume: bool,
    /// Where results go, one trial per line (JSON).
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an output file that exists.
    #[arg(long, conflicts_with = "resume")]
    pub force: bool,
}

/// Where localisations of simulated trials come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PerceptionName {
    /// Pictures are drawn, and the tracker looks at them.
    #[default]
    Pixels,
    /// The truth, with noise.
    Truth,
}

/// One of several parts of a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

/// `merge`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman merge shard-*.jsonl --output campaign.jsonl")]
pub struct MergeArgs {
    /// The files of the shards.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Where the whole goes.
    #[arg(long, value_name = "FILE.jsonl")]
    pub output: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Overwrite an output file that exists.
    #[arg(long)]
    pub force: bool,
}

/// `compare`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman trials lab1 --perception truth --trials 200 --law schema --output schema.jsonl
  barrelman trials lab1 --perception truth --trials 200 --law centre --output centre.jsonl
  barrelman compare schema.jsonl centre.jsonl")]
pub struct CompareArgs {
    /// A campaign's file.
    pub first: PathBuf,
    /// Another's, on the same scenario and seeds.
    pub second: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `scenarios`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman scenarios\n  barrelman scenarios lab1 > mine.toml\n  barrelman scenarios mine.toml"
)]
pub struct ScenariosArgs {
    /// The scenario to print, or the path of your own .toml file to check.
    pub name: Option<String>,
}

/// `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman replay sortie.mcap --compare")]
pub struct ReplayArgs {
    /// The recording.
    pub recording: PathBuf,
    /// Replay with this configuration instead of the recorded one.
    #[arg(long, value_name = "CHANGED.toml")]
    pub config: Option<PathBuf>,
    /// Compare every command with the recorded one; exit 1 if any differs.
    #[arg(long)]
    pub compare: bool,
}

/// `export`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman export sortie.mcap --output sortie")]
pub struct ExportArgs {
    /// The recording.
    pub recording: PathBuf,
    /// The folder that the files go to.
    #[arg(long, value_name = "DIR")]
    pub output: PathBuf,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

/// `emulate`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman emulate fotokite-pro --pty /tmp/fotokite")]
pub struct EmulateArgs {
    /// What to emulate.
    #[command(subcommand)]
    pub station: StationName,
}

/// The ground stations that can be emulated.
#[derive(Debug, Subcommand)]
pub enum StationName {
    /// The Fotokite Pro's serial ground station.
    FotokitePro(EmulateFotokiteProArgs),
}

/// `emulate fotokite-pro`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  barrelman emulate fotokite-pro --pty /tmp/fotokite --log station.jsonl
and in another terminal
  barrelman run --video file:clip.mp4 --select 600,300,80,60 --engage --link serial:/tmp/fotokite
With --world sim:arena1 it moves that world's camera and serves its video:
  barrelman run --video rtsp://127.0.0.1:8554/world --select 555,296,80,42 --engage --link serial:/tmp/fotokite")]
#[group(skip)]
#[command(group = ArgGroup::new("port").required(true).args(["pty", "listen"]))]
pub struct EmulateFotokiteProArgs {
    /// Make a pseudo-terminal and link it here. A link that a killed emulator left is replaced.
    #[arg(long, value_name = "PATH")]
    pub pty: Option<PathBuf>,
    /// Listen for the pass-through server's TCP connections here.
    #[arg(long, value_name = "ADDR", conflicts_with = "pty")]
    pub listen: Option<String>,
    /// Move the camera of this simulated world, and serve its video: sim:SCENARIO?seed=1&size=WxH. The world begins
    /// when somebody looks.
    #[arg(long, value_name = "SIM")]
    pub world: Option<String>,
    /// Where the world's video is served (RTSP, path /world).
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8554")]
    pub video_listen: SocketAddr,
    /// Log every line and state here, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Go wrong on purpose: KIND@SECONDS[+DURATION], several with commas, KIND being stall, drop, delay, duplicate,
    /// corrupt, disconnect or reboot. The times count from the program's start.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// A rate ends by itself this long after the last command for its axis, in seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub rate_timeout: Option<f64>,
    /// Do not echo what the shell is sent.
    #[arg(long)]
    pub no_echo: bool,
    /// Overwrite a log that exists, and replace a symbolic link at the path of --pty.
    #[arg(long)]
    pub force: bool,
}

/// `check`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman check barrelman.toml")]
pub struct CheckArgs {
    /// Configuration file (TOML).
    pub config: Option<PathBuf>,
    /// Look at this video source.
    #[arg(long, value_name = "URL")]
    pub video: Option<String>,
    /// File whose first line is user:password of the camera at rtsp://...
    #[arg(long, value_name = "FILE")]
    pub video_login_file: Option<PathBuf>,
    /// Look at this link.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `config`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  barrelman config example > barrelman.toml\n  barrelman config print barrelman.toml"
)]
pub struct ConfigArgs {
    /// What to print.
    #[command(subcommand)]
    pub what: ConfigWhat,
}

/// What `config` prints.
#[derive(Debug, Subcommand)]
pub enum ConfigWhat {
    /// An example with every key, its unit, range and default.
    #[command(after_help = "Example:\n  barrelman config example > barrelman.toml")]
    Example,
    /// The JSON schema, for editors.
    #[command(after_help = "Example:\n  barrelman config schema > barrelman.schema.json")]
    Schema,
    /// The full effective configuration.
    #[command(after_help = "Example:\n  barrelman config print barrelman.toml")]
    Print {
        /// Configuration file (TOML); without it the defaults.
        config: Option<PathBuf>,
    },
}

fn numbers<const N: usize>(text: &str, separator: char, form: &str) -> Result<[f64; N], String> {
    let wrong = || format!("expected {form}");
    let mut parts = text.split(separator);
    let mut values = [0.0; N];
    for value in &mut values {
        let part = parts.next().ok_or_else(wrong)?;
        *value = part.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(wrong)?;
    }
    if parts.next().is_some() { Err(wrong()) } else { Ok(values) }
}

fn parse_box(text: &str) -> Result<PixelBox, String> {
    let [u, v, w, h] = numbers(text, ',', "X,Y,W,H in pixels, as in 600,300,80,60")?;
    if w <= 0.0 || h <= 0.0 {
        return Err(format!("the box is {w} wide and {h} high: give it a width and a height above zero"));
    }
    Ok(PixelBox { u, v, w, h })
}

fn parse_size(text: &str) -> Result<PictureSize, String> {
    let [width, height] = numbers(text, 'x', "WIDTHxHEIGHT, as in 640x480")?;
    let side = |value: f64| (1.0..=65_536.0).contains(&value) && value.fract() == 0.0;
    if side(width) && side(height) {
        Ok(PictureSize::new(width as u32, height as u32))
    } else {
        Err("width and height are whole numbers from 1 to 65536".to_owned())
    }
}

fn parse_region(text: &str) -> Result<RegionShares, String> {
    let [half_width, half_height] = numbers(text, ',', "A,B, as in 0.6,0.5")?;
    let share = |value: f64| value > 0.0 && value <= 1.0;
    if share(half_width) && share(half_height) {
        Ok(RegionShares { half_width, half_height })
    } else {
        Err("both shares lie above 0 and are at most 1".to_owned())
    }
}

fn parse_positive(text: &str) -> Result<f64, String> {
    let [value] = numbers(text, '\0', "a number")?;
    if value > 0.0 { Ok(value) } else { Err("must be above zero".to_owned()) }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = parse_positive(text)?;
    if seconds <= 1.0e6 { Ok(seconds) } else { Err("at most a million seconds".to_owned()) }
}

fn parse_clip_length(text: &str) -> Result<f64, String> {
    let seconds = parse_positive(text)?;
    if seconds <= 3600.0 { Ok(seconds) } else { Err("a clip is at most 3600 s long".to_owned()) }
}

fn parse_not_negative(text: &str) -> Result<f64, String> {
    let [value] = numbers(text, '\0', "a number")?;
    if value >= 0.0 { Ok(value) } else { Err("must not be negative".to_owned()) }
}

fn parse_sea_state(text: &str) -> Result<u8, String> {
    text.parse()
        .ok()
        .filter(|state| *state <= 4)
        .ok_or_else(|| "a sea state is a whole number from 0 (glassy) to 4 (moderate)".to_owned())
}

fn parse_count(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|count| (1..=1024).contains(count))
        .ok_or_else(|| "a whole number from 1 to 1024".to_owned())
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    let wrong = || "I/N with I from 1 to N, as in 3/10".to_owned();
    let (index, count) = text.split_once('/').ok_or_else(wrong)?;
    let (index, count) = (index.parse().map_err(|_| wrong())?, count.parse().map_err(|_| wrong())?);
    if (1..=count).contains(&index) { Ok(Shard { index, count }) } else { Err(wrong()) }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    let [rate] = numbers(text, '\0', "a rate in rad/s, as in 0.3")?;
    if rate > 0.0 && rate <= 3.0 {
        Ok(rate)
    } else {
        Err("a rate lies above 0 and is at most 3 rad/s".to_owned())
    }
}
