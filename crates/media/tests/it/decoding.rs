//! Decoded pictures against those of FFmpeg.

use barrelman_media_protocol::decoder::{DecodedPicture, ToDecoder};
use barrelman_media_protocol::format::CodedFormat;
use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};

use crate::clip::{self, Folder, Unit};
use crate::media::Media;

/// Two seconds of small pictures with motion.
const SMALL: &str = "s=320x240:r=25:d=2";

/// A clip, its units and what a decoder makes of them.
struct Decoded {
    units: Vec<Unit>,
    pictures: Vec<(DecodedPicture, Vec<u8>)>,
    expected: Vec<u8>,
}

fn decode(format: CodedFormat, is_live: bool, input: &str, encoder: &str) -> Decoded {
    decode_as(format, is_live, input, encoder, "yuv420p")
}

/// The same, with FFmpeg's pictures in this format.
fn decode_as(format: CodedFormat, is_live: bool, input: &str, encoder: &str, expected: &str) -> Decoded {
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    clip::encode(input, encoder, &file);
    let units = clip::units(&file, format);
    let pictures = Media::decoder(format, is_live).decode_all(&units);
    Decoded { pictures, expected: clip::pictures(&file, expected), units }
}

impl Decoded {
    /// Every picture comes once, in the order of display, with the time of its unit.
    fn assert_times(&self) {
        let mut times: Vec<u64> = self.units.iter().map(|unit| unit.pts_ns).collect();
        times.sort_unstable();
        let got: Vec<u64> = self.pictures.iter().map(|(picture, _)| picture.pts_ns).collect();
        assert_eq!(got, times);
    }

    /// No sample differs by more than `tolerance`.
    fn assert_samples(&self, tolerance: u8) {
        let got = self.pictures.iter().flat_map(|(_, samples)| samples);
        assert_eq!(got.clone().count(), self.expected.len());
        let largest = got.zip(&self.expected).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(largest <= tolerance, "{largest}");
    }
}

fn check(format: CodedFormat, is_live: bool, encoder: &str) {
    if clip::has_ffmpeg() {
        let decoded = decode(format, is_live, SMALL, encoder);
        decoded.assert_times();
        decoded.assert_samples(0);
    }
}

#[test]
fn h264_with_b_frames() {
    check(CodedFormat::H264, false, "-c:v libx264 -bf 3 -g 20 -pix_fmt yuv420p");
}

#[test]
fn h264_with_a_pyramid_of_b_frames_and_open_groups() {
    check(
        CodedFormat::H264,
        false,
        "-c:v libx264 -bf 5 -g 20 -x264opts b-pyramid=normal:open-gop=1:ref=4 -pix_fmt yuv420p",
    );
}

#[test]
fn h265_with_b_frames() {
    check(CodedFormat::H265, false, "-c:v libx265 -x265-params log-level=0:bframes=4:keyint=20:open-gop=0");
}

#[test]
fn vp9() {
    check(CodedFormat::Vp9, false, "-c:v libvpx-vp9 -cpu-used 8 -g 20");
}

#[test]
fn av1() {
    check(CodedFormat::Av1, false, "-c:v libaom-av1 -cpu-used 8 -g 20 -t 1");
}

#[test]
fn a_live_decoder_delivers_each_picture_before_its_done() {
    if !clip::has_ffmpeg() {
        return;
    }
    let formats = [
        (CodedFormat::H264, "-c:v libx264 -tune zerolatency -bf 0 -pix_fmt yuv420p"),
        (CodedFormat::H264, "-c:v libx264 -profile:v baseline -pix_fmt yuv420p"),
        (CodedFormat::H265, "-c:v libx265 -x265-params log-level=0:bframes=0 -tune zerolatency"),
        (CodedFormat::Vp9, "-c:v libvpx-vp9 -deadline realtime -lag-in-frames 0 -cpu-used 8"),
        (CodedFormat::Av1, "-c:v libaom-av1 -usage realtime -lag-in-frames 0 -cpu-used 8 -t 1"),
    ];
    for (format, encoder) in formats {
        let folder = Folder::new();
        let file = folder.file("clip.mkv");
        clip::encode(SMALL, encoder, &file);
        let mut media = Media::decoder(format, true);
        for unit in clip::units(&file, format) {
            let answer = media.decode(&unit);
            assert_eq!(answer.damage, None);
            let times: Vec<u64> = answer.pictures.iter().map(|(picture, _)| picture.pts_ns).collect();
            assert_eq!(times, [unit.pts_ns], "{encoder}");
        }
    }
}

