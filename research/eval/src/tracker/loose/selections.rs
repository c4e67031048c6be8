//! Loose selections: boxes that an operator drags in a hurry.
//!
//! Four sizes in eight directions. The centre lies beside the label's by 0.1 or 0.2 of the label's sides
//! along the direction: both amounts alternate from direction to direction and from size to size.

use barrelman_vocab::PixelBox;

/// Sides of the selections, as shares of the label's.
pub(super) const SIZES: [f64; 4] = [0.8, 1.0, 1.2, 1.4];

/// Directions, the first to the right, every 45 degrees.
const DIRECTIONS: usize = 8;

/// Distances of the centres, as shares of the label's sides.
const AMOUNTS: [f64; 2] = [0.1, 0.2];

/// The loose selections around a label.
pub(super) fn loose_selections(label: PixelBox) -> Vec<PixelBox> {
    let mut selections = Vec::with_capacity(SIZES.len() * DIRECTIONS);
    for (size_index, size) in SIZES.into_iter().enumerate() {
        for direction in 0..DIRECTIONS {
            let amount = AMOUNTS[(direction + size_index) % AMOUNTS.len()];
            let (sin, cos) = (direction as f64 * std::f64::consts::TAU / DIRECTIONS as f64).sin_cos();
            let centre = label.centre();
            let (w, h) = (label.w * size, label.h * size);
            selections.push(PixelBox {
                u: centre.u + amount * label.w * cos - w / 2.0,
                v: centre.v + amount * label.h * sin - h / 2.0,
                w,
                h,
            });
        }
    }
    selections
}

#[cfg(test)]
mod tests {
    use super::*;

    const LABEL: PixelBox = PixelBox { u: 100.0, v: 50.0, w: 40.0, h: 20.0 };

    /// The distance of the centre from the label's, as a share of the label's sides.
    fn amount(selection: PixelBox) -> f64 {
        let (a, b) = (selection.centre(), LABEL.centre());
        ((a.u - b.u) / LABEL.w).hypot((a.v - b.v) / LABEL.h)
    }

    #[test]
    fn thirty_two_selections_alternate_between_both_amounts() {
        let selections = loose_selections(LABEL);
        assert_eq!(selections.len(), 32);
        for (index, selection) in selections.iter().enumerate() {
            let expected = AMOUNTS[(index / DIRECTIONS + index % DIRECTIONS) % 2];
            assert!((amount(*selection) - expected).abs() < 1e-12, "{index}: {selection}");
        }
    }

    #[test]
    fn selections_keep_the_shape_of_the_label() {
        let selections = loose_selections(LABEL);
        assert_eq!((selections[0].w, selections[0].h), (32.0, 16.0));
        assert_eq!((selections[31].w, selections[31].h), (56.0, 28.0));
        // The first is 0.1 to the right.
        assert_eq!(selections[0].centre().u, 124.0);
    }
}
