//! Decimation: a plane at a lower resolution, each sample the mean of a square cell of pixels.
//!
//! Integer arithmetic throughout, so the result is the same on every machine. Outside the picture the border
//! samples are replicated.

use barrelman_vocab::video::Plane;

use crate::simd::simd_kernel;

/// Maximum number of picture rows averaged into one output row.
const MAX_ROWS_PER_CELL: i32 = 4;

simd_kernel! {
/// Writes `size` (width, height) means over cells of `k` x `k` samples of a plane to `out`, rows tightly
/// packed. `corner` (left, top) is the first cell's corner, in samples of the plane; it may lie outside the
/// plane. `columns` is scratch space. A plane without samples gives zeros.
pub(crate) fn decimate(plane: Plane<'_>, corner: (i32, i32), k: i32, size: (usize, usize), columns: &mut Vec<u16>, out: &mut Vec<u8>) {
    let ((left, top), (width, height)) = (corner, size);
    out.clear();
    if plane.width == 0 || plane.height == 0 {
        out.resize(width * height, 0);
        return;
    }
    let (last_x, last_y) = (plane.width as i32 - 1, plane.height as i32 - 1);
    // Samples `first..last` of a plane's row are used; to the left and right, the border sample is
    // replicated.
    let whole = width as i32 * k;
    let (first, last) = (left.clamp(0, last_x), (left + whole).clamp(1, last_x + 1));
    let before = (first - left).clamp(0, whole) as usize;
    let count = (last - first).max(0).min(whole - before as i32) as usize;
    if k == 1 {
        for row in 0..height as i32 {
            let source = plane.row((top + row).clamp(0, last_y) as usize);
            let start = out.len();
            out.resize(start + before, source[first as usize]);
            out.extend_from_slice(&source[first as usize..first as usize + count]);
            let edge = source[(last - 1).max(0) as usize];
            out.resize(start + width, edge);
        }
        return;
    }
    // Of tall cells, only some evenly spaced rows are read: enough against aliasing, and it bounds the work.
    let lines = k.min(MAX_ROWS_PER_CELL);
    // The sum of a column fits into 16 bits, the sum of a cell into 32.
    let scale = (65_536 / (k * lines)) as u32;
    for row in 0..height as i32 {
        columns.clear();
        columns.resize(whole as usize, 0);
        for line in 0..lines {
            let source = plane.row((top + row * k + (2 * line + 1) * k / (2 * lines)).clamp(0, last_y) as usize);
            let middle = &mut columns[before..before + count];
            for (sum, &value) in middle.iter_mut().zip(&source[first as usize..first as usize + count]) {
                *sum += u16::from(value);
            }
        }
        if count > 0 {
            let (edge_left, edge_right) = (columns[before], columns[before + count - 1]);
            columns[..before].fill(edge_left);
            columns[before + count..].fill(edge_right);
        }
        match k {
            2 => means::<2>(columns, scale, out),
            3 => means::<3>(columns, scale, out),
            4 => means::<4>(columns, scale, out),
            5 => means::<5>(columns, scale, out),
            6 => means::<6>(columns, scale, out),
            _ => out.extend(columns.chunks_exact(k as usize).map(|cell| mean(cell, scale))),
        }
    }
}
}

#[inline(always)]
fn means<const K: usize>(columns: &[u16], scale: u32, out: &mut Vec<u8>) {
    let (cells, _) = columns.as_chunks::<K>();
    out.extend(cells.iter().map(|cell| mean(cell, scale)));
}

#[inline(always)]
fn mean(cell: &[u16], scale: u32) -> u8 {
    let sum: u32 = cell.iter().map(|&c| u32::from(c)).sum();
    ((sum * scale + 32_768) >> 16).min(255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_picture::picture;

    #[test]
    fn means_of_squares_are_means() {
        let picture = picture((64, 48), |column, row| (3 * column + row) as f32);
        let (mut columns, mut out) = (Vec::new(), Vec::new());
        for step in 1..=8 {
            decimate(picture.y(), (4, 3), step, (5, 4), &mut columns, &mut out);
            for (index, &sample) in out.iter().enumerate() {
                let (left, top) = (4 + step * (index % 5) as i32, 3 + step * (index / 5) as i32);
                let middle = 0.5 * (step as f32 - 1.0);
                let mean = 3.0 * (left as f32 + middle) + top as f32 + middle;
                // Of cells higher than four rows, four evenly spaced rows are read: at most half a row off.
                assert!((f32::from(sample) - mean).abs() <= 1.0, "{step} {index}: {sample}, not {mean}");
            }
        }
    }

    #[test]
    fn border_samples_are_replicated_outside_the_picture() {
        let picture = picture((20, 16), |column, row| if column == 0 || row == 15 { 200.0 } else { 50.0 });
        let (mut columns, mut out) = (Vec::new(), Vec::new());
        for step in [1, 2, 7] {
            decimate(picture.y(), (-2 * step, 2), step, (3, 1), &mut columns, &mut out);
            assert_eq!(out[..2], [200; 2]);
            decimate(picture.y(), (5, 300), step, (2, 2), &mut columns, &mut out);
            assert_eq!(out, [200; 4]);
            decimate(picture.y(), (300, -300), step, (2, 2), &mut columns, &mut out);
            assert_eq!(out, [50; 4]);
        }
    }
}
