//! Truths of simulated worlds, to and from their stored form.

use barrelman_vocab::{Angle, ImagePoint, Timestamp};

use crate::records::entry::RecordedTruth;
use crate::records::stored;
use crate::target_in_picture::TargetInPicture;

impl From<&RecordedTruth> for stored::WorldTruth {
    fn from(truth: &RecordedTruth) -> Self {
        Self {
            tick: truth.tick,
            at_ns: truth.at.as_nanos(),
            target_x_m: truth.target_m.0,
            target_y_m: truth.target_m.1,
            target_heading_rad: truth.target_heading.radians(),
            camera_x_m: truth.camera_m.0,
            camera_y_m: truth.camera_m.1,
            camera_z_m: truth.camera_m.2,
            camera_pan_rad: truth.camera_pan.radians(),
            camera_tilt_rad: truth.camera_tilt.radians(),
            image_x: truth.target_position.x,
            image_y: truth.target_position.y,
            in_picture: truth.in_picture,
            range_m: truth.range_m,
            target: truth.target.map(|target| stored::TargetInPicture {
                visible_share: target.visible_share,
                bounds: target.bounds.map(Into::into),
            }),
        }
    }
}

impl From<stored::WorldTruth> for RecordedTruth {
    fn from(truth: stored::WorldTruth) -> Self {
        Self {
            tick: truth.tick,
            at: Timestamp::from_nanos(truth.at_ns),
            target_m: (truth.target_x_m, truth.target_y_m),
            target_heading: Angle::from_radians(truth.target_heading_rad),
            camera_m: (truth.camera_x_m, truth.camera_y_m, truth.camera_z_m),
            camera_pan: Angle::from_radians(truth.camera_pan_rad),
            camera_tilt: Angle::from_radians(truth.camera_tilt_rad),
            target_position: ImagePoint { x: truth.image_x, y: truth.image_y },
            in_picture: truth.in_picture,
            range_m: truth.range_m,
            target: truth.target.map(|target| TargetInPicture {
                visible_share: target.visible_share,
                bounds: target.bounds.map(Into::into),
            }),
        }
    }
}
