//! The catalogue of views: place of the camera, sea, light and surroundings of each.

use barrelman_sim::render::WaterColour;

/// One view. The camera looks along bearing 0.
pub(super) struct View {
    /// Name of the file, without `.png`.
    pub(super) name: &'static str,
    /// Height of the camera above the water, metres.
    pub(super) height_m: f64,
    /// Depression of the optical axis below the horizon, degrees.
    pub(super) depression_deg: f64,
    /// Sea state, 0 to 4.
    pub(super) sea_state: u8,
    pub(super) water: WaterColour,
    /// Cloud cover, 0 to 1.
    pub(super) overcast: f64,
    /// Bearing and elevation of the sun, degrees.
    pub(super) sun_deg: (f64, f64),
    pub(super) surroundings: Surroundings,
    /// Rate of pan while the picture is exposed, degrees per second.
    pub(super) pan_deg_per_s: f64,
}

/// The objects around the boat.
pub(super) enum Surroundings {
    People,
    PierAndShore,
    Arena,
    LaboratoryFloor,
}

const DEFAULT_VIEW: View = View {
    name: "",
    height_m: 10.0,
    depression_deg: 30.0,
    sea_state: 1,
    water: WaterColour::Lake,
    overcast: 0.0,
    sun_deg: (140.0, 42.0),
    surroundings: Surroundings::People,
    pan_deg_per_s: 0.0,
};

/// All views. Their names are the names of the files.
pub(super) fn views() -> Vec<View> {
    vec![
        View { name: "1_lake_10m_p30", ..DEFAULT_VIEW },
        View {
            name: "2_sea_20m_p45",
            height_m: 20.0,
            depression_deg: 45.0,
            sea_state: 3,
            water: WaterColour::Sea,
            ..DEFAULT_VIEW
        },
        View {
            name: "3_nadir_8m",
            height_m: 8.0,
            depression_deg: 88.0,
            sun_deg: (-60.0, 66.0),
            ..DEFAULT_VIEW
        },
        View {
            name: "4_low_3m_p8_pier",
            height_m: 3.0,
            depression_deg: 8.0,
            surroundings: Surroundings::PierAndShore,
            ..DEFAULT_VIEW
        },
        View {
            name: "5_glint_12m_p25",
            height_m: 12.0,
            depression_deg: 25.0,
            sun_deg: (-4.0, 36.0),
            ..DEFAULT_VIEW
        },
        View {
            name: "6_overcast_30m_p60",
            height_m: 30.0,
            depression_deg: 60.0,
            sea_state: 2,
            water: WaterColour::Green,
            overcast: 1.0,
            ..DEFAULT_VIEW
        },
        View {
            name: "8_sea_6m_p15",
            height_m: 6.0,
            depression_deg: 15.0,
            sea_state: 3,
            water: WaterColour::Sea,
            ..DEFAULT_VIEW
        },
        View {
            name: "9_arena_5m5_p24",
            height_m: 5.5,
            depression_deg: 24.0,
            surroundings: Surroundings::Arena,
            ..DEFAULT_VIEW
        },
        View {
            name: "10_arena_panning",
            height_m: 5.5,
            depression_deg: 24.0,
            surroundings: Surroundings::Arena,
            pan_deg_per_s: 14.0,
            ..DEFAULT_VIEW
        },
        View { name: "11_close_2m_p25", height_m: 2.0, depression_deg: 25.0, ..DEFAULT_VIEW },
        View {
            name: "12_floor_1m83_p24",
            height_m: 1.83,
            depression_deg: 24.0,
            overcast: 1.0,
            surroundings: Surroundings::LaboratoryFloor,
            ..DEFAULT_VIEW
        },
    ]
}
