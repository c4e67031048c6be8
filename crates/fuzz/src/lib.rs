//! What the fuzz targets do with the bytes that they are given. The targets themselves, for libFuzzer, are in
//! the folder `fuzz`; the files of its corpus are run by this crate's test.
#![forbid(unsafe_code)]

pub mod tracker;

pub mod gimbal;
pub mod guard_messages;
pub mod onvif;
pub mod sigma;
pub mod tracking_camera;
pub mod vehicle;

pub mod rtp;
pub mod video;

pub mod logs;
pub mod recording;

pub mod texts;

mod memory_file;

/// What a target does with any bytes.
pub type Target = fn(&[u8]);

/// Every target, by its name.
pub const TARGETS: [(&str, Target); 19] = [
    ("tracker", tracker::session),
    ("session", vehicle::session),
    ("ground_station", vehicle::ground_station),
    ("mavlink", gimbal::mavlink),
    ("sigma", sigma::sigma),
    ("onvif", onvif::onvif),
    ("tracking_camera", tracking_camera::tracking_camera),
    ("guard_messages", guard_messages::decode),
    ("recording", recording::read),
    ("h264", video::h264),
    ("rtp", rtp::receive),
    ("mp4", video::mp4),
    ("y4m", video::y4m),
    ("logs", logs::parse),
    ("configuration", texts::configuration),
    ("scenario", texts::scenario),
    ("drive", texts::drive),
    ("console", texts::console),
    ("urls", texts::urls),
];

/// Runs a target on any bytes.
///
/// # Panics
/// If the target does, which is a finding, and if there is no target of this name.
pub fn run(name: &str, bytes: &[u8]) {
    let (_, target) = TARGETS
        .into_iter()
        .find(|(known, _)| *known == name)
        .expect("every program of the folder fuzz names a target");
    target(bytes);
}
