//! The paint of objects: a function of part, position in the body's frame of reference, and seed. Detail is
//! as fine as the picture can show.

use barrelman_vocab::rng;

use super::super::light::Colour;
use super::super::mesh::Part;

/// Paint at a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    /// Albedo.
    pub(crate) albedo: Colour,
    /// Strength of highlights, 0 to 1.
    pub(crate) gloss: f32,
}

const RED: Colour = [0.62, 0.012, 0.022];
const DARK: Colour = [0.018, 0.018, 0.02];
const WHITE: Colour = [0.78, 0.78, 0.76];
const GREY: Colour = [0.30, 0.31, 0.32];
const ORANGE: Colour = [0.78, 0.20, 0.012];
const YELLOW: Colour = [0.80, 0.58, 0.02];

/// The seed of a yellow buoy.
pub(crate) const YELLOW_BUOY: u64 = 1;

/// A 5 x 5 font for the name on the deck: a row of bits for each row from the top.
const NAME: [[u8; 5]; 5] = [
    [0b11111, 0b10000, 0b11110, 0b10000, 0b11111],
    [0b10001, 0b11011, 0b10101, 0b10001, 0b10001],
    [0b01110, 0b00100, 0b00100, 0b00100, 0b01110],
    [0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
    [0b10001, 0b01010, 0b00100, 0b00100, 0b00100],
];

/// Whether the name covers a point of its panel: `u` along the letters, `v` down, both 0 to 1.
fn lettered(u: f32, v: f32) -> bool {
    if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
        return false;
    }
    let column = u * 29.0;
    let letter = (column / 6.0) as usize;
    let bit = (column - 6.0 * letter as f32) as usize;
    bit < 5 && letter < 5 && NAME[letter][(v * 5.0) as usize] >> (4 - bit) & 1 == 1
}

/// Smooth noise of the position, 0 to 1, with lumps of `size` metres.
fn mottle(position: [f32; 3], size: f32) -> f32 {
    let lump = |x: f32, y: f32, z: f32| {
        let key = |v: f32| (v as i32 as u32) as u64 & 0xFFFF;
        (rng::hash(7, key(x) << 32 | key(y) << 16 | key(z), 3) >> 40) as f32 / 16_777_216.0
    };
    let p = position.map(|v| v / size + 1_000.0);
    let base = p.map(|v| v as i32 as f32);
    let part: [f32; 3] = core::array::from_fn(|i| p[i] - base[i]);
    let edge = |dy: f32, dz: f32| {
        let (a, b) =
            (lump(base[0], base[1] + dy, base[2] + dz), lump(base[0] + 1.0, base[1] + dy, base[2] + dz));
        a + part[0] * (b - a)
    };
    let (near, far) = (edge(0.0, 0.0), edge(0.0, 1.0));
    let lower = near + part[1] * (edge(1.0, 0.0) - near);
    let upper = far + part[1] * (edge(1.0, 1.0) - far);
    lower + part[2] * (upper - lower)
}

fn dimmed(colour: Colour, factor: f32) -> Colour {
    colour.map(|channel| channel * factor)
}

