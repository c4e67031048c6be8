//! The boat's wake: the waves it raises and the foam its jet leaves, on a grid that moves with the boat.
//!
//! The elevation h (m) follows a damped wave equation, `h'' = c^2 laplace(h) - d h'`, at fixed steps of
//! [`STEP_TICKS`]; the boat raises the water at its bow and lowers it at its stern. One speed c stands for
//! all waves of the wake: the arms of the V lie right at the speeds of the trials, but the inner pattern of a
//! real wake is missing. Foam decays and spreads. The boat's position is interpolated between snapshots, so
//! that the wake does not depend on the frame rate.
//!
//! The grid is a torus: each cell of the world has a fixed slot. Slots of cells that leave the window are
//! cleared for those that enter it.

use barrelman_simd::{Simd, multiversion};

use super::chunk::{CHUNK, Chunk};
use super::nodes::Nodes;
use super::texture::ROUNDING;
use crate::snapshot::{Boat, Snapshot, Target};
use crate::tick::TICKS_PER_SECOND;

/// Slots along the side of the grid.
const SIDE: usize = 512;
const MASK: i64 = SIDE as i64 - 1;
/// Cells along the side of a block, and blocks along the grid's side.
const BLOCK: usize = 16;
const BLOCKS: usize = SIDE / BLOCK;
/// Side of a cell, metres.
const CELL_M: f64 = 0.075;
/// Ticks of a simulation step.
const STEP_TICKS: u64 = 4;
/// Snapshots more steps apart than this start a new wake.
const MAX_GAP_STEPS: u64 = 300;
/// Speed of the waves, m/s.
const WAVE_SPEED: f64 = 1.3;
/// Share of the motion lost in a step.
const DAMPING: f32 = 0.014;
/// Decay of foam in a step, from the number of steps to 1/e; and its diffusion.
const FOAM_DECAY: f32 = 1.0 / (3.0 * 30.0);
const FOAM_SPREAD: f32 = 0.012;
/// Slope of one step of a byte.
const SLOPE_STEP: f32 = 0.45 / 127.0;

/// The grid.
#[derive(Debug)]
pub(super) struct Wake {
    height: Vec<f32>,
    before: Vec<f32>,
    foam: Vec<f32>,
    foam_before: Vec<f32>,
    /// Slopes (two signed bytes), foam and air (a byte each).
    packed: Box<[u32; SIDE * SIDE]>,
    /// Blocks with anything in them, a bit each, row by row.
    occupied: [u32; BLOCKS],
    /// Cell at the lower corner of the window.
    window: Option<(i64, i64)>,
    last: Option<(u64, Boat)>,
    stepped: u64,
}

impl Wake {
    pub(super) fn new() -> Self {
        let zeros = || vec![0.0; SIDE * SIDE];
        let packed = vec![0_u32; SIDE * SIDE].into_boxed_slice();
        Self {
            height: zeros(),
            before: zeros(),
            foam: zeros(),
            foam_before: zeros(),
            packed: packed.try_into().unwrap_or_else(|_| Box::new([0; SIDE * SIDE])),
            occupied: [0; BLOCKS],
            window: None,
            last: None,
            stepped: 0,
        }
    }

    /// Advances to a snapshot.
    pub(super) fn advance_to(&mut self, simd: Simd, snapshot: &Snapshot) {
        let Target::Boat(boat) = snapshot.target else {
            self.reset();
            return;
        };
        let now = snapshot.tick / STEP_TICKS;
        let (from_tick, from) = match self.last {
            Some((tick, from)) if tick <= snapshot.tick && now - self.stepped <= MAX_GAP_STEPS => {
                (tick, from)
            }
            _ => {
                self.reset();
                self.stepped = now;
                (snapshot.tick, boat)
            }
        };
        let span = (snapshot.tick - from_tick).max(1) as f64;
        while self.stepped < now {
            self.stepped += 1;
            let tick = self.stepped * STEP_TICKS;
            let part = ((tick.saturating_sub(from_tick)) as f64 / span).min(1.0);
            let mix = |a: f64, b: f64| a + part * (b - a);
            let x = mix(from.pose.position.x, boat.pose.position.x);
            let y = mix(from.pose.position.y, boat.pose.position.y);
            self.step(simd, x, y, &boat);
        }
        self.last = Some((snapshot.tick, boat));
        pack(simd, &self.height, &self.foam, &mut self.packed, &mut self.occupied);
    }

