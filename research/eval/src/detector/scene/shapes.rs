//! Boats, people and other objects of random shapes and colours.

use barrelman_vocab::rng::SplitMix64;

use super::mesh::{Colour, Hull, Mesh};

/// What an object of a scene is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Person,
    Boat,
    /// Anything else that floats: it has no label.
    Other,
}

const WHITE: Colour = [0.80, 0.80, 0.78];
const DARK: Colour = [0.03, 0.03, 0.035];
const GREY: Colour = [0.30, 0.31, 0.32];
const WOOD: Colour = [0.30, 0.18, 0.08];
/// Colours of hulls, jackets and boards.
const VIVID: [Colour; 8] = [
    [0.62, 0.02, 0.03],
    [0.80, 0.22, 0.02],
    [0.80, 0.60, 0.04],
    [0.04, 0.10, 0.45],
    [0.03, 0.30, 0.10],
    [0.05, 0.35, 0.50],
    [0.70, 0.10, 0.35],
    [0.30, 0.70, 0.10],
];

fn pick<T: Copy, const N: usize>(rng: &mut SplitMix64, choices: [T; N]) -> T {
    choices[(rng.uniform() * N as f64) as usize % N]
}

fn chance(rng: &mut SplitMix64, share: f64) -> bool {
    rng.uniform() < share
}

fn tinted(rng: &mut SplitMix64, colour: Colour) -> Colour {
    let tone = rng.between(0.6, 1.2);
    colour.map(|channel| (channel * tone + rng.between(-0.03, 0.03)).clamp(0.005, 0.95))
}

fn vivid(rng: &mut SplitMix64) -> Colour {
    let colour = pick(rng, VIVID);
    tinted(rng, colour)
}

fn plain(rng: &mut SplitMix64) -> Colour {
    let colour = pick(rng, [WHITE, WHITE, DARK, GREY, WOOD]);
    tinted(rng, colour)
}

fn any_colour(rng: &mut SplitMix64) -> Colour {
    if chance(rng, 0.5) { vivid(rng) } else { plain(rng) }
}

fn skin(rng: &mut SplitMix64) -> Colour {
    let tone = rng.between(0.25, 1.3);
    [0.50 * tone, 0.29 * tone, 0.19 * tone]
}

fn clothes(rng: &mut SplitMix64) -> Colour {
    if chance(rng, 0.35) { tinted(rng, DARK) } else { any_colour(rng) }
}

fn head_colour(rng: &mut SplitMix64) -> Colour {
    if chance(rng, 0.7) { tinted(rng, [0.04, 0.03, 0.02]) } else { any_colour(rng) }
}

/// A boat.
pub(super) fn boat(rng: &mut SplitMix64) -> Mesh {
    match (rng.uniform() * 7.0) as u32 {
        0 | 1 => inflatable(rng),
        2 | 3 => motor_boat(rng),
        4 => sailing_boat(rng),
        5 => rowing_boat(rng),
        _ => ship(rng),
    }
}

/// A person: in the water, or on a board.
pub(super) fn person(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    match (rng.uniform() * 6.0) as u32 {
        0 | 1 => upright(rng, &mut mesh, 0.0),
        2 => lying(rng, &mut mesh, 0.02),
        3 => {
            board(rng, &mut mesh);
            lying(rng, &mut mesh, 0.12);
        }
        _ => {
            board(rng, &mut mesh);
            standing(rng, &mut mesh);
        }
    }
    mesh
}

/// Something that is neither: a ball, a log, a crate, a sheet of plastic.
pub(super) fn other(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let colour = any_colour(rng);
    match (rng.uniform() * 4.0) as u32 {
        0 => {
            let radius = rng.between(0.1, 0.6);
            mesh.ellipsoid(colour, [0.0, 0.0, 0.3 * radius], [radius; 3]);
        }
        1 => {
            let (length, radius) = (rng.between(0.5, 3.0), rng.between(0.05, 0.2));
            mesh.limb(tinted(rng, WOOD), [-length, 0.0, 0.0], [length, 0.0, 0.03], radius);
            mesh.cuboid(WOOD, WOOD, [-length, -radius, -0.1], [length, radius, 0.6 * radius]);
        }
        2 => {
            let (x, y, z) = (rng.between(0.2, 0.8), rng.between(0.2, 0.6), rng.between(0.1, 0.6));
            mesh.cuboid(colour, any_colour(rng), [-x, -y, -0.2], [x, y, z]);
        }
        _ => {
            let side = rng.between(0.2, 1.0);
            mesh.ellipsoid(colour, [0.0; 3], [side, rng.between(0.3, 1.0) * side, 0.04]);
        }
    }
    mesh
}

