//! The elliptical region, the diagonals that divide the picture outside of it into four sectors, and the
//! active sector.
//!
//! The diagonals are |x| = |y| in pixels: they do not run to the picture's corners. See `docs/law.md`.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use barrelman_control::{MotorSchema, Percept, Region, Sector};
use barrelman_vocab::{ImagePoint, PictureSize};

use super::canvas::Canvas;
use super::layer::Layer;
use super::shapes::{Line, polyline};
use super::style::{Detail, Rgba};

/// Number of chords of the ellipse: at 1080 lines the error is below a twentieth of a pixel.
const CHORDS: u32 = 256;

/// The region's ellipse in the direction of an angle from the picture's centre, anticlockwise from image
/// right.
fn on_ellipse(region: Region, direction: f64) -> ImagePoint {
    let (s, c) = (libm::sin(direction), libm::cos(direction));
    let distance = 1.0 / libm::hypot(c / region.a_px, s / region.b_px);
    ImagePoint { x: distance * c, y: distance * s }
}

fn in_pixels(point: ImagePoint, picture: PictureSize) -> (f32, f32) {
    let point = point.in_pixels(picture);
    (point.u as f32, point.v as f32)
}

/// The region as last drawn, on a layer of its own, because it rarely changes between frames.
#[derive(Debug, Default)]
pub(super) struct RegionLayer {
    layer: Layer,
    shows: Option<(PictureSize, Region, Option<Sector>)>,
}

impl RegionLayer {
    /// Begins the canvas's layer with the region and, where P > 1, the active sector. `false` if the layer
    /// cannot have the size of the picture.
    pub(super) fn begin(
        &mut self,
        canvas: &mut Canvas,
        picture: PictureSize,
        region: Region,
        percept: Option<&Percept>,
    ) -> bool {
        let active = percept.filter(|percept| MotorSchema::is_released(percept));
        let wanted = (picture, region, active.map(|percept| Sector::from_point(percept.position)));
        if self.shows != Some(wanted) {
            self.shows = Some(wanted);
            core::mem::swap(&mut canvas.layer, &mut self.layer);
            if canvas.layer.begin(picture) {
                draw(canvas, region, wanted.2);
            }
            core::mem::swap(&mut canvas.layer, &mut self.layer);
        }
        canvas.layer.begin_on(&self.layer);
        self.layer.size() == picture
    }
}

fn draw(canvas: &mut Canvas, region: Region, active: Option<Sector>) {
    let is_usable = |semi_axis: f64| semi_axis > 0.0 && semi_axis < 1e5;
    if !is_usable(region.a_px) || !is_usable(region.b_px) {
        return;
    }
    let picture = canvas.layer.size();
    if let Some(sector) = active {
        fill_sector(canvas, region, sector);
    }
    if canvas.style.detail > Detail::Bare {
        draw_diagonals(canvas, region);
    }
    let around = |chord: u32| {
        // The parameter of the ellipse, not the direction: the chords are shortest where the curvature is
        // largest.
        let parameter = f64::from(chord) * TAU / f64::from(CHORDS);
        let (x, y) = (region.a_px * libm::cos(parameter), region.b_px * libm::sin(parameter));
        in_pixels(ImagePoint { x, y }, picture)
    };
    canvas.line(polyline((0..CHORDS).map(around), true), Line::new(Rgba::LIGHT.with_opacity(0.75)));
    if let Some(sector) = active {
        let arc = arc_of(region, sector, picture);
        canvas.line(polyline(arc, false), Line::new(Rgba::ACCENT).with_weight(1.8));
    }
    draw_centre(canvas);
}

fn draw_diagonals(canvas: &mut Canvas, region: Region) {
    let picture = canvas.layer.size();
    let edge = f64::from(picture.width.min(picture.height)) / 2.0;
    for quarter in 0..4 {
        let from = on_ellipse(region, FRAC_PI_4 + f64::from(quarter) * FRAC_PI_2);
        if from.x.abs() < edge {
            let to = ImagePoint { x: edge.copysign(from.x), y: edge.copysign(from.y) };
            let (from, to) = (in_pixels(from, picture), in_pixels(to, picture));
            canvas.segment(from, to, Line::new(Rgba::LIGHT.with_opacity(0.28)));
        }
    }
}

/// A small cross at the picture's centre, the origin of r.
fn draw_centre(canvas: &mut Canvas) {
    let (u, v) = in_pixels(ImagePoint::default(), canvas.layer.size());
    let arm = canvas.style.scaled(9.0).max(3.0);
    let line = Line::new(Rgba::LIGHT.with_opacity(0.9));
    canvas.segment((u - arm, v), (u + arm, v), line);
    canvas.segment((u, v - arm), (u, v + arm), line);
}

/// The arc of the ellipse that borders a sector.
fn arc_of(region: Region, sector: Sector, picture: PictureSize) -> impl Iterator<Item = (f32, f32)> {
    let middle = f64::from(quarter_of(sector)) * FRAC_PI_2;
    let chords = CHORDS / 4;
    (0..=chords).map(move |chord| {
        let share = f64::from(chord) / f64::from(chords) - 0.5;
        in_pixels(on_ellipse(region, middle + share * FRAC_PI_2), picture)
    })
}

fn fill_sector(canvas: &mut Canvas, region: Region, sector: Sector) {
    let picture = canvas.layer.size();
    let first = f64::from(quarter_of(sector)) * FRAC_PI_2 + FRAC_PI_4;
    let far = f64::from(picture.width.max(picture.height));
    let beyond = [first, first - FRAC_PI_2].map(|direction| {
        let point = ImagePoint { x: far * libm::cos(direction), y: far * libm::sin(direction) };
        in_pixels(point, picture)
    });
    let outline = arc_of(region, sector, picture).chain(beyond);
    if let Some(path) = polyline(outline, true) {
        canvas.layer.fill_replacing(&path, Rgba::ACCENT.with_opacity(0.1));
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
