//! Reads Y4M files and pipes (YUV4MPEG2): uncompressed pictures after a text header, as ffmpeg and mjpegtools
//! write them.
//!
//! Supported: 8 bit, 4:2:0 in every siting (without a distinction), and mono. Unsupported, with an error that
//! names them: more bits, other chroma formats, interlaced pictures. `XCOLORRANGE=FULL` is respected; the
//! matrix is the customary one for the size.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, SampleRange};
use bytes::Bytes;

use super::stamp::capture_at;
use crate::error::{VideoError, cannot_read};
use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};

/// Maximum length of a header line, bytes.
const MAX_LINE_BYTES: u64 = 1024;

/// Maximum width and height of a picture, pixels: bounds the memory that a damaged header can request.
const MAX_SIDE: u32 = 8192;

/// Reads the pictures of a Y4M file one by one.
pub struct Y4mReader {
    path: PathBuf,
    input: BufReader<File>,
    header: Header,
    next: u64,
    ended: bool,
}

/// The values of the first line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Header {
    size: PictureSize,
    /// Pictures per second: numerator and denominator.
    rate: (u64, u64),
    mono: bool,
    colour: ColourEncoding,
}

/// A header that is not supported or malformed, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
enum HeaderError {
    Unsupported(String),
    Malformed(String),
}

impl Y4mReader {
    /// Reads the header, with which the file or pipe begins.
    ///
    /// # Errors
    /// A malformed header, or unsupported pictures.
    pub fn open(path: &Path, file: File) -> Result<Self, VideoError> {
        let mut input = BufReader::new(file);
        let line = read_line(&mut input).map_err(|error| cannot_read(path, error))?;
        let header = Header::parse(&line).map_err(|error| match error {
            HeaderError::Unsupported(what) => VideoError::Unsupported {
                path: path.to_owned(),
                what,
                remedy: "Convert it: ffmpeg -i IN -vf yadif=deint=interlaced -pix_fmt yuv420p OUT.y4m"
                    .to_owned(),
            },
            HeaderError::Malformed(what) => VideoError::Damaged { path: path.to_owned(), units: 0, what },
        })?;
        Ok(Self { path: path.to_owned(), input, header, next: 0, ended: false })
    }

    /// The next picture.
    ///
    /// # Errors
    /// A truncated picture, or data that is not a picture.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        if self.ended {
            return Ok(None);
        }
        // No picture follows unless this one is read completely.
        self.ended = true;
        let line = read_line(&mut self.input).map_err(|error| cannot_read(&self.path, error))?;
        if line.is_empty() {
            return Ok(None);
        }
        if !line.starts_with(b"FRAME") {
            return Err(self.damaged("a picture must begin with FRAME"));
        }
        let size = self.header.size;
        let chroma = 2 * PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2)).area();
        let mut samples = vec![128; size.area() + chroma];
        let stored = if self.header.mono { size.area() } else { samples.len() };
        match self.input.read_exact(&mut samples[..stored]) {
            Ok(()) => {}
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                return Err(self.damaged("the file ends within a picture"));
            }
            Err(error) => return Err(cannot_read(&self.path, error)),
        }
        let index = self.next;
        self.next += 1;
        self.ended = false;
        let (pictures, seconds) = self.header.rate;
        Ok(Some(EncodedUnit {
            epoch: 0,
            index,
            capture: capture_at(index.saturating_mul(seconds), pictures),
            key: true,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::RawYuv420 { size, colour: self.header.colour },
            payload: Bytes::from(samples),
        }))
    }

    fn damaged(&self, what: &str) -> VideoError {
        VideoError::Damaged { path: self.path.clone(), units: self.next, what: what.to_owned() }
    }
}

fn read_line(input: &mut BufReader<File>) -> std::io::Result<Vec<u8>> {
    let mut line = Vec::new();
    input.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut line)?;
    Ok(line)
}

