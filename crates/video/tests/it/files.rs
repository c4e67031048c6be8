//! Video files read and written, against what ffmpeg makes of the same files
//! (`fixtures/video/expected.csv`, made by `fixtures/video/make.sh`).

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::Duration;

use barrelman_video::decoder::{DecodeMode, UnitDecoder};
use barrelman_video::demux::FileReader;
use barrelman_video::encoder::EncoderSettings;
use barrelman_video::writer::Mp4Writer;
use barrelman_video::{DecodeError, FileFrames, VideoError, VideoUrl};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::unit::EncodedUnit;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, Picture, Plane, SampleRange, VideoFrame};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/video").join(name)
}

/// All frames of a file, and the error at its end, if any.
fn read(path: PathBuf) -> (Vec<VideoFrame>, Option<VideoError>) {
    let mut frames = match FileFrames::open(&VideoUrl::file(path)) {
        Ok(frames) => frames,
        Err(error) => return (Vec::new(), Some(error)),
    };
    let mut all = Vec::new();
    loop {
        match frames.next_frame() {
            Ok(Some(frame)) => all.push(frame),
            Ok(None) => return (all, None),
            Err(error) => return (all, Some(error)),
        }
    }
}

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

/// Compares a file with what ffmpeg decodes from it: number, times (to the microsecond that ffmpeg prints) and
/// sizes of the frames, and their samples, to the bit or by the means of planes and blocks.
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
    /// The means of each plane and of 4x4 blocks of luma, within so much.
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
    // Another inverse transform, and chroma that was smoothed on its way through 4:4:4.
    for name in ["1", "2", "3"] {
        check_like_ffmpeg(&format!("jpeg/{name}.jpg"), Same::Means(0.5));
    }
}

