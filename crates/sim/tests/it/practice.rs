//! The practice clip and its truth.

use barrelman_sim::practice::PracticeClip;
use barrelman_vocab::video::ColourEncoding;
use barrelman_vocab::{Picture, PictureSize};

const SIZE: PictureSize = PictureSize::new(320, 180);

fn rendered(clip: &PracticeClip, frame: u32) -> Picture {
    let mut picture = Picture::black(SIZE, ColourEncoding::JPEG);
    clip.render(frame, &mut picture);
    picture
}

#[test]
fn the_boat_crosses_all_four_sectors_and_comes_back_inside() {
    let clip = PracticeClip::new(SIZE, 1);
    let mut sectors = [0; 4];
    let mut inside = 0;
    for frame in 0..clip.frames() {
        let at = clip.truth(frame).centre;
        let (x, y) = (at.x / 96.0, at.y / 45.0);
        if x * x + y * y <= 1.0 {
            inside += 1;
        } else if at.x.abs() > at.y.abs() {
            sectors[usize::from(at.x > 0.0)] += 1;
        } else {
            sectors[2 + usize::from(at.y > 0.0)] += 1;
        }
    }
    assert!(inside > 200 && sectors.iter().all(|frames| *frames > 20), "{inside} {sectors:?}");
}

#[test]
fn the_truth_is_where_the_red_pixels_are() {
    let clip = PracticeClip::new(SIZE, 1);
    for frame in (0..clip.frames()).step_by(17) {
        let picture = rendered(&clip, frame);
        let (mut count, mut sum_u, mut sum_v) = (0.0, 0.0, 0.0);
        for row in 0..picture.v().height {
            for (column, red) in picture.v().row(row).iter().enumerate() {
                if *red > 160 {
                    count += 1.0;
                    sum_u += column as f64 * 2.0 + 1.0;
                    sum_v += row as f64 * 2.0 + 1.0;
                }
            }
        }
        let truth = clip.truth(frame).centre.in_pixels(SIZE);
        // The bow is drawn in, so the mean of the red pixels lies a little behind the hull's centre.
        let off = libm::hypot(sum_u / count - truth.u, sum_v / count - truth.v);
        assert!(count > 10.0 && off < 2.5, "frame {frame}: {count} red samples, {off:.2} px off");
    }
}

#[test]
fn the_same_seed_draws_the_same_bits() {
    let one = rendered(&PracticeClip::new(SIZE, 3), 100);
    assert_eq!(one, rendered(&PracticeClip::new(SIZE, 3), 100));
    assert_ne!(one, rendered(&PracticeClip::new(SIZE, 4), 100));
}
