//! Connected components of the target's colour in a crop: the target, and other objects of its colour around
//! it.

use barrelman_vocab::PixelBox;

use crate::crop::Crop;
use crate::probability_view::ProbabilityView;

/// Target probability, 0 to 255, from which on a sample belongs to a component.
const MIN_PROBABILITY: u8 = 128;
/// Number of components that are kept: those with the most samples.
pub(crate) const MAX_COMPONENTS: usize = 12;

/// Samples of the target's colour that touch each other, also at a corner.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Component {
    /// Mean of the samples, weighted with the target probability, pixels of the picture.
    pub(crate) centroid: (f32, f32),
    /// Bounds, pixels of the picture.
    pub(crate) bounds: PixelBox,
    /// Area, pixels squared.
    pub(crate) area: f32,
    /// Chroma of its paint: U and V less those around the components, levels; the mean over its bounds and a
    /// sample around them, weighted with the distance from the chroma around.
    pub(crate) chroma: (f32, f32),
}

/// Finds components; keeps its buffers.
#[derive(Debug, Default)]
pub(crate) struct ComponentFinder {
    /// Whether a sample was visited.
    visited: Vec<bool>,
    /// Samples whose neighbours are not visited yet.
    pending: Vec<u32>,
    found: Vec<Component>,
}

impl ComponentFinder {
    /// The largest components in a crop, in the order of their first samples.
    pub(crate) fn find(&mut self, crop: &Crop) -> &[Component] {
        let map = crop.probabilities();
        let (width, height) = (map.width, map.height);
        // Room for the largest crop so far, so that one that is as large as an earlier one allocates nothing.
        let largest = crop.sample_capacity();
        self.visited.clear();
        self.visited.reserve(largest);
        self.visited.resize(width * height, false);
        self.pending.reserve(largest);
        self.found.clear();
        self.found.reserve(MAX_COMPONENTS);
        for first in 0..width * height {
            if self.visited[first] || map.values[first] < MIN_PROBABILITY {
                continue;
            }
            let component = self.fill(first, &map);
            if self.found.len() < MAX_COMPONENTS {
                self.found.push(component);
            } else if let Some(smallest) = self.found.iter_mut().min_by(|a, b| a.area.total_cmp(&b.area))
                && smallest.area < component.area
            {
                *smallest = component;
            }
        }
        let around = self.chroma_around(crop);
        for component in &mut self.found {
            component.chroma = paint_chroma(crop, component.bounds, around);
        }
        &self.found
    }

    /// Mean chroma of the samples that belong to no component.
    fn chroma_around(&self, crop: &Crop) -> (f32, f32) {
        let [u, v] = crop.chroma();
        let (mut sum, mut count) = ((0_u32, 0_u32), 0_u32);
        for ((&u, &v), _) in u.iter().zip(v).zip(&self.visited).filter(|(_, visited)| !**visited) {
            sum = (sum.0 + u32::from(u), sum.1 + u32::from(v));
            count += 1;
        }
        let count = count.max(1) as f32;
        (sum.0 as f32 / count, sum.1 as f32 / count)
    }

    /// The component that contains a sample.
    fn fill(&mut self, first: usize, map: &ProbabilityView<'_>) -> Component {
        let (width, height, unit) = (map.width, map.height, map.unit);
        let (mut sum, mut mass, mut count) = ((0.0_f32, 0.0_f32), 0.0_f32, 0_u32);
        let (mut begin, mut end) = ((usize::MAX, usize::MAX), (0, 0));
        self.visited[first] = true;
        self.pending.push(first as u32);
        while let Some(index) = self.pending.pop() {
            let (column, row) = (index as usize % width, index as usize / width);
            let weight = f32::from(map.values[index as usize]);
            sum = (sum.0 + weight * (column as f32 + 0.5), sum.1 + weight * (row as f32 + 0.5));
            (mass, count) = (mass + weight, count + 1);
            begin = (begin.0.min(column), begin.1.min(row));
            end = (end.0.max(column + 1), end.1.max(row + 1));
            for near_row in row.saturating_sub(1)..(row + 2).min(height) {
                for near_column in column.saturating_sub(1)..(column + 2).min(width) {
                    let near = near_row * width + near_column;
                    if !self.visited[near] && map.values[near] >= MIN_PROBABILITY {
                        self.visited[near] = true;
                        self.pending.push(near as u32);
                    }
                }
            }
        }
        Component {
            centroid: (map.left + unit * (sum.0 / mass), map.top + unit * (sum.1 / mass)),
            bounds: map.bounds_of(begin, end),
            area: unit * unit * count as f32,
            chroma: (0.0, 0.0),
        }
    }
}