#[test]
fn times_that_go_backwards_stay_as_they_are() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    clip::encode(SMALL, "-c:v libx264 -bf 0 -pix_fmt yuv420p", &file);
    let mut units = clip::units(&file, CodedFormat::H264);
    let far = u64::MAX / 2 + 7;
    units.iter_mut().for_each(|unit| unit.pts_ns = far - unit.pts_ns);
    let pictures = Media::decoder(CodedFormat::H264, true).decode_all(&units);
    let times: Vec<u64> = pictures.iter().map(|(picture, _)| picture.pts_ns).collect();
    assert_eq!(times, units.iter().map(|unit| unit.pts_ns).collect::<Vec<_>>());
}

#[test]
fn ten_bits_become_eight() {
    if !clip::has_ffmpeg() {
        return;
    }
    let encoder = "-c:v libx265 -x265-params log-level=0 -pix_fmt yuv420p10le";
    let decoded = decode(CodedFormat::H265, false, SMALL, encoder);
    decoded.assert_times();
    // FFmpeg rounds with a pattern of dither.
    decoded.assert_samples(1);
}

#[test]
fn grey_has_chroma_in_the_middle() {
    if !clip::has_ffmpeg() {
        return;
    }
    let decoded = decode(CodedFormat::H264, false, SMALL, "-c:v libx264 -pix_fmt gray");
    assert!(!decoded.pictures.is_empty());
    for (_, samples) in &decoded.pictures {
        assert!(samples[320 * 240..].iter().all(|&sample| sample == 128));
    }
}

#[test]
fn colours_are_told_and_samples_stay_unchanged() {
    if !clip::has_ffmpeg() {
        return;
    }
    let h264 = "-c:v libx264 -bf 0 -t 0.2 -pix_fmt";
    let limited = |matrix| ColourEncoding { matrix, range: SampleRange::Limited };
    let full = |matrix| ColourEncoding { matrix, range: SampleRange::Full };
    let cases = [
        ("yuv420p", "", limited(ColourMatrix::Bt601)),
        ("yuvj420p", "-color_range pc", full(ColourMatrix::Bt601)),
        (
            "yuv420p",
            "-colorspace bt709 -color_primaries bt709 -color_trc bt709",
            limited(ColourMatrix::Bt709),
        ),
        ("yuvj420p", "-color_range pc -colorspace bt709", full(ColourMatrix::Bt709)),
        ("yuv420p", "-colorspace smpte170m", limited(ColourMatrix::Bt601)),
    ];
    for (pixels, options, colour) in cases {
        let encoder = format!("{h264} {pixels} {options}");
        let decoded = decode_as(CodedFormat::H264, false, SMALL, &encoder, pixels);
        decoded.assert_samples(0);
        assert_eq!(decoded.pictures[0].0.colour, colour, "{options}");
    }
    let large = decode(CodedFormat::H264, false, "s=1280x720:r=5:d=1", &format!("{h264} yuv420p"));
    assert_eq!(large.pictures[0].0.colour, limited(ColourMatrix::Bt709));
}

