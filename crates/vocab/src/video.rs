//! Video frames: a planar YUV 4:2:0 picture with its time of capture.

use std::sync::Arc;

use crate::image::PictureSize;
use crate::time::Timestamp;

/// Which matrix turned the camera's red, green and blue into Y, U and V.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ColourMatrix {
    /// ITU-R BT.601: standard definition, and JPEG.
    Bt601,
    /// ITU-R BT.709: high definition.
    Bt709,
}

/// Which part of 0..=255 the samples use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SampleRange {
    /// Y 16..=235, U and V 16..=240: what video uses unless it says otherwise.
    Limited,
    /// 0..=255: JPEG.
    Full,
}

/// How the samples of a picture stand for colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ColourEncoding {
    /// The matrix.
    pub matrix: ColourMatrix,
    /// The range.
    pub range: SampleRange,
}

impl ColourEncoding {
    /// What JPEG files use.
    pub const JPEG: Self = Self { matrix: ColourMatrix::Bt601, range: SampleRange::Full };

    /// What to take where a video does not say: limited range, and BT.709 from 720 lines on, else BT.601.
    pub fn assumed_for(size: PictureSize) -> Self {
        let matrix = if size.height >= 720 { ColourMatrix::Bt709 } else { ColourMatrix::Bt601 };
        Self { matrix, range: SampleRange::Limited }
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
    /// One row of samples, without the padding behind it.
    ///
    /// # Panics
    /// If `row` is not below `height`.
    pub fn row(&self, row: usize) -> &'a [u8] {
        &self.data[row * self.stride..][..self.width]
    }
}

/// A planar YUV 4:2:0 picture that owns its samples, rows tightly packed. The chroma planes are half as wide
/// and half as high, rounded up, so that odd sizes work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    size: PictureSize,
    colour: ColourEncoding,
    samples: Vec<u8>,
}

impl Picture {
    /// A black picture (in the given encoding).
    pub fn black(size: PictureSize, colour: ColourEncoding) -> Self {
        let mut picture = Self { size, colour, samples: Vec::new() };
        picture.reshape(size, colour);
        let black = if colour.range == SampleRange::Limited { 16 } else { 0 };
        picture.samples.fill(128);
        picture.samples[..size.area()].fill(black);
        picture
    }

    /// Makes this a picture of another size and encoding, and keeps its memory. The samples hold whatever was
    /// there before: a caller fills all three planes.
    pub fn reshape(&mut self, size: PictureSize, colour: ColourEncoding) {
        self.size = size;
        self.colour = colour;
        let chroma = Self::chroma_size_of(size);
        self.samples.resize(size.area() + 2 * chroma.area(), 128);
    }

    /// Size of the luma plane, which is the picture's.
    pub const fn size(&self) -> PictureSize {
        self.size
    }

    /// Size of each chroma plane: half of the picture's, rounded up.
    pub const fn chroma_size(&self) -> PictureSize {
        Self::chroma_size_of(self.size)
    }

    const fn chroma_size_of(size: PictureSize) -> PictureSize {
        PictureSize::new(size.width.div_ceil(2), size.height.div_ceil(2))
    }

    /// How the samples stand for colours.
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

    /// The samples of all three planes, to be written: Y, U, V, each tightly packed.
    pub fn planes_mut(&mut self) -> [&mut [u8]; 3] {
        let chroma = self.chroma_size().area();
        let (y, uv) = self.samples.split_at_mut(self.size.area());
        let (u, v) = uv.split_at_mut(chroma);
        [y, u, v]
    }

    /// The samples of all three planes, Y, U, V, one behind the other.
    pub fn samples(&self) -> &[u8] {
        &self.samples
    }
}

fn plane(data: &[u8], size: PictureSize) -> Plane<'_> {
    Plane { data, width: size.width as usize, height: size.height as usize, stride: size.width as usize }
}

/// How good a time of capture is: whose clock stamped the picture, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CaptureQuality {
    /// Stamped at the sensor (V4L2 buffer time, simulator).
    Sensor,
    /// Stamped by the sender and mapped to our clock (RTP, RTCP, the PTS of a file).
    Sender,
    /// The time at which it arrived here: the true capture was earlier by an unknown latency.
    Arrival,
}

/// When a picture was taken, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capture {
    /// Time of capture.
    pub at: Timestamp,
    /// Whose clock said so.
    pub quality: CaptureQuality,
}

/// One picture of a video with its place in time. Cloning shares the picture.
#[derive(Debug, Clone)]
pub struct VideoFrame {
    /// Running number of the decoded frames of this source from 0; gaps are frames that were dropped.
    pub sequence: u64,
    /// When it was taken.
    pub capture: Capture,
    /// The samples.
    pub picture: Arc<Picture>,
}