/// Foam around and behind an object of this length, flat on the water: a trail, and the two arms of a wake.
pub(super) fn foam(rng: &mut SplitMix64, length: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let (reach, spread) = (length * rng.between(0.5, 12.0), rng.between(0.05, 0.4));
    let (grain, arms) = (length * rng.between(0.03, 0.12), rng.between(0.0, 0.8));
    for _ in 0..(rng.between(30.0, 900.0)) as u32 {
        let behind = reach * rng.uniform() * rng.uniform();
        let width = 0.2 * length + spread * behind;
        let across = if chance(rng, arms) {
            width * rng.between(0.8, 1.0) * if chance(rng, 0.5) { 1.0 } else { -1.0 }
        } else {
            0.6 * width * rng.between(-1.0, 1.0)
        };
        let half = [grain * (0.3 + rng.uniform()), grain * (0.2 + 0.6 * rng.uniform())];
        mesh.disc(tinted(rng, WHITE), [0.4 * length - behind, across, -0.02], half);
    }
    mesh
}

/// A person who floats upright: head, shoulders, perhaps a life jacket and raised arms.
fn upright(rng: &mut SplitMix64, mesh: &mut Mesh, at: f64) {
    let (skin, shirt) = (skin(rng), clothes(rng));
    let rise = rng.between(-0.08, 0.16);
    mesh.ellipsoid(skin, [at + 0.02, 0.0, 0.24 + rise], [0.10, 0.085, 0.125]);
    mesh.ellipsoid(head_colour(rng), [at - 0.01, 0.0, 0.28 + rise], [0.105, 0.095, 0.105]);
    let girth = rng.between(0.9, 1.4);
    mesh.ellipsoid(shirt, [at - 0.02, 0.0, rise - 0.05], [0.14 * girth, 0.23 * girth, 0.20]);
    for side in [-1.0, 1.0] {
        if chance(rng, 0.7) {
            let lift = if chance(rng, 0.25) { rng.between(0.3, 0.7) } else { 0.02 };
            let hand = [at + rng.between(0.0, 0.5), side * rng.between(0.3, 0.6), lift];
            mesh.limb(skin, [at, side * 0.22, 0.05 + rise], hand, 0.05);
        }
    }
}

/// A person who lies at a height, arms and legs anyhow.
fn lying(rng: &mut SplitMix64, mesh: &mut Mesh, height: f64) {
    let (skin, shirt, trousers) = (skin(rng), clothes(rng), clothes(rng));
    mesh.ellipsoid(head_colour(rng), [0.48, 0.0, height + 0.08], [0.12, 0.09, 0.11]);
    mesh.ellipsoid(shirt, [0.12, 0.0, height + 0.03], [0.34, 0.20, 0.13]);
    for side in [-1.0, 1.0] {
        let hand = [rng.between(-0.2, 0.9), side * rng.between(0.3, 0.6), height];
        mesh.limb(skin, [0.32, side * 0.2, height + 0.03], hand, 0.05);
        let foot = [rng.between(-1.1, -0.8), side * rng.between(0.08, 0.4), height - rng.between(0.0, 0.1)];
        mesh.limb(if chance(rng, 0.5) { trousers } else { skin }, [-0.2, side * 0.1, height], foot, 0.075);
    }
}

fn standing(rng: &mut SplitMix64, mesh: &mut Mesh) {
    let (skin, shirt, trousers) = (skin(rng), clothes(rng), clothes(rng));
    // From kneeling to upright, leaning.
    let (tall, lean) = (rng.between(0.5, 1.0), rng.between(-0.45, 0.45));
    let hip = [0.0, 0.3 * lean, 0.12 + 0.8 * tall];
    let neck = [rng.between(-0.2, 0.2), lean, hip[2] + 0.52];
    for side in [-1.0, 1.0] {
        mesh.limb(trousers, hip, [side * rng.between(0.12, 0.45), 0.0, 0.12], 0.085);
        let reach = [neck[0] + rng.between(-0.6, 0.6), neck[1] + side * rng.between(0.1, 0.6), neck[2] - 0.2];
        mesh.limb(skin, [neck[0], neck[1] + side * 0.18, neck[2]], reach, 0.05);
    }
    mesh.limb(shirt, hip, neck, 0.17);
    mesh.ellipsoid(head_colour(rng), [neck[0], neck[1], neck[2] + 0.24], [0.10, 0.09, 0.13]);
}

