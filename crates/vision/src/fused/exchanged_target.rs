//! The correction of a track that stayed with another thing of the target's colour.

use barrelman_vocab::{Picture, PixelBox};

use super::companions::{CLEAR_SIZES, Seen, own_component};
use super::config::FusedConfig;
use super::shape_following::rate_in;
use super::target::Target;
use super::vector::{difference, sum};
use super::workspace::Workspace;
use crate::components::MAX_COMPONENTS;

/// Minimum usual contrast of a target whose colour tells things apart.
const MIN_CONTRAST: f32 = 0.35;
/// A component that is larger than usual by this factor is the target and another thing.
const MERGED: f32 = 1.6;
/// Time constant of the usual area, seconds.
const USUAL_AREA_S: f64 = 1.5;
/// A component with its middle within this factor of the box is a part of the target.
const OWN_BOX: f32 = 1.15;
/// Area of a thing that is compared with the target, as a share of the target's usual area.
const MIN_AREA: f32 = 0.3;
const MAX_AREA: f32 = 4.0;
/// Shortest time between two corrections, seconds.
const MIN_INTERVAL_S: f32 = 1.5;

impl Workspace {
    /// Follows the things of the target's colour around it, `seconds` after the last frame. If one of them must be the target, the track
    /// moves onto it, and the filter is retrained. Whether it did.
    pub(super) fn correct_exchanged_target(
        &mut self,
        config: &FusedConfig,
        target: &mut Target,
        picture: &Picture,
        seconds: f32,
    ) -> bool {
        if target.paint.is_none()
            || target.appearance.usual.contrast < MIN_CONTRAST
            || target.geometry.touches_border()
        {
            return false;
        }
        let components = self.components.find(&self.crop);
        let geometry = &target.geometry;
        let ((u, v), (w, h)) = (geometry.centre, geometry.upright_box());
        let half = (0.5 * OWN_BOX * w, 0.5 * OWN_BOX * h);
        let own_box = PixelBox {
            u: f64::from(u - half.0),
            v: f64::from(v - half.1),
            w: f64::from(2.0 * half.0),
            h: f64::from(2.0 * half.1),
        };
        let Some(own) = own_component(components, own_box) else { return false };
        let area = components[own].area;
        let surroundings = &mut target.surroundings;
        let usual = surroundings.usual_area.get_or_insert(area);
        let is_merged = area > MERGED * *usual;
        if surroundings.companions.nearest_distance() > CLEAR_SIZES * geometry.size_px() {
            *usual += rate_in(f64::from(seconds), USUAL_AREA_S) * (area - *usual);
        }
        if is_merged {
            return false;
        }
        let origin = components[own].centroid;
        let mut others = [Seen::default(); MAX_COMPONENTS];
        let mut areas = [0.0; MAX_COMPONENTS];
        let mut count = 0;
        for (index, component) in components.iter().enumerate() {
            let (right, down) = (component.centroid.0 - u, component.centroid.1 - v);
            let is_like = (MIN_AREA * *usual..=MAX_AREA * *usual).contains(&component.area);
            if is_like && index != own && (right.abs() > half.0 || down.abs() > half.1) {
                let place = difference(component.centroid, origin);
                others[count] = Seen { place, chroma: component.chroma };
                areas[count] = component.area;
                count += 1;
            }
        }
        let size = geometry.size_px();
        let view = self.crop.probabilities().bounds();
        let is_visible = |(du, dv): (f32, f32)| {
            (view.u..view.u + view.w).contains(&f64::from(origin.0 + du))
                && (view.v..view.v + view.h).contains(&f64::from(origin.1 + dv))
        };
        let chroma = components[own].chroma;
        let found = surroundings.companions.measure(chroma, &others[..count], size, seconds, is_visible);
        surroundings.since_exchange_s += seconds;
        let found = found.filter(|_| surroundings.since_exchange_s > MIN_INTERVAL_S);
        let Some(index) = found else {
            if surroundings.companions.nearest_distance() > CLEAR_SIZES * size {
                surroundings.clear_shape = Some((geometry.scale, geometry.extent));
            }
            return false;
        };
        let place = others[index].place;
        surroundings.companions.exchange(place, size);
        (surroundings.usual_area, surroundings.since_exchange_s) = (Some(areas[index]), 0.0);
        let geometry = &mut target.geometry;
        if let Some((scale, extent)) = surroundings.clear_shape {
            (geometry.scale, geometry.extent) = (scale, extent);
        }
        geometry.centre = sum(origin, place);
        geometry.offset = (0.0, 0.0);
        target.motion.restart_at(target.geometry.centre, f64::from(target.geometry.size_px()));
        target.heading.clear_path();
        target.blob = None;
        target.reported_edges = None;
        self.retrain_at_box(config, target, picture);
        true
    }
}

#[cfg(test)]
mod tests {
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

    /// Where the track is, pixels, after the boat passed the buoy, if it stays with what `followed` gives for the boat's place.
    fn track_after_passing(followed: impl Fn(f32) -> f32) -> f32 {
        let config = FusedConfig::default();
        let selection = PixelBox { u: 100.0, v: 60.0, w: 16.0, h: 8.0 };
        let (mut workspace, mut target, _) = selected(&config, picture(100), selection);
        assert!(target.paint.is_some());
        for boat in (100..190).flat_map(|boat| [boat, boat]) {
            let picture = picture(boat);
            target.geometry.centre = (followed(boat as f32 + 8.0), 64.0);
            let pose = target.patch_pose(&config);
            workspace.extract_crop(&target, &picture, &pose);
            target.surroundings.predict(target.geometry.size_px(), FRAME_S);
            if workspace.correct_exchanged_target(&config, &mut target, &picture, FRAME_S) {
                break;
            }
        }
        target.geometry.centre.0
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
