//! Non-maximum suppression: of boxes of a class that overlap, that of the highest score stays.

use crate::{MAX_OBJECTS, Object};

/// Boxes that are compared with each other at most: those of the highest scores.
const MAX_COMPARED: usize = 512;

/// Keeps the objects, the highest score first, at most [`MAX_OBJECTS`].
pub(crate) fn suppress(objects: &mut Vec<Object>, largest_iou: f64) {
    objects.sort_by(|one, other| other.score.total_cmp(&one.score));
    objects.truncate(MAX_COMPARED);
    let mut kept: Vec<Object> = Vec::with_capacity(MAX_OBJECTS);
    for object in objects.iter() {
        if kept.len() == MAX_OBJECTS {
            break;
        }
        let is_same =
            |other: &Object| other.class == object.class && other.bounds.iou(object.bounds) > largest_iou;
        if !kept.iter().any(is_same) {
            kept.push(*object);
        }
    }
    *objects = kept;
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::PixelBox;

    use super::*;

    fn object(u: f64, class: usize, score: f32) -> Object {
        Object { bounds: PixelBox { u, v: 0.0, w: 10.0, h: 10.0 }, class, score }
    }

    #[test]
    fn the_best_of_overlapping_boxes_of_a_class_stays() {
        // IoU with the first box: 9/11, 1/3, 0.
        let mut objects = vec![
            object(1.0, 0, 0.8),
            object(0.0, 0, 0.9),
            object(1.0, 1, 0.7),
            object(5.0, 0, 0.6),
            object(50.0, 0, 0.95),
        ];
        suppress(&mut objects, 0.5);
        let expected = [object(50.0, 0, 0.95), object(0.0, 0, 0.9), object(1.0, 1, 0.7), object(5.0, 0, 0.6)];
        assert_eq!(objects, expected);
    }

    #[test]
    fn the_number_of_objects_is_bounded() {
        let mut objects: Vec<_> = (0..5_000).map(|i| object(20.0 * f64::from(i), 0, 0.5)).collect();
        suppress(&mut objects, 0.5);
        assert_eq!(objects.len(), MAX_OBJECTS);
    }
}