/// Chroma of what lies within bounds, less that around it.
fn paint_chroma(crop: &Crop, bounds: PixelBox, around: (f32, f32)) -> (f32, f32) {
    let map = crop.probabilities();
    let [us, vs] = crop.chroma();
    // A cast turns negative numbers into 0.
    let sample = |at: f64, from: f32| (at - f64::from(from)) / f64::from(map.unit);
    let range = |begin: f64, length: f64, from: f32, samples: usize| {
        let begin = sample(begin, from);
        let end = begin + length / f64::from(map.unit);
        (begin - 1.0) as usize..((end + 1.0) as usize).min(samples)
    };
    let columns = range(bounds.u, bounds.w, map.left, map.width);
    let (mut sum, mut mass) = ((0.0, 0.0), f32::MIN_POSITIVE);
    for row in range(bounds.v, bounds.h, map.top, map.height) {
        for index in columns.clone().map(|column| row * map.width + column) {
            let (u, v) = (f32::from(us[index]) - around.0, f32::from(vs[index]) - around.1);
            let weight = libm::hypotf(u, v);
            sum = (sum.0 + weight * u, sum.1 + weight * v);
            mass += weight;
        }
    }
    (sum.0 / mass, sum.1 / mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour_model::{ColourModel, TargetEllipse, count_colours};
    use crate::test_picture::painted;

    #[test]
    fn things_of_the_colour_are_found_with_place_and_area() {
        let is_red = |column: usize, row: usize| {
            (40..60).contains(&column) && (40..50).contains(&row)
                || (80..84).contains(&column) && (44..48).contains(&row)
        };
        let picture = painted(
            (160, 120),
            |column, row| {
                if is_red(column, row) { [90, 90, 240] } else { [80, 190, 100] }
            },
        );
        let mut colours = ColourModel::default();
        let ellipse = TargetEllipse::inscribed_in((20.0, 10.0));
        count_colours(&picture, (50.0, 45.0), &ellipse, &mut colours.target, &mut colours.surroundings);
        colours.remember_selection();
        colours.update_table();
        let mut crop = Crop::default();
        crop.extract(&picture, &colours, (60.0, 50.0), 50.0, 1.0);
        let mut finder = ComponentFinder::default();
        let found = finder.find(&crop);
        let expected = [((50.0, 45.0), 200.0), ((82.0, 46.0), 16.0)];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (component, (centre, area)) in found.iter().zip(expected) {
            let (du, dv) = (component.centroid.0 - centre.0, component.centroid.1 - centre.1);
            assert!(du.abs() < 0.5 && dv.abs() < 0.5 && (component.area - area).abs() < 1.0, "{component:?}");
            let (u, v) = component.chroma;
            assert!((u + 100.0).abs() < 1.0 && (v - 140.0).abs() < 1.0, "{component:?}");
        }
        let right_part = PixelBox { u: 45.0, v: 40.0, w: 55.0, h: 60.0 };
        assert!((found[0].bounds.intersection(right_part).area() - 150.0).abs() < 1.0);
    }

    #[test]
    fn there_is_room_for_the_largest_crop_after_a_small_one() {
        let picture = painted((160, 120), |_, _| [80, 190, 100]);
        let mut crop = Crop::default();
        let mut samples_within = |reach| {
            crop.extract(&picture, &ColourModel::default(), (60.0, 50.0), reach, 1.0);
            crop.probabilities().values.len()
        };
        let (largest, few) = (samples_within(50.0), samples_within(10.0));
        assert!(few < largest);
        let mut finder = ComponentFinder::default();
        finder.find(&crop);
        assert!(finder.visited.capacity() >= largest && finder.pending.capacity() >= largest);
    }
}
