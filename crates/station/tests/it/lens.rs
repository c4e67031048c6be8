//! A calibrated lens: read from a file, scaled to the picture, compared with OpenCV's projections, and
//! refused where it does not fit.

use std::path::{Path, PathBuf};

use barrelman_control::water::WaterView;
use barrelman_station::config::lens::misfit;
use barrelman_station::config::{self, Configuration};
use barrelman_vocab::{Angle, CameraAboveWater, Lens, PictureSize, PixelPoint, WaterPoint};

use crate::program::empty_folder;

const LENS: &str = "width = 1280\nheight = 720\nfx = 760\nfy = 755\ncx = 640\ncy = 355\nk1 = -0.09\n";

/// The effective lens of a configuration with this text, in a folder that also has these files.
fn lens_of(folder: &Path, text: &str) -> Result<Option<Lens>, String> {
    let path = folder.join("barrelman.toml");
    std::fs::write(&path, text).unwrap();
    let read = || -> anyhow::Result<_> { Configuration::resolve(&config::read(&path)?) };
    read().map(|found| found.profile.camera.lens).map_err(|error| format!("{error:#}"))
}

#[test]
fn a_lens_file_is_the_same_as_the_table() {
    let folder = empty_folder("lens-file");
    let file = folder.join("lens.toml");
    std::fs::write(&file, LENS).unwrap();
    let named = format!("[camera]\nlens_file = {file:?}\n");
    let found = lens_of(&folder, &named);
    assert_eq!(found, lens_of(&folder, &format!("[camera.lens]\n{LENS}")));
    assert_eq!(found.unwrap().unwrap().principal, PixelPoint { u: 640.5, v: 355.5 });
    let both = lens_of(&folder, &format!("{named}[camera.lens]\n{LENS}"));
    assert!(both.unwrap_err().contains("camera.lens_file and camera.lens are both given: omit one"));
    std::fs::write(&file, LENS.replace("-0.09", "-0.9")).unwrap();
    let refused = lens_of(&folder, &named).unwrap_err();
    assert!(refused.contains("lens.toml is not usable") && refused.contains("folds over"), "{refused}");
    std::fs::remove_file(&file).unwrap();
    assert!(lens_of(&folder, &named).unwrap_err().contains("there is no file"));
}

#[test]
fn a_lens_that_does_not_fit_the_picture_says_what_to_do() {
    let folder = empty_folder("lens-misfit");
    let lens = lens_of(&folder, &format!("[camera.lens]\n{LENS}")).unwrap().unwrap();
    assert_eq!(misfit(&lens, PictureSize::new(1920, 1080)), None);
    let message = misfit(&lens, PictureSize::new(640, 480)).unwrap();
    for part in ["camera.lens is calibrated for 1280x720", "the video has 640x480", "or omit the lens"] {
        assert!(message.contains(part), "{message}");
    }
}

/// The loaded lens, at the size of its calibration and at half of it, sees each point where
/// `cv2.projectPoints` does.
#[test]
fn a_loaded_lens_sees_where_opencv_does() {
    let folder = empty_folder("lens-opencv");
    let fixtures = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/water/projected.csv");
    let text = std::fs::read_to_string(fixtures).unwrap();
    let mut max_px: f64 = 0.0;
    let mut rows = 0;
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        // The webcam of the laboratory has larger pictures than the others.
        let (width, height) = if fields[0] == "1400.66" { (1600, 1200) } else { (1280, 720) };
        let keys = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];
        let table: String =
            keys.iter().zip(&fields).map(|(key, value)| format!("{key} = {value}\n")).collect();
        let config = format!("[camera.lens]\nwidth = {width}\nheight = {height}\n{table}");
        let lens = lens_of(&folder, &config).unwrap().unwrap();
        let values: Vec<f64> = fields.iter().map(|field| field.parse().unwrap()).collect();
        let [height_m, pan, tilt, roll, x, y, u, v] = values[9..] else { panic!("{line}") };
        let camera = CameraAboveWater {
            below: WaterPoint::default(),
            height_m,
            pan: Angle::from_radians(pan),
            tilt: Angle::from_radians(tilt),
            roll: Angle::from_radians(roll),
        };
        for share in [1_u32, 2] {
            let scaled = lens.scaled_to(PictureSize::new(width / share, height / share)).unwrap();
            let seen = WaterView::new(scaled, &camera).pixel_of_water(WaterPoint { x, y }).unwrap();
            let share = f64::from(share);
            max_px = max_px.max((share * seen.u - 0.5 - u).abs()).max((share * seen.v - 0.5 - v).abs());
        }
        rows += 1;
    }
    assert_eq!(rows, 240);
    assert!(max_px < 1e-8, "{max_px} px from OpenCV's projections");
}
