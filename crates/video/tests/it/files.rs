//! Video files read, against what ffmpeg makes of the same files
//! (`fixtures/video/expected.csv`, made by `fixtures/video/make.sh`).

use barrelman_video::{VideoFrames, VideoUrl};
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, Plane, SampleRange};

use crate::clips::{fixture, read};

/// One row of `expected.csv`.
struct Expected {
    file: String,
    frame: u64,
    time_s: f64,
    size: (u32, u32),
    md5: String,
    means: [f64; 3],
    thumbnail: Vec<f64>,
}

fn expected() -> Vec<Expected> {
    let csv = std::fs::read_to_string(fixture("expected.csv")).unwrap();
    let row = |line: &str| {
        let fields: Vec<_> = line.split(',').collect();
        let mean = |at: usize| fields[at].parse().unwrap();
        Expected {
            file: fields[0].to_owned(),
            frame: fields[1].parse().unwrap(),
            time_s: fields[2].parse().unwrap(),
            size: (fields[3].parse().unwrap(), fields[4].parse().unwrap()),
            md5: fields[5].to_owned(),
            means: [mean(6), mean(7), mean(8)],
            thumbnail: fields[9].split(' ').map(|cell| cell.parse().unwrap()).collect(),
        }
    };
    csv.lines().skip(1).map(row).collect()
}

fn mean(plane: Plane<'_>) -> f64 {
    plane.data.iter().map(|sample| f64::from(*sample)).sum::<f64>() / plane.data.len() as f64
}

/// The mean of each of 4x4 blocks, row by row: enough to tell one picture of a clip from the next.
fn thumbnail(plane: Plane<'_>) -> Vec<f64> {
    let cell = |row: usize, column: usize| {
        let columns = plane.width * column / 4..plane.width * (column + 1) / 4;
        let rows = plane.height * row / 4..plane.height * (row + 1) / 4;
        let samples = rows.clone().flat_map(|row| &plane.row(row)[columns.clone()]);
        samples.map(|sample| f64::from(*sample)).sum::<f64>() / (rows.len() * columns.len()) as f64
    };
    (0..16).map(|index| cell(index / 4, index % 4)).collect()
}

fn md5(bytes: &[u8]) -> String {
    format!("{:x}", <md5::Md5 as md5::Digest>::digest(bytes))
}

