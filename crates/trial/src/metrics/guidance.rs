//! How the boat went to a person, in a trial with guidance.

use serde::{Deserialize, Serialize};

/// Figures of the guidance. Fields are `null` where they are not defined. All are from the truth, from the
/// moment at which the guidance was engaged.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GuidanceMetrics {
    /// Whether the boat came within 4 m of the person.
    pub arrived: bool,
    /// Time to those 4 m, s.
    pub time_to_circle_s: Option<f64>,
    /// Mean distance from the line between start and person, from 4 s on until the arrival, m.
    pub cross_track_m: Option<f64>,
    /// Sum of the changes of the rudder until the arrival; from full left to full right is 2.
    pub rudder_travel: Option<f64>,
    /// Least distance to any person, m.
    pub closest_person_m: Option<f64>,
    /// Length of the path until the arrival over that of the straight way.
    pub path_ratio: Option<f64>,
    /// Share of the time with boat and person in the picture, 0 to 1.
    pub both_in_view: Option<f64>,
}
