//! The operator's marks: places and people that stay on the water while the camera moves.
//!
//! A mark is a line of sight from the camera at the time of its video frame; where height and tilt are known,
//! it is the point at which that line meets the water. The camera's model turns it back into a pixel of every
//! later frame.
//!
//! A place, an area and home stay where they were marked, as uncertain as they were then. A person is
//! followed by a tracker where an object is found under the mark: the mark is held, and is where the person
//! is seen. While the person is not seen, the mark drifts on at the velocity that the places before tell
//! ([`Drift`]), and the uncertainty of the place grows. The operator moves the mark of a person that is not
//! held.

use barrelman_control::guidance::{Destination, KeepOut};
use barrelman_vocab::{
    DrawnMark, MarkKind, MovedMark, PixelPoint, Timestamp, VesselProfile, WaterFix, WaterPoint,
};

use super::frame_view::FrameView;

mod drift;
mod holding;
mod mark;

pub use drift::Drift;
pub use mark::{FORBIDDEN_M, Mark};

/// Most marks at a time.
pub const MAX_MARKS: usize = 16;

/// Why a mark cannot be set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkRefusal {
    /// There are [`MAX_MARKS`] already.
    TooMany,
    /// The line of sight does not meet the water.
    NotOnWater,
    /// There is no mark of that number.
    NoSuchMark,
}

/// What a mark that is moved, or gets its place on the water, does to the way on the present route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouteChange {
    /// Nothing, or another route begins.
    None,
    /// The last leg ends elsewhere.
    DestinationMoved,
}

/// The line of sight of a pixel, and the point on the water, where it can be known.
fn place(pixel: PixelPoint, frame_view: &FrameView) -> Result<([f64; 3], Option<WaterFix>), MarkRefusal> {
    let direction = frame_view.view.direction_of(pixel).ok_or(MarkRefusal::NotOnWater)?;
    if frame_view.sees_water {
        let fix = frame_view.fix(pixel).ok_or(MarkRefusal::NotOnWater)?;
        Ok((direction, Some(fix)))
    } else if direction[2] < 0.0 {
        Ok((direction, None))
    } else {
        Err(MarkRefusal::NotOnWater)
    }
}

/// All marks, in the order in which they were set.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Marks {
    marks: [Option<Mark>; MAX_MARKS],
    count: usize,
    newest_id: u32,
    /// Number of the mark that is the destination.
    destination: Option<u32>,
    /// Changes whenever the way-points begin anew.
    route: u32,
}

