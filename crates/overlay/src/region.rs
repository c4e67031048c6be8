//! The elliptical region, the diagonals that divide what is outside it into four sectors, and the sector that the
//! target is in.
//!
//! The diagonals are |x| = |y| in pixels: they do not run to the picture's corners. See `docs/law.md`.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use barrelman_control::{MotorSchema, Percept, Region, Sector};
use barrelman_vocab::{ImagePoint, PictureSize};

use super::layer::Layer;
use super::pen::Pen;
use super::shapes::{Line, polyline};
use super::style::{Detail, Ink};

/// Chords that the whole ellipse is drawn with: at 1080 lines none is off by more than a twentieth of a pixel.
const CHORDS: u32 = 256;

/// The region's ellipse in the direction of an angle from the picture's centre, anticlockwise from image right.
fn on_ellipse(region: Region, direction: f64) -> ImagePoint {
    let (s, c) = (libm::sin(direction), libm::cos(direction));
    let distance = 1.0 / libm::hypot(c / region.a_px, s / region.b_px);
    ImagePoint { x: distance * c, y: distance * s }
}

fn in_pixels(point: ImagePoint, picture: PictureSize) -> (f32, f32) {
    let point = point.in_pixels(picture);
    (point.u as f32, point.v as f32)
}

/// The region as it was drawn last, on a layer of its own: it seldom changes from one frame to the next.
#[derive(Debug, Default)]
pub(super) struct RegionLayer {
    layer: Layer,
    shows: Option<(PictureSize, Region, Option<Sector>)>,
}

impl RegionLayer {
    /// Begins the pen's layer with the region on it, and where P > 1 the sector that is active. `false` where
    /// there is no room to draw.
    pub(super) fn begin(
        &mut self,
        pen: &mut Pen,
        picture: PictureSize,
        region: Region,
        percept: Option<&Percept>,
    ) -> bool {
        let active = percept.filter(|percept| MotorSchema::is_released(percept));
        let wanted = (picture, region, active.map(|percept| Sector::from_point(percept.position)));
        if self.shows != Some(wanted) {
            self.shows = Some(wanted);
            core::mem::swap(&mut pen.layer, &mut self.layer);
            if pen.layer.begin(picture) {
                draw(pen, region, wanted.2);
            }
            core::mem::swap(&mut pen.layer, &mut self.layer);
        }
        pen.layer.begin_on(&self.layer);
        self.layer.size() == picture
    }
}

fn draw(pen: &mut Pen, region: Region, active: Option<Sector>) {
    let sound = |semi_axis: f64| semi_axis > 0.0 && semi_axis < 1e5;
    if !sound(region.a_px) || !sound(region.b_px) {
        return;
    }
    let picture = pen.layer.size();
    if let Some(sector) = active {
        fill_sector(pen, region, sector);
    }
    if pen.style.detail > Detail::Bare {
        draw_diagonals(pen, region);
    }
    let around = |chord: u32| {
        // The parameter of the ellipse, not the direction: chords are then shortest where it bends most.
        let parameter = f64::from(chord) * TAU / f64::from(CHORDS);
        let (x, y) = (region.a_px * libm::cos(parameter), region.b_px * libm::sin(parameter));
        in_pixels(ImagePoint { x, y }, picture)
    };
    pen.line(polyline((0..CHORDS).map(around), true), Line::of(Ink::LIGHT.at(0.75)));
    if let Some(sector) = active {
        let arc = arc_of(region, sector, picture);
        pen.line(polyline(arc, false), Line::of(Ink::ACCENT).wide(1.8));
    }
    draw_centre(pen);
}

fn draw_diagonals(pen: &mut Pen, region: Region) {
    let picture = pen.layer.size();
    let edge = f64::from(picture.width.min(picture.height)) / 2.0;
    for quarter in 0..4 {
        let from = on_ellipse(region, FRAC_PI_4 + f64::from(quarter) * FRAC_PI_2);
        if from.x.abs() < edge {
            let to = ImagePoint { x: edge.copysign(from.x), y: edge.copysign(from.y) };
            let (from, to) = (in_pixels(from, picture), in_pixels(to, picture));
            pen.segment(from, to, Line::of(Ink::LIGHT.at(0.28)));
        }
    }
}

/// A small cross at the picture's centre, where r begins.
fn draw_centre(pen: &mut Pen) {
    let (u, v) = in_pixels(ImagePoint::default(), pen.layer.size());
    let arm = pen.style.scaled(9.0).max(3.0);
    let line = Line::of(Ink::LIGHT.at(0.9));
    pen.segment((u - arm, v), (u + arm, v), line);
    pen.segment((u, v - arm), (u, v + arm), line);
}

/// The part of the ellipse that borders on a sector.
fn arc_of(region: Region, sector: Sector, picture: PictureSize) -> impl Iterator<Item = (f32, f32)> {
    let middle = f64::from(quarter_of(sector)) * FRAC_PI_2;
    let chords = CHORDS / 4;
    (0..=chords).map(move |chord| {
        let share = f64::from(chord) / f64::from(chords) - 0.5;
        in_pixels(on_ellipse(region, middle + share * FRAC_PI_2), picture)
    })
}

fn fill_sector(pen: &mut Pen, region: Region, sector: Sector) {
    let picture = pen.layer.size();
    let first = f64::from(quarter_of(sector)) * FRAC_PI_2 + FRAC_PI_4;
    let far = f64::from(picture.width.max(picture.height));
    let beyond = [first, first - FRAC_PI_2].map(|direction| {
        let point = ImagePoint { x: far * libm::cos(direction), y: far * libm::sin(direction) };
        in_pixels(point, picture)
    });
    let outline = arc_of(region, sector, picture).chain(beyond);
    if let Some(path) = polyline(outline, true) {
        pen.layer.wash(&path, Ink::ACCENT.at(0.1));
    }
}

/// Quarter turns from image right to the middle of a sector, anticlockwise.
fn quarter_of(sector: Sector) -> u32 {
    match sector {
        Sector::Right => 0,
        Sector::Top => 1,
        Sector::Left => 2,
        Sector::Bottom => 3,
    }
}
