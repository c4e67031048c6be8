//! SVG path data of lines through many points, simplified without a visible difference.

use super::canvas::{Point, coordinate};

/// Largest distance of an omitted point from the line, units of paper.
const TOLERANCE: f64 = 0.3;

/// Path data of a line through points, interrupted at each `None`.
pub(super) fn through(points: impl IntoIterator<Item = Option<Point>>) -> String {
    let mut data = String::new();
    let mut segment: Vec<Point> = Vec::new();
    for point in points.into_iter().chain([None]) {
        match point {
            Some(point) => segment.push(point),
            None => {
                add_segment(&mut data, &segment);
                segment.clear();
            }
        }
    }
    data
}

fn add_segment(data: &mut String, segment: &[Point]) {
    for (index, (x, y)) in simplified(segment).into_iter().enumerate() {
        data.push(if index == 0 { 'M' } else { 'L' });
        data.push_str(&coordinate(x));
        data.push(' ');
        data.push_str(&coordinate(y));
    }
    // A line of no length is invisible: a single point becomes a short line.
    if segment.len() == 1 {
        data.push_str("h0.6");
    }
}

/// Path data of the polygon between corners.
pub(super) fn polygon(corners: &[Point]) -> String {
    let mut data = through(corners.iter().copied().map(Some));
    if !data.is_empty() {
        data.push('Z');
    }
    data
}

/// Path data of the area between a line and a level.
pub(super) fn area(points: &[Point], level: f64) -> String {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return String::new() };
    let mut data = through(points.iter().copied().map(Some));
    data.push_str(&format!("L{} {}", coordinate(last.0), coordinate(level)));
    data.push_str(&format!("L{} {}Z", coordinate(first.0), coordinate(level)));
    data
}

/// The points that represent a line within the tolerance (Douglas-Peucker).
fn simplified(segment: &[Point]) -> Vec<Point> {
    if segment.len() < 3 {
        return segment.to_vec();
    }
    let mut kept = vec![false; segment.len()];
    (kept[0], kept[segment.len() - 1]) = (true, true);
    let mut open = vec![(0, segment.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let farthest = (from + 1..to)
            .map(|index| (index, distance_to_segment(segment[index], segment[from], segment[to])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, off)) = farthest
            && off > TOLERANCE
        {
            kept[index] = true;
            open.extend([(from, index), (index, to)]);
        }
    }
    segment.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// Distance of a point from the line segment between two others.
fn distance_to_segment(point: Point, from: Point, to: Point) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length2 = dx * dx + dy * dy;
    let along = if length2 > 0.0 {
        (((point.0 - from.0) * dx + (point.1 - from.1) * dy) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    super::canvas::distance(point, (from.0 + along * dx, from.1 + along * dy))
}

#[cfg(test)]
mod tests {
    use super::{area, polygon, through};

    #[test]
    fn points_on_a_line_are_left_out_and_corners_kept() {
        let line = |points: &[(f64, f64)]| through(points.iter().copied().map(Some));
        assert_eq!(line(&[(0.0, 0.0), (1.0, 0.1), (2.0, 0.0)]), "M0 0L2 0");
        assert_eq!(line(&[(0.0, 0.0), (1.0, 5.0), (2.0, 0.0)]), "M0 0L1 5L2 0");
        assert_eq!(line(&[(0.0, 0.0), (9.0, 0.0), (1.0, 0.0)]), "M0 0L9 0L1 0");
        assert_eq!(line(&[(3.0, 4.0)]), "M3 4h0.6");
        assert_eq!(line(&[]), "");
        assert_eq!(through([Some((0.0, 0.0)), Some((1.0, 1.0)), None, Some((5.0, 5.0))]), "M0 0L1 1M5 5h0.6");
    }

    #[test]
    fn a_polygon_is_closed() {
        assert_eq!(polygon(&[(0.0, 5.0), (2.0, 1.0), (4.0, 5.0)]), "M0 5L2 1L4 5Z");
        assert_eq!(polygon(&[]), "");
    }

    #[test]
    fn an_area_comes_back_along_its_level() {
        assert_eq!(area(&[(0.0, 5.0), (2.0, 1.0), (4.0, 5.0)], 6.0), "M0 5L2 1L4 5L4 6L0 6Z");
        assert_eq!(area(&[], 6.0), "");
    }
}