impl Header {
    fn parse(line: &[u8]) -> Result<Self, HeaderError> {
        let malformed = |what: &str| HeaderError::Malformed(what.to_owned());
        let line = std::str::from_utf8(line).map_err(|_| malformed("the header is not text"))?;
        let line = line.strip_suffix('\n').ok_or_else(|| malformed("the header has no end"))?;
        let (mut width, mut height, mut rate) = (None, None, None);
        let (mut mono, mut range) = (false, SampleRange::Limited);
        for field in line.split(' ').skip(1) {
            let Some(kind) = field.chars().next() else { continue };
            let value = &field[kind.len_utf8()..];
            match kind {
                'W' => width = value.parse::<u32>().ok(),
                'H' => height = value.parse::<u32>().ok(),
                'F' => rate = parse_rate(value),
                'I' if !matches!(value, "p" | "?") => {
                    return Err(HeaderError::Unsupported("interlaced Y4M".to_owned()));
                }
                'C' => mono = parse_chroma(value)?,
                'X' if value == "COLORRANGE=FULL" => range = SampleRange::Full,
                _ => {}
            }
        }
        let (Some(width), Some(height)) = (width, height) else {
            return Err(malformed("the header does not give width and height"));
        };
        let size = PictureSize::new(width, height);
        if size.area() == 0 || width.max(height) > MAX_SIDE {
            return Err(malformed(&format!(
                "a picture of {size} is not possible (at most {MAX_SIDE} a side)"
            )));
        }
        let rate = rate.ok_or_else(|| malformed("the header does not give pictures per second"))?;
        let colour = ColourEncoding { range, ..ColourEncoding::assumed_for(size) };
        Ok(Self { size, rate, mono, colour })
    }
}

fn parse_rate(value: &str) -> Option<(u64, u64)> {
    let (pictures, seconds) = value.split_once(':')?;
    let rate = (pictures.parse().ok()?, seconds.parse().ok()?);
    (rate.0 > 0 && rate.1 > 0).then_some(rate)
}

/// Whether the pictures are mono.
fn parse_chroma(value: &str) -> Result<bool, HeaderError> {
    match value {
        "mono" => Ok(true),
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(false),
        _ => Err(HeaderError::Unsupported(format!(
            "Y4M with samples of kind C{value} (read are C420 and Cmono)"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_tells_size_rate_and_range() {
        let header =
            Header::parse(b"YUV4MPEG2 W176 H144 F30000:1001 Ip A1:1 C420jpeg XCOLORRANGE=FULL\n").unwrap();
        assert_eq!(header.size, PictureSize::new(176, 144));
        assert_eq!(header.rate, (30_000, 1_001));
        assert_eq!(header.colour, ColourEncoding::JPEG);
        assert!(!header.mono);
        assert!(Header::parse(b"YUV4MPEG2 W2 H2 F25:1 Cmono\n").unwrap().mono);
    }

    #[test]
    fn what_is_not_read_is_named() {
        for (fields, named) in [
            ("W2 H2 F25:1 It", "interlaced"),
            ("W2 H2 F25:1 C422", "C422"),
            ("W2 H2 F25:1 C420p10", "C420p10"),
            ("W2 H2 F25:1 Cmono16", "Cmono16"),
        ] {
            match Header::parse(format!("YUV4MPEG2 {fields}\n").as_bytes()) {
                Err(HeaderError::Unsupported(what)) => assert!(what.contains(named), "{what}"),
                other => panic!("{fields}: {other:?}"),
            }
        }
    }

    #[test]
    fn a_malformed_header_is_an_error() {
        for line in [
            "YUV4MPEG2 W2 H2 F25:1",
            "YUV4MPEG2 W0 H2 F25:1\n",
            "YUV4MPEG2 W2 H2 F0:1\n",
            "YUV4MPEG2 H2 F25:1\n",
            "YUV4MPEG2 W99999 H99999 F25:1\n",
            "YUV4MPEG2 W2 H2\n",
        ] {
            assert!(matches!(Header::parse(line.as_bytes()), Err(HeaderError::Malformed(_))), "{line}");
        }
    }
}
