//! Triangle meshes in the frame of reference of a body: x forward, y to the left, z up, metres, the origin in
//! the middle of the waterline. [`Part`] determines the paint of a triangle.

/// The part of an object that a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// A boat's hull with its deck.
    Hull,
    /// A distractor's hull.
    PlainHull,
    /// Black rubber and plastics.
    Black,
    /// Steering nozzle of a jet.
    Nozzle,
    /// White plastics.
    White,
    /// A flag of signal colour.
    Flag,
    /// A mast of black plastics.
    Mast,
    /// A buoy's body, in the colour of its seed.
    Float,
    /// Orange cloth of a life jacket, with reflecting tape.
    Jacket,
    /// Skin.
    Skin,
    /// Hair, or a cap.
    Hair,
    /// A swimmer's shirt, in the colour of its seed.
    Shirt,
    /// Boards of a pier.
    Boards,
    /// Posts and beams.
    Timber,
    /// A wall, in the colour of its seed.
    Wall,
    /// A roof.
    Roof,
    /// The red target of the laboratory.
    FloorRed,
    /// Paint on the floor.
    Mark,
}

impl Part {
    /// Whether the part rises from the body as something slender, which a box around the body leaves out.
    pub(super) fn is_rigging(self) -> bool {
        matches!(self, Self::Flag | Self::Mast)
    }

    /// Whether the part is a sheet without a back of its own.
    pub(super) fn is_seen_from_both_sides(self) -> bool {
        matches!(self, Self::Flag | Self::Roof | Self::Mark)
    }
}

/// A vertex with its normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) part: Part,
}

/// A triangle mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<Vertex>,
    pub(super) triangles: Vec<([u32; 3], Part)>,
    /// Largest distance of a vertex from the origin; [`Mesh::measured`] computes it.
    pub(super) radius_m: f32,
}

pub(super) fn normalised(v: [f32; 3]) -> [f32; 3] {
    let shorten = 1.0 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-9);
    [v[0] * shorten, v[1] * shorten, v[2] * shorten]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Sine and cosine in single precision.
pub(super) fn sin_cos_f32(radians: f64) -> (f32, f32) {
    let (sin, cos) = libm::sincos(radians);
    (sin as f32, cos as f32)
}

impl Mesh {
    /// The mesh with its radius computed.
    pub(super) fn measured(mut self) -> Self {
        let square = |p: [f32; 3]| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let max_square = self.vertices.iter().fold(0.0_f32, |max, vertex| max.max(square(vertex.position)));
        self.radius_m = max_square.sqrt();
        self
    }

    /// A surface over rings of `around` points each, given by `point(ring, k)`; closed around, open at its
    /// ends.
    pub(super) fn skin(
        &mut self,
        part: Part,
        rings: usize,
        around: usize,
        point: impl Fn(usize, usize) -> [f32; 3],
    ) {
        let first = self.vertices.len();
        for ring in 0..rings {
            for k in 0..around {
                let here = point(ring, k);
                let (before, after) = (point(ring, (k + around - 1) % around), point(ring, (k + 1) % around));
                let along = minus(point((ring + 1).min(rings - 1), k), point(ring.saturating_sub(1), k));
                let normal = normalised(cross(minus(after, before), along));
                self.vertices.push(Vertex { position: here, normal, part });
            }
        }
        for ring in 0..rings - 1 {
            for k in 0..around {
                let at = |ring: usize, k: usize| (first + ring * around + k % around) as u32;
                let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1));
                self.triangles.push(([a, b, c], part));
                self.triangles.push(([b, d, c], part));
            }
        }
    }

    /// An ellipsoid about a centre.
    pub(super) fn ellipsoid(&mut self, part: Part, centre: [f32; 3], half: [f32; 3], rings: usize) {
        let around = 2 * rings;
        let first = self.vertices.len();
        let unit = |ring: usize, k: usize| {
            let (sin_p, cos_p) = sin_cos_f32(core::f64::consts::PI * ring as f64 / rings as f64);
            let (sin_a, cos_a) = sin_cos_f32(core::f64::consts::TAU * k as f64 / around as f64);
            [sin_p * cos_a, sin_p * sin_a, cos_p]
        };
        for ring in 0..=rings {
            for k in 0..around {
                let n = unit(ring, k);
                self.vertices.push(Vertex {
                    position: [
                        centre[0] + half[0] * n[0],
                        centre[1] + half[1] * n[1],
                        centre[2] + half[2] * n[2],
                    ],
                    normal: normalised([n[0] / half[0], n[1] / half[1], n[2] / half[2]]),
                    part,
                });
            }
        }
        for ring in 0..rings {
            for k in 0..around {
                let at = |ring: usize, k: usize| (first + ring * around + k % around) as u32;
                self.triangles.push(([at(ring, k), at(ring + 1, k), at(ring, k + 1)], part));
                self.triangles.push(([at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)], part));
            }
        }
    }

    /// A tube of constant radius (m) through points, its ends open.
    pub(super) fn tube(&mut self, part: Part, radius: f32, sides: usize, points: &[[f32; 3]]) {
        self.skin(part, points.len(), sides, |ring, k| {
            let (before, after) = (points[ring.saturating_sub(1)], points[(ring + 1).min(points.len() - 1)]);
            let along = normalised(minus(after, before));
            let helper = if along[2].abs() > 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
            let side = normalised(cross(helper, along));
            let up = cross(along, side);
            let (sin, cos) = sin_cos_f32(core::f64::consts::TAU * k as f64 / sides as f64);
            let at = points[ring];
            core::array::from_fn(|i| at[i] + radius * (cos * side[i] + sin * up[i]))
        });
    }

    /// A box from its lower to its upper corner, divided along x into pieces of about `piece` metres, so that
    /// a lens can bend it.
    pub(super) fn cuboid(&mut self, part: Part, low: [f32; 3], high: [f32; 3], piece: f32) {
        let count = ((high[0] - low[0]) / piece).max(1.0) as usize;
        for index in 0..count {
            let share = |i: usize| low[0] + (high[0] - low[0]) * i as f32 / count as f32;
            self.plain_cuboid(part, [share(index), low[1], low[2]], [share(index + 1), high[1], high[2]]);
        }
    }

    fn plain_cuboid(&mut self, part: Part, low: [f32; 3], high: [f32; 3]) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for (level, sign) in [(low[axis], -1.0), (high[axis], 1.0)] {
                let first = self.vertices.len() as u32;
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                for (a, b) in [(low[u], low[v]), (high[u], low[v]), (high[u], high[v]), (low[u], high[v])] {
                    let mut position = [0.0; 3];
                    (position[axis], position[u], position[v]) = (level, a, b);
                    self.vertices.push(Vertex { position, normal, part });
                }
                self.triangles.push(([first, first + 1, first + 2], part));
                self.triangles.push(([first, first + 2, first + 3], part));
            }
        }
    }

    /// A flat polygon, seen from both sides, as a fan about its first corner.
    pub(super) fn sheet(&mut self, part: Part, normal: [f32; 3], corners: &[[f32; 3]]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners.iter().map(|&position| Vertex { position, normal, part }));
        for k in 1..corners.len() as u32 - 1 {
            self.triangles.push(([first, first + k, first + k + 1], part));
        }
    }
}