#[test]
fn more_chroma_is_reduced_and_the_range_stays() {
    if !clip::has_ffmpeg() {
        return;
    }
    for (range, pixels) in [("tv", "yuv444p"), ("pc", "yuvj444p")] {
        let encoder = format!("-c:v libx264 -pix_fmt {pixels} -color_range {range}");
        let decoded = decode_as(CodedFormat::H264, false, "s=320x240:r=25:d=0.2", &encoder, pixels);
        let luma = 320 * 240;
        assert_eq!(decoded.pictures.len(), decoded.units.len());
        for ((_, samples), expected) in decoded.pictures.iter().zip(decoded.expected.chunks(3 * luma)) {
            assert_eq!(samples.len(), luma * 3 / 2);
            assert!(samples[..luma] == expected[..luma], "{range}");
        }
    }
}

#[test]
fn interlaced_pictures_keep_their_top_field_and_have_no_delay() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    let encoder = "-vf tinterlace=interleave_top -c:v libx264 -bf 0 -flags +ildct+ilme -x264opts tff=1 -pix_fmt yuv420p";
    clip::encode("s=320x240:r=50:d=2", encoder, &file);
    let units = clip::units(&file, CodedFormat::H264);
    let expected = clip::pictures(&file, "yuv420p");
    let mut media = Media::decoder(CodedFormat::H264, true);
    for (unit, expected) in units.iter().zip(expected.chunks(320 * 240 * 3 / 2)) {
        let answer = media.decode(unit);
        let [(picture, samples)] = &answer.pictures[..] else { panic!("{} pictures", answer.pictures.len()) };
        assert_eq!(picture.pts_ns, unit.pts_ns);
        let row = |samples: &[u8], row: usize| samples[row * 320..][..320].to_vec();
        for top in (0..240).step_by(2) {
            assert_eq!(row(samples, top), row(expected, top));
        }
        assert!((1..239).step_by(2).any(|bottom| row(samples, bottom) != row(expected, bottom)));
    }
}

#[test]
fn the_size_may_change() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let mut media = Media::decoder(CodedFormat::H265, true);
    let mut sizes = Vec::new();
    for (name, size) in [("a.mkv", "320x240"), ("b.mkv", "642x362"), ("c.mkv", "160x90")] {
        let file = folder.file(name);
        let encoder = "-c:v libx265 -x265-params log-level=0:bframes=0 -tune zerolatency";
        clip::encode(&format!("s={size}:r=25:d=0.2"), encoder, &file);
        let expected = clip::pictures(&file, "yuv420p");
        let mut got = Vec::new();
        for unit in clip::units(&file, CodedFormat::H265) {
            for (picture, samples) in media.decode(&unit).pictures {
                sizes.push(picture.size);
                got.extend(samples);
            }
        }
        assert_eq!(got.len(), expected.len(), "{size}");
        assert!(got == expected, "{size}");
    }
    sizes.dedup();
    let expected = [(320, 240), (642, 362), (160, 90)];
    assert_eq!(sizes, expected.map(|(width, height)| PictureSize::new(width, height)));
}

#[test]
fn a_picture_of_more_than_4096_columns_is_scaled_down() {
    if !clip::has_ffmpeg() {
        return;
    }
    let encoder = "-c:v libx264 -preset ultrafast -frames:v 2 -pix_fmt yuv420p";
    let decoded = decode(CodedFormat::H264, false, "s=5312x2988:r=25", encoder);
    assert_eq!(decoded.pictures.len(), 2);
    for (picture, samples) in &decoded.pictures {
        assert_eq!(picture.size, PictureSize::new(4096, 2304));
        assert_eq!(picture.scaled_from, Some(PictureSize::new(5312, 2988)));
        assert_eq!(samples.len(), 4096 * 2304 * 3 / 2);
    }
}

