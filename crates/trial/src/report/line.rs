//! Lines through many points as SVG path data, with the points left out that nobody could see.

use super::canvas::{Place, coordinate};

/// A point may lie so far off the line that is drawn, in units of paper.
const OFF: f64 = 0.3;

/// Path data of a line through places; gaps (`None`) begin it anew.
pub(super) fn through(places: impl IntoIterator<Item = Option<Place>>) -> String {
    let mut data = String::new();
    let mut run: Vec<Place> = Vec::new();
    for place in places.into_iter().chain([None]) {
        match place {
            Some(place) => run.push(place),
            None => {
                add(&mut data, &run);
                run.clear();
            }
        }
    }
    data
}

fn add(data: &mut String, run: &[Place]) {
    for (index, (x, y)) in simplified(run).into_iter().enumerate() {
        data.push(if index == 0 { 'M' } else { 'L' });
        data.push_str(&coordinate(x));
        data.push(' ');
        data.push_str(&coordinate(y));
    }
    // A line to itself shows as nothing; a short one shows where a lone point was.
    if run.len() == 1 {
        data.push_str("h0.6");
    }
}

/// Path data of an area between a line and a level.
pub(super) fn area(places: &[Place], level: f64) -> String {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return String::new() };
    let mut data = through(places.iter().copied().map(Some));
    data.push_str(&format!("L{} {}", coordinate(last.0), coordinate(level)));
    data.push_str(&format!("L{} {}Z", coordinate(first.0), coordinate(level)));
    data
}

/// The points of a line that are needed (Douglas and Peucker).
fn simplified(run: &[Place]) -> Vec<Place> {
    if run.len() < 3 {
        return run.to_vec();
    }
    let mut kept = vec![false; run.len()];
    (kept[0], kept[run.len() - 1]) = (true, true);
    let mut open = vec![(0, run.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let farthest = (from + 1..to)
            .map(|index| (index, distance(run[index], run[from], run[to])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, off)) = farthest
            && off > OFF
        {
            kept[index] = true;
            open.extend([(from, index), (index, to)]);
        }
    }
    run.iter().zip(kept).filter(|(_, kept)| *kept).map(|(place, _)| *place).collect()
}

/// From a point to the stretch between two others.
fn distance(point: Place, from: Place, to: Place) -> f64 {
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
    use super::{area, through};

    #[test]
    fn points_on_a_line_are_left_out_and_corners_kept() {
        let line = |places: &[(f64, f64)]| through(places.iter().copied().map(Some));
        assert_eq!(line(&[(0.0, 0.0), (1.0, 0.1), (2.0, 0.0)]), "M0 0L2 0");
        assert_eq!(line(&[(0.0, 0.0), (1.0, 5.0), (2.0, 0.0)]), "M0 0L1 5L2 0");
        assert_eq!(line(&[(0.0, 0.0), (9.0, 0.0), (1.0, 0.0)]), "M0 0L9 0L1 0");
        assert_eq!(line(&[(3.0, 4.0)]), "M3 4h0.6");
        assert_eq!(line(&[]), "");
        assert_eq!(through([Some((0.0, 0.0)), Some((1.0, 1.0)), None, Some((5.0, 5.0))]), "M0 0L1 1M5 5h0.6");
    }

    #[test]
    fn an_area_comes_back_along_its_level() {
        assert_eq!(area(&[(0.0, 5.0), (2.0, 1.0), (4.0, 5.0)], 6.0), "M0 5L2 1L4 5L4 6L0 6Z");
        assert_eq!(area(&[], 6.0), "");
    }
}
