//! Outlines of floating objects, and their silhouettes in a picture.
//!
//! An outline is symmetric about its centre line. Its half-width is given at equidistant stations from stern
//! to bow and is linear between them, so that the rendered object and the polygon of the truth are the same.

use barrelman_vocab::{PictureSize, PixelBox, PixelPoint};

use super::view::{PlanePoint, View};

/// Stations from stern to bow: linear pieces differ from a curve of 200 px by less than 0.1 px.
const STATIONS: usize = 65;

/// Shape of an object from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// Blunt at the stern, pointed at the bow; the exponent (1.5..=3) is the fullness of the bow.
    Hull {
        fullness: f64,
    },
    Round,
    /// A rectangle with rounded corners.
    Raft,
    /// A rectangle.
    Bar,
}

impl Shape {
    /// Share of the half-width at a station `along`, -1 (stern) to 1 (bow).
    fn half_width(self, along: f64) -> f64 {
        match self {
            Self::Hull { fullness } => {
                let stern = ((along + 1.0) / 0.3).min(1.0);
                let bow = ((along - 0.1) / 0.9).max(0.0);
                (0.78 + 0.22 * stern * (2.0 - stern)) * (1.0 - libm::pow(bow, fullness))
            }
            Self::Round => libm::sqrt((1.0 - along * along).max(0.0)),
            Self::Raft => libm::pow((1.0 - libm::pow(along.abs(), 6.0)).max(0.0), 1.0 / 6.0),
            Self::Bar => 1.0,
        }
    }
}

/// Outline in the object's coordinates: along and across the centre line, origin in the middle.
#[derive(Debug, Clone)]
pub(super) struct Outline {
    /// Half of the length, in the plane's unit.
    pub(super) half_length: f64,
    /// Half of the greatest width, in the plane's unit.
    pub(super) half_beam: f64,
    widths: [f64; STATIONS],
}

impl Outline {
    pub(super) fn new(shape: Shape, length: f64, beam: f64) -> Self {
        let widths = core::array::from_fn(|station| shape.half_width(along_at(station)));
        Self { half_length: length / 2.0, half_beam: beam / 2.0, widths }
    }

    /// Area in square units of the plane.
    pub(super) fn area(&self) -> f64 {
        let sum: f64 = self.widths.windows(2).map(|pair| pair[0] + pair[1]).sum();
        sum * self.half_beam * 2.0 * self.half_length / (STATIONS - 1) as f64
    }

    /// Largest distance of the outline from its middle, in the plane's unit.
    pub(super) fn reach(&self) -> f64 {
        libm::hypot(self.half_length, self.half_beam)
    }

    /// An offset from the middle in shares of half length and half beam, if it lies on the object.
    pub(super) fn normalised_offset(&self, along: f64, across: f64) -> Option<(f64, f64)> {
        let (along, across) = (along / self.half_length, across / self.half_beam);
        if !(along.abs() < 1.0 && across.abs() <= 1.0) {
            return None;
        }
        let station = (along + 1.0) * 0.5 * (STATIONS - 1) as f64;
        let before = (station as usize).min(STATIONS - 2);
        let share = station - before as f64;
        let width = self.widths[before] + (self.widths[before + 1] - self.widths[before]) * share;
        (across.abs() <= width).then_some((along, across))
    }

    /// The outline in a picture, with its middle at a point of the plane and its bow in a direction of the
    /// plane (radians, anticlockwise from x).
    pub(super) fn silhouette(&self, middle: PlanePoint, heading: f64, view: &View) -> Silhouette {
        let (s, c) = (libm::sin(heading), libm::cos(heading));
        let side = |station: usize, sign: f64| {
            let along = along_at(station) * self.half_length;
            let across = sign * self.widths[station] * self.half_beam;
            view.picture(middle.offset(along * c - across * s, along * s + across * c))
        };
        let port = (0..STATIONS).map(|station| side(station, 1.0));
        let starboard = (0..STATIONS).rev().map(|station| side(station, -1.0));
        Silhouette { corners: port.chain(starboard).collect() }
    }
}

