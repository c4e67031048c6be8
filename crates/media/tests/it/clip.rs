//! Clips made by FFmpeg, their units, and their pictures as FFmpeg decodes them.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use barrelman_media_protocol::format::CodedFormat;
use gst::prelude::*;
use gstreamer as gst;
use gstreamer_app::AppSink;

/// One encoded picture.
#[derive(Debug, Clone)]
pub(crate) struct Unit {
    pub payload: Vec<u8>,
    pub pts_ns: u64,
    pub key: bool,
}

/// A folder that is removed at the end of the test.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name =
            format!("barrelman-media-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir(&path).unwrap();
        Self(path)
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Whether a test that needs FFmpeg can run. In CI it must.
pub(crate) fn has_ffmpeg() -> bool {
    let found = Command::new("ffmpeg").arg("-version").output().is_ok();
    assert!(found || std::env::var_os("CI").is_none(), "ffmpeg is not installed");
    if !found {
        eprintln!("skipped: ffmpeg is not installed (scripts/setup.sh test)");
    }
    found
}

/// FFmpeg's test picture as a clip. `input`: what follows `testsrc2=`; `encoder`: the arguments of the
/// encoder.
pub(crate) fn encode(input: &str, encoder: &str, file: &Path) {
    run(&format!("-f lavfi -i testsrc2={input} {encoder}"), file);
}

/// A clip in another container, or with other metadata.
pub(crate) fn remux(input: &Path, options: &str, file: &Path) {
    run(&format!("-i {} -c copy {options}", input.to_str().unwrap()), file);
}

/// The pictures of a clip, one after the other, in planes of this format.
pub(crate) fn pictures(file: &Path, format: &str) -> Vec<u8> {
    let folder = Folder::new();
    let raw = folder.file("raw.yuv");
    let input = file.to_str().unwrap();
    run(&format!("-i {input} -fps_mode passthrough -pix_fmt {format} -f rawvideo"), &raw);
    std::fs::read(raw).unwrap()
}

fn run(arguments: &str, output: &Path) {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-nostdin", "-y"]).args(arguments.split_whitespace()).arg(output);
    let done = command.output().unwrap();
    assert!(done.status.success(), "{command:?}: {}", String::from_utf8_lossy(&done.stderr));
}

/// The units of a clip, in the order of decoding.
pub(crate) fn units(file: &Path, format: CodedFormat) -> Vec<Unit> {
    gst::init().unwrap();
    let line = match format {
        CodedFormat::H264 => {
            "h264parse config-interval=-1 ! video/x-h264,stream-format=byte-stream,alignment=au"
        }
        CodedFormat::H265 => {
            "h265parse config-interval=-1 ! video/x-h265,stream-format=byte-stream,alignment=au"
        }
        CodedFormat::Vp9 => "vp9parse ! video/x-vp9,alignment=super-frame",
        CodedFormat::Av1 => "av1parse ! video/x-av1,stream-format=obu-stream,alignment=tu",
    };
    let file = file.to_str().unwrap();
    let text = format!("filesrc location={file} ! parsebin ! {line} ! appsink name=end sync=false");
    let pipeline = gst::parse::launch(&text).unwrap().downcast::<gst::Pipeline>().unwrap();
    let sink = pipeline.by_name("end").unwrap().downcast::<AppSink>().unwrap();
    pipeline.set_state(gst::State::Playing).unwrap();
    let mut units = Vec::new();
    while let Ok(sample) = sink.pull_sample() {
        let buffer = sample.buffer().unwrap();
        units.push(Unit {
            payload: buffer.map_readable().unwrap().to_vec(),
            pts_ns: buffer.pts().unwrap().nseconds(),
            key: !buffer.flags().contains(gst::BufferFlags::DELTA_UNIT),
        });
    }
    pipeline.set_state(gst::State::Null).unwrap();
    assert!(!units.is_empty(), "{file} has no units");
    units
}
