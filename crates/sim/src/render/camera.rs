//! The camera of one frame: a pose for each row, because a rolling shutter exposes the rows one after the
//! other.

use barrelman_vocab::{Angle, PixelPoint};

use crate::optics::Optics;
use crate::pose::{CameraAxes, CameraPose, WorldPoint};
use crate::snapshot::Snapshot;

/// Iterations that bring the row of a point and the pose of that row to agreement.
const ROUNDS: usize = 3;
/// The same for the vertices of a shape, starting from the row of the shape's middle.
const VERTEX_ROUNDS: usize = 2;
/// Newton steps for a vertex in single precision: exact within the picture, off by a thousandth of a pixel
/// far outside.
const STEPS: usize = 3;
/// Points less far ahead than this are not projected, metres.
const MIN_DEPTH_M: f32 = 0.05;

/// Position and axes of the camera for one row.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowPose {
    pub(super) position: WorldPoint,
    pub(super) axes: CameraAxes,
}

impl RowPose {
    fn from_pose(pose: &CameraPose) -> Self {
        Self { position: pose.position, axes: pose.axes() }
    }

    /// Right, down and ahead of the optical centre, metres.
    pub(super) fn camera_from_world(&self, position: WorldPoint) -> (f64, f64, f64) {
        let from = self.position.vector_to(position);
        (from.dot(self.axes.right), from.dot(self.axes.down), from.dot(self.axes.ahead))
    }
}

/// The same in single precision, relative to the middle row's position.
#[derive(Debug, Clone, Copy)]
struct SinglePrecisionPose {
    position: [f32; 3],
    right: [f32; 3],
    down: [f32; 3],
    ahead: [f32; 3],
}

impl SinglePrecisionPose {
    fn new(pose: &RowPose, middle: WorldPoint) -> Self {
        let single = |p: WorldPoint| [p.x as f32, p.y as f32, p.z as f32];
        Self {
            position: single(middle.vector_to(pose.position)),
            right: single(pose.axes.right),
            down: single(pose.axes.down),
            ahead: single(pose.axes.ahead),
        }
    }
}

/// The camera of one frame.
#[derive(Debug, Clone)]
pub(super) struct Camera {
    pub(super) optics: Optics,
    rows: Vec<RowPose>,
    near: Vec<SinglePrecisionPose>,
    still: bool,
}

impl Camera {
    pub(super) fn new(optics: Optics) -> Self {
        let height = optics.picture.height as usize;
        Self { optics, rows: Vec::with_capacity(height), near: Vec::with_capacity(height), still: true }
    }

    /// Takes the poses of a snapshot.
    pub(super) fn pose(&mut self, snapshot: &Snapshot) {
        let height = self.optics.picture.height as usize;
        self.rows.clear();
        self.still = snapshot.first_row == snapshot.last_row;
        if self.still {
            self.rows.resize(height, RowPose::from_pose(&snapshot.first_row));
        } else {
            let last = (height - 1).max(1) as f64;
            let pose = |row| between(&snapshot.first_row, &snapshot.last_row, row as f64 / last);
            self.rows.extend((0..height).map(|row| RowPose::from_pose(&pose(row))));
        }
        let middle = self.middle().position;
        self.near.clear();
        self.near.extend(self.rows.iter().map(|pose| SinglePrecisionPose::new(pose, middle)));
    }

    /// The pose of the middle row.
    pub(super) fn middle(&self) -> &RowPose {
        self.row(self.optics.picture.height as usize / 2)
    }

    /// The pose of a row.
    pub(super) fn row(&self, row: usize) -> &RowPose {
        &self.rows[row]
    }

    /// Projects a point; also returns its depth (m). `None` behind the camera.
    pub(super) fn project(&self, position: WorldPoint) -> Option<(PixelPoint, f64)> {
        let mut row = self.rows.len() / 2;
        let rounds = if self.still { 1 } else { ROUNDS };
        let mut seen = None;
        for _ in 0..rounds {
            let there = self.rows[row].camera_from_world(position);
            let point = self.optics.project(there)?;
            row = (point.v.max(0.0) as usize).min(self.rows.len() - 1);
            seen = Some((point, there.2));
        }
        seen
    }