/// Compares a file with ffmpeg's decoding of it: number, times (to the microsecond that ffmpeg prints) and
/// sizes of the frames, and their samples, bit for bit or by the means of planes and blocks.
fn check_like_ffmpeg(file: &str, same: Same) {
    let expected: Vec<_> = expected().into_iter().filter(|row| row.file == file).collect();
    assert!(!expected.is_empty(), "{file} is not in expected.csv");
    let (frames, error) = read(fixture(file));
    assert!(error.is_none(), "{file}: {error:?}");
    assert_eq!(frames.len(), expected.len(), "{file}: number of frames");
    for (frame, row) in frames.iter().zip(expected) {
        let place = format!("{file}, frame {}", row.frame);
        assert_eq!(frame.sequence, row.frame, "{place}");
        let size = frame.picture.size();
        assert_eq!((size.width, size.height), row.size, "{place}");
        let time_s = frame.capture.at.as_secs_f64();
        assert!((time_s - row.time_s).abs() < 1e-5, "{place}: at {time_s} s, not {} s", row.time_s);
        match same {
            Same::Bits => assert_eq!(md5(frame.picture.samples()), row.md5, "{place}"),
            Same::Means(tolerance) => {
                let planes = [frame.picture.y(), frame.picture.u(), frame.picture.v()];
                let means = planes.map(mean);
                let thumbnail = thumbnail(frame.picture.y());
                for (mean, expected) in
                    means.iter().chain(&thumbnail).zip(row.means.iter().chain(&row.thumbnail))
                {
                    assert!((mean - expected).abs() <= tolerance, "{place}: mean {mean}, not {expected}");
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Same {
    /// Every sample.
    Bits,
    /// The means of each plane and of 4x4 blocks of luma, within a tolerance.
    Means(f64),
}

#[test]
fn h264_without_bidirectional_pictures_decodes_to_the_bit_like_ffmpeg() {
    check_like_ffmpeg("baseline.mp4", Same::Bits);
    check_like_ffmpeg("cropped.mp4", Same::Bits);
    check_like_ffmpeg("wide.mp4", Same::Bits);
    check_like_ffmpeg("full_range_709.mp4", Same::Bits);
}

#[test]
fn bidirectional_pictures_come_in_the_order_of_display() {
    // The decoder's B-pictures differ from ffmpeg's by one in a few samples; neighbours differ by several.
    check_like_ffmpeg("high_b.mp4", Same::Means(0.5));
    check_like_ffmpeg("fragmented.mp4", Same::Means(0.5));
}

#[test]
fn times_follow_the_file_with_varying_rate_edit_list_and_pause() {
    check_like_ffmpeg("vfr.mp4", Same::Bits);
    check_like_ffmpeg("pause_in_front.mp4", Same::Bits);
    check_like_ffmpeg("edit_list.mp4", Same::Means(0.5));
}

#[test]
fn the_rotation_of_the_file_is_applied() {
    check_like_ffmpeg("rotated_90.mp4", Same::Bits);
    check_like_ffmpeg("rotated_180.mp4", Same::Bits);
    check_like_ffmpeg("rotated_270.mp4", Same::Bits);
}

#[test]
fn the_size_may_change_in_mid_stream() {
    check_like_ffmpeg("size_changes.mp4", Same::Bits);
}

#[test]
fn raw_pictures_are_taken_as_they_are() {
    check_like_ffmpeg("odd.y4m", Same::Bits);
    check_like_ffmpeg("mono.y4m", Same::Bits);
}

#[test]
fn pictures_become_planes_of_bt_601_in_full_range() {
    // 16-bit samples are cut to 8 bits where ffmpeg rounds, which lowers the mean by up to a half.
    for name in ["f1", "f2", "f3", "f9", "f10"] {
        check_like_ffmpeg(&format!("png/{name}.png"), Same::Means(0.5));
    }
    // ffmpeg uses another inverse transform, and smooths the chroma in a conversion through 4:4:4.
    for name in ["1", "2", "3"] {
        check_like_ffmpeg(&format!("jpeg/{name}.jpg"), Same::Means(0.5));
    }
}

#[test]
fn a_folder_of_pictures_is_a_video_in_natural_order() {
    let url = VideoUrl::parse(&format!("{}?fps=10", fixture("png").display())).unwrap();
    let mut frames = VideoFrames::open(&url).unwrap();
    assert_eq!(frames.frame_count(), Some(5));
    let mut means = Vec::new();
    while let Some(frame) = frames.next_frame().unwrap() {
        assert!((frame.capture.at.as_secs_f64() - 0.1 * frame.sequence as f64).abs() < 1e-9);
        means.push(mean(frame.picture.u()));
    }
    assert_eq!(means.len(), 5);
    assert!((means[2] - 128.0).abs() < 0.01, "the grey one, f3.png, is the third: {means:?}");
}

#[test]
fn colours_are_those_that_the_stream_names() {
    let colour = |file| read(fixture(file)).0[0].picture.colour();
    let named = ColourEncoding { matrix: ColourMatrix::Bt709, range: SampleRange::Full };
    assert_eq!(colour("full_range_709.mp4"), named);
    let assumed = ColourEncoding { matrix: ColourMatrix::Bt601, range: SampleRange::Limited };
    assert_eq!(colour("baseline.mp4"), assumed);
    assert_eq!(colour("png"), ColourEncoding::JPEG);
}

fn check_refused(file: &str, named: &str, remedy: &str) {
    let (frames, error) = read(fixture(file));
    assert!(frames.is_empty(), "{file}");
    let error = error.unwrap_or_else(|| panic!("{file} was read")).to_string();
    for expected in [file, named, remedy] {
        assert!(error.contains(expected), "{file}: `{error}` does not say `{expected}`");
    }
}

#[test]
fn what_is_not_read_is_named_together_with_a_remedy() {
    check_refused("interlaced.mp4", "interlaced H.264", "yadif");
    check_refused("ten_bit.mp4", "10-bit H.264", "ffmpeg -i IN");
    check_refused("chroma_422.mp4", "4:2:2", "-pix_fmt yuv420p");
    check_refused("hevc.mp4", "HEVC (H.265)", "-c:v libx264");
    check_refused("motion_jpeg.avi", "an AVI file", "ffmpeg -i IN");
    check_refused("clip.mkv", "Matroska", "-c copy OUT.mp4");
    check_refused("ten_bit.y4m", "C420p10", "-pix_fmt yuv420p");
    check_refused("text.mp4", "a text file", "Give a video");
    check_refused("empty.mp4", "an empty file", "Give a video");
    check_refused("no_index.mp4", "(moov) is missing", "Copy it again");
    check_refused("absent.mp4", "no file or folder", "check the path");
}

#[test]
fn what_stands_before_the_damage_is_delivered() {
    let (whole, _) = read(fixture("baseline.mp4"));
    let (frames, error) = read(fixture("truncated.mp4"));
    assert!(frames.len() > 5 && frames.len() < whole.len(), "{}", frames.len());
    for (frame, whole) in frames.iter().zip(&whole) {
        assert_eq!(frame.picture, whole.picture);
    }
    let error = error.unwrap().to_string();
    assert!(
        error.contains("truncated.mp4") && error.contains(&format!("after {} pictures", frames.len())),
        "{error}"
    );
}