#[test]
fn a_flush_delivers_what_is_held_back_and_the_next_stream_starts_anew() {
    if !clip::has_ffmpeg() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    clip::encode(SMALL, "-c:v libx264 -bf 3 -g 20 -pix_fmt yuv420p", &file);
    let units = clip::units(&file, CodedFormat::H264);
    let mut media = Media::decoder(CodedFormat::H264, false);
    let first = media.decode_all(&units);
    let second = media.decode_all(&units);
    assert_eq!(first.len(), units.len());
    assert!(first == second);
    assert!(media.answer(ToDecoder::Flush, b"").pictures.is_empty());
    // Units up to the next key are skipped.
    let skipped = media.decode_all(&units[1..20]);
    assert!(skipped.is_empty());
}

/// What loss does to a unit, and whether every decoder notices it.
type Fault = (bool, fn(&mut Vec<u8>));

const FAULTS: [Fault; 5] = [
    (true, |payload| payload.truncate(payload.len() / 2)),
    (true, |payload| payload.iter_mut().enumerate().for_each(|(at, byte)| *byte = (at * 37 % 251) as u8)),
    (true, Vec::clear),
    (false, |payload| payload[10..].fill(0)),
    (false, |payload| {
        let third = payload.len() / 3;
        payload[third..].iter_mut().take(20).for_each(|byte| *byte ^= 0x55);
    }),
];

/// Damages every fifth unit in turn. The decoder goes on at the next key frame. Returns the number of
/// delivered pictures that are not those of the intact clip: all of them come from units before that key.
fn wrong_pictures(format: CodedFormat, encoder: &str, fault: fn(&mut Vec<u8>)) -> usize {
    let folder = Folder::new();
    let file = folder.file("clip.mkv");
    clip::encode(SMALL, encoder, &file);
    let units = clip::units(&file, format);
    let mut media = Media::decoder(format, true);
    let intact = media.decode_all(&units);
    let mut wrong = 0;
    for damaged in (5..units.len()).step_by(5) {
        let mut media = Media::decoder(format, true);
        let mut pictures = Vec::new();
        for (index, unit) in units.iter().enumerate() {
            let mut unit = unit.clone();
            if index == damaged {
                fault(&mut unit.payload);
            }
            pictures.extend(media.decode(&unit).pictures);
        }
        pictures.extend(media.answer(ToDecoder::Flush, b"").pictures);
        let resumed = units.iter().skip(damaged + 1).find(|unit| unit.key).map(|unit| unit.pts_ns);
        for picture in &pictures {
            let same = intact.iter().find(|intact| intact.0.pts_ns == picture.0.pts_ns).unwrap();
            let is_intact = same == picture;
            assert!(is_intact || resumed.is_none_or(|resumed| picture.0.pts_ns < resumed));
            wrong += usize::from(!is_intact);
        }
        let after = intact.iter().filter(|(picture, _)| resumed.is_some_and(|at| picture.pts_ns >= at));
        assert!(after.clone().all(|expected| pictures.contains(expected)), "{damaged} is not survived");
    }
    wrong
}

#[test]
fn damage_to_a_unit_is_survived() {
    if !clip::has_ffmpeg() {
        return;
    }
    let formats = [
        (CodedFormat::H264, "-c:v libx264 -tune zerolatency -bf 0 -g 12 -t 1 -pix_fmt yuv420p"),
        (
            CodedFormat::H265,
            "-c:v libx265 -tune zerolatency -x265-params log-level=0:bframes=0:keyint=12 -t 1",
        ),
        (CodedFormat::Vp9, "-c:v libvpx-vp9 -deadline realtime -lag-in-frames 0 -cpu-used 8 -g 12 -t 1"),
        (CodedFormat::Av1, "-c:v libaom-av1 -usage realtime -lag-in-frames 0 -cpu-used 8 -g 12 -t 1"),
    ];
    for (format, encoder) in formats {
        for (number, (is_noticed, fault)) in FAULTS.into_iter().enumerate() {
            let wrong = wrong_pictures(format, encoder, fault);
            assert!(wrong == 0 || !is_noticed, "{} {number}: {wrong}", format.name());
        }
    }
}
