//! The way of a boat that was commanded, as the pilot knew it.
//!
//! Points on the water: x to the right and y ahead of pan 0, from the point below the camera, metres.

use barrelman_vocab::{MarkKind, WaterPoint};

use crate::records::RecordedVessel;

/// Boat, marks and views of a recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WaterLog {
    /// Where the boat was, in the order of time; `None` once where it was not known for a while.
    pub boat: Vec<Option<WaterPoint>>,
    /// The marks, in the order in which they were set.
    pub marks: Vec<MarkOnWater>,
    /// Corners of what the picture showed of the water, at the beginning and at the end.
    pub views: Option<[[WaterPoint; 4]; 2]>,
}

/// A mark with its way.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkOnWater {
    /// Number of the mark.
    pub id: u32,
    /// What was there.
    pub kind: MarkKind,
    /// Where it was, in the order of time: it drifts, and is moved.
    pub path: Vec<WaterPoint>,
    /// Largest radius of the circle that the boat kept out of, metres, without the uncertainty; 0: none.
    pub radius_m: f64,
    /// Last standard deviation of each coordinate, metres.
    pub std_dev_m: f64,
    /// Whether it was the destination at any time.
    pub was_destination: bool,
}

impl WaterLog {
    /// Whether there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty() && self.boat.iter().all(Option::is_none)
    }

    /// Adds the vessel's part of the next outcome.
    pub(super) fn add(&mut self, vessel: &RecordedVessel) {
        let boat = vessel.progress.map(|progress| progress.boat);
        if self.boat.last().is_none_or(|last| *last != boat) {
            self.boat.push(boat);
        }
        for mark in &vessel.marks {
            let index = self.marks.iter().position(|known| known.id == mark.id).unwrap_or_else(|| {
                self.marks.push(MarkOnWater {
                    id: mark.id,
                    kind: mark.kind,
                    path: Vec::new(),
                    radius_m: 0.0,
                    std_dev_m: 0.0,
                    was_destination: false,
                });
                self.marks.len() - 1
            });
            let known = &mut self.marks[index];
            if known.path.last() != Some(&mark.at) {
                known.path.push(mark.at);
            }
            known.radius_m = known.radius_m.max(mark.radius_m);
            known.std_dev_m = mark.std_dev_m;
            known.was_destination |= vessel.destination.is_some_and(|(id, _)| id == mark.id);
        }
        if let Some(view) = vessel.view {
            let first = self.views.map_or(view, |[first, _]| first);
            self.views = Some([first, view]);
        }
    }
}