    fn reset(&mut self) {
        if self.window.is_some() {
            for grid in [&mut self.height, &mut self.before, &mut self.foam] {
                grid.fill(0.0);
            }
        }
        (self.window, self.last) = (None, None);
    }

    fn step(&mut self, simd: Simd, x: f64, y: f64, boat: &Boat) {
        // The window extends farther behind the boat than ahead of it.
        let speed = libm::hypot(boat.velocity.0, boat.velocity.1);
        let back = 9.0 * (speed / 1.5).min(1.0) / speed.max(1e-6);
        let half = 0.5 * SIDE as f64;
        let corner = |at: f64, v: f64| libm::floor((at - back * v) / CELL_M - half) as i64;
        self.move_window(corner(x, boat.velocity.0), corner(y, boat.velocity.1));
        let courant = (WAVE_SPEED * STEP_TICKS as f64 / f64::from(TICKS_PER_SECOND) / CELL_M) as f32;
        step_heights(simd, courant * courant, &self.height, &mut self.before);
        core::mem::swap(&mut self.height, &mut self.before);
        step_foam(simd, &self.foam, &mut self.foam_before);
        core::mem::swap(&mut self.foam, &mut self.foam_before);
        self.apply_boat(x, y, boat, speed);
    }

    /// Adds the boat's effect in a step.
    fn apply_boat(&mut self, x: f64, y: f64, boat: &Boat, speed: f64) {
        let (sin, cos) = libm::sincos(boat.pose.heading.radians());
        let seconds = STEP_TICKS as f64 / f64::from(TICKS_PER_SECOND);
        let push = (speed * speed / (1.0 + 0.4 * speed) * 0.0020).min(0.007);
        self.splat(x + 0.45 * cos, y + 0.45 * sin, 0.16, |slot, weight| slot.0 += (push * weight) as f32);
        self.splat(x - 0.45 * cos, y - 0.45 * sin, 0.17, |slot, weight| slot.0 -= (push * weight) as f32);
        let jet = boat.thrust.abs().min(1.0);
        let foam = ((0.20 + 0.45 * jet) * (speed / 1.2).min(1.0) + 0.5 * jet) * 5.2 * seconds;
        self.splat(x - 0.80 * cos, y - 0.80 * sin, 0.13, |slot, weight| {
            slot.1 = (slot.1 + (foam * weight) as f32).min(1.15);
        });
        if speed > 0.8 {
            let spray = 0.7 * (speed - 0.8) * seconds;
            for side in [-1.0, 1.0] {
                let (bx, by) = (x + 0.30 * cos - 0.2 * side * sin, y + 0.30 * sin + 0.2 * side * cos);
                self.splat(bx, by, 0.09, |slot, weight| slot.1 = (slot.1 + (spray * weight) as f32).min(0.8));
            }
        }
    }

    /// Changes elevation and foam around a position, with Gaussian weights of this radius (m).
    fn splat(&mut self, x: f64, y: f64, radius: f64, act: impl Fn(&mut (f32, f32), f64)) {
        let reach = libm::ceil(2.5 * radius / CELL_M) as i64;
        let (cx, cy) = (libm::floor(x / CELL_M) as i64, libm::floor(y / CELL_M) as i64);
        for j in cy - reach..=cy + reach {
            for i in cx - reach..=cx + reach {
                let (dx, dy) = ((i as f64 + 0.5) * CELL_M - x, (j as f64 + 0.5) * CELL_M - y);
                let weight = libm::exp(-0.5 * (dx * dx + dy * dy) / (radius * radius));
                let at = ((j & MASK) * SIDE as i64 + (i & MASK)) as usize;
                let mut slot = (self.height[at], self.foam[at]);
                act(&mut slot, weight);
                (self.height[at], self.foam[at]) = slot;
            }
        }
    }

    fn move_window(&mut self, x: i64, y: i64) {
        let Some((ox, oy)) = self.window.replace((x, y)) else { return };
        let entered = |old: i64, new: i64| {
            let far = (new - old).abs() >= SIDE as i64;
            if far {
                new..new + SIDE as i64
            } else if new > old {
                old + SIDE as i64..new + SIDE as i64
            } else {
                new..old
            }
        };
        // One more cell stays empty, so that waves do not cross the seam of the torus.
        for column in entered(ox, x).chain([x]) {
            for row in 0..SIDE {
                self.clear(row * SIDE + (column & MASK) as usize);
            }
        }
        for row in entered(oy, y).chain([y]) {
            let start = (row & MASK) as usize * SIDE;
            (start..start + SIDE).for_each(|at| self.clear(at));
        }
    }

