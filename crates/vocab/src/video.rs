//! Video frames: a planar YUV 4:2:0 picture with its time of capture.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::image::PictureSize;
use crate::time::Timestamp;

/// The matrix that converted red, green and blue to Y, U and V.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColourMatrix {
    /// ITU-R BT.601: standard definition and JPEG.
    Bt601,
    /// ITU-R BT.709: high definition.
    Bt709,
}

impl ColourMatrix {
    /// The weights of red, green and blue in luma: ITU-R BT.601-7, section 2.5.1, and BT.709-6, section 3.2.
    pub const fn luma_weights(self) -> LumaWeights {
        match self {
            Self::Bt601 => LumaWeights { red: 0.299, green: 0.587, blue: 0.114 },
            Self::Bt709 => LumaWeights { red: 0.2126, green: 0.7152, blue: 0.0722 },
        }
    }
}

/// Weights of red, green and blue (0 to 1) in luma, Y = `red` R + `green` G + `blue` B. Their sum is 1. The
/// colour differences are Cb = (B - Y) / [`Self::cb_divisor`] and Cr = (R - Y) / [`Self::cr_divisor`], -0.5
/// to 0.5.
///
/// ```
/// use barrelman_vocab::video::ColourMatrix;
///
/// let weights = ColourMatrix::Bt601.luma_weights();
/// let [r, g, b] = [1.0, 1.0, 0.0];
/// let y = weights.red * r + weights.green * g + weights.blue * b;
/// assert!((y - 0.886).abs() < 1e-9);
/// assert!(((b - y) / weights.cb_divisor() + 0.5).abs() < 1e-9, "yellow has the least blue difference");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LumaWeights {
    /// Weight of red.
    pub red: f64,
    /// Weight of green.
    pub green: f64,
    /// Weight of blue.
    pub blue: f64,
}

impl LumaWeights {
    /// The largest absolute value of B - Y, times 2.
    pub const fn cb_divisor(self) -> f64 {
        2.0 * (1.0 - self.blue)
    }

    /// The largest absolute value of R - Y, times 2.
    pub const fn cr_divisor(self) -> f64 {
        2.0 * (1.0 - self.red)
    }
}

/// The range of sample values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SampleRange {
    /// Y 16..=235, U and V 16..=240: the default of video.
    Limited,
    /// 0..=255: JPEG.
    Full,
}

/// From samples of a range to the scale of 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullScale {
    /// Factor of the luma above black.
    pub luma: f64,
    /// Factor of the chroma from its middle, 128.
    pub chroma: f64,
    /// The luma of black.
    pub black: f64,
}

impl SampleRange {
    /// What makes samples of this range those of 0 to 255.
    pub const fn full_scale(self) -> FullScale {
        match self {
            Self::Limited => FullScale { luma: 255.0 / 219.0, chroma: 255.0 / 224.0, black: 16.0 },
            Self::Full => FullScale { luma: 1.0, chroma: 1.0, black: 0.0 },
        }
    }
}

/// Colour encoding of a picture's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ColourEncoding {
    /// The matrix.
    pub matrix: ColourMatrix,
    /// The range.
    pub range: SampleRange,
}

impl ColourEncoding {
    /// The encoding of JPEG files.
    pub const JPEG: Self = Self { matrix: ColourMatrix::Bt601, range: SampleRange::Full };

    /// The encoding assumed for a video that does not declare one: limited range, BT.709 from 720 rows on,
    /// else BT.601.
    pub fn assumed_for(size: PictureSize) -> Self {
        let matrix = if size.height >= 720 { ColourMatrix::Bt709 } else { ColourMatrix::Bt601 };
        Self { matrix, range: SampleRange::Limited }
    }
}

impl core::fmt::Display for ColourEncoding {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let matrix = match self.matrix {
            ColourMatrix::Bt601 => "BT.601",
            ColourMatrix::Bt709 => "BT.709",
        };
        let range = match self.range {
            SampleRange::Limited => "limited range",
            SampleRange::Full => "full range",
        };
        write!(f, "{matrix}, {range}")
    }
}

/// One plane of samples, borrowed. Row `r` is `data[r * stride..][..width]`.
#[derive(Debug, Clone, Copy)]
pub struct Plane<'a> {
    /// The samples.
    pub data: &'a [u8],
    /// Samples per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples from the start of a row to the start of the next; at least `width`.
    pub stride: usize,
}

impl<'a> Plane<'a> {
    /// One row of samples, without padding.
    ///
    /// # Panics
    /// If `row >= height`.
    pub fn row(&self, row: usize) -> &'a [u8] {
        &self.data[row * self.stride..][..self.width]
    }

    /// The planes Y, U, V of a YUV 4:2:0 picture that lie one behind the other without padding. `None`: the
    /// number of samples is another than `size` asks for.
    pub fn split_yuv420(samples: &'a [u8], size: PictureSize) -> Option<[Self; 3]> {
        let chroma = PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2));
        if samples.len() != size.area() + 2 * chroma.area() {
            return None;
        }
        let (y, uv) = samples.split_at(size.area());
        let (u, v) = uv.split_at(chroma.area());
        let plane = |data, size: PictureSize| {
            let (width, height) = (size.width as usize, size.height as usize);
            Self { data, width, height, stride: width }
        };
        Some([plane(y, size), plane(u, chroma), plane(v, chroma)])
    }
}

