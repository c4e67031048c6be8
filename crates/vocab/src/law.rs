//! The camera laws: their keys and titles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use crate::named::Named;

/// A camera law, with its mode.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum LawId {
    /// The optimal law in the mode [`OptimalMode::MinimumEnergy`].
    MinimumEnergy,
    /// The optimal law in the mode [`OptimalMode::TimeFuel`].
    TimeFuel,
    /// The optimal law in the mode [`OptimalMode::Eco`].
    Eco,
    /// The optimal law in the mode [`OptimalMode::Intermittent`].
    Intermittent,
    /// The paper's motor schema.
    Schema,
    /// A PID controller that centres the target, to compare with.
    Centre,
}

/// A camera law on the command line and in a configuration, where the mode has a key of its own.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum LawName {
    /// The paper's motor schema.
    Schema,
    /// Both axes at once, by prediction.
    Optimal,
    /// A PID controller that centres the target, to compare with.
    Centre,
}

/// What the optimal law minimises.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum OptimalMode {
    /// The integral of the squared rate: the camera moves slowly and nearly all the time.
    MinimumEnergy,
    /// Energy and time in motion: the camera moves at a cruising speed and rests in between.
    TimeFuel,
    /// Energy, time in motion and number of movements: all are lower than with the motor schema. The target
    /// spends more time outside of the region than with the other modes.
    Eco,
    /// All of it, and the smoothness of the commands: one movement for each excursion, with a rest after it.
    #[default]
    Intermittent,
}

/// What the optimal law shows.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Framed {
    /// The target.
    #[default]
    Boat,
    /// The target, and where it goes, as far as both fit into the picture.
    Both,
}

impl LawId {
    /// The law of this name; `mode` is the optimal law's.
    pub const fn new(name: LawName, mode: OptimalMode) -> Self {
        match (name, mode) {
            (LawName::Schema, _) => Self::Schema,
            (LawName::Centre, _) => Self::Centre,
            (LawName::Optimal, OptimalMode::MinimumEnergy) => Self::MinimumEnergy,
            (LawName::Optimal, OptimalMode::TimeFuel) => Self::TimeFuel,
            (LawName::Optimal, OptimalMode::Eco) => Self::Eco,
            (LawName::Optimal, OptimalMode::Intermittent) => Self::Intermittent,
        }
    }

    /// The law's name.
    pub const fn name(self) -> LawName {
        match self {
            Self::Schema => LawName::Schema,
            Self::Centre => LawName::Centre,
            Self::MinimumEnergy | Self::TimeFuel | Self::Eco | Self::Intermittent => LawName::Optimal,
        }
    }

    /// The optimal law's mode; `None` for another law.
    pub const fn mode(self) -> Option<OptimalMode> {
        match self {
            Self::Schema | Self::Centre => None,
            Self::MinimumEnergy => Some(OptimalMode::MinimumEnergy),
            Self::TimeFuel => Some(OptimalMode::TimeFuel),
            Self::Eco => Some(OptimalMode::Eco),
            Self::Intermittent => Some(OptimalMode::Intermittent),
        }
    }
}

impl Named for LawId {
    fn text(self) -> &'static str {
        match self {
            Self::Schema => "paper's schema",
            Self::Centre => "PID on the centre",
            Self::MinimumEnergy => "optimal: least energy",
            Self::TimeFuel => "optimal: quick",
            Self::Eco => "optimal: most rest",
            Self::Intermittent => "optimal: one movement each time",
        }
    }
}

impl Named for LawName {
    fn text(self) -> &'static str {
        match self {
            Self::Schema => "The paper's motor schema",
            Self::Optimal => "Both axes at once, by prediction",
            Self::Centre => "A PID controller that centres the target, to compare with",
        }
    }
}

impl Named for OptimalMode {
    fn text(self) -> &'static str {
        match self {
            Self::MinimumEnergy => "The integral of the squared rate: gentle movements, nearly all the time",
            Self::TimeFuel => "Energy and time in motion: short movements at a cruising speed",
            Self::Eco => "Least energy and time in motion, in about as many movements as the schema",
            Self::Intermittent => "One smooth movement for each excursion, with a rest after it",
        }
    }
}

impl Named for Framed {
    fn text(self) -> &'static str {
        match self {
            Self::Boat => "The boat alone: fewest movements",
            Self::Both => "The boat, and its destination as far as both fit into the picture",
        }
    }
}