fn board(rng: &mut SplitMix64, mesh: &mut Mesh) {
    let (half, width) = (rng.between(0.65, 1.6), rng.between(0.2, 0.4));
    mesh.ellipsoid(any_colour(rng), [0.0, 0.0, 0.06], [half, width, 0.06]);
}

/// People on board, of a boat of this length and breadth, the seats at a height.
fn crew(rng: &mut SplitMix64, mesh: &mut Mesh, [length, breadth, height]: [f64; 3], most: f64) {
    for _ in 0..(rng.uniform() * (most + 1.0)) as u32 {
        let at = [rng.between(-0.4, 0.3) * length, rng.between(-0.35, 0.35) * breadth];
        let shirt = clothes(rng);
        mesh.ellipsoid(shirt, [at[0], at[1], height + 0.35], [0.17, 0.24, 0.34]);
        mesh.ellipsoid(head_colour(rng), [at[0], at[1], height + 0.8], [0.10, 0.10, 0.13]);
    }
}

/// An inflatable: a thick tube around a lower floor, perhaps a console and an engine.
fn inflatable(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let length = rng.between(1.1, 6.5);
    let breadth = length * rng.between(0.28, 0.5);
    let tube = 0.13 * breadth + 0.05;
    let (colour, floor) = (any_colour(rng), plain(rng));
    let sharpness = rng.between(0.5, 1.0);
    let hull = Hull { length, breadth: 0.8 * breadth, freeboard: tube, sharpness, stern: 0.9 };
    hull.build(&mut mesh, [colour, colour, floor], 0.5);
    for side in [-1.0, 1.0] {
        let (stern, waist) =
            ([-0.5 * length, side * 0.4 * breadth, tube], [0.1 * length, side * 0.42 * breadth, tube]);
        mesh.limb(colour, stern, waist, tube);
        mesh.limb(colour, waist, [0.48 * length, side * (1.0 - sharpness) * 0.4 * breadth, 1.2 * tube], tube);
    }
    if chance(rng, 0.5) && length > 3.0 {
        mesh.cuboid(plain(rng), DARK, [-0.6, -0.35, 0.0], [0.1, 0.35, rng.between(0.7, 1.4)]);
    }
    if chance(rng, 0.6) {
        mesh.cuboid(
            DARK,
            GREY,
            [-0.5 * length - 0.3, -0.2, 0.0],
            [-0.5 * length + 0.1, 0.2, 0.25 + 0.1 * length],
        );
    }
    if length > 2.0 {
        crew(rng, &mut mesh, [length, breadth, 0.0], 8.0);
    }
    mesh
}

/// A motor boat with a cabin or a windscreen.
fn motor_boat(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let length = rng.between(4.0, 16.0);
    let breadth = length * rng.between(0.25, 0.4);
    let freeboard = 0.35 + 0.08 * length * rng.between(0.6, 1.2);
    let colours =
        [if chance(rng, 0.6) { tinted(rng, WHITE) } else { any_colour(rng) }, any_colour(rng), plain(rng)];
    let hull =
        Hull { length, breadth, freeboard, sharpness: rng.between(0.6, 1.0), stern: rng.between(0.7, 1.0) };
    hull.build(&mut mesh, colours, rng.between(0.5, 1.0));
    let wall = if chance(rng, 0.7) { WHITE } else { plain(rng) };
    let (aft, fore) = (-rng.between(0.0, 0.4) * length, rng.between(0.0, 0.3) * length);
    let (half, top) = (0.36 * breadth, freeboard + rng.between(0.5, 2.2));
    if chance(rng, 0.75) {
        let sill = freeboard + 0.45 * (top - freeboard);
        mesh.cuboid(wall, wall, [aft, -half, 0.5 * freeboard], [fore, half, sill]);
        mesh.cuboid(DARK, wall, [aft, -half, sill], [fore, half, top - 0.1]);
        mesh.cuboid(wall, wall, [aft - 0.3, -1.1 * half, top - 0.1], [fore, 1.1 * half, top]);
    } else {
        mesh.sheet(
            GREY,
            &[
                [0.1, -half, freeboard],
                [0.1, half, freeboard],
                [-0.3, half, top - 0.2],
                [-0.3, -half, top - 0.2],
            ],
        );
    }
    crew(rng, &mut mesh, [length, breadth, 0.4 * freeboard], 4.0);
    mesh
}

