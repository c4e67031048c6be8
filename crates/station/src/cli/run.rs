//! The arguments of `run`.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_vocab::PixelBox;
use clap::Args;

use crate::config::vessel::GuidanceName;

use super::connection_options::ConnectionOptions;
use super::console_options::ConsoleOptions;
use super::law_options::LawOptions;
use super::values::{parse_box, parse_listen, parse_mp4_path};

/// `run`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:
  barrelman run --video sim:arena1 --link sim: --hands-on
  barrelman run --video file:clip.mp4 --select 293,138,48,23
  barrelman run --video rtsp://camera.example/live \\
    --link serial:/dev/ttyACM0 --record sortie.mcap
  barrelman run barrelman.toml

The run starts disengaged: it tracks and sends zeros. The console's link is
printed; on the console the operator selects the boat, engages, and stops.
Keys on a terminal: e engages, d disengages, s searches for a lost boat, space
stops camera and boat, q quits.",
    mut_arg("law", |arg| arg.help("The camera law; default: the configuration's, or optimal"))
)]
pub struct RunArgs {
    /// Configuration, video and link.
    #[command(flatten)]
    pub connection: ConnectionOptions,
    /// The guard's program; default: barrelman-guard beside this program. A guard owns the port of a vehicle
    /// that keeps its last rate, and another one the port of a boat; it sends zeros (neutral) when this
    /// program is gone.
    #[arg(long, value_name = "FILE")]
    pub guard: Option<PathBuf>,
    /// Run without guards: if this program is killed, crashes or hangs, the camera goes on turning, and the
    /// boat goes on until its own time-out.
    #[arg(long, conflicts_with = "guard")]
    pub without_guard: bool,
    /// The vehicle's profile; default: the configuration's, or fotokite-pro; also fotokite-sigma and
    /// mavlink-gimbal.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
    /// Command the boat there: udp://host:port, tcp://host:port or serial:/dev/ttyACM0?baud=57600
    /// (ArduPilot), udp://host:port (lab-udp), or sim:, the boat of the simulated world.
    #[arg(long, value_name = "URL")]
    pub vessel: Option<String>,
    /// The boat's profile: mavlink-rover, mavlink-rover-manual, lab-udp or simulator; default: the
    /// configuration's, or simulator at sim:, else mavlink-rover.
    #[arg(long, value_name = "NAME")]
    pub vessel_profile: Option<String>,
    /// How the boat goes to a mark; default: the configuration's, or los.
    #[arg(long, value_enum, value_name = "NAME")]
    pub guidance: Option<GuidanceName>,
    /// Appear as a tracking camera to MAVLink ground stations (QGroundControl, MAVSDK) there:
    /// udp://host:port, tcp://host:port or serial:/dev/ttyACM0?baud=57600. They see the target and select;
    /// they never engage.
    #[arg(long, value_name = "URL")]
    pub mavlink: Option<String>,
    /// Show boat, camera and marks on the maps of TAK (ATAK, WinTAK, servers) there, where latitude and
    /// longitude are known: udp://host:port, also of a group as udp://239.2.3.1:6969, tcp://host:port, or
    /// tls://host:port.
    #[arg(long, value_name = "URL")]
    pub tak: Option<String>,
    /// Serve the annotated live video to other programs (FFmpeg, GStreamer) there, as RTSP with H.264:
    /// rtsp://IP:PORT/PATH, as in rtsp://0.0.0.0:8554/boat. They give the user watch and the console's watch
    /// token. Needs barrelman-media.
    #[arg(long, value_name = "URL")]
    pub share: Option<String>,
    /// Say what the numbered objects are, by this model in ONNX. detector.toml beside it says what the model
    /// takes and answers. Nothing is selected, marked or moved by it.
    #[arg(long, value_name = "FILE")]
    pub detector: Option<PathBuf>,
    /// Track what is in this box of the first picture: left, top, width, height in pixels. Without it nothing
    /// is tracked until the operator selects, except in a simulated world, where the world selects its boat.
    /// A file waits with its first picture until the box is drawn in a browser, where there is a display or
    /// --listen is given.
    #[arg(long, value_name = "X,Y,W,H", allow_hyphen_values = true, value_parser = parse_box)]
    pub select: Option<PixelBox>,
    /// Let the operator select the boat on the console: also in a simulated world, and on a file while it
    /// plays.
    #[arg(long, conflicts_with_all = ["select", "headless"])]
    pub hands_on: bool,
    /// The tracker; default: the configuration's, or fused.
    #[arg(long, value_enum, value_name = "NAME")]
    pub tracker: Option<TrackerName>,
    /// The law.
    #[command(flatten)]
    pub law: LawOptions,
    /// Engage at the start.
    #[arg(long)]
    pub engage: bool,
    /// The console.
    #[command(flatten)]
    pub console: ConsoleOptions,
    /// Write the console's links to this file while it is served, for its owner alone: `barrelman links`
    /// prints them.
    #[arg(long, value_name = "FILE")]
    pub links_file: Option<PathBuf>,
    /// No console.
    #[arg(long, conflicts_with_all = ["ConsoleOptions", "links_file"])]
    pub headless: bool,
    /// Record to this file; default: a file of its own in the folder of the configuration, or `recordings`.
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Let Foxglove or Lichtblick watch what is recorded: the address of a WebSocket server, as in
    /// 127.0.0.1:8765. Other devices connect to wss://ADDR/?token= and the console's watch token.
    #[arg(long, value_name = "ADDR", value_parser = parse_listen, conflicts_with = "no_record")]
    pub foxglove: Option<SocketAddr>,
    /// Do not record.
    #[arg(long, conflicts_with = "record")]
    pub no_record: bool,
    /// Write the annotated video to this file.
    #[arg(long, value_name = "OUT.mp4", value_parser = parse_mp4_path)]
    pub overlay: Option<PathBuf>,
    /// Overwrite existing output files.
    #[arg(long)]
    pub force: bool,
    /// Inject a fault into a thread, to test the fail-safe: THREAD:panic@SECONDS or
    /// THREAD:stall@SECONDS+DURATION or THREAD:hang@SECONDS. THREAD: pilot, recorder, overlay, terminal,
    /// status. Times count from the program's start.
    #[arg(long, hide = true, value_name = "THREAD:FAULT")]
    pub fault: Vec<String>,
    /// Inject the faults of a file, one place a line: PLACE: KIND@SECONDS[+DURATION], several with commas.
    /// PLACE: a thread, link, video, or program (suspend).
    #[arg(long, hide = true, value_name = "FILE")]
    pub faults: Option<PathBuf>,
}