/// A planar YUV 4:2:0 picture that owns its samples, without padding between rows. The chroma planes have
/// half the width and height, rounded up, so that odd sizes work.
///
/// ```
/// use barrelman_vocab::video::ColourEncoding;
/// use barrelman_vocab::{Picture, PictureSize};
///
/// let mut picture = Picture::black(PictureSize::new(4, 2), ColourEncoding::JPEG);
/// let [luma, _, _] = picture.planes_mut();
/// luma[0] = 255;
/// assert_eq!(picture.y().row(0), [255, 0, 0, 0]);
/// assert_eq!(picture.chroma_size(), PictureSize::new(2, 1));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    size: PictureSize,
    colour: ColourEncoding,
    samples: Vec<u8>,
}

impl Picture {
    /// A black picture.
    pub fn black(size: PictureSize, colour: ColourEncoding) -> Self {
        let mut picture = Self { size, colour, samples: Vec::new() };
        picture.reshape(size, colour);
        let black = if colour.range == SampleRange::Limited { 16 } else { 0 };
        picture.samples.fill(128);
        picture.samples[..size.area()].fill(black);
        picture
    }

    /// Changes size and encoding and reuses the memory. The content is unspecified afterwards: the caller
    /// must fill all three planes.
    pub fn reshape(&mut self, size: PictureSize, colour: ColourEncoding) {
        self.size = size;
        self.colour = colour;
        let chroma = Self::chroma_size_of(size);
        self.samples.resize(size.area() + 2 * chroma.area(), 128);
    }

    /// Size of the picture and of its luma plane.
    pub const fn size(&self) -> PictureSize {
        self.size
    }

    /// Size of each chroma plane: half the picture's size, rounded up.
    pub const fn chroma_size(&self) -> PictureSize {
        Self::chroma_size_of(self.size)
    }

    const fn chroma_size_of(size: PictureSize) -> PictureSize {
        PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2))
    }

    /// Colour encoding of the samples.
    pub const fn colour(&self) -> ColourEncoding {
        self.colour
    }

    /// The luma plane.
    pub fn y(&self) -> Plane<'_> {
        plane(&self.samples[..self.size.area()], self.size)
    }

    /// The first chroma plane (blue difference).
    pub fn u(&self) -> Plane<'_> {
        let chroma = self.chroma_size();
        plane(&self.samples[self.size.area()..][..chroma.area()], chroma)
    }

    /// The second chroma plane (red difference).
    pub fn v(&self) -> Plane<'_> {
        let chroma = self.chroma_size();
        plane(&self.samples[self.size.area() + chroma.area()..][..chroma.area()], chroma)
    }

    /// The samples of the Y, U and V plane, mutable, each without padding.
    pub fn planes_mut(&mut self) -> [&mut [u8]; 3] {
        let chroma = self.chroma_size().area();
        let (y, uv) = self.samples.split_at_mut(self.size.area());
        let (u, v) = uv.split_at_mut(chroma);
        [y, u, v]
    }

    /// The samples of the Y, U and V plane in this order.
    pub fn samples(&self) -> &[u8] {
        &self.samples
    }
}

fn plane(data: &[u8], size: PictureSize) -> Plane<'_> {
    Plane { data, width: size.width as usize, height: size.height as usize, stride: size.width as usize }
}

/// Quality of a time of capture: the clock that stamped the picture, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CaptureQuality {
    /// Stamped at the sensor (V4L2 buffer time, simulator).
    Sensor,
    /// Stamped by the sender and mapped to this program's clock (RTP, RTCP, the PTS of a file).
    Sender,
    /// Time of arrival. The picture was captured earlier by an unknown latency.
    Arrival,
}

/// Time of capture of a picture, and its quality.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capture {
    /// Time of capture.
    pub at: Timestamp,
    /// The clock that stamped it.
    pub quality: CaptureQuality,
}

/// One picture of a video with its time of capture. Cloning shares the picture.
///
/// ```
/// use std::sync::Arc;
///
/// use barrelman_vocab::video::{Capture, CaptureQuality, ColourEncoding};
/// use barrelman_vocab::{Picture, PictureSize, Timestamp, VideoFrame};
///
/// let capture = Capture { at: Timestamp::from_secs_f64(0.5), quality: CaptureQuality::Sensor };
/// let picture = Arc::new(Picture::black(PictureSize::new(640, 480), ColourEncoding::JPEG));
/// let frame = VideoFrame { sequence: 0, capture, picture };
/// assert_eq!(frame.picture.size().area(), 307_200);
/// ```
#[derive(Debug, Clone)]
pub struct VideoFrame {
    /// Number of the decoded frame since the start of this source, from 0. A gap means dropped frames.
    pub sequence: u64,
    /// Time of capture.
    pub capture: Capture,
    /// The samples.
    pub picture: Arc<Picture>,
}