    fn clear(&mut self, at: usize) {
        (self.height[at], self.before[at], self.foam[at]) = (0.0, 0.0, 0.0);
    }

    /// The wake relative to a camera above this position; `None` without wake.
    pub(super) fn lookup(&self, x: f64, y: f64) -> Option<WakeLookup<'_>> {
        let (left, low) = self.window?;
        let cells = |at: f64| at / CELL_M;
        let base = |at: f64| libm::floor(cells(at)) as i64;
        let slot = |at: f64| (base(at) & MASK) as f64 + (cells(at) - libm::floor(cells(at)));
        let from = |corner: i64, at: f64| ((corner as f64 + 2.0) * CELL_M - at) as f32;
        let reach = ((SIDE as f64 - 4.0) * CELL_M) as f32;
        Some(WakeLookup {
            packed: &self.packed,
            occupied: &self.occupied,
            origin: (slot(x) as f32, slot(y) as f32),
            low: (from(left, x), from(low, y)),
            high: (from(left, x) + reach, from(low, y) + reach),
        })
    }
}

multiversion! { simd;
    /// A step of the wave equation: `before` becomes the elevation after `height`.
    fn step_heights(simd: Simd, courant2: f32, height: &[f32], before: &mut [f32]) {
        update_cells(height, before, |here, laplace, before| {
            let moved = here + (1.0 - DAMPING) * (here - before) + courant2 * laplace;
            moved * 0.9985
        });
    }
}

multiversion! { simd;
    fn step_foam(simd: Simd, foam: &[f32], after: &mut [f32]) {
        update_cells(foam, after, |here, laplace, _| {
            let kept = here * (1.0 - FOAM_DECAY) + FOAM_SPREAD * laplace;
            // Foam below a thousandth is invisible; numbers must not become subnormal.
            if kept > 1e-3 { kept } else { 0.0 }
        });
    }
}

/// Updates all cells of a map that repeats in both directions. `update` gets the cell's value in `values`,
/// its Laplacian, and its value in `out`, and returns the new value in `out`.
#[inline(always)]
fn update_cells(values: &[f32], out: &mut [f32], update: impl Fn(f32, f32, f32) -> f32) {
    for row in 0..SIDE {
        let here = &values[row * SIDE..][..SIDE];
        let upper = &values[((row + SIDE - 1) % SIDE) * SIDE..][..SIDE];
        let lower = &values[((row + 1) % SIDE) * SIDE..][..SIDE];
        let out = &mut out[row * SIDE..][..SIDE];
        let mut update_cell = |left: usize, at: usize, right: usize| {
            let laplace = upper[at] + lower[at] + here[left] + here[right] - 4.0 * here[at];
            out[at] = update(here[at], laplace, out[at]);
        };
        update_cell(SIDE - 1, 0, 1);
        for at in 1..SIDE - 1 {
            update_cell(at - 1, at, at + 1);
        }
        update_cell(SIDE - 2, SIDE - 1, 0);
    }
}

multiversion! { simd;
    fn pack(
        simd: Simd,
        height: &[f32],
        foam: &[f32],
        packed: &mut [u32; SIDE * SIDE],
        occupied: &mut [u32; BLOCKS],
    ) {
        *occupied = [0; BLOCKS];
        let scale = 0.5 / (CELL_M as f32 * SLOPE_STEP);
        for row in 0..SIDE {
            let here = &height[row * SIDE..][..SIDE];
            let upper = &height[((row + SIDE - 1) % SIDE) * SIDE..][..SIDE];
            let lower = &height[((row + 1) % SIDE) * SIDE..][..SIDE];
            let foam = &foam[row * SIDE..][..SIDE];
            let out = &mut packed[row * SIDE..][..SIDE];
            for at in 1..SIDE - 1 {
                let sx = ((here[at + 1] - here[at - 1]) * scale).max(-127.0).min(127.0) + ROUNDING;
                let sy = ((lower[at] - upper[at]) * scale).max(-127.0).min(127.0) + ROUNDING;
                let white = (foam[at] * 200.0).min(255.0) + ROUNDING;
                out[at] = sx.to_bits() & 0xFF | (sy.to_bits() & 0xFF) << 8 | (white.to_bits() & 0xFF) << 16;
            }
            (out[0], out[SIDE - 1]) = (out[1], out[SIDE - 2]);
            let blocks = &mut occupied[row / BLOCK];
            for (block, cells) in out.chunks_exact(BLOCK).enumerate() {
                let any = cells.iter().fold(0, |any, cell| any | cell);
                *blocks |= u32::from(any != 0) << block;
            }
        }
    }
}

