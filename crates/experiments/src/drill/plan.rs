//! The world of each drill, and its limits.

use barrelman_vocab::DrillName;

/// The world of a drill, and its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrillPlan {
    /// The scenario.
    pub scenario: &'static str,
    /// Within which time the task has to be done, from the drill's begin on, seconds. Of
    /// [`DrillName::StopOnAlarm`]: from the alarm on.
    pub limit_s: f64,
    /// The drill goes on for so long after the task was done, seconds.
    pub after_s: f64,
    /// Whether the boat is followed, and the camera engaged, at the begin.
    pub begins_engaged: bool,
}

impl DrillPlan {
    /// The plan of a drill.
    pub const fn of(name: DrillName) -> Self {
        match name {
            DrillName::KeepInView => {
                Self { scenario: "arena1", limit_s: 60.0, after_s: 0.0, begins_engaged: false }
            }
            DrillName::SelectInGlare => {
                Self { scenario: "glint", limit_s: 15.0, after_s: 3.0, begins_engaged: false }
            }
            DrillName::FindTheBoat => {
                Self { scenario: "arena1", limit_s: 30.0, after_s: 3.0, begins_engaged: false }
            }
            DrillName::ReachAPerson => {
                Self { scenario: "rescue", limit_s: 90.0, after_s: 5.0, begins_engaged: true }
            }
            DrillName::StopOnAlarm => {
                Self { scenario: "open", limit_s: 2.0, after_s: 1.0, begins_engaged: true }
            }
        }
    }
}
