//! Reads a sequence parameter set (ITU-T H.264, 7.3.2.1 and annex E): whether the stream is supported, the
//! size of its pictures, and their colour encoding.
//!
//! Unsupported, with an error that names them: interlaced streams, more than 8 bits per sample, chroma other
//! than 4:2:0. Not handled: pixels that are not square (they are shown as stored).

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use h264_reader::nal::sps::{ChromaFormat, FrameMbsFlags, SeqParameterSet, VuiParameters};
use h264_reader::rbsp::{BitReader, decode_nal};

use crate::error::DecodeError;

/// Maximum width and height of a picture, pixels: the limit of the decoder's highest level, 5.2.
const MAX_SIDE: u32 = 4096;

/// The values of a sequence parameter set that the crate uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SequenceParameters {
    /// Size of the picture, cropped.
    pub(crate) size: PictureSize,
    /// Colour encoding of the samples.
    pub(crate) colour: ColourEncoding,
    /// Whether the stream announces that its display order differs from its decoding order. Not every stream
    /// with such pictures announces them.
    pub(crate) reorders: bool,
}

impl SequenceParameters {
    /// Reads a sequence parameter set: a NAL unit with its header.
    ///
    /// # Errors
    /// [`DecodeError::Unsupported`] for a damaged set and for an unsupported stream.
    pub(crate) fn parse(sps_nal: &[u8]) -> Result<Self, DecodeError> {
        let unreadable =
            |what: &str| unsupported(format!("H.264 with parameters that cannot be read ({what})"));
        let rbsp = decode_nal(sps_nal).map_err(|error| unreadable(&error.to_string()))?;
        let sps = SeqParameterSet::from_bits(BitReader::new(&*rbsp))
            .map_err(|error| unreadable(&format!("{error:?}")))?;
        check_supported(&sps)?;
        let sides = (sps.pic_width_in_mbs_minus1, sps.pic_height_in_map_units_minus1);
        if sides.0 >= MAX_SIDE / 16 || sides.1 >= MAX_SIDE / 16 {
            return Err(unsupported(format!("larger than {MAX_SIDE} pixels a side")));
        }
        let (width, height) = sps.pixel_dimensions().map_err(|error| unreadable(&format!("{error:?}")))?;
        let size = PictureSize::new(width, height);
        if size.area() == 0 {
            return Err(unreadable("the picture has no pixels"));
        }
        let colour = colour_of(sps.vui_parameters.as_ref(), size);
        let restrictions = sps.vui_parameters.as_ref().and_then(|vui| vui.bitstream_restrictions.as_ref());
        let reorders = restrictions.is_some_and(|restrictions| restrictions.max_num_reorder_frames > 0);
        Ok(Self { size, colour, reorders })
    }
}

fn check_supported(sps: &SeqParameterSet) -> Result<(), DecodeError> {
    let chroma = &sps.chroma_info;
    let depth = chroma.bit_depth_luma_minus8.max(chroma.bit_depth_chroma_minus8);
    if depth > 0 {
        return Err(unsupported(format!("{}-bit H.264", u32::from(depth) + 8)));
    }
    let format = match chroma.chroma_format {
        ChromaFormat::YUV420 => None,
        ChromaFormat::Monochrome => Some("H.264 without colour (4:0:0)"),
        ChromaFormat::YUV422 => Some("H.264 with 4:2:2 chroma"),
        ChromaFormat::YUV444 => Some("H.264 with 4:4:4 chroma"),
        ChromaFormat::Invalid(_) => Some("H.264 with an unknown chroma format"),
    };
    if let Some(format) = format {
        return Err(unsupported(format.to_owned()));
    }
    if sps.frame_mbs_flags != FrameMbsFlags::Frames {
        return Err(DecodeError::Unsupported {
            what: "interlaced H.264".to_owned(),
            remedy: "Set the camera to progressive (\"p\"), or convert the file: \
                     ffmpeg -i IN -vf yadif -c:v libx264 -pix_fmt yuv420p OUT.mp4"
                .to_owned(),
        });
    }
    Ok(())
}

fn unsupported(what: String) -> DecodeError {
    let remedy = "Set the camera to H.264 baseline or main profile (8 bit, 4:2:0), or convert the file: \
                  ffmpeg -i IN -c:v libx264 -pix_fmt yuv420p OUT.mp4";
    DecodeError::Unsupported { what, remedy: remedy.to_owned() }
}

/// Matrix and range from the usability information (annex E.2.1), else the customary ones for the size.
fn colour_of(vui: Option<&VuiParameters>, size: PictureSize) -> ColourEncoding {
    let assumed = ColourEncoding::assumed_for(size);
    let Some(signal) = vui.and_then(|vui| vui.video_signal_type.as_ref()) else { return assumed };
    let range = if signal.video_full_range_flag { SampleRange::Full } else { SampleRange::Limited };
    let matrix = match signal.colour_description.as_ref().map(|colour| colour.matrix_coefficients) {
        // BT.709. SMPTE 240M and BT.2020 are nearer to BT.709 than to BT.601.
        Some(1 | 7 | 9 | 10) => ColourMatrix::Bt709,
        // FCC, BT.470 B/G, SMPTE 170M: the weights of BT.601.
        Some(4..=6) => ColourMatrix::Bt601,
        _ => assumed.matrix,
    };
    ColourEncoding { matrix, range }
}
