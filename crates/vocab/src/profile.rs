//! Vehicle profiles: everything in which one vehicle's camera differs from another's.
//!
//! No sign, gain, rate limit or latency of a vehicle is written anywhere else. Inside the program pan > 0 turns
//! the view right and tilt > 0 raises it; [`VehicleProfile::to_vehicle`] turns that into the vehicle's own signs,
//! once, where a command leaves.

use core::time::Duration;

use crate::angle::{Angle, AngularRate};
use crate::command::CameraCommand;

/// What a vehicle is and how its camera is to be moved.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleProfile {
    /// The name that the command line knows it by.
    pub name: String,
    /// What is spoken on its link.
    pub protocol: Protocol,
    /// The region the target may roam in.
    pub region: RegionShares,
    /// The fixed rates of the motor schemas.
    pub motor_schema_rates: AxisRates,
    /// What the vehicle can do at most.
    pub limits: AxisRates,
    /// The vehicle's own signs.
    pub signs: AxisSigns,
    /// How its camera answers, for laws that predict.
    pub camera: CameraDynamics,
    /// Nominal time from the sensor to the arrival of a video frame.
    pub video_latency: Duration,
    /// How much older than `video_latency` a video frame may be on arrival before it counts as stale.
    pub stale_after: Duration,
    /// How long a rate may stay in force after the last fresh localisation arrived.
    pub coast_motion: Duration,
}

/// What is spoken on a vehicle's link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Protocol {
    /// The Fotokite Pro ground station's serial text protocol.
    FotokitePro,
}

/// The elliptical region as shares of the picture: its semi-axes are `half_width` x W/2 and `half_height` x H/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionShares {
    /// Share of half the picture's width, above 0, at most 1.
    pub half_width: f64,
    /// Share of half the picture's height, above 0, at most 1.
    pub half_height: f64,
}

/// A rate for each of the camera's axes, both at least zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisRates {
    /// Pan.
    pub pan: AngularRate,
    /// Tilt.
    pub tilt: AngularRate,
}

/// How a camera answers commands and what it sees: the nominal values, which a law goes by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDynamics {
    /// Focal length as a share of the picture's width.
    pub focal_share: f64,
    /// The camera's elevation at the start where no telemetry tells; negative looks down.
    pub initial_tilt: Angle,
    /// The end stops of that elevation, lower and upper.
    pub tilt_stops: (Angle, Angle),
    /// The axis that pans.
    pub pan: AxisDynamics,
    /// The axis that tilts.
    pub tilt: AxisDynamics,
}

/// How one axis answers a rate that is asked of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisDynamics {
    /// From a command that moves to the start of its effect, without the video's latency.
    pub start_dead_time: Duration,
    /// From a zero to the start of its effect; not less.
    pub stop_dead_time: Duration,
    /// Time constant of the rate after that.
    pub lag: Duration,
    /// The least rate other than zero that it turns at.
    pub min_rate: AngularRate,
}

/// How the vehicle's own rates are signed against ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisSigns {
    /// Its yaw rate against our pan.
    pub yaw: Sign,
    /// Its pitch rate against our tilt.
    pub pitch: Sign,
}

/// Same or opposite sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The vehicle counts as we do.
    Same,
    /// The vehicle counts the other way.
    Opposite,
}

impl Sign {
    fn apply(self, rate: AngularRate) -> AngularRate {
        match self {
            // Twice the opposite: a zero loses its sign on either way.
            Self::Same => -(-rate),
            Self::Opposite => -rate,
        }
    }
}

/// Rates in a vehicle's own signs, within its limits: what goes out on the link.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleRates {
    /// Yaw, in the vehicle's sense.
    pub yaw: AngularRate,
    /// Pitch, in the vehicle's sense.
    pub pitch: AngularRate,
}

impl VehicleRates {
    /// Both axes at rest.
    pub const REST: Self = Self { yaw: AngularRate::ZERO, pitch: AngularRate::ZERO };

    /// Whether no motion is asked for on either axis.
    pub fn is_rest(self) -> bool {
        self.yaw.is_zero() && self.pitch.is_zero()
    }
}

impl CameraDynamics {
    /// The Fotokite Pro's camera as identified from the recorded laboratory trials, the camera's 0.10 s taken off the
    /// dead times.
    pub fn laboratory() -> Self {
        let axis = |start_ms, stop_ms, lag_ms| AxisDynamics {
            start_dead_time: Duration::from_millis(start_ms),
            stop_dead_time: Duration::from_millis(stop_ms),
            lag: Duration::from_millis(lag_ms),
            min_rate: AngularRate::ZERO,
        };
        Self {
            focal_share: 330.0 / 640.0,
            initial_tilt: Angle::from_degrees(-24.0),
            tilt_stops: (Angle::from_degrees(-90.0), Angle::from_degrees(10.0)),
            pan: axis(200, 400, 420),
            tilt: axis(100, 400, 100),
        }
    }
}

impl VehicleProfile {
    /// The Fotokite Pro as the paper's authors flew it: negative yaw turns the view right, negative pitch
    /// raises it; 0.3 rad/s on both axes; yaw limited to 0.4 and gimbal pitch to 0.3 rad/s by its clients.
    pub fn fotokite_pro() -> Self {
        let rad_per_s = AngularRate::from_radians_per_second;
        Self {
            name: "fotokite-pro".to_owned(),
            protocol: Protocol::FotokitePro,
            region: RegionShares { half_width: 0.6, half_height: 0.5 },
            motor_schema_rates: AxisRates { pan: rad_per_s(0.3), tilt: rad_per_s(0.3) },
            limits: AxisRates { pan: rad_per_s(0.4), tilt: rad_per_s(0.3) },
            signs: AxisSigns { yaw: Sign::Opposite, pitch: Sign::Opposite },
            camera: CameraDynamics::laboratory(),
            video_latency: Duration::from_millis(200),
            stale_after: Duration::from_millis(300),
            coast_motion: Duration::from_millis(250),
        }
    }

    /// The same vehicle with another rate of the schema on both axes. A limit below it is raised: who asks what
    /// another rate would do asks about a vehicle that can turn so fast.
    #[must_use]
    pub fn with_motor_schema_rate(mut self, rate: AngularRate) -> Self {
        let raised = |limit: AngularRate| if limit < rate { rate } else { limit };
        self.motor_schema_rates = AxisRates { pan: rate, tilt: rate };
        self.limits = AxisRates { pan: raised(self.limits.pan), tilt: raised(self.limits.tilt) };
        self
    }

    /// The door from the other side, for whoever plays the vehicle: rates in its own signs as our command.
    pub fn from_vehicle(&self, rates: VehicleRates) -> CameraCommand {
        CameraCommand { pan: self.signs.yaw.apply(rates.yaw), tilt: self.signs.pitch.apply(rates.pitch) }
    }

    /// The door: a command inside becomes rates in the vehicle's own signs, within its limits.
    pub fn to_vehicle(&self, command: CameraCommand) -> VehicleRates {
        VehicleRates {
            yaw: self.signs.yaw.apply(command.pan.clamped(self.limits.pan)),
            pitch: self.signs.pitch.apply(command.tilt.clamped(self.limits.tilt)),
        }
    }
}
