//! Deinterlacing without a delay: the rows of the top field stay, each row of the bottom field becomes the
//! mean of its neighbours.
//!
//! GStreamer's `deinterlace` holds back one picture, and looks at several. Half of the rows are lost here,
//! which a tracker bears better than a target with two outlines.

use crate::picture::FramePlane;

/// Appends the rows of an interlaced plane.
pub(super) fn keep_top_field(plane: &FramePlane<'_>, joined: &mut Vec<u8>) {
    for row in 0..plane.height {
        if row % 2 == 0 {
            joined.extend_from_slice(plane.row(row));
        } else if row + 1 < plane.height {
            let neighbours = plane.row(row - 1).iter().zip(plane.row(row + 1));
            joined.extend(neighbours.map(|(&above, &below)| u16::midpoint(above.into(), below.into()) as u8));
        } else {
            joined.extend_from_slice(plane.row(row - 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bottom_field_is_interpolated_from_the_top_field() {
        let plane = |data, height| FramePlane { data, width: 2, height, stride: 3 };
        let mut joined = Vec::new();
        keep_top_field(&plane(&[10, 20, 0, 99, 99, 0, 20, 31, 0, 99, 99], 4), &mut joined);
        assert_eq!(joined, [10, 20, 15, 25, 20, 31, 20, 31]);
        joined.clear();
        keep_top_field(&plane(&[1, 2], 1), &mut joined);
        assert_eq!(joined, [1, 2]);
    }
}