fn sailing_boat(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let length = rng.between(2.3, 14.0);
    let breadth = length * rng.between(0.2, 0.33);
    let freeboard = 0.1 + 0.07 * length;
    let colours = [any_colour(rng), any_colour(rng), plain(rng)];
    Hull { length, breadth, freeboard, sharpness: 0.95, stern: 0.7 }.build(&mut mesh, colours, 0.9);
    let (mast, at) = (length * rng.between(1.0, 1.6), rng.between(0.0, 0.2) * length);
    mesh.limb(GREY, [at, 0.0, freeboard], [at, 0.0, mast], 0.02 * length);
    if chance(rng, 0.8) {
        let sail = if chance(rng, 0.6) { WHITE } else { vivid(rng) };
        let swing = rng.between(-0.3, 0.3) * length;
        let foot = freeboard + 0.08 * length;
        mesh.sheet(sail, &[[at, 0.0, mast], [at, 0.0, foot], [at - 0.5 * length, swing, foot]]);
        if chance(rng, 0.6) {
            let bow = [0.49 * length, 0.0, freeboard];
            mesh.sheet(sail, &[[at, 0.0, 0.85 * mast], bow, [at, 0.6 * swing, foot]]);
        }
    }
    crew(rng, &mut mesh, [length, breadth, 0.5 * freeboard], 3.0);
    mesh
}

/// A rowing boat, canoe or kayak.
fn rowing_boat(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let length = rng.between(2.5, 6.0);
    let breadth = rng.between(0.6, 1.6);
    let colours = [any_colour(rng), any_colour(rng), plain(rng)];
    let stern = rng.between(0.05, 0.8);
    Hull { length, breadth, freeboard: rng.between(0.2, 0.5), sharpness: 0.97, stern }.build(
        &mut mesh,
        colours,
        rng.between(0.2, 0.9),
    );
    crew(rng, &mut mesh, [length, 0.5 * breadth, 0.0], 3.0);
    if chance(rng, 0.5) {
        for side in [-1.0, 1.0] {
            mesh.limb(WOOD, [0.0, 0.0, 0.4], [0.3, side * rng.between(1.2, 2.2), 0.05], 0.04);
        }
    }
    mesh
}

/// A ship: cargo, ferry or cruise.
fn ship(rng: &mut SplitMix64) -> Mesh {
    let mut mesh = Mesh::default();
    let length = rng.between(15.0, 180.0);
    let breadth = length * rng.between(0.13, 0.26);
    let freeboard = length * rng.between(0.035, 0.09);
    let sides = if chance(rng, 0.4) { tinted(rng, WHITE) } else { any_colour(rng) };
    let colours = [sides, any_colour(rng), any_colour(rng)];
    let hull =
        Hull { length, breadth, freeboard, sharpness: rng.between(0.7, 0.98), stern: rng.between(0.7, 1.0) };
    hull.build(&mut mesh, colours, 0.95);
    let is_long = chance(rng, 0.5);
    let (mut aft, mut fore) = (-0.46, if is_long { 0.3 } else { rng.between(-0.36, -0.1) });
    let storey = freeboard * rng.between(0.35, 0.7);
    let mut base = 0.95 * freeboard;
    for _ in 0..1 + (rng.uniform() * 5.0) as u32 {
        let half = 0.45 * breadth;
        let (low, high) = ([aft * length, -half, base], [fore * length, half, base + 0.45 * storey]);
        mesh.cuboid(DARK, WHITE, low, high);
        let top = tinted(rng, WHITE);
        mesh.cuboid(WHITE, top, [low[0], -half, high[2]], [high[0], half, base + storey]);
        base += storey;
        aft += rng.between(0.0, 0.04);
        fore -= rng.between(0.0, 0.08);
        if fore - aft < 0.05 {
            break;
        }
    }
    if !is_long && chance(rng, 0.6) {
        for stack in 0..5 {
            let x = (-0.05 + 0.1 * f64::from(stack)) * length;
            let height = freeboard * rng.between(1.0, 2.0);
            mesh.cuboid(
                vivid(rng),
                any_colour(rng),
                [x, -0.4 * breadth, freeboard],
                [x + 0.08 * length, 0.4 * breadth, height],
            );
        }
    }
    mesh
}
