//! The camera of one frame: a pose for each row, since a rolling shutter takes one row after the other.

use barrelman_vocab::{Angle, PixelPoint};

use crate::optics::Optics;
use crate::pose::{CameraAxes, CameraPose, WorldPoint};
use crate::snapshot::Snapshot;

/// Rounds in which the row of a thing and the pose of that row are brought to agree.
const ROUNDS: usize = 3;

/// One row's place and axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowPose {
    pub(super) place: WorldPoint,
    pub(super) axes: CameraAxes,
}

impl RowPose {
    fn of(pose: &CameraPose) -> Self {
        Self { place: pose.place, axes: pose.axes() }
    }

    /// To the right, down and ahead, metres.
    pub(super) fn in_camera(&self, place: WorldPoint) -> (f64, f64, f64) {
        let from = self.place.to(place);
        (from.dot(self.axes.right), from.dot(self.axes.down), from.dot(self.axes.ahead))
    }
}

/// The camera.
#[derive(Debug, Clone)]
pub(super) struct Camera {
    pub(super) optics: Optics,
    rows: Vec<RowPose>,
    still: bool,
}

impl Camera {
    pub(super) fn new(optics: Optics) -> Self {
        Self { optics, rows: Vec::with_capacity(optics.picture.height as usize), still: true }
    }

    /// Takes up the poses of a snapshot.
    pub(super) fn pose(&mut self, snapshot: &Snapshot) {
        let height = self.optics.picture.height as usize;
        self.rows.clear();
        self.still = snapshot.first_row == snapshot.last_row;
        if self.still {
            self.rows.resize(height, RowPose::of(&snapshot.first_row));
            return;
        }
        let last = (height - 1).max(1) as f64;
        self.rows
            .extend((0..height).map(|row| {
                RowPose::of(&between(&snapshot.first_row, &snapshot.last_row, row as f64 / last))
            }));
    }

    /// The pose of a row.
    pub(super) fn row(&self, row: usize) -> &RowPose {
        &self.rows[row]
    }

    /// Where a place is seen, and how far ahead of the optical centre it lies (m); `None` behind the camera.
    pub(super) fn seen(&self, place: WorldPoint) -> Option<(PixelPoint, f64)> {
        let mut row = self.rows.len() / 2;
        let rounds = if self.still { 1 } else { ROUNDS };
        let mut seen = None;
        for _ in 0..rounds {
            let there = self.rows[row].in_camera(place);
            let point = self.optics.seen_at(there)?;
            row = (point.v.max(0.0) as usize).min(self.rows.len() - 1);
            seen = Some((point, there.2));
        }
        seen
    }
}

fn between(first: &CameraPose, last: &CameraPose, part: f64) -> CameraPose {
    let mix = |a: f64, b: f64| a + part * (b - a);
    let turn = |a: Angle, b: Angle| Angle::from_radians(mix(a.radians(), b.radians()));
    CameraPose {
        place: WorldPoint {
            x: mix(first.place.x, last.place.x),
            y: mix(first.place.y, last.place.y),
            z: mix(first.place.z, last.place.z),
        },
        pan: turn(first.pan, last.pan),
        tilt: turn(first.tilt, last.tilt),
        roll: turn(first.roll, last.roll),
    }
}