fn along_at(station: usize) -> f64 {
    2.0 * station as f64 / (STATIONS - 1) as f64 - 1.0
}

/// A polygon in a picture.
#[derive(Debug, Clone)]
pub(super) struct Silhouette {
    corners: Vec<PixelPoint>,
}

impl Silhouette {
    /// Square pixels.
    pub(super) fn area(&self) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        let twice: f64 = self.corners.iter().zip(next).map(|(a, b)| a.u * b.v - b.u * a.v).sum();
        twice.abs() / 2.0
    }

    /// Direction of the principal axis, radians anticlockwise from image right, within +-90 degrees: from the
    /// second moments of area, summed over the triangles of the edges with a corner.
    pub(super) fn axis(&self) -> f64 {
        let Some(origin) = self.corners.first() else { return 0.0 };
        // Upwards is positive here; moments about the corner, and then about the centroid.
        let at = |corner: &PixelPoint| (corner.u - origin.u, origin.v - corner.v);
        let (mut area, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
        for pair in self.corners.windows(2) {
            let ((ax, ay), (bx, by)) = (at(&pair[0]), at(&pair[1]));
            let twice = ax * by - bx * ay;
            area += twice / 2.0;
            first[0] += twice * (ax + bx) / 6.0;
            first[1] += twice * (ay + by) / 6.0;
            second[0] += twice * (ax * ax + ax * bx + bx * bx) / 12.0;
            second[1] += twice * (ay * ay + ay * by + by * by) / 12.0;
            second[2] += twice * (2.0 * ax * ay + ax * by + bx * ay + 2.0 * bx * by) / 24.0;
        }
        let xx = second[0] / area - first[0] * first[0] / (area * area);
        let yy = second[1] / area - first[1] * first[1] / (area * area);
        let xy = second[2] / area - first[0] * first[1] / (area * area);
        0.5 * libm::atan2(2.0 * xy, xx - yy)
    }

    /// The upright box around the polygon; empty for an empty polygon.
    pub(super) fn bounds(&self) -> PixelBox {
        let Some(first) = self.corners.first() else { return PixelBox::default() };
        let (mut low, mut high) = (*first, *first);
        for corner in &self.corners {
            low = PixelPoint { u: low.u.min(corner.u), v: low.v.min(corner.v) };
            high = PixelPoint { u: high.u.max(corner.u), v: high.v.max(corner.v) };
        }
        PixelBox { u: low.u, v: low.v, w: high.u - low.u, h: high.v - low.v }
    }

    /// Extent along a direction of the picture, given as a unit vector.
    pub(super) fn extent(&self, direction: (f64, f64)) -> f64 {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in &self.corners {
            let reach = corner.u * direction.0 + corner.v * direction.1;
            low = low.min(reach);
            high = high.max(reach);
        }
        (high - low).max(0.0)
    }

    /// The part inside a picture, by the algorithm of Sutherland and Hodgman.
    pub(super) fn clipped(mut self, size: PictureSize) -> Self {
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        let insides: [&dyn Fn(&PixelPoint) -> f64; 4] =
            [&|point| point.u, &|point| width - point.u, &|point| point.v, &|point| height - point.v];
        for inside in insides {
            let mut kept = Vec::with_capacity(self.corners.len() + 2);
            let next = self.corners.iter().cycle().skip(1);
            for (from, to) in self.corners.iter().zip(next) {
                let (depth_from, depth_to) = (inside(from), inside(to));
                if depth_from >= 0.0 {
                    kept.push(*from);
                }
                if (depth_from >= 0.0) != (depth_to >= 0.0) {
                    let share = depth_from / (depth_from - depth_to);
                    let mix = |a: f64, b: f64| a + (b - a) * share;
                    kept.push(PixelPoint { u: mix(from.u, to.u), v: mix(from.v, to.v) });
                }
            }
            self.corners = kept;
        }
        self
    }
}