    /// The row in which a point is seen, or the nearest row.
    pub(super) fn row_seeing(&self, position: WorldPoint) -> usize {
        let last = self.rows.len() - 1;
        self.project(position).map_or(last / 2, |(point, _)| (point.v.max(0.0) as usize).min(last))
    }

    /// Projects a vertex: pixel coordinates and 1 / depth. `None` behind the camera. `from` is its position
    /// relative to that of the middle row, metres; `row` is a row near its image.
    pub(super) fn project_vertex(&self, from: [f32; 3], mut row: usize) -> Option<(f32, f32, f32)> {
        let size = self.optics.picture;
        let (middle_u, middle_v) = (0.5 * size.width as f32, 0.5 * size.height as f32);
        let (focal, barrel) = (self.optics.focal_px as f32, self.optics.barrel as f32);
        let rounds = if self.still { 1 } else { VERTEX_ROUNDS };
        let mut seen = None;
        for _ in 0..rounds {
            let pose = &self.near[row];
            let p = [from[0] - pose.position[0], from[1] - pose.position[1], from[2] - pose.position[2]];
            let dot = |axis: &[f32; 3]| p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2];
            let ahead = dot(&pose.ahead);
            if ahead <= MIN_DEPTH_M {
                return None;
            }
            let nearness = 1.0 / ahead;
            let (x, y) = (dot(&pose.right) * nearness, dot(&pose.down) * nearness);
            // The projected radius is s times the pinhole radius, where s solves s + bend s^3 = 1.
            let bend = barrel * (x * x + y * y);
            let mut share = (1.0 + 2.0 * bend) / (1.0 + 3.0 * bend);
            for _ in 0..STEPS {
                let square = share * share;
                share -= (share + bend * square * share - 1.0) / (1.0 + 3.0 * bend * square);
            }
            let (u, v) = (middle_u + focal * x * share, middle_v + focal * y * share);
            row = (v.max(0.0) as usize).min(self.near.len() - 1);
            seen = Some((u, v, nearness));
        }
        seen
    }

    /// Whether nothing of a ball can be seen in the picture or within a margin around it, pixels.
    pub(super) fn is_outside_view(&self, centre: WorldPoint, radius_m: f64, margin: (i32, i32)) -> bool {
        let (right, down, ahead) = self.middle().camera_from_world(centre);
        if ahead < -radius_m {
            return true;
        }
        let size = self.optics.picture;
        let half = |pixels: u32, margin: i32| 0.5 * f64::from(pixels) + f64::from(margin);
        let (x, y) = (
            half(size.width, margin.0) / self.optics.focal_px,
            half(size.height, margin.1) / self.optics.focal_px,
        );
        let stretch = 1.0 + self.optics.barrel * (x * x + y * y);
        // The plane through the border, widened by the motion of the camera during the picture.
        let beyond = |aside: f64, edge: f64| {
            let tangent = edge * stretch + MAX_TURN_TANGENT;
            (libm::fabs(aside) - tangent * ahead) / libm::sqrt(1.0 + tangent * tangent)
                > radius_m + MAX_MOVE_M
        };
        beyond(right, x) || beyond(down, y)
    }
}

/// Upper bounds of the turn (as a tangent) and the motion (metres) of the camera from its middle row to any
/// other.
const MAX_TURN_TANGENT: f64 = 0.1;
const MAX_MOVE_M: f64 = 0.2;

fn between(first: &CameraPose, last: &CameraPose, part: f64) -> CameraPose {
    let mix = |a: f64, b: f64| a + part * (b - a);
    let turn = |a: Angle, b: Angle| Angle::from_radians(mix(a.radians(), b.radians()));
    CameraPose {
        position: WorldPoint {
            x: mix(first.position.x, last.position.x),
            y: mix(first.position.y, last.position.y),
            z: mix(first.position.z, last.position.z),
        },
        pan: turn(first.pan, last.pan),
        tilt: turn(first.tilt, last.tilt),
        roll: turn(first.roll, last.roll),
    }
}
