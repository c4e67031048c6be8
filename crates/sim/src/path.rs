//! A path on the floor or the water: way-points joined by straight legs.

/// A path of at least two way-points; neighbouring way-points differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    points: Vec<(f64, f64)>,
    /// Length from the start to each way-point, metres.
    lengths: Vec<f64>,
}

/// The way-points make no path: fewer than two differ, or a coordinate is not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InvalidPath;

/// Neighbouring way-points nearer than this are one, metres.
const SAME_PLACE_M: f64 = 1.0e-6;

impl Path {
    /// The path through way-points, metres.
    ///
    /// # Errors
    /// [`InvalidPath`] where fewer than two way-points differ, or a coordinate is not finite.
    pub fn from_way_points(way_points: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, InvalidPath> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut lengths: Vec<f64> = Vec::new();
        for point in way_points {
            if !(point.0.is_finite() && point.1.is_finite()) {
                return Err(InvalidPath);
            }
            let Some(last) = points.last() else {
                points.push(point);
                lengths.push(0.0);
                continue;
            };
            let leg = libm::hypot(point.0 - last.0, point.1 - last.1);
            if leg > SAME_PLACE_M {
                lengths.push(lengths.last().copied().unwrap_or_default() + leg);
                points.push(point);
            }
        }
        if points.len() < 2 { Err(InvalidPath) } else { Ok(Self { points, lengths }) }
    }

    /// The path with a leg from its end to its start.
    #[must_use]
    pub fn closed(&self) -> Self {
        let points = self.points.iter().chain(self.points.first()).copied();
        Self::from_way_points(points).unwrap_or_else(|_| self.clone())
    }

    /// Way-points, metres.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Length of the path, metres.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or_default()
    }

    /// The point at an arc length from the start, metres; clamped to the ends of the path.
    pub fn point_at(&self, along_m: f64) -> (f64, f64) {
        let leg = self.leg_at(along_m);
        let (from, to) = (self.points[leg], self.points[leg + 1]);
        let share =
            ((along_m - self.lengths[leg]) / (self.lengths[leg + 1] - self.lengths[leg])).clamp(0.0, 1.0);
        (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
    }

    /// Direction of the path at an arc length, radians anticlockwise from x.
    pub fn direction_at(&self, along_m: f64) -> f64 {
        let (x, y) = self.leg(self.leg_at(along_m));
        libm::atan2(y, x)
    }

    /// Arc lengths of the way-points at which the path turns by more than an angle, metres.
    pub fn corners(&self, radians: f64) -> impl Iterator<Item = f64> + '_ {
        (1..self.points.len() - 1).filter_map(move |index| {
            let (a, b) = (self.leg(index - 1), self.leg(index));
            let turn = libm::atan2(a.0 * b.1 - a.1 * b.0, a.0 * b.0 + a.1 * b.1);
            (turn.abs() > radians).then_some(self.lengths[index])
        })
    }

    /// Arc length of the point of the path nearest to `position`, searched from `from_m` over the next
    /// `reach_m`: a path may cross itself.
    pub fn nearest_arc_length(&self, position: (f64, f64), from_m: f64, reach_m: f64) -> f64 {
        let mut best = (f64::INFINITY, from_m);
        for leg in self.leg_at(from_m)..self.points.len() - 1 {
            let (start, end) = (self.lengths[leg], self.lengths[leg + 1]);
            if start > from_m + reach_m {
                break;
            }
            let (a, b) = (self.points[leg], self.points[leg + 1]);
            let (dx, dy) = ((b.0 - a.0) / (end - start), (b.1 - a.1) / (end - start));
            let along = (start + (position.0 - a.0) * dx + (position.1 - a.1) * dy)
                .clamp(start.max(from_m), end.min(from_m + reach_m));
            let (x, y) = (a.0 + (along - start) * dx, a.1 + (along - start) * dy);
            let distance = libm::hypot(position.0 - x, position.1 - y);
            if distance < best.0 {
                best = (distance, along);
            }
        }
        best.1
    }

    /// Vector of a leg, metres.
    fn leg(&self, index: usize) -> (f64, f64) {
        let (from, to) = (self.points[index], self.points[index + 1]);
        (to.0 - from.0, to.1 - from.1)
    }

    fn leg_at(&self, along_m: f64) -> usize {
        self.lengths.partition_point(|length| *length <= along_m).clamp(1, self.points.len() - 1) - 1
    }
}
