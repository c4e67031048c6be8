//! MP4 files written, and read back.

use std::fs::File;
use std::path::Path;
use std::time::Duration;

use barrelman_video::encoder::EncoderSettings;
use barrelman_video::mode::DecodeMode;
use barrelman_video::writer::{Mp4Writer, takes_units_like};
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, Picture, SampleRange};

use crate::clips::{decode, output, read, skip, units, units_of};

const SETTINGS: EncoderSettings = EncoderSettings { fps: 30.0, bits_per_second: 2_000_000 };

/// A picture with a moving texture.
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
        // A varying rate, with a start other than 0.
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
fn h264_that_is_not_read_here_is_not_written_unchanged() {
    for (file, is_taken) in [
        ("baseline.mp4", true),
        ("high_b.mp4", true),
        ("interlaced.mp4", false),
        ("ten_bit.mp4", false),
        ("chroma_422.mp4", false),
        ("png", false),
    ] {
        assert_eq!(takes_units_like(&units(file)[0]), is_taken, "{file}");
    }
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
