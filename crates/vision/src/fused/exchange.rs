//! The stage that detects a track that stayed with another object of the target's colour.
//!
//! Input: the crop and the target. Output: the place of the target, if the followed object is not the target.
//! State: the objects around the target, and area, scale and proportions of the target before these objects
//! came near.

use barrelman_vocab::PixelBox;

use super::companion::Seen;
use super::companions::Companions;
use super::extent::Extent;
use super::target::Target;
use super::time_constant::rate_in;
use crate::components::{Component, ComponentFinder, MAX_COMPONENTS};
use crate::crop::Crop;
use crate::vector::{Vector, difference, sum};

/// Settings of the comparison with objects around the target. Settings without a figure were not measured
/// individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExchangeSettings {
    /// Minimum usual contrast of a target whose colour distinguishes objects, 0 to 1.
    min_contrast: f32,
    /// Minimum area of a component that consists of the target and another object, relative to the usual
    /// area.
    merged: f32,
    /// Time constant of the usual area, seconds.
    usual_area_s: f64,
    /// Size of the box, relative to the target's, in which components are parts of the target.
    own_box: f32,
    /// Minimum area of an object that is compared with the target, relative to the target's usual area.
    min_area: f32,
    /// The maximum of the same area.
    max_area: f32,
    /// Minimum time between two corrections, seconds.
    min_interval_s: f32,
}

impl Default for ExchangeSettings {
    fn default() -> Self {
        Self {
            min_contrast: 0.35,
            merged: 1.6,
            usual_area_s: 1.5,
            own_box: 1.15,
            min_area: 0.3,
            max_area: 4.0,
            min_interval_s: 1.5,
        }
    }
}

/// The target, where another object was followed in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ExchangedTarget {
    /// Centre of the target, pixels.
    pub(super) centre: Vector,
    /// Scale and proportions while no other object was near.
    pub(super) shape: Option<(f32, Extent)>,
}

/// The objects around a target, with the buffers.
#[derive(Debug, Default)]
pub(super) struct Exchange {
    settings: ExchangeSettings,
    /// Objects of the target's colour.
    components: ComponentFinder,
    companions: Companions,
    /// Usual area of the target's component, square pixels.
    usual_area: Option<f32>,
    /// Scale and proportions while no other object was near.
    clear_shape: Option<(f32, Extent)>,
    /// Time since the track was moved, seconds.
    since_exchange_s: f32,
}

/// The components that may be the target.
struct Others {
    seen: [Seen; MAX_COMPONENTS],
    areas: [f32; MAX_COMPONENTS],
    count: usize,
}

impl Exchange {
    /// Forgets the objects, since the track continues at another place.
    pub(super) fn restart(&mut self) {
        self.companions = Companions::default();
        (self.usual_area, self.clear_shape, self.since_exchange_s) = (None, None, 0.0);
    }

    /// Moves the predictions to the next frame, `seconds` after the last one. `size` is that of the target,
    /// pixels.
    pub(super) fn predict(&mut self, size: f32, seconds: f32) {
        self.companions.predict(size, seconds);
    }

    /// Whether an object touched the target recently, and it is not known which of the two is followed.
    pub(super) fn is_in_doubt(&self) -> bool {
        self.companions.are_in_doubt()
    }

    /// Follows the objects of the target's colour around the target, `seconds` after the last frame. Returns
    /// the target if one of these objects must be it. `has_paint`: whether the target has a paint of its own.
    pub(super) fn find(
        &mut self,
        crop: &Crop,
        target: &Target,
        has_paint: bool,
        seconds: f32,
    ) -> Option<ExchangedTarget> {
        let settings = self.settings;
        let geometry = &target.geometry;
        if !has_paint || target.appearance.usual.contrast < settings.min_contrast || geometry.touches_border()
        {
            return None;
        }
        let components = self.components.find(crop);
        let (w, h) = geometry.upright_box();
        let half = (0.5 * settings.own_box * w, 0.5 * settings.own_box * h);
        let own = own_component(components, box_around(geometry.centre, half))?;
        let Component { area, centroid: origin, chroma, .. } = components[own];
        let size = geometry.size_px();
        let clear_px = self.companions.clear_distance(size);
        let usual = self.usual_area.get_or_insert(area);
        let is_merged = area > settings.merged * *usual;
        if self.companions.nearest_distance() > clear_px {
            *usual += rate_in(f64::from(seconds), settings.usual_area_s) * (area - *usual);
        }
        if is_merged {
            return None;
        }
        let others = settings.others(components, own, *usual, geometry.centre, half);
        let view = crop.probabilities().bounds();
        let is_visible = |(du, dv): Vector| {
            (view.u..view.u + view.w).contains(&f64::from(origin.0 + du))
                && (view.v..view.v + view.h).contains(&f64::from(origin.1 + dv))
        };
        let seen = &others.seen[..others.count];
        let found = self.companions.measure(chroma, seen, size, seconds, is_visible);
        self.since_exchange_s += seconds;
        let found = found.filter(|_| self.since_exchange_s > settings.min_interval_s);
        let Some(index) = found else {
            if self.companions.nearest_distance() > clear_px {
                self.clear_shape = Some((geometry.scale, geometry.extent));
            }
            return None;
        };
        let place = seen[index].place;
        self.companions.exchange(place, size);
        (self.usual_area, self.since_exchange_s) = (Some(others.areas[index]), 0.0);
        Some(ExchangedTarget { centre: sum(origin, place), shape: self.clear_shape })
    }
}

