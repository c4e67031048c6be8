//! The profiles that the program knows by name.

use core::time::Duration;

use super::{
    AxisDynamics, AxisRates, AxisSigns, CameraDynamics, DEGREE, NetYawLimits, Protocol, RegionShares, Sign,
    SizeKeeping, VehicleProfile,
};
use crate::angle::{Angle, AngularRate};
use crate::mavlink::MavlinkPeers;
use crate::zoom::ZoomDynamics;

impl CameraDynamics {
    /// The Fotokite Pro's camera as identified from the recorded laboratory trials. The camera's video
    /// latency of 0.10 s is subtracted from the dead times.
    pub fn laboratory() -> Self {
        let axis = |start_ms, stop_ms, lag_ms| AxisDynamics {
            start_dead_time: Duration::from_millis(start_ms),
            stop_dead_time: Duration::from_millis(stop_ms),
            lag: Duration::from_millis(lag_ms),
            min_rate: AngularRate::ZERO,
            gain: 1.0,
        };
        Self {
            focal_share: 330.0 / 640.0,
            lens: None,
            initial_tilt: Angle::from_degrees(-24.0),
            tilt_stops: (Angle::from_degrees(-90.0), Angle::from_degrees(10.0)),
            pan: axis(200, 400, 420),
            tilt: axis(100, 400, 100),
        }
    }
}

impl VehicleProfile {
    /// Names of the built-in profiles; the first is the default.
    pub const NAMES: [&str; 4] = ["fotokite-pro", "fotokite-sigma", "mavlink-gimbal", "onvif-ptz"];

    /// The built-in profile of a name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "fotokite-pro" => Some(Self::fotokite_pro()),
            "fotokite-sigma" => Some(Self::fotokite_sigma()),
            "mavlink-gimbal" => Some(Self::mavlink_gimbal()),
            "onvif-ptz" => Some(Self::onvif_ptz()),
            _ => None,
        }
    }

    /// The Fotokite Pro as the paper's authors flew it. Negative yaw turns the view right, negative pitch
    /// turns it up. The motor schema turns at 0.3 rad/s on both axes. The vehicle's clients limit yaw to 0.4
    /// rad/s and gimbal pitch to 0.3 rad/s.
    pub fn fotokite_pro() -> Self {
        let rad_per_s = AngularRate::from_radians_per_second;
        Self {
            name: "fotokite-pro".to_owned(),
            protocol: Protocol::FotokitePro,
            region: RegionShares { half_width: 0.6, half_height: 0.5 },
            size: SizeKeeping::DEFAULT,
            motor_schema_rates: AxisRates { pan: rad_per_s(0.3), tilt: rad_per_s(0.3) },
            limits: Protocol::FotokitePro.rate_limits(),
            signs: AxisSigns { yaw: Sign::Opposite, pitch: Sign::Opposite },
            camera: CameraDynamics::laboratory(),
            video_latency: Duration::from_millis(200),
            stale_after: Duration::from_millis(300),
            coast_motion: Duration::from_millis(250),
            net_yaw: NetYawLimits::DEFAULT,
            gimbal_tilt: None,
            attitude_yaw: None,
            speeds: None,
            zoom: None,
        }
    }

    /// Any gimbal behind a MAVLink gimbal manager. Positive yaw turns the view right, positive pitch turns it
    /// up. Attitude reports state the tilt above the horizon. The dynamics are those of the laboratory's
    /// camera, slower than most gimbals, until `barrelman calibrate axes` measures them. The end stops are
    /// those of a gimbal that looks straight down and a little up.
    pub fn mavlink_gimbal() -> Self {
        let protocol = Protocol::MavlinkGimbal(MavlinkPeers::DEFAULT);
        Self {
            name: "mavlink-gimbal".to_owned(),
            protocol,
            limits: protocol.rate_limits(),
            signs: AxisSigns { yaw: Sign::Same, pitch: Sign::Same },
            ..Self::fotokite_pro()
        }
    }

    /// Any PTZ camera with ONVIF's PTZ service. Positive pan turns the view right, positive tilt turns it up.
    /// How fast it turns at which speed is not known until `barrelman calibrate axes` has measured it; the
    /// camera is not moved before. The other dynamics are those of the laboratory's camera until then. The
    /// end stops are those of a dome that looks straight down.
    pub fn onvif_ptz() -> Self {
        Self {
            name: "onvif-ptz".to_owned(),
            protocol: Protocol::OnvifPtz,
            limits: Protocol::OnvifPtz.rate_limits(),
            signs: AxisSigns { yaw: Sign::Same, pitch: Sign::Same },
            video_latency: Duration::from_millis(300),
            ..Self::fotokite_pro()
        }
    }

    /// The Fotokite Sigma. Its API counts pan to the right and tilt downwards. Limits (25 degrees per
    /// second), least rates (2) and end stops (80 degrees below the kite's horizon, 11 above) are the
    /// examples of the API document; the session also keeps what the vehicle itself states. No document
    /// states the dynamics of the camera: those of the Pro hold until `barrelman calibrate axes` has measured
    /// them. The field of view is reported by the vehicle, and the zoom is that of the API document's
    /// example.
    pub fn fotokite_sigma() -> Self {
        let limits = Protocol::FotokiteSigma.rate_limits();
        let laboratory = CameraDynamics::laboratory();
        let least =
            |axis| AxisDynamics { min_rate: AngularRate::from_radians_per_second(2.0 * DEGREE), ..axis };
        Self {
            name: "fotokite-sigma".to_owned(),
            protocol: Protocol::FotokiteSigma,
            limits,
            signs: AxisSigns { yaw: Sign::Same, pitch: Sign::Opposite },
            camera: CameraDynamics {
                tilt_stops: (Angle::from_degrees(-80.0), Angle::from_degrees(11.0)),
                pan: least(laboratory.pan),
                tilt: least(laboratory.tilt),
                ..laboratory
            },
            zoom: Some(ZoomDynamics::usual(32.0)),
            ..Self::fotokite_pro()
        }
    }
}
