//! Which of a vehicle's gimbals, cameras and streams a run uses, by the names that the vehicle gives them.

use core::fmt;

use crate::short_text::ShortText;

/// What a vehicle can have several of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EquipmentKind {
    /// The gimbal that is moved.
    Gimbal,
    /// The camera that zooms.
    Camera,
    /// The video stream, with its source.
    Stream,
}

impl EquipmentKind {
    /// The name in the event log.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Gimbal => "gimbal",
            Self::Camera => "camera",
            Self::Stream => "stream",
        }
    }
}

/// One of them, that is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Equipment {
    /// What it is.
    pub kind: EquipmentKind,
    /// Its name. Another name is another one.
    pub name: ShortText,
}

impl Equipment {
    /// The one of this name.
    pub fn new(kind: EquipmentKind, name: &str) -> Self {
        Self { kind, name: ShortText::of(name.as_bytes()) }
    }
}

/// What is used, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UsedEquipment {
    /// The gimbal.
    pub gimbal: Option<ShortText>,
    /// The camera that zooms.
    pub camera: Option<ShortText>,
    /// The video stream.
    pub stream: Option<ShortText>,
}

/// Something is used that was not before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EquipmentChange {
    /// What is used now.
    pub now: Equipment,
    /// What was used until now; `None`: nothing was known.
    pub before: Option<ShortText>,
}

impl UsedEquipment {
    /// Takes what is used now; `None`: it is the same.
    pub fn on_used(&mut self, now: Equipment) -> Option<EquipmentChange> {
        let known = match now.kind {
            EquipmentKind::Gimbal => &mut self.gimbal,
            EquipmentKind::Camera => &mut self.camera,
            EquipmentKind::Stream => &mut self.stream,
        };
        let before = known.replace(now.name);
        (before != Some(now.name)).then_some(EquipmentChange { now, before })
    }
}

impl fmt::Display for EquipmentChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Equipment { kind, name } = self.now;
        match self.before {
            None => write!(f, "the {} is {name}", kind.key()),
            Some(before) => write!(f, "the {} is another one: {name} instead of {before}", kind.key()),
        }
    }
}
