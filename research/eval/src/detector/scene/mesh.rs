//! Triangle meshes in the frame of reference of a body: x forward, y to the left, z up, metres, the origin in
//! the middle of the waterline.

use barrelman_sim::{BodyPose, WorldPoint};

/// A linear colour: red, green and blue.
pub(super) type Colour = [f64; 3];
type Point = [f64; 3];

/// Triangles, each of one colour.
#[derive(Debug, Clone, Default)]
pub(super) struct Mesh {
    pub(super) triangles: Vec<([Point; 3], Colour)>,
}

/// Points around an ellipsoid, and around a tube or hull.
const AROUND: usize = 12;

impl Mesh {
    /// A flat convex polygon.
    pub(super) fn sheet(&mut self, colour: Colour, corners: &[Point]) {
        for pair in corners.windows(2).skip(1) {
            self.triangles.push(([corners[0], pair[0], pair[1]], colour));
        }
    }

    /// A level ellipse about a centre, with these half axes.
    pub(super) fn disc(&mut self, colour: Colour, [x, y, z]: Point, [along, across]: [f64; 2]) {
        let corners: [Point; 8] = core::array::from_fn(|step| {
            let (sin, cos) = libm::sincos(core::f64::consts::TAU * step as f64 / 8.0);
            [x + along * cos, y + across * sin, z]
        });
        self.sheet(colour, &corners);
    }

    /// A box from its lower to its upper corner; its top may have a colour of its own.
    pub(super) fn cuboid(&mut self, sides: Colour, top: Colour, low: Point, high: Point) {
        let [x0, y0, z0] = low;
        let [x1, y1, z1] = high;
        let base = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        for index in 0..4 {
            let ([ax, ay], [bx, by]) = (base[index], base[(index + 1) % 4]);
            self.sheet(sides, &[[ax, ay, z0], [bx, by, z0], [bx, by, z1], [ax, ay, z1]]);
        }
        self.sheet(top, &base.map(|[x, y]| [x, y, z1]));
    }

    /// An ellipsoid about a centre, with these half axes.
    pub(super) fn ellipsoid(&mut self, colour: Colour, centre: Point, half: Point) {
        let rings = AROUND / 2;
        let at = |ring: usize, step: usize| {
            let (sin_p, cos_p) = libm::sincos(core::f64::consts::PI * ring as f64 / rings as f64);
            let (sin_a, cos_a) = libm::sincos(core::f64::consts::TAU * step as f64 / AROUND as f64);
            let unit = [sin_p * cos_a, sin_p * sin_a, cos_p];
            core::array::from_fn(|axis| centre[axis] + half[axis] * unit[axis])
        };
        for ring in 0..rings {
            for step in 0..AROUND {
                let corners =
                    [at(ring, step), at(ring + 1, step), at(ring + 1, step + 1), at(ring, step + 1)];
                self.sheet(colour, &corners);
            }
        }
    }

    /// A limb from one point to another.
    pub(super) fn limb(&mut self, colour: Colour, from: Point, to: Point, radius: f64) {
        let reach = (0..3).map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
        let steps = (reach / (0.6 * radius)).clamp(1.0, 24.0) as usize;
        for bead in 0..=steps {
            let part = bead as f64 / steps as f64;
            let centre = core::array::from_fn(|axis| from[axis] + part * (to[axis] - from[axis]));
            self.ellipsoid(colour, centre, [radius; 3]);
        }
    }

    /// Largest distance ahead or behind of the middle, twice.
    pub(super) fn length(&self) -> f64 {
        let reaches = self.triangles.iter().flat_map(|(corners, _)| corners).map(|corner| corner[0].abs());
        2.0 * reaches.fold(0.0, f64::max)
    }

    /// The mesh in the world.
    pub(super) fn placed(&self, pose: &BodyPose) -> Self {
        let (sh, ch) = libm::sincos(pose.heading.radians());
        let (sp, cp) = libm::sincos(pose.pitch.radians());
        let (sr, cr) = libm::sincos(pose.roll.radians());
        let forward = [ch * cp, sh * cp, sp];
        let (level, up) = ([-sh, ch, 0.0], [-sp * ch, -sp * sh, cp]);
        let left: Point = core::array::from_fn(|i| level[i] * cr + up[i] * sr);
        let up: Point = core::array::from_fn(|i| up[i] * cr - level[i] * sr);
        let WorldPoint { x, y, z } = pose.position;
        let to_world = |[a, b, c]: Point| -> Point {
            core::array::from_fn(|i| [x, y, z][i] + a * forward[i] + b * left[i] + c * up[i])
        };
        let triangles =
            self.triangles.iter().map(|(corners, colour)| (corners.map(to_world), *colour)).collect();
        Self { triangles }
    }
}

/// The shape of a hull, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hull {
    pub(super) length: f64,
    pub(super) breadth: f64,
    /// Height of the gunwale above the water.
    pub(super) freeboard: f64,
    /// 0: as broad at the bow as in the middle; 1: pointed.
    pub(super) sharpness: f64,
    /// Breadth of the stern, as a share.
    pub(super) stern: f64,
}

impl Hull {
    /// Half the breadth at a share of the length from the stern.
    fn half_breadth(&self, share: f64) -> f64 {
        let forward = ((share - 0.4) / 0.6).max(0.0);
        let aft = ((0.3 - share) / 0.3).max(0.0);
        let full = 1.0 - self.sharpness * forward * forward - (1.0 - self.stern) * aft;
        0.5 * self.breadth * full
    }

    /// Adds sides of one colour with a stripe below the gunwale, and a deck of another at a share of the
    /// freeboard.
    pub(super) fn build(&self, mesh: &mut Mesh, [sides, stripe, deck]: [Colour; 3], deck_share: f64) {
        const STATIONS: usize = 10;
        let rim = |station: usize, side: f64, height: f64| {
            let share = station as f64 / STATIONS as f64;
            let x = self.length * (share - 0.5);
            let sheer = 1.0 + 0.35 * share * share * self.sharpness;
            let flare = 0.85 + 0.15 * height;
            [x, side * self.half_breadth(share) * flare, self.freeboard * height * sheer]
        };
        for station in 0..STATIONS {
            for side in [-1.0, 1.0] {
                for (low, high, colour) in [(-0.3, 0.7, sides), (0.7, 1.0, stripe)] {
                    mesh.sheet(
                        colour,
                        &[
                            rim(station, side, low),
                            rim(station + 1, side, low),
                            rim(station + 1, side, high),
                            rim(station, side, high),
                        ],
                    );
                }
            }
            let [a, b] = [station, station + 1].map(|at| [-1.0, 1.0].map(|side| rim(at, side, deck_share)));
            mesh.sheet(deck, &[a[0], b[0], b[1], a[1]]);
        }
        for end in [0, STATIONS] {
            let corners =
                [rim(end, -1.0, -0.3), rim(end, 1.0, -0.3), rim(end, 1.0, 1.0), rim(end, -1.0, 1.0)];
            mesh.sheet(sides, &corners);
        }
    }
}
