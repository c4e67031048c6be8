//! Video capture devices (V4L2).

use std::path::Path;
use std::sync::Arc;

use barrelman_media_protocol::failure::SourceFailure;
use barrelman_media_protocol::source::{DeviceFormat, DeviceSettings};
use gst::prelude::*;
use gstreamer as gst;

use super::failure::{permanent, temporary, unlinked};
use super::play::{Play, Times, Way};

/// A rate of pictures that differs by less than this is the one that was asked for: 29.97 is 30000/1001.
const FPS_TOLERANCE: f64 = 0.02;

/// Formats in the order of preference where none is asked for.
const PREFERRED: [DeviceFormat; 4] =
    [DeviceFormat::Mjpeg, DeviceFormat::H264, DeviceFormat::H265, DeviceFormat::Raw];

pub(super) fn open(play: &Arc<Play>, settings: &DeviceSettings) -> Result<(), SourceFailure> {
    if !settings.path.exists() {
        // A camera may be plugged in later.
        return Err(temporary("does not exist", present_devices(Path::new("/sys/class/video4linux"))));
    }
    let source = play.add("v4l2src")?;
    source.set_property("device", settings.path.to_string_lossy().as_ref());
    // The device is opened here, so that it says what it offers.
    source.set_state(gst::State::Ready).map_err(|_| {
        temporary("does not open, or is in use", "Close the other program that uses the device")
    })?;
    let pad = source.static_pad("src").ok_or_else(|| unlinked("v4l2src has no source"))?;
    let offered = pad.query_caps(None);
    let caps = PREFERRED
        .into_iter()
        .filter(|format| settings.format.is_none_or(|asked| asked == *format))
        .map(|format| asked_caps(format, settings))
        .find(|caps| offered.can_intersect(caps))
        .ok_or_else(|| not_offered(&offered))?;
    let filter = play.add("capsfilter")?;
    filter.set_property("caps", &caps);
    source.link(&filter).map_err(unlinked)?;
    let out = filter.static_pad("src").ok_or_else(|| unlinked("capsfilter has no source"))?;
    let name = format!("from {}", settings.path.display());
    let way = Way { name, times: Times::Captured };
    let name = caps.structure(0).map(|structure| structure.name().to_string()).unwrap_or_default();
    super::units::attach(play, &out, &name, &way)?;
    play.start();
    Ok(())
}

/// The caps that ask for a format with the size and the rate of the settings.
fn asked_caps(format: DeviceFormat, settings: &DeviceSettings) -> gst::Caps {
    let name = match format {
        DeviceFormat::Mjpeg => "image/jpeg",
        DeviceFormat::H264 => "video/x-h264",
        DeviceFormat::H265 => "video/x-h265",
        DeviceFormat::Raw => "video/x-raw",
    };
    let mut caps = gst::Caps::builder(name);
    if let Some(size) = settings.size {
        caps = caps.field("width", size.width as i32).field("height", size.height as i32);
    }
    if let Some(fps) = settings.fps {
        let fraction = |fps: f64| gst::Fraction::approximate_f64(fps).unwrap_or(gst::Fraction::new(1, 1));
        let range = gst::FractionRange::new(fraction(fps - FPS_TOLERANCE), fraction(fps + FPS_TOLERANCE));
        caps = caps.field("framerate", range);
    }
    caps.build()
}

fn not_offered(offered: &gst::Caps) -> SourceFailure {
    /// Longest list of what a device offers.
    const LISTED: usize = 12;
    let list: Vec<String> = offered.iter().take(LISTED).map(describe).collect();
    permanent(
        "does not offer pictures of this format, size and rate",
        format!("Choose one of: {}", list.join("; ")),
    )
}

fn describe(structure: &gst::StructureRef) -> String {
    let field = |name| structure.value(name).ok().and_then(|value| value.serialize().ok());
    let kind = structure.name().trim_start_matches("video/x-").trim_start_matches("image/");
    let [width, height, rate] = ["width", "height", "framerate"].map(|name| field(name).unwrap_or_default());
    format!("{kind} {width} x {height}, {rate} per second")
}

/// The devices that there are, with their names.
fn present_devices(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut devices: Vec<String> = entries
        .map(|entry| {
            let name = std::fs::read_to_string(entry.path().join("name")).unwrap_or_default();
            format!("/dev/{} ({})", entry.file_name().to_string_lossy(), name.trim())
        })
        .collect();
    devices.sort();
    if devices.is_empty() {
        return "This machine has no video device: connect the camera".to_owned();
    }
    format!("Choose one of: {}", devices.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use barrelman_vocab::image::PictureSize;

    #[test]
    fn what_is_asked_for_meets_what_a_device_offers() {
        gst::init().unwrap();
        let offered: gst::Caps =
            "image/jpeg, width=640, height=480, framerate={ (fraction)30000/1001, (fraction)15/1 }"
                .parse()
                .unwrap();
        let settings = |fps, width| DeviceSettings {
            path: "/dev/video0".into(),
            size: Some(PictureSize::new(width, 480)),
            fps: Some(fps),
            format: None,
        };
        let meets = |format, settings| offered.can_intersect(&asked_caps(format, &settings));
        assert!(meets(DeviceFormat::Mjpeg, settings(29.97, 640)));
        assert!(meets(DeviceFormat::Mjpeg, settings(15.0, 640)));
        assert!(!meets(DeviceFormat::Mjpeg, settings(25.0, 640)));
        assert!(!meets(DeviceFormat::Mjpeg, settings(15.0, 320)));
        assert!(!meets(DeviceFormat::Raw, settings(15.0, 640)));
        let remedy = not_offered(&offered).remedy;
        assert!(remedy.contains("jpeg 640 x 480"), "{remedy}");
    }

    #[test]
    fn devices_are_listed_with_their_names() {
        let folder = std::env::temp_dir().join(format!("barrelman-devices-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("video2")).unwrap();
        std::fs::write(folder.join("video2/name"), "USB Camera\n").unwrap();
        assert_eq!(present_devices(&folder), "Choose one of: /dev/video2 (USB Camera)");
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(present_devices(&folder), "This machine has no video device: connect the camera");
    }
}
