//! Planar pictures.

use barrelman_vocab::unit::Rotation;
use barrelman_vocab::video::{ColourEncoding, ColourMatrix, SampleRange};
use barrelman_vocab::{Picture, PictureSize};

#[test]
fn chroma_planes_are_half_as_wide_and_high_rounded_up() {
    let check = |(width, height), (chroma_width, chroma_height), samples: usize| {
        let picture = Picture::black(PictureSize::new(width, height), ColourEncoding::JPEG);
        assert_eq!(picture.chroma_size(), PictureSize::new(chroma_width, chroma_height));
        assert_eq!(picture.samples().len(), samples);
        assert_eq!((picture.y().width, picture.y().height), (width as usize, height as usize));
        for plane in [picture.u(), picture.v()] {
            assert_eq!((plane.width, plane.height), (chroma_width as usize, chroma_height as usize));
            assert_eq!(plane.data.len(), plane.width * plane.height);
        }
    };
    check((4, 2), (2, 1), 12);
    check((5, 3), (3, 2), 27);
    check((1, 1), (1, 1), 3);
    check((1, 4), (1, 2), 8);
    check((0, 0), (0, 0), 0);
    check((0, 3), (0, 2), 0);
}

#[test]
fn what_is_written_to_a_plane_is_read_from_it_and_no_other() {
    let mut picture = Picture::black(PictureSize::new(5, 3), ColourEncoding::JPEG);
    for (plane, value) in picture.planes_mut().into_iter().zip([1, 2, 3]) {
        plane.fill(value);
    }
    for (plane, value) in [picture.y(), picture.u(), picture.v()].into_iter().zip([1, 2, 3]) {
        for row in 0..plane.height {
            assert!(plane.row(row).iter().all(|sample| *sample == value));
            assert_eq!(plane.row(row).len(), plane.width);
        }
    }
    assert_eq!(picture.samples(), [[1; 15].as_slice(), &[2; 6], &[3; 6]].concat());
}

#[test]
fn black_is_what_the_encoding_calls_black() {
    let check = |range, luma: u8| {
        let colour = ColourEncoding { matrix: ColourMatrix::Bt709, range };
        let picture = Picture::black(PictureSize::new(3, 3), colour);
        assert!(picture.y().data.iter().all(|sample| *sample == luma));
        assert!(picture.u().data.iter().chain(picture.v().data).all(|sample| *sample == 128));
    };
    check(SampleRange::Limited, 16);
    check(SampleRange::Full, 0);
}

#[test]
fn a_picture_takes_another_shape_and_keeps_its_memory() {
    let mut picture = Picture::black(PictureSize::new(64, 48), ColourEncoding::JPEG);
    let memory = picture.samples().as_ptr();
    picture.reshape(PictureSize::new(5, 3), ColourEncoding::assumed_for(PictureSize::new(5, 3)));
    assert_eq!((picture.size(), picture.samples().len()), (PictureSize::new(5, 3), 27));
    assert_eq!(picture.colour().range, SampleRange::Limited);
    picture.reshape(PictureSize::new(64, 48), ColourEncoding::JPEG);
    assert_eq!(picture.samples().as_ptr(), memory);
}

#[test]
fn a_video_that_does_not_say_is_taken_by_its_height() {
    let check = |height, matrix| {
        assert_eq!(ColourEncoding::assumed_for(PictureSize::new(1280, height)).matrix, matrix);
    };
    check(480, ColourMatrix::Bt601);
    check(719, ColourMatrix::Bt601);
    check(720, ColourMatrix::Bt709);
    check(2160, ColourMatrix::Bt709);
}

#[test]
fn a_quarter_turn_swaps_width_and_height() {
    let check = |rotation: Rotation, (width, height)| {
        assert_eq!(rotation.displayed_size(PictureSize::new(640, 360)), PictureSize::new(width, height));
    };
    check(Rotation::None, (640, 360));
    check(Rotation::Clockwise90, (360, 640));
    check(Rotation::Half, (640, 360));
    check(Rotation::Clockwise270, (360, 640));
}
