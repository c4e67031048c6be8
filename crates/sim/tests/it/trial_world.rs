//! A small scenario, for tests of the world, and for those of simulated trials in `trial`.

use barrelman_sim::boat::LENGTH_M;
use barrelman_sim::electronics::ElectronicsModel;
use barrelman_sim::pursuit::PursuitScript;
use barrelman_sim::random::OrnsteinUhlenbeck;
use barrelman_sim::scenario::{
    AxisRanges, BeyondBorder, CameraSetup, FirstView, PlantRanges, Platform, Scenario, SensorModel,
    TargetScript,
};
use barrelman_sim::snapshot::Light;
use barrelman_sim::sway::Sway;
use barrelman_sim::video_link::VideoLinkModel;
use barrelman_sim::{MountPlant, Optics};
use barrelman_vocab::{Angle, PictureSize};

/// A target that crosses the floor at 1 m/s, 4 m ahead of a camera 2 m high, without any randomness.
pub(crate) fn plain() -> Scenario {
    let none = OrnsteinUhlenbeck { std_dev: 0.0, time_constant_s: 1.0 };
    let picture = PictureSize::new(640, 360);
    let axis = AxisRanges {
        start_dead_time_s: (0.1, 0.2),
        stop_dead_time_s: (0.3, 0.4),
        lag_s: (0.2, 0.4),
        gain: (1.0, 1.0),
    };
    Scenario {
        name: "plain".to_owned(),
        camera: CameraSetup {
            height_m: 2.0,
            optics: Optics { picture, focal_px: 330.0, barrel: 0.0 },
            frame: picture,
            pictures_per_second: 30,
            rolling_shutter_s: 0.0,
            video: VideoLinkModel::steady(0.1),
            first_view: FirstView::default(),
            electronics: ElectronicsModel { brightness: none, white_balance: none, exposure_s: 0.0 },
            zoom: None,
        },
        mount: MountPlant::laboratory(),
        ranges: PlantRanges {
            focal_px: (300.0, 360.0),
            pan: axis,
            tilt: axis,
            cross_talk: (0.0, 0.0),
            droop_rad_per_s: (0.0, 0.0),
        },
        platform: Platform::Swaying(Sway::STILL),
        water: None,
        light: Light { sun_bearing: Angle::ZERO, sun_elevation: Angle::from_degrees(45.0), overcast: 1.0 },
        target: TargetScript::Pursuit(pursuit()),
        objects: Vec::new(),
        sensing: SensorModel {
            noise: OrnsteinUhlenbeck::default(),
            is_rounded: false,
            beyond_border: BeyondBorder::Absent,
            target_size_m: (LENGTH_M, 0.3),
            heading_std_dev: None,
        },
        max_s: 60.0,
    }
}

/// Along x from -4 to 4 m, 4 m ahead.
pub(crate) fn pursuit() -> PursuitScript {
    PursuitScript {
        way_points: vec![(-4.0, 4.0), (0.0, 4.0), (4.0, 4.0)],
        speed_m_per_s: 1.0,
        log_speed_std_dev: 0.0,
        speed_variation: OrnsteinUhlenbeck { std_dev: 0.0, time_constant_s: 1.0 },
        weave: OrnsteinUhlenbeck { std_dev: 0.0, time_constant_s: 1.0 },
        look_ahead_m: 0.3,
        way_point_jitter_m: 0.0,
        heading_gain: 3.5,
        max_turn_rad_per_s: 2.5,
        surge_lag_s: 0.1,
        turn_lag_s: 0.1,
        corner_slow_down: 0.5,
        arrival_m: 0.0,
        stand_before_s: 0.0,
        stand_after_s: 0.0,
        pauses_per_s: 0.0,
        range_exponent: 0.0,
        leg_end_slow_down: 0.0,
        corner_pauses: 0.0,
        pause_s: 0.0,
    }
}