impl ExchangeSettings {
    /// The components whose area is similar to the target's usual area, outside of the target's box with this
    /// centre and half sides, pixels.
    fn others(
        &self,
        components: &[Component],
        own: usize,
        usual_area: f32,
        (u, v): Vector,
        half: (f32, f32),
    ) -> Others {
        let mut others =
            Others { seen: [Seen::default(); MAX_COMPONENTS], areas: [0.0; MAX_COMPONENTS], count: 0 };
        let areas = self.min_area * usual_area..=self.max_area * usual_area;
        for (index, component) in components.iter().enumerate() {
            let (right, down) = (component.centroid.0 - u, component.centroid.1 - v);
            let is_outside = right.abs() > half.0 || down.abs() > half.1;
            if areas.contains(&component.area) && index != own && is_outside {
                let place = difference(component.centroid, components[own].centroid);
                others.seen[others.count] = Seen { place, chroma: component.chroma };
                others.areas[others.count] = component.area;
                others.count += 1;
            }
        }
        others
    }
}

/// The index of the component whose bounds overlap a box most.
fn own_component(components: &[Component], own_box: PixelBox) -> Option<usize> {
    let common = components.iter().map(|component| component.bounds.intersection(own_box).area()).enumerate();
    common.filter(|&(_, area)| area > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// The upright box with this centre and these half sides, pixels.
fn box_around((u, v): Vector, half: (f32, f32)) -> PixelBox {
    PixelBox {
        u: f64::from(u - half.0),
        v: f64::from(v - half.1),
        w: f64::from(2.0 * half.0),
        h: f64::from(2.0 * half.1),
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Picture;

    use super::super::test_target::{red_on_blue, selected};
    use super::*;

    const FRAME_S: f32 = 1.0 / 30.0;
    const BUOY: usize = 150;

    /// A boat of 16 x 8 pixels with its left edge here, and a buoy of 8 x 8 pixels, in one row.
    fn picture(boat: usize) -> Picture {
        let is_red = |column, row: usize| {
            (60..68).contains(&row)
                && ((boat..boat + 16).contains(&column) || (BUOY..BUOY + 8).contains(&column))
        };
        red_on_blue((320, 160), is_red)
    }

    /// The track's place, pixels, after the boat has passed the buoy. `followed`: the place that is followed
    /// for each place of the boat.
    fn track_after_passing(followed: impl Fn(f32) -> f32) -> f32 {
        let selection = PixelBox { u: 100.0, v: 60.0, w: 16.0, h: 8.0 };
        let (mut follower, _) = selected(picture(100), selection);
        let has_paint = follower.shape.blob.paint.is_some();
        assert!(has_paint);
        for boat in (100..190).flat_map(|boat| [boat, boat]) {
            let picture = picture(boat);
            let target = &mut follower.target;
            target.geometry.centre = (followed(boat as f32 + 8.0), 64.0);
            let observer = &mut follower.detector.observer;
            let pose = observer.patch_pose(target);
            observer.extract_crop(target, &picture, &pose);
            follower.exchange.predict(target.geometry.size_px(), FRAME_S);
            if let Some(found) = follower.exchange.find(&observer.crop, target, has_paint, FRAME_S) {
                return found.centre.0;
            }
        }
        follower.target.geometry.centre.0
    }

    #[test]
    fn a_track_that_stays_with_the_buoy_is_moved_onto_the_boat() {
        let buoy = BUOY as f32 + 4.0;
        let place = track_after_passing(|boat| boat.min(buoy));
        assert!(place > buoy + 12.0, "{place}");
    }

    #[test]
    fn a_track_that_stays_with_the_boat_is_left_alone() {
        assert_eq!(track_after_passing(|boat| boat), 197.0);
    }
}
