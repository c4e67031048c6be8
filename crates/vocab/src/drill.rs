//! The drills of the demo: their keys, their titles, and what a person has to do.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use crate::named::Named;

/// A drill: a short task in a simulated world, with a result.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, IntoStaticStr, VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum DrillName {
    /// The camera is turned by hand.
    KeepInView,
    /// The boat is selected against a low sun.
    SelectInGlare,
    /// The boat has left the picture, and is brought back into it.
    FindTheBoat,
    /// The boat goes to a person.
    ReachAPerson,
    /// An alarm is raised at a time that is not known before.
    StopOnAlarm,
}

impl Named for DrillName {
    fn text(self) -> &'static str {
        match self {
            Self::KeepInView => "keep the boat in view",
            Self::SelectInGlare => "select in glare",
            Self::FindTheBoat => "find the lost boat",
            Self::ReachAPerson => "reach a person",
            Self::StopOnAlarm => "stop on an alarm",
        }
    }
}

impl DrillName {
    /// What the person has to do.
    pub const fn task(self) -> &'static str {
        match self {
            Self::KeepInView => {
                "Keep the boat in the picture for 60 seconds. Turn the camera by hand; do not engage."
            }
            Self::SelectInGlare => "Select the boat against the sun within 15 seconds.",
            Self::FindTheBoat => {
                "The boat has left the picture. Turn the camera to it, and have it followed again within 30 \
                 seconds."
            }
            Self::ReachAPerson => {
                "Bring the boat within 4 metres of a person, and no closer than 2 metres, within 90 seconds. Mark \
                 the person and press Go, or drive by hand."
            }
            Self::StopOnAlarm => {
                "An alarm is raised between 10 and 25 seconds after the start. Press STOP within 2 seconds of it."
            }
        }
    }
}