/// The paint of a part at a position.
pub(crate) fn paint(part: Part, position: [f32; 3], normal: [f32; 3], seed: u64) -> Paint {
    let plain = |albedo: Colour, gloss: f32| Paint { albedo, gloss };
    match part {
        Part::Hull => boat_hull(position, normal),
        Part::PlainHull => {
            let rim = position[2] > 0.10 && normal[2] < 0.5;
            plain(if rim { WHITE } else { RED }, 0.5)
        }
        Part::Black | Part::Mast => plain(DARK, 0.35),
        Part::Nozzle => plain(if position[0] < -0.66 { GREY } else { DARK }, 0.5),
        Part::White => plain(WHITE, 0.6),
        Part::Flag => plain([0.85, 0.42, 0.01], 0.1),
        Part::Float => {
            let colours = [RED, YELLOW, ORANGE, [0.02, 0.28, 0.08]];
            let band = position[2] > 0.30 && position[2] < 0.36;
            let colour = if band { WHITE } else { colours[(seed % 4) as usize] };
            plain(dimmed(colour, 0.8 + 0.3 * mottle(position, 0.09)), 0.45)
        }
        Part::Jacket => {
            let taped = (position[0] - 0.02).abs() < 0.028;
            let creased = 0.72 + 0.45 * mottle(position, 0.05);
            plain(
                if taped { [0.75, 0.77, 0.78] } else { dimmed(ORANGE, creased) },
                if taped { 0.7 } else { 0.08 },
            )
        }
        Part::Skin => plain([0.50, 0.27, 0.17], 0.2),
        Part::Hair => plain([0.03, 0.02, 0.015], 0.25),
        Part::Shirt => {
            let colours = [[0.04, 0.07, 0.30], ORANGE, [0.10, 0.10, 0.11], [0.30, 0.03, 0.04]];
            plain(dimmed(colours[(seed % 4) as usize], 0.7 + 0.5 * mottle(position, 0.07)), 0.12)
        }
        Part::Boards => {
            let board = position[0] / 0.14 + 500.0;
            let gap = board - board as i32 as f32;
            let tone = 0.7 + 0.5 * mottle([board as i32 as f32 * 0.3, position[1] * 0.3, 0.0], 0.3);
            plain(dimmed([0.30, 0.25, 0.20], if gap < 0.08 { 0.25 } else { tone }), 0.05)
        }
        Part::Timber => plain(dimmed([0.10, 0.085, 0.07], 0.6 + 0.8 * mottle(position, 0.1)), 0.1),
        Part::Wall => {
            let colours = [[0.42, 0.05, 0.04], [0.55, 0.50, 0.42], [0.25, 0.32, 0.36]];
            let board = position[2] / 0.22;
            let seam = board - board as i32 as f32 > 0.9;
            let window = position[0].abs() % 1.7 < 0.45 && position[2] > 1.3 && position[2] < 2.2;
            let colour = if window { [0.05, 0.07, 0.09] } else { colours[(seed % 3) as usize] };
            plain(dimmed(colour, if seam { 0.7 } else { 1.0 }), 0.1)
        }
        Part::Roof => plain(dimmed([0.14, 0.09, 0.08], 0.7 + 0.6 * mottle(position, 0.25)), 0.1),
        Part::FloorRed => {
            let front = position[0] > 0.11;
            let plate = position[0].abs() < 0.05 && position[1].abs() < 0.04 && normal[2] > 0.8;
            plain(if front || plate { DARK } else { [0.60, 0.02, 0.03] }, 0.35)
        }
        Part::Mark => {
            let cross = position[0].abs() < 0.016 || position[1].abs() < 0.016;
            let colours = [[0.05, 0.10, 0.42], [0.03, 0.03, 0.035], [0.70, 0.62, 0.08]];
            plain(if cross { [0.7, 0.7, 0.7] } else { colours[(seed % 3) as usize] }, 0.1)
        }
    }
}

fn boat_hull([x, y, z]: [f32; 3], normal: [f32; 3]) -> Paint {
    let on_deck = normal[2] > 0.55 && z > 0.08;
    let across = y.abs();
    // Cloth over foam: seams across the hull, faint dirt.
    let seam = ((x + 2.0) * 5.0) % 1.0 < 0.035 && !on_deck;
    let red = || dimmed(RED, if seam { 0.55 } else { 0.86 + 0.22 * mottle([x, y, z], 0.06) });
    let (albedo, gloss) = if on_deck {
        // The bow carries a white arrow, the foredeck the name, the after deck a black mat.
        let arrow = x > 0.395 && across < 0.62 * (0.55 - x);
        let panel = (-0.03..0.36).contains(&x) && across < 0.088;
        let mat = (-0.56..-0.06).contains(&x) && across < 0.098;
        if arrow {
            (WHITE, 0.5)
        } else if panel {
            // Legible from the boat's left side: letters run from the bow aft.
            let letters = lettered((0.335 - x) / 0.34, (y + 0.055) / 0.11);
            (if letters { DARK } else { WHITE }, 0.5)
        } else if mat {
            let ribbed = ((y + 1.0) * 60.0) % 1.0 < 0.3;
            (dimmed(DARK, if ribbed { 1.6 } else { 1.0 }), 0.25)
        } else {
            (red(), 0.55)
        }
    } else if (0.052..0.078).contains(&z) && x > -0.52 {
        (WHITE, 0.45)
    } else if z < -0.01 {
        (dimmed(DARK, 1.5), 0.4)
    } else {
        (red(), 0.55)
    };
    Paint { albedo, gloss }
}
