//! A pool of pictures: a frame is copied once out of its decoder, into the memory of an earlier frame.
//!
//! The pool keeps a reference to each of its pictures. A picture without another reference is free. The pool
//! holds at most [`PicturePool::MAX_PICTURES`] pictures; while more frames are in use, the further ones get
//! memory of their own.

use std::sync::Arc;

use barrelman_vocab::image::PictureSize;
use barrelman_vocab::video::{ColourEncoding, Picture, Plane};

use barrelman_vocab::unit::Rotation;

/// A pool of pictures.
#[derive(Debug, Default)]
pub struct PicturePool {
    pictures: Vec<Arc<Picture>>,
}

impl PicturePool {
    /// Maximum number of pictures in the pool: one in the decoder, one waiting, some in recorder, overlay and
    /// console, those that the tracker keeps, and those that the pilot keeps for selections (1.5 s). The pool
    /// takes memory only for as many as were in use at once.
    pub const MAX_PICTURES: usize = 104;

    /// A picture of this size, filled by `fill`, which must write all samples of the three planes.
    ///
    /// # Errors
    /// The error of `fill`.
    pub fn fill<E>(
        &mut self,
        size: PictureSize,
        colour: ColourEncoding,
        fill: impl FnOnce(&mut Picture) -> Result<(), E>,
    ) -> Result<Arc<Picture>, E> {
        for shared in &mut self.pictures {
            if let Some(picture) = Arc::get_mut(shared) {
                picture.reshape(size, colour);
                fill(picture)?;
                return Ok(Arc::clone(shared));
            }
        }
        let mut picture = Picture::black(size, colour);
        fill(&mut picture)?;
        let shared = Arc::new(picture);
        if self.pictures.len() < Self::MAX_PICTURES {
            self.pictures.push(Arc::clone(&shared));
        }
        Ok(shared)
    }

    /// A copy of three planes, rotated for display.
    pub fn copy(
        &mut self,
        planes: [Plane<'_>; 3],
        colour: ColourEncoding,
        rotation: Rotation,
    ) -> Arc<Picture> {
        let stored = PictureSize::new(planes[0].width as u32, planes[0].height as u32);
        let filled =
            self.fill::<std::convert::Infallible>(rotation.displayed_size(stored), colour, |picture| {
                for (plane, samples) in planes.iter().zip(picture.planes_mut()) {
                    copy_plane(plane, rotation, samples);
                }
                Ok(())
            });
        match filled {
            Ok(picture) => picture,
            Err(never) => match never {},
        }
    }
}

/// Copies and rotates a plane into rows without padding.
fn copy_plane(plane: &Plane<'_>, rotation: Rotation, out: &mut [u8]) {
    let (width, height) = (plane.width, plane.height);
    match rotation {
        Rotation::None => {
            for (row, out) in out.chunks_exact_mut(width).enumerate() {
                out.copy_from_slice(plane.row(row));
            }
        }
        Rotation::Half => {
            for (row, out) in out.chunks_exact_mut(width).rev().enumerate() {
                out.copy_from_slice(plane.row(row));
                out.reverse();
            }
        }
        Rotation::Clockwise90 => copy_quarter_turn(plane, out, |row, column| (column, height - 1 - row)),
        Rotation::Clockwise270 => copy_quarter_turn(plane, out, |row, column| (width - 1 - column, row)),
    }
}

/// Copies a plane rotated by a quarter turn, in blocks that fit into the cache. `to` maps row and column to
/// those of the output, whose rows have the length of the plane's height.
fn copy_quarter_turn(plane: &Plane<'_>, out: &mut [u8], to: impl Fn(usize, usize) -> (usize, usize)) {
    const BLOCK: usize = 32;
    let stride = plane.height;
    for top in (0..plane.height).step_by(BLOCK) {
        for left in (0..plane.width).step_by(BLOCK) {
            for row in top..plane.height.min(top + BLOCK) {
                let samples = plane.row(row);
                for (column, sample) in samples.iter().enumerate().skip(left).take(BLOCK) {
                    let (out_row, out_column) = to(row, column);
                    out[out_row * stride + out_column] = *sample;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: PictureSize = PictureSize::new(3, 2);

    fn copied(rotation: Rotation) -> Arc<Picture> {
        let y = [1, 2, 3, 0, 4, 5, 6, 0];
        let u = [7, 8];
        let plane = |data, width, height, stride| Plane { data, width, height, stride };
        let planes = [plane(&y, 3, 2, 4), plane(&u, 2, 1, 2), plane(&u, 2, 1, 2)];
        PicturePool::default().copy(planes, ColourEncoding::JPEG, rotation)
    }

    fn check_rotation(rotation: Rotation, size: PictureSize, y: &[u8], u: &[u8]) {
        let picture = copied(rotation);
        assert_eq!((picture.size(), picture.y().data, picture.u().data), (size, y, u), "{rotation:?}");
    }

    #[test]
    fn planes_are_turned_clockwise() {
        check_rotation(Rotation::None, SIZE, &[1, 2, 3, 4, 5, 6], &[7, 8]);
        check_rotation(Rotation::Half, SIZE, &[6, 5, 4, 3, 2, 1], &[8, 7]);
        check_rotation(Rotation::Clockwise90, PictureSize::new(2, 3), &[4, 1, 5, 2, 6, 3], &[7, 8]);
        check_rotation(Rotation::Clockwise270, PictureSize::new(2, 3), &[3, 6, 2, 5, 1, 4], &[8, 7]);
    }

    fn black(pool: &mut PicturePool) -> Arc<Picture> {
        pool.fill::<()>(SIZE, ColourEncoding::JPEG, |_| Ok(())).unwrap()
    }

    #[test]
    fn a_picture_that_nobody_holds_is_used_again() {
        let mut pool = PicturePool::default();
        let first = Arc::as_ptr(&black(&mut pool));
        assert_eq!(Arc::as_ptr(&black(&mut pool)), first);
        let held = black(&mut pool);
        assert_ne!(Arc::as_ptr(&black(&mut pool)), Arc::as_ptr(&held));
    }

    #[test]
    fn the_pool_keeps_no_more_than_its_limit() {
        let mut pool = PicturePool::default();
        let held: Vec<_> = (0..PicturePool::MAX_PICTURES + 5).map(|_| black(&mut pool)).collect();
        assert_eq!(pool.pictures.len(), PicturePool::MAX_PICTURES);
        drop(held);
    }
}