/// The wake, relative to a camera.
#[derive(Clone, Copy)]
pub(super) struct WakeLookup<'a> {
    packed: &'a [u32; SIDE * SIDE],
    occupied: &'a [u32; BLOCKS],
    /// Slot below the camera.
    origin: (f32, f32),
    /// Corners of the window, from below the camera, metres.
    low: (f32, f32),
    high: (f32, f32),
}

impl WakeLookup<'_> {
    /// Whether a chunk sees any of the wake, if relief moves its points by at most `moved` metres.
    pub(super) fn meets(&self, nodes: &Nodes, column: usize, moved: f32) -> bool {
        let wider = |(low, high): (f32, f32)| (low - moved, high + moved);
        let (x, y) = (wider(nodes.px.range(column)), wider(nodes.py.range(column)));
        let columns = blocks(x, (self.low.0, self.high.0), self.origin.0);
        let rows = blocks(y, (self.low.1, self.high.1), self.origin.1);
        let mask = columns.fold(0_u32, |mask, block| mask | 1 << (block as usize % BLOCKS));
        rows.map(|block| block as usize % BLOCKS).any(|block| self.occupied[block] & mask != 0)
    }
}

/// The blocks that look-ups from `low` to `high` metres may touch, within the window.
fn blocks((low, high): (f32, f32), window: (f32, f32), origin: f32) -> std::ops::Range<i32> {
    if high <= window.0 || low >= window.1 {
        return 0..0;
    }
    let slot = |at: f32| (origin + at / CELL_M as f32) as i32 + 2 * SIDE as i32;
    let (first, last) = (slot(low.max(window.0)) - 2, slot(high.min(window.1)) + 2);
    let (first, last) = (first / BLOCK as i32, last / BLOCK as i32);
    first..(last + 1).min(first + BLOCKS as i32)
}

multiversion! { simd;
    /// Adds slopes, foam and air of the wake.
    pub(super) fn add_wake(simd: Simd, lookup: &WakeLookup<'_>, chunk: &mut Chunk) {
        const PER_CELL: f32 = (1.0 / CELL_M) as f32;
        for i in 0..CHUNK {
            let (px, py) = (chunk.px[i], chunk.py[i]);
            let inside = px > lookup.low.0 && px < lookup.high.0 && py > lookup.low.1 && py < lookup.high.1;
            let (px, py) = if inside { (px, py) } else { (lookup.low.0, lookup.low.1) };
            let (u, v) = (lookup.origin.0 + px * PER_CELL, lookup.origin.1 + py * PER_CELL);
            let (mu, mv) = ((u - 1.0) + ROUNDING, (v - 1.0) + ROUNDING);
            let (fu, fv) = (u - 0.5 - (mu - ROUNDING), v - 0.5 - (mv - ROUNDING));
            const WRAP: u32 = SIDE as u32 - 1;
            let (iu, iv) = (mu.to_bits() & WRAP, mv.to_bits() & WRAP);
            let (ju, jv) = ((iu + 1) & WRAP, (iv + 1) & WRAP);
            let texel = |u: u32, v: u32| lookup.packed[(v * SIDE as u32 + u) as usize & (SIDE * SIDE - 1)];
            let four = [texel(iu, iv), texel(ju, iv), texel(iu, jv), texel(ju, jv)];
            let blend = |value: fn(u32) -> f32| {
                let (a, b, c, d) = (value(four[0]), value(four[1]), value(four[2]), value(four[3]));
                let (upper, lower) = (a + fu * (b - a), c + fu * (d - c));
                upper + fv * (lower - upper)
            };
            let wide = chunk.footprint[i] * (0.6 * PER_CELL);
            let seen = if inside { SLOPE_STEP / (1.0 + wide * wide) } else { 0.0 };
            chunk.sx[i] += seen * blend(|bits| ((bits << 24) as i32 >> 24) as f32);
            chunk.sy[i] += seen * blend(|bits| ((bits << 16) as i32 >> 24) as f32);
            let foam = blend(|bits| (bits >> 16 & 0xFF) as i32 as f32) * (1.0 / 200.0);
            let foam = if inside { foam } else { 0.0 };
            chunk.foam[i] = if foam > chunk.foam[i] { foam } else { chunk.foam[i] };
            chunk.air[i] = (foam * 0.75).min(0.8);
        }
    }
}