#[test]
fn a_folder_of_pictures_is_a_video_in_natural_order() {
    let url = VideoUrl::parse(&format!("{}?fps=10", fixture("png").display())).unwrap();
    let mut frames = FileFrames::open(&url).unwrap();
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

/// The units of a file.
fn units(file: &str) -> Vec<EncodedUnit> {
    units_of(&fixture(file))
}

fn units_of(path: &Path) -> Vec<EncodedUnit> {
    let mut reader = FileReader::open(&VideoUrl::file(path)).unwrap();
    std::iter::from_fn(|| reader.next_unit().unwrap()).collect()
}

fn decode(units: &[EncodedUnit], mode: DecodeMode) -> (Vec<VideoFrame>, Vec<DecodeError>) {
    let (mut frames, mut errors) = (Vec::new(), Vec::new());
    let mut decoder = UnitDecoder::new(mode);
    for unit in units {
        errors.extend(decoder.decode(unit, &mut |frame| frames.push(frame)).err());
    }
    decoder.finish(&mut |frame| frames.push(frame));
    (frames, errors)
}

#[test]
fn the_same_units_give_the_same_frames_live_and_from_a_file() {
    let units = units("baseline.mp4");
    let (file, _) = decode(&units, DecodeMode::File);
    let mut decoder = UnitDecoder::new(DecodeMode::Live);
    for (unit, expected) in units.iter().zip(&file) {
        let mut at_once = None;
        decoder.decode(unit, &mut |frame| at_once = Some(frame)).unwrap();
        let frame = at_once.expect("live, each unit gives its picture at once");
        assert_eq!((frame.sequence, frame.capture), (expected.sequence, unit.capture));
        assert_eq!(frame.picture, expected.picture);
    }
}

#[test]
fn a_live_stream_with_bidirectional_pictures_is_put_in_order() {
    let (frames, errors) = decode(&units("high_b.mp4"), DecodeMode::Live);
    assert_eq!(errors, []);
    assert_eq!(frames.len(), 20);
    assert!(frames.is_sorted_by_key(|frame| frame.capture.at));
}

#[test]
fn after_a_missing_picture_nothing_is_shown_until_the_next_key_frame() {
    for file in ["baseline.mp4", "high_b.mp4"] {
        for mode in [DecodeMode::Live, DecodeMode::File] {
            let units = units(file);
            let (whole, _) = decode(&units, mode);
            let mut cut = units.clone();
            let missing = cut.remove(3);
            assert!(!missing.key);
            let (frames, _) = decode(&cut, mode);
            let next_key = units.iter().skip(3).find(|unit| unit.key).unwrap();
            assert!(frames.iter().any(|frame| frame.capture.at >= next_key.capture.at), "{file}: goes on");
            for frame in &frames {
                let same = whole.iter().find(|other| other.capture.at == frame.capture.at).unwrap();
                assert!(
                    same.picture == frame.picture,
                    "{file}, {mode:?}: not intact at {}",
                    frame.capture.at
                );
            }
        }
    }
}

#[test]
fn a_new_epoch_waits_for_a_key_frame_and_goes_on_counting() {
    let mut units = units("baseline.mp4");
    units.truncate(15);
    let mut second = units.split_off(5);
    second.iter_mut().for_each(|unit| unit.epoch = 1);
    let key = second.iter().position(|unit| unit.key).unwrap();
    units.extend(second);
    let (frames, errors) = decode(&units, DecodeMode::Live);
    assert_eq!(errors, []);
    assert_eq!(frames.len(), 15 - key);
    assert!(frames.iter().enumerate().all(|(index, frame)| frame.sequence == index as u64));
}

fn output(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

const SETTINGS: EncoderSettings = EncoderSettings { fps: 30.0, bits_per_second: 2_000_000 };

/// A picture with something to see in it, that moves.
fn scene(size: PictureSize, colour: ColourEncoding, shift: usize) -> Picture {
    let mut picture = Picture::black(size, colour);
    let width = size.width as usize;
    let [y, u, v] = picture.planes_mut();
    for (index, sample) in y.iter_mut().enumerate() {
        *sample = (40 + ((index % width + 3 * shift) % 64) * 2 + index / width) as u8;
    }
    u.fill(100);
    v.fill(160);
    picture
}

fn writer(path: &Path) -> Mp4Writer<File> {
    Mp4Writer::new(File::create(path).unwrap(), path, SETTINGS)
}

#[test]
fn pictures_written_are_read_back_with_their_times_and_colours() {
    let path = output("pictures.mp4");
    for (matrix, range) in
        [(ColourMatrix::Bt709, SampleRange::Full), (ColourMatrix::Bt601, SampleRange::Limited)]
    {
        let colour = ColourEncoding { matrix, range };
        let size = PictureSize::new(96, 64);
        // A varying rate, from some moment of the clock on.
        let times: Vec<_> = (0..45).map(|n| Duration::from_millis(7000 + 40 * n + n * n / 4)).collect();
        let mut writer = writer(&path);
        for (shift, time) in times.iter().enumerate() {
            writer.write_picture(&scene(size, colour, shift), Timestamp::ZERO.plus(*time)).unwrap();
        }
        writer.finish().unwrap();
        let (frames, error) = read(path.clone());
        assert!(error.is_none(), "{error:?}");
        assert_eq!(frames.len(), times.len());
        for (frame, time) in frames.iter().zip(&times) {
            assert_eq!((frame.picture.size(), frame.picture.colour()), (size, colour));
            // The file counts in ticks of 1/90000 s.
            let error_s = frame.capture.at.as_secs_f64() - (*time - times[0]).as_secs_f64();
            assert!(error_s.abs() < 1.2e-5, "{error_s}");
        }
        let written = scene(size, colour, 44);
        let last = &frames.last().unwrap().picture;
        let far = last.y().data.iter().zip(written.y().data).filter(|(a, b)| a.abs_diff(**b) > 24).count();
        assert!(far * 20 < size.area(), "{far} samples are far off");
    }
    let keys = units_of(&path).iter().filter(|unit| unit.key).count();
    assert_eq!(keys, 3, "one at the start and one after each second");
}

#[test]
fn units_written_are_read_back_unchanged() {
    for file in ["baseline.mp4", "high_b.mp4", "size_changes.mp4", "rotated_90.mp4", "vfr.mp4"] {
        let path = output(&format!("units_of_{file}"));
        let original = units(file);
        let mut writer = writer(&path);
        original.iter().for_each(|unit| writer.write_unit(unit).unwrap());
        writer.finish().unwrap();
        let copy = units_of(&path);
        assert_eq!(copy.len(), original.len());
        for (copy, original) in copy.iter().zip(&original) {
            assert_eq!((copy.key, copy.rotation), (original.key, original.rotation), "{file}");
            let apart = copy.capture.at.as_secs_f64() - original.capture.at.as_secs_f64();
            assert!(apart.abs() < 1.2e-5, "{file}: {apart} s apart");
        }
        let (copied, _) = decode(&copy, DecodeMode::File);
        let (expected, _) = decode(&original, DecodeMode::File);
        assert!(copied.iter().map(|frame| &frame.picture).eq(expected.iter().map(|frame| &frame.picture)));
    }
}

#[test]
fn an_odd_picture_loses_its_last_column_and_row_when_written() {
    let path = output("odd.mp4");
    let mut writer = writer(&path);
    writer.write_picture(&scene(PictureSize::new(35, 27), ColourEncoding::JPEG, 0), Timestamp::ZERO).unwrap();
    writer.finish().unwrap();
    assert_eq!(read(path).0[0].picture.size(), PictureSize::new(34, 26));
}

#[test]
fn a_full_disk_is_an_error_and_no_panic() {
    let mut writer = writer(Path::new("/dev/full"));
    let picture = scene(PictureSize::new(96, 64), ColourEncoding::JPEG, 0);
    let written = writer.write_picture(&picture, Timestamp::ZERO);
    let error = written.and_then(|()| writer.finish()).unwrap_err().to_string();
    assert!(error.contains("cannot write `/dev/full`"), "{error}");
}

#[test]
fn a_file_without_a_picture_is_an_error() {
    let error = writer(&output("none.mp4")).finish().unwrap_err();
    assert!(error.to_string().contains("no picture"), "{error}");
}

#[test]
fn ffmpeg_reads_what_is_written_without_a_warning() {
    let copy = output("for_ffmpeg.mp4");
    for file in ["baseline.mp4", "high_b.mp4", "size_changes.mp4", "rotated_270.mp4"] {
        let mut writer = writer(&copy);
        let original = units(file);
        original.iter().for_each(|unit| writer.write_unit(unit).unwrap());
        writer.finish().unwrap();
        let mut ffmpeg = std::process::Command::new("ffmpeg");
        ffmpeg.args(["-v", "warning", "-nostdin", "-i"]).arg(&copy).args(["-f", "framemd5", "-"]);
        let Ok(output) = ffmpeg.output() else {
            return skip("ffmpeg is not installed");
        };
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{file}");
        let frames = String::from_utf8_lossy(&output.stdout).lines().filter(|l| !l.starts_with('#')).count();
        assert_eq!(frames, original.len(), "{file}");
    }
}

/// Ends a test that needs a program that is not here; where everything must be here, in CI, it fails instead.
fn skip(reason: &str) {
    assert!(std::env::var_os("CI").is_none(), "{reason}");
    println!("skipped: {reason}");
}

/// SplitMix64, so that the same bytes are changed each time.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb) >> 16
}

/// Reads a file with some bytes changed or cut off, `times` over: whatever comes, it is frames or an error.
fn check_survives_damage(file: &str, times: u64) {
    let whole = std::fs::read(fixture(file)).unwrap();
    let path = output(&format!("damaged_{}", file.replace('/', "_")));
    for seed in 0..times {
        let mut state = seed;
        let mut bytes = whole.clone();
        for _ in 0..=random(&mut state) % 8 {
            let at = random(&mut state) as usize % bytes.len();
            bytes[at] = match random(&mut state) % 3 {
                0 => 0,
                1 => 0xff,
                _ => random(&mut state) as u8,
            };
        }
        if seed % 4 == 0 {
            bytes.truncate(random(&mut state) as usize % bytes.len());
        }
        std::fs::write(&path, &bytes).unwrap();
        let _ = read(path.clone());
    }
}

#[test]
fn a_damaged_file_gives_frames_or_an_error_and_never_a_panic() {
    let times = 40;
    for file in ["baseline.mp4", "high_b.mp4", "edit_list.mp4", "fragmented.mp4", "size_changes.mp4"] {
        check_survives_damage(file, times);
    }
    for file in ["odd.y4m", "png/f1.png", "png/f10.png", "jpeg/1.jpg", "jpeg/2.jpg"] {
        check_survives_damage(file, times);
    }
}
