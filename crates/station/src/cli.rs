//! The command line: every command, its options, and an example of each.
//!
//! Values are checked while they are parsed; what is wrong with one is said in clap's words and ends with exit
//! code 2. What a command does lives in `commands`.

use std::path::PathBuf;

use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{PictureSize, PixelBox};
use clap::{Args, Parser, Subcommand, ValueEnum};

pub use crate::tracker::TrackerName;

/// Keeps an unmanned surface vehicle in a small tethered UAV's view, moving the camera as little as possible.
#[derive(Debug, Parser)]
#[command(name = "barrelman", version, max_term_width = 100)]
pub struct Cli {
    /// What to do; without a command: demo.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// How much is logged on stderr.
    #[arg(long, global = true, value_enum, default_value_t = LogLevel::Info)]
    pub log_level: LogLevel,
    /// How log lines look.
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
}

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
    /// The loop on a practice clip that the program draws itself, against an emulated ground station.
    Demo(DemoArgs),
    /// Track in live video and move the vehicle's camera.
    Run(RunArgs),
    /// The tracker alone on a recording.
    Track(TrackArgs),
    /// Recorded positions through a camera law.
    Law(LawArgs),
    /// Metrics per trial and over all of them.
    Metrics(MetricsArgs),
    /// A recording through the pilot again.
    Replay(ReplayArgs),
    /// A recording as CSV files and an MP4.
    Export(ExportArgs),
    /// A ground station to test against.
    Emulate(EmulateArgs),
    /// Tells what is reachable, what is missing, and how to mend it.
    Check(CheckArgs),
    /// The configuration, documented.
    Config(ConfigArgs),
}

/// `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman demo --output demo-output")]
pub struct DemoArgs {
    /// Where the clip, the annotated video and the recording go.
    #[arg(long, default_value = "demo-output")]
    pub output: PathBuf,
    /// The tracker.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub tracker: TrackerName,
    /// Draw the practice clip and its truth, and run nothing.
    #[arg(long)]
    pub draw_only: bool,
    /// Overwrite what an earlier demo wrote.
    #[arg(long)]
    pub force: bool,
}

impl Default for DemoArgs {
    fn default() -> Self {
        Self {
            output: PathBuf::from("demo-output"),
            tracker: TrackerName::default(),
            draw_only: false,
            force: true,
        }
    }
}

/// `run`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  barrelman run --video rtsp://192.168.2.100/live --link serial:/dev/ttyACM0?baud=115200 --record sortie.mcap
  barrelman run --video file:clip.mp4 --select 600,300,80,60 --engage --link tcp://127.0.0.1:5000
  barrelman run barrelman.toml --engage

It starts disengaged. On a terminal: e engages, space stops, q quits.")]
pub struct RunArgs {
    /// Configuration file (TOML); options of the command line go before it.
    pub config: Option<PathBuf>,
    /// Where the video comes from: rtsp://..., file:clip.mp4, a folder of pictures.
    #[arg(long, value_name = "URL")]
    pub video: Option<String>,
    /// Where the commands go: serial:/dev/ttyACM0?baud=115200 or tcp://host:port. Without it: a dry run.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// The vehicle.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Follow what is in this box of the first picture: left, top, width, height in pixels.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = parse_box)]
    pub select: Option<PixelBox>,
    /// The tracker; without it the configuration's, which is fused unless something else is said.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// Move the camera from the start.
    #[arg(long)]
    pub engage: bool,
    /// No console in the browser: the only way this build has, and so the default.
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
    /// pilot, recorder, overlay, terminal, status.
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
    /// Print figures as JSON; the track then needs --output.
    #[arg(long, requires = "output")]
    pub json: bool,
    /// Overwrite output files that exist.
    #[arg(long)]
    pub force: bool,
}

/// The camera laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LawName {
    /// The paper's motor schema.
    Schema,
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
#[command(after_help = "Example:\n  barrelman law arena1_01.csv --law schema --output commands.csv")]
pub struct LawArgs {
    /// The log: the laboratory's CSV, an exported one, or a recording.
    pub log: PathBuf,
    /// The law.
    #[arg(long, value_enum, default_value_t = LawName::Schema)]
    pub law: LawName,
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
    /// The logs: the laboratory's CSV, exported ones, or recordings.
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
  barrelman run --video file:clip.mp4 --select 600,300,80,60 --engage --link serial:/tmp/fotokite")]
#[group(required = true, multiple = true)]
pub struct EmulateFotokiteProArgs {
    /// Make a pseudo-terminal and link it here.
    #[arg(long, value_name = "PATH")]
    pub pty: Option<PathBuf>,
    /// Listen for the pass-through server's TCP connections here.
    #[arg(long, value_name = "ADDR", conflicts_with = "pty")]
    pub listen: Option<String>,
    /// Log every line and state here, one JSON object per line.
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,
    /// Go wrong on purpose: KIND@SECONDS[+DURATION], several with commas.
    #[arg(long, value_name = "SPEC")]
    pub fault: Option<String>,
    /// A rate ends by itself this long after the last command for its axis, in seconds.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = parse_positive)]
    pub rate_timeout: Option<f64>,
    /// Do not echo what the shell is sent.
    #[arg(long)]
    pub no_echo: bool,
    /// Overwrite a log that exists.
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
    /// Look at this link.
    #[arg(long, value_name = "URL")]
    pub link: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `config`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  barrelman config example > barrelman.toml")]
pub struct ConfigArgs {
    /// What to print.
    #[command(subcommand)]
    pub what: ConfigWhat,
}

/// What `config` prints.
#[derive(Debug, Subcommand)]
pub enum ConfigWhat {
    /// An example with every key, its unit, range and default.
    Example,
    /// The JSON schema, for editors.
    Schema,
    /// The full effective configuration.
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

fn parse_rate(text: &str) -> Result<f64, String> {
    let [rate] = numbers(text, '\0', "a rate in rad/s, as in 0.3")?;
    if rate > 0.0 && rate <= 3.0 {
        Ok(rate)
    } else {
        Err("a rate lies above 0 and is at most 3 rad/s".to_owned())
    }
}
