//! The names of a section's keys, in the order of their declaration.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{self, Deserializer, Visitor};

use super::camera::{AxisSection, CameraSection};
use super::console::{ConsoleSection, RecordingSection};
use super::detector::DetectorSection;
use super::file::{ConfigFile, GimbalTiltSection, LawSection, LinkSection, VehicleSection, VideoSection};
use super::lens::LensSection;
use super::share::ShareSection;
use super::speeds::SpeedsSection;
use super::tak::TakSection;
use super::tracker::{FusedSection, TrackerSection};
use super::tracking_camera::TrackingCameraSection;
use super::vessel::VesselSection;
use super::zoom::ZoomSection;

macro_rules! names_of {
    ($($section:ident),+ $(,)?) => {
        BTreeMap::from([$((stringify!($section), keys_of::<$section>())),+])
    };
}

/// The keys of each section type, by the type's name.
pub(super) type FieldNames = BTreeMap<&'static str, &'static [&'static str]>;

/// The keys of all section types.
pub(super) fn field_names() -> FieldNames {
    names_of![
        ConfigFile,
        VideoSection,
        LinkSection,
        VehicleSection,
        GimbalTiltSection,
        SpeedsSection,
        CameraSection,
        LensSection,
        AxisSection,
        ZoomSection,
        LawSection,
        TrackerSection,
        FusedSection,
        TrackingCameraSection,
        TakSection,
        ShareSection,
        DetectorSection,
        VesselSection,
        ConsoleSection,
        RecordingSection,
    ]
}

fn keys_of<T: Deserialize<'static>>() -> &'static [&'static str] {
    let mut keys: &'static [&'static str] = &[];
    let _ = T::deserialize(Asked(&mut keys));
    keys
}

/// A deserialiser that has no value: it notes which fields a struct asks for.
struct Asked<'a>(&'a mut &'static [&'static str]);

/// There is no value.
#[derive(Debug)]
struct NoValue;

impl fmt::Display for NoValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("there is no value")
    }
}

impl std::error::Error for NoValue {}

impl de::Error for NoValue {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Self
    }
}

impl<'de> Deserializer<'de> for Asked<'_> {
    type Error = NoValue;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, NoValue> {
        Err(NoValue)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, NoValue> {
        *self.0 = fields;
        Err(NoValue)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map enum identifier ignored_any
    }
}
