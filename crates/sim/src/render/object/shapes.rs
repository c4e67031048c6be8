//! The meshes of all shapes; each is built once.

use super::super::mesh::{Mesh, Part, sin_cos_f32};

/// Half the length of the rescue boat, metres.
pub(crate) const HALF_LENGTH: f32 = 0.6;
/// Half its breadth.
const HALF_BREADTH: f32 = 0.185;

/// Breadth of the boat at a share of its length from the stern, as a share of its full breadth.
fn fullness(s: f32) -> f32 {
    let stern = ((s + 0.02) / 0.16).min(1.0);
    let stern = 0.80 + 0.20 * stern * (2.0 - stern);
    let towards_bow = ((s - 0.50) / 0.50).max(0.0);
    let bow = 1.0 - towards_bow * towards_bow * (0.55 + 0.45 * towards_bow);
    stern * bow.max(0.0).sqrt().min(1.0) * if s > 0.999 { 0.0 } else { 1.0 }
}

/// A point of a hull's cross-section (deck, bilge and keel) at share `s` of the length.
fn section(s: f32, k: usize, around: usize, breadth: f32, depth: f32) -> [f32; 3] {
    let (sin, cos) = sin_cos_f32(core::f64::consts::TAU * k as f64 / around as f64);
    // A superellipse: rounder than a box, fuller than an ellipse.
    let full = |v: f32| v.signum() * v.abs().sqrt() * (0.62 + 0.38 * v.abs().sqrt());
    let sheer = ((s - 0.45) / 0.55).max(0.0);
    let top = 0.145 + 0.055 * sheer * sheer;
    let bottom = -depth + (depth + 0.06) * sheer * sheer * sheer;
    let half = breadth * fullness(s);
    let (middle, height) = (0.5 * (top + bottom), 0.5 * (top - bottom));
    let rise = full(sin);
    // The sides lean in towards the deck.
    let lean = 1.0 - 0.16 * rise.max(0.0);
    [HALF_LENGTH * (2.0 * s - 1.0), half * full(cos) * lean, middle + height * rise]
}

fn hull(mesh: &mut Mesh, part: Part, breadth: f32) {
    const STATIONS: usize = 26;
    const AROUND: usize = 24;
    // Stations are closer together towards the bow, where the shape changes.
    let share = |ring: usize| {
        let x = ring as f32 / (STATIONS - 1) as f32;
        1.0 - (1.0 - x) * (1.0 - 0.35 * x)
    };
    mesh.skin(part, STATIONS, AROUND, |ring, k| section(share(ring), k, AROUND, breadth, 0.09));
    let transom: Vec<[f32; 3]> = (0..AROUND).map(|k| section(0.0, k, AROUND, breadth, 0.09)).collect();
    mesh.sheet(part, [-1.0, 0.0, 0.0], &transom);
}

/// The rescue boat: a red hull with a pointed bow, grab lines along its sides, handles, a jet, a mast with a
/// flag.
pub(crate) fn boat() -> Mesh {
    let mut mesh = Mesh::default();
    hull(&mut mesh, Part::Hull, HALF_BREADTH);
    for side in [-1.0_f32, 1.0] {
        // A line in five bights.
        let line: Vec<[f32; 3]> = (0..=40)
            .map(|i| {
                let s = 0.10 + 0.72 * i as f32 / 40.0;
                let bight = ((i % 8) as f32 / 8.0 - 0.5) * 2.0;
                let sag = 0.030 * (1.0 - bight * bight);
                let half = HALF_BREADTH * fullness(s);
                [HALF_LENGTH * (2.0 * s - 1.0), side * (half * 0.97 + 0.012 + 0.3 * sag), 0.105 - sag]
            })
            .collect();
        mesh.tube(Part::Black, 0.009, 5, &line);
        let handle: Vec<[f32; 3]> = (0..=8)
            .map(|i| {
                let (sin, cos) = sin_cos_f32(core::f64::consts::PI * i as f64 / 8.0);
                [-0.22 - 0.11 * cos, side * 0.105, 0.135 + 0.05 * sin]
            })
            .collect();
        mesh.tube(Part::Black, 0.010, 5, &handle);
    }
    // The fairing of the jet's intake on deck, and a hatch ring.
    mesh.ellipsoid(Part::Black, [-0.40, 0.0, 0.125], [0.15, 0.085, 0.055], 8);
    mesh.tube(Part::Nozzle, 0.048, 10, &[[-0.58, 0.0, 0.015], [-0.64, 0.0, 0.012], [-0.70, 0.0, 0.010]]);
    mesh.tube(Part::Mast, 0.008, 5, &[[-0.33, 0.0, 0.12], [-0.335, 0.0, 0.30], [-0.34, 0.0, 0.46]]);
    mesh.sheet(
        Part::Flag,
        [0.0, 1.0, 0.0],
        &[[-0.34, 0.0, 0.46], [-0.34, 0.0, 0.36], [-0.46, 0.015, 0.375], [-0.455, 0.02, 0.445]],
    );
    mesh
}

/// A craft in the boat's colour with another shape: no deck gear, a windscreen.
pub(crate) fn red_craft() -> Mesh {
    let mut mesh = Mesh::default();
    hull(&mut mesh, Part::PlainHull, 0.27);
    mesh.ellipsoid(Part::White, [-0.05, 0.0, 0.15], [0.16, 0.12, 0.12], 8);
    mesh
}