impl Marks {
    /// The marks, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Mark> {
        self.marks.iter().flatten()
    }

    /// The mark of a number.
    fn get_mut(&mut self, id: u32) -> Option<&mut Mark> {
        self.marks.iter_mut().flatten().find(|mark| mark.id == id)
    }

    /// The mark that is the destination.
    pub fn destination(&self) -> Option<&Mark> {
        self.iter().find(|mark| Some(mark.id) == self.destination)
    }

    /// Number of the route: another one, with all way-points, begins when a way-point changes, or which mark
    /// is the destination. A destination that is moved stays on its route.
    pub const fn route(&self) -> u32 {
        self.route
    }

    /// Sets a mark in the view of its video frame. The first place or person is the destination, and so is
    /// each one that is set while the one before is a place, or home to which no boat `is_guided`: a person
    /// that is being approached stays the destination, and so does home on the way there.
    pub fn add(
        &mut self,
        drawn: &DrawnMark,
        frame_view: &FrameView,
        is_tilt_known: bool,
        is_guided: bool,
    ) -> Result<u32, MarkRefusal> {
        if self.count == MAX_MARKS {
            return Err(MarkRefusal::TooMany);
        }
        let (direction, water) = place(drawn.at, frame_view)?;
        if drawn.mark == MarkKind::Home {
            self.remove_if(|mark| mark.kind == MarkKind::Home);
        }
        self.newest_id += 1;
        let id = self.newest_id;
        self.marks[self.count] = Some(Mark {
            id,
            kind: drawn.mark,
            direction,
            water,
            has_tilt: is_tilt_known,
            marked: drawn.captured_ns,
            drift: water
                .filter(|_| drawn.mark == MarkKind::Person)
                .map(|fix| Drift::at_rest(&fix, drawn.captured_ns)),
            scatter_m2: 0.0,
            held: None,
        });
        self.count += 1;
        let is_goal = matches!(drawn.mark, MarkKind::Place | MarkKind::Person);
        let replaces = self
            .destination()
            .is_none_or(|mark| mark.kind == MarkKind::Place || (mark.kind == MarkKind::Home && !is_guided));
        let is_destination = is_goal && replaces;
        if is_destination {
            self.destination = Some(id);
        }
        if is_destination || drawn.mark == MarkKind::WayPoint {
            self.route += 1;
        }
        Ok(id)
    }

    /// Places the marks without a place on the water that the camera's view now has one for: height or tilt
    /// were not known when they were set. A mark that was set before any tilt was reported gets none: its
    /// line of sight was not known.
    pub fn place_on_water(&mut self, frame_view: &FrameView) -> RouteChange {
        let mut change = RouteChange::None;
        let can_be_placed = |mark: &&mut Mark| mark.water.is_none() && mark.has_tilt;
        for mark in self.marks.iter_mut().flatten().filter(can_be_placed) {
            let Some(fix) = frame_view.view.pixel_of(mark.direction).and_then(|pixel| frame_view.fix(pixel))
            else {
                continue;
            };
            mark.water = Some(fix);
            if mark.kind == MarkKind::Person {
                mark.drift = Some(Drift::at_rest(&fix, mark.marked));
            }
            if self.destination == Some(mark.id) {
                change = RouteChange::DestinationMoved;
            } else if mark.is_on_route(self.destination) {
                self.route += 1;
            }
        }
        change
    }

    /// Whether all marks have a place on the water.
    pub fn are_placed(&self) -> bool {
        self.iter().all(|mark| mark.water.is_some())
    }

    /// Whether a mark that a boat on its way over the water must regard has no place there: the destination,
    /// a way-point, or one with a circle.
    pub fn have_unplaced(&self, profile: &VesselProfile) -> bool {
        self.iter()
            .filter(|mark| mark.water.is_none())
            .any(|mark| mark.is_on_route(self.destination) || mark.radius_m(profile, false) > 0.0)
    }

    /// Whether there are people or areas that a boat keeps out of.
    pub fn have_circles(&self) -> bool {
        self.iter().any(|mark| matches!(mark.kind, MarkKind::Person | MarkKind::Forbidden))
    }

    /// The guidance begins here and now: its line starts where the boat is.
    pub const fn begin_route(&mut self) {
        self.route += 1;
    }

    /// Moves a mark to a pixel in the view of its video frame. The mark of a person drifts on as it was
    /// moved. Where height or tilt are not known, the moved mark has no place on the water until they are.
    pub fn move_to(
        &mut self,
        moved: &MovedMark,
        frame_view: &FrameView,
        is_tilt_known: bool,
    ) -> Result<RouteChange, MarkRefusal> {
        let (direction, water) = place(moved.at, frame_view)?;
        let destination = self.destination;
        let mark = self.get_mut(moved.id).ok_or(MarkRefusal::NoSuchMark)?;
        let is_on_route = mark.is_on_route(destination);
        match (mark.kind, water, &mut mark.drift) {
            (MarkKind::Person, Some(fix), Some(drift)) if mark.water.is_some() => {
                drift.move_to(&fix, moved.captured_ns);
            }
            (MarkKind::Person, Some(fix), drift) => *drift = Some(Drift::at_rest(&fix, moved.captured_ns)),
            _ => mark.drift = None,
        }
        (mark.direction, mark.water, mark.marked) = (direction, water, moved.captured_ns);
        (mark.has_tilt, mark.held) = (is_tilt_known, None);
        // A boat that rests at its destination goes on to where the destination is now.
        if self.destination == Some(moved.id) {
            return Ok(RouteChange::DestinationMoved);
        }
        if is_on_route {
            self.route += 1;
        }
        Ok(RouteChange::None)
    }

    /// Removes a mark. Returns whether there was one. Another destination is not chosen: the operator does.
    pub fn remove(&mut self, id: u32) -> bool {
        self.remove_if(|mark| mark.id == id)
    }

    /// Removes all marks.
    pub fn clear(&mut self) {
        self.remove_if(|_| true);
    }

    fn remove_if(&mut self, is_removed: impl Fn(&Mark) -> bool) -> bool {
        let before = self.count;
        let changes_route = self.iter().any(|mark| is_removed(mark) && mark.is_on_route(self.destination));
        let mut kept = [None; MAX_MARKS];
        let left = self.marks.iter().flatten().filter(|mark| !is_removed(mark));
        self.count = kept.iter_mut().zip(left).map(|(slot, mark)| *slot = Some(*mark)).count();
        self.marks = kept;
        if self.destination().is_none() {
            self.destination = None;
        }
        if changes_route {
            self.route += 1;
        }
        self.count != before
    }

    /// The next place or person becomes the destination, after the last the first. Returns its number.
    pub fn choose_next(&mut self) -> Option<u32> {
        let is_goal = |mark: &&Mark| matches!(mark.kind, MarkKind::Place | MarkKind::Person);
        let present = self.destination.unwrap_or(0);
        let next = self.iter().filter(is_goal).find(|mark| mark.id > present);
        let chosen = next.or_else(|| self.iter().find(is_goal)).map(|mark| mark.id)?;
        self.choose(chosen);
        Some(chosen)
    }

    /// The place that is marked as home becomes the destination. Returns its number.
    pub fn choose_home(&mut self) -> Option<u32> {
        let home = self.iter().find(|mark| mark.kind == MarkKind::Home)?.id;
        self.choose(home);
        Some(home)
    }

    fn choose(&mut self, id: u32) {
        if self.destination.replace(id) != Some(id) {
            self.route += 1;
        }
    }

    /// The destination for the guidance over the water.
    pub fn water_destination(&self, profile: &VesselProfile, now: Timestamp) -> Option<Destination> {
        let mark = self.destination()?;
        let (at, uncertainty_m) = (mark.point(now)?, mark.std_dev_m(now)?);
        Some(match mark.kind {
            MarkKind::Person => Destination::Person {
                at,
                velocity_m_per_s: mark.velocity_m_per_s(),
                stand_off_m: profile.stand_off_m,
                uncertainty_m,
            },
            _ => Destination::Place(at),
        })
    }

    /// Fills `out` with the way-points before the destination. A way home has none. Returns how many there
    /// are.
    pub fn way_points(&self, now: Timestamp, out: &mut [WaterPoint; MAX_MARKS]) -> usize {
        if self.destination().is_none_or(|mark| mark.kind == MarkKind::Home) {
            return 0;
        }
        let points =
            self.iter().filter(|mark| mark.kind == MarkKind::WayPoint).filter_map(|mark| mark.point(now));
        out.iter_mut().zip(points).map(|(slot, point)| *slot = point).count()
    }

    /// Whether a boat that goes no further than `reach_m` (metres) in any direction stays out of all circles,
    /// their uncertainty included, and short of the destination.
    pub fn are_beyond(
        &self,
        boat: WaterPoint,
        reach_m: f64,
        profile: &VesselProfile,
        now: Timestamp,
    ) -> bool {
        self.iter().all(|mark| {
            let is_destination = Some(mark.id) == self.destination;
            let radius_m = mark.radius_m(profile, is_destination);
            if radius_m <= 0.0 && !is_destination {
                return true;
            }
            let (Some(at), Some(std_dev_m)) = (mark.point(now), mark.std_dev_m(now)) else { return false };
            boat.distance_to(at) - radius_m - std_dev_m >= reach_m
        })
    }

    /// Fills `out` with the circles that the boat keeps out of. Returns how many there are.
    pub fn keep_outs(
        &self,
        profile: &VesselProfile,
        now: Timestamp,
        out: &mut [KeepOut; MAX_MARKS],
    ) -> usize {
        let circles = self.iter().filter(|mark| Some(mark.id) != self.destination).filter_map(|mark| {
            let radius_m = mark.radius_m(profile, false);
            let centre = mark.point(now).filter(|_| radius_m > 0.0)?;
            Some(KeepOut { centre, radius_m: radius_m + mark.std_dev_m(now)? })
        });
        out.iter_mut().zip(circles).map(|(slot, circle)| *slot = circle).count()
    }
}
