//! Cost of one proposal in a 1280x720 picture, by the size of the object at the point. The live loop waits
//! for it: it must stay below 10 ms.

use barrelman_vision::{ObjectSizes, Proposer};
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize, PixelPoint};

const SIZE: PictureSize = PictureSize::new(1280, 720);

fn main() {
    divan::main();
}

/// An object of this width, half as high; 0: water alone.
#[divan::bench(args = [0, 12, 60, 300])]
fn proposal(bencher: divan::Bencher<'_, '_>, width: usize) {
    let picture = painted(width);
    let sizes = ObjectSizes::in_picture_of_height(SIZE.height);
    let at = PixelPoint { u: 640.0, v: 360.0 };
    let mut proposer = Proposer::default();
    let is_found = proposer.propose(&picture, at, sizes).is_ok();
    assert_eq!(is_found, width > 0, "the proposal is not the one to be measured");
    bencher.bench_local(|| proposer.propose(divan::black_box(&picture), at, sizes));
}

/// Blue water with waves, and a red object in the middle.
fn painted(width: usize) -> Picture {
    let mut picture = Picture::black(SIZE, ColourEncoding::assumed_for(SIZE));
    for (plane, (samples, step)) in picture.planes_mut().into_iter().zip([1, 2, 2]).enumerate() {
        let columns = SIZE.width as usize / step;
        for (index, sample) in samples.iter_mut().enumerate() {
            let (column, row) = (index % columns * step, index / columns * step);
            let is_object = 2 * column.abs_diff(640) < width && 4 * row.abs_diff(360) < width;
            let wave = libm::sin(column as f64 * 0.31 + libm::sin(row as f64 * 0.17) * 2.0);
            *sample = match (is_object, plane) {
                (true, _) => [80, 90, 220][plane],
                (false, 0) => (90.0 + 8.0 * wave) as u8,
                (false, _) => [90, 150, 112][plane],
            };
        }
    }
    picture
}