/// A buoy: a ball of 0.6 m with a collar, a stick and a lamp.
pub(crate) fn buoy() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ellipsoid(Part::Float, [0.0, 0.0, 0.13], [0.30, 0.30, 0.29], 11);
    mesh.tube(Part::Black, 0.035, 8, &[[0.0, 0.0, 0.38], [0.0, 0.0, 0.50], [0.0, 0.0, 0.62]]);
    mesh.ellipsoid(Part::Flag, [0.0, 0.0, 0.66], [0.065, 0.065, 0.065], 7);
    mesh
}

/// A life jacket: a thick horseshoe with tape, afloat.
pub(crate) fn life_jacket() -> Mesh {
    let mut mesh = Mesh::default();
    let points: Vec<[f32; 3]> = (0..=20)
        .map(|i| {
            let (sin, cos) = sin_cos_f32((-0.78 + 1.56 * i as f64 / 20.0) * core::f64::consts::PI);
            [0.20 * cos, 0.145 * sin, 0.035]
        })
        .collect();
    mesh.tube(Part::Jacket, 0.078, 10, &points);
    for end in [0, 20] {
        mesh.ellipsoid(Part::Jacket, points[end], [0.085, 0.08, 0.076], 7);
    }
    mesh.tube(Part::Black, 0.014, 5, &[[-0.10, -0.10, 0.07], [-0.11, 0.0, 0.06], [-0.10, 0.10, 0.07]]);
    mesh
}

/// A person upright in the water, arms out.
pub(crate) fn swimmer() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.ellipsoid(Part::Skin, [0.02, 0.0, 0.25], [0.10, 0.085, 0.125], 9);
    mesh.ellipsoid(Part::Hair, [-0.005, 0.0, 0.29], [0.105, 0.095, 0.105], 9);
    mesh.ellipsoid(Part::Shirt, [-0.02, 0.0, 0.0], [0.14, 0.23, 0.14], 10);
    for side in [-1.0_f32, 1.0] {
        let arm = |t: f32| [0.02 + 0.30 * t, side * (0.22 + 0.16 * t), 0.045 - 0.03 * t];
        mesh.tube(Part::Skin, 0.046, 8, &[arm(0.0), arm(0.35), arm(0.7), arm(1.0)]);
        mesh.ellipsoid(Part::Skin, arm(1.06), [0.06, 0.045, 0.035], 5);
    }
    mesh
}

/// A pier section of this length and breadth, its deck 1.2 m above the water.
pub(crate) fn pier(length: f32, breadth: f32, with_posts: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let half = 0.5 * breadth;
    mesh.cuboid(Part::Boards, [-0.5 * length, -half, 1.12], [0.5 * length, half, 1.2], 0.5);
    for side in [-1.0_f32, 1.0] {
        let y = side * (half - 0.06);
        mesh.cuboid(Part::Timber, [-0.5 * length, y - 0.07, 0.86], [0.5 * length, y + 0.07, 1.12], 0.5);
        if with_posts {
            let out = side * half;
            mesh.cuboid(Part::Timber, [-0.11, out - 0.11, -0.8], [0.11, out + 0.11, 1.75], 1.0);
        }
    }
    mesh
}

/// A hut with a roof, its floor 0.5 m over the water.
pub(crate) fn hut() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.cuboid(Part::Wall, [-2.4, -1.8, 0.3], [2.4, 1.8, 2.9], 1.2);
    for side in [-1.0_f32, 1.0] {
        let eaves = side * 2.15;
        mesh.sheet(
            Part::Roof,
            [0.0, side * 0.6, 0.8],
            &[[-2.8, eaves, 2.7], [2.8, eaves, 2.7], [2.8, 0.0, 4.3], [-2.8, 0.0, 4.3]],
        );
        let gable = side * 2.4;
        mesh.sheet(Part::Wall, [side, 0.0, 0.0], &[[gable, -1.8, 2.9], [gable, 1.8, 2.9], [gable, 0.0, 4.2]]);
    }
    mesh
}

/// A crate of signal colour on a beach.
pub(crate) fn crate_on_beach() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.cuboid(Part::Float, [-0.45, -0.3, 0.0], [0.45, 0.3, 0.7], 1.0);
    mesh
}

/// The red target of the laboratory: a low wagon of 0.3 m.
pub(crate) fn floor_target() -> Mesh {
    let mut mesh = Mesh::default();
    let rings = 8;
    mesh.skin(Part::FloorRed, rings, 16, |ring, k| {
        let (sin, cos) = sin_cos_f32(core::f64::consts::TAU * k as f64 / 16.0);
        let full = |v: f32| v.signum() * v.abs().sqrt();
        let level = [0.0, 0.03, 0.07, 0.10, 0.115, 0.12, 0.12, 0.12][ring];
        let inset = [1.0, 1.0, 0.99, 0.95, 0.88, 0.6, 0.3, 0.0][ring];
        [0.15 * inset * full(cos), 0.10 * inset * full(sin), level]
    });
    mesh
}

/// A disc of paint on the floor, 0.2 m across, a millimetre thick.
pub(crate) fn floor_mark() -> Mesh {
    let mut mesh = Mesh::default();
    let rim: Vec<[f32; 3]> = (0..20)
        .map(|k| {
            let (sin, cos) = sin_cos_f32(core::f64::consts::TAU * k as f64 / 20.0);
            [0.1 * cos, 0.1 * sin, 0.001]
        })
        .collect();
    mesh.sheet(Part::Mark, [0.0, 0.0, 1.0], &rim);
    mesh
}
