//! Vehicle profiles: all properties in which the cameras of two vehicles may differ.
//!
//! No other place in the program contains a vehicle's signs, gains, rate limits or latencies. Inside the
//! program, pan > 0 turns the view right and tilt > 0 turns it up. [`VehicleProfile::to_vehicle`] converts a
//! command to the vehicle's own signs and applies its limits and least rates, once, at the vehicle boundary.

use core::time::Duration;

use crate::angle::{Angle, AngularRate};
use crate::command::CameraCommand;
use crate::lens::Lens;
use crate::mavlink::MavlinkPeers;
use crate::speed_curve::AxisSpeeds;
use crate::telemetry::{EulerAxis, Quaternion};
use crate::zoom::{ZoomDynamics, ZoomRate};

mod built_in;

/// The longest [`VehicleProfile::coast_motion`] that is used: a camera never turns longer than this without a
/// fresh look.
pub const MAX_COAST_MOTION: Duration = Duration::from_millis(500);

/// One degree, radians.
const DEGREE: f64 = core::f64::consts::PI / 180.0;

/// A vehicle and how to move its camera.
///
/// ```
/// use barrelman_vocab::{AngularRate, CameraCommand, VehicleProfile};
///
/// let profile = VehicleProfile::fotokite_pro();
/// let rate = AngularRate::from_radians_per_second(0.2);
/// let pan_right = CameraCommand::turning(rate, AngularRate::ZERO);
/// // The Fotokite Pro counts yaw the other way.
/// let rates = profile.to_vehicle(pan_right);
/// assert_eq!(rates.yaw, -rate);
/// assert_eq!(profile.from_vehicle(rates), pan_right);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleProfile {
    /// Name on the command line.
    pub name: String,
    /// Protocol of the vehicle's link.
    pub protocol: Protocol,
    /// The region the target may roam in.
    pub region: RegionShares,
    /// The size in which a zoom keeps the target.
    pub size: SizeKeeping,
    /// The fixed rates of the motor schema.
    pub motor_schema_rates: AxisRates,
    /// The largest rates that the vehicle accepts.
    pub limits: AxisRates,
    /// Signs of the vehicle's rates.
    pub signs: AxisSigns,
    /// Dynamics of the camera, for predictive laws.
    pub camera: CameraDynamics,
    /// Nominal time from the sensor to the arrival of a video frame.
    pub video_latency: Duration,
    /// How much older than `video_latency` a video frame may be on arrival before it counts as stale.
    pub stale_after: Duration,
    /// How long a rate may stay in force after the last fresh localisation arrived, at most
    /// [`MAX_COAST_MOTION`].
    pub coast_motion: Duration,
    /// How far the vehicle may turn about the vertical.
    pub net_yaw: NetYawLimits,
    /// How the reported attitude of the gimbal tells the tilt; `None`: not known, and the reports are not
    /// used.
    pub gimbal_tilt: Option<GimbalTilt>,
    /// The sense of the yaw in the reported attitude of the vehicle; `None`: not known, and the reports are
    /// not used.
    pub attitude_yaw: Option<Sign>,
    /// The rates at the vehicle's speeds, where those have no unit; `None`: they have one, or were not
    /// measured.
    pub speeds: Option<AxisSpeeds>,
    /// The camera's zoom; `None`: the camera has none, or it is not moved.
    pub zoom: Option<ZoomDynamics>,
}

/// Limits of the net yaw: every turn of the vehicle twists its tether.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetYawLimits {
    /// From this size on, the operator is warned.
    pub warn: Angle,
    /// From this size on, the vehicle turns back only.
    pub refuse: Angle,
}

impl NetYawLimits {
    /// One and a half turns, and three. No document of a vehicle states what its tether bears.
    pub const DEFAULT: Self = Self { warn: Angle::from_degrees(540.0), refuse: Angle::from_degrees(1080.0) };
}

/// The tilt in the reported attitude of a gimbal: one of the angles of its quaternion, with a sense and a
/// zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GimbalTilt {
    /// The angle of the quaternion.
    pub axis: EulerAxis,
    /// The sense of that angle relative to the tilt (positive upwards).
    pub sign: Sign,
    /// The tilt at which that angle is zero.
    pub zero: Angle,
}

impl GimbalTilt {
    /// The tilt of a reported attitude; `None`: the quaternion has no direction.
    pub fn tilt(&self, attitude: Quaternion) -> Option<Angle> {
        let angle = attitude.angle_about(self.axis)?.radians();
        let raised = match self.sign {
            Sign::Same => angle,
            Sign::Opposite => -angle,
        };
        Some(Angle::from_radians(self.zero.radians() + raised))
    }
}

/// The largest rates of a vehicle whose protocol states none. The limit is our own: ArduPilot carries out 7
/// rad/s.
pub const OWN_RATE_LIMITS: AxisRates = AxisRates {
    pan: AngularRate::from_radians_per_second(0.5),
    tilt: AngularRate::from_radians_per_second(0.5),
};

/// The protocol of a vehicle's link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Protocol {
    /// The Fotokite Pro ground station's serial text protocol.
    FotokitePro,
    /// The Fotokite Sigma's web API.
    FotokiteSigma,
    /// A MAVLink gimbal manager, between these peers.
    MavlinkGimbal(MavlinkPeers),
    /// The PTZ service of an ONVIF camera.
    OnvifPtz,
}

impl Protocol {
    /// Whether the vehicle keeps the last rate for ever when nobody is there any more to send another one.
    pub const fn keeps_last_rate(self) -> bool {
        match self {
            // ArduPilot's gimbal manager turns to its end stops.
            Self::FotokitePro | Self::MavlinkGimbal(_) => true,
            // Each command to turn names its duration.
            Self::FotokiteSigma | Self::OnvifPtz => false,
        }
    }

    /// Whether the protocol has commands to zoom.
    pub const fn zooms(self) -> bool {
        match self {
            Self::FotokitePro => false,
            Self::FotokiteSigma | Self::MavlinkGimbal(_) | Self::OnvifPtz => true,
        }
    }

    /// How the vehicle's link is addressed.
    pub const fn addressing(self) -> Addressing {
        match self {
            Self::FotokitePro | Self::MavlinkGimbal(_) => Addressing::Line,
            Self::FotokiteSigma => Addressing::HttpApi,
            Self::OnvifPtz => Addressing::Onvif,
        }
    }

    /// Whether the speeds that the vehicle takes are rates. Otherwise they are shares of its largest ones
    /// ([`VehicleProfile::speeds`]).
    pub const fn speeds_are_rates(self) -> bool {
        match self {
            Self::FotokitePro | Self::FotokiteSigma | Self::MavlinkGimbal(_) => true,
            Self::OnvifPtz => false,
        }
    }

    /// The reports that show the camera's motion.
    pub const fn motion_reports(self) -> MotionReports {
        match self {
            Self::MavlinkGimbal(_) | Self::OnvifPtz => MotionReports::Held,
            Self::FotokiteSigma => MotionReports::Swaying,
            Self::FotokitePro => MotionReports::Attitudes,
        }
    }

    /// Who speaks to whom; `None`: the protocol is not MAVLink.
    pub const fn mavlink_peers(self) -> Option<MavlinkPeers> {
        match self {
            Self::MavlinkGimbal(peers) => Some(peers),
            Self::FotokitePro | Self::FotokiteSigma | Self::OnvifPtz => None,
        }
    }

    /// The largest rates that the protocol's client ever writes, whatever a profile or a configuration says.
    ///
    /// Fotokite Pro: yaw 0.4 and gimbal pitch 0.3 rad/s, which the vehicle's known clients keep. Fotokite
    /// Sigma: 25 degrees per second on both axes, the example of its API document; what the vehicle itself
    /// states, if less, holds too. MAVLink gimbal, ONVIF camera: [`OWN_RATE_LIMITS`].
    pub const fn rate_limits(self) -> AxisRates {
        match self {
            Self::FotokitePro => AxisRates {
                pan: AngularRate::from_radians_per_second(0.4),
                tilt: AngularRate::from_radians_per_second(0.3),
            },
            Self::FotokiteSigma => AxisRates {
                pan: AngularRate::from_radians_per_second(25.0 * DEGREE),
                tilt: AngularRate::from_radians_per_second(25.0 * DEGREE),
            },
            Self::MavlinkGimbal(_) | Self::OnvifPtz => OWN_RATE_LIMITS,
        }
    }
}

/// How a vehicle's link is addressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Addressing {
    /// A serial line, or a network in its place, that carries bytes.
    Line,
    /// The base address of an API over HTTP.
    HttpApi,
    /// The address of a camera with ONVIF's services.
    Onvif,
}

/// Which of a vehicle's reports show its camera's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionReports {
    /// Pan and tilt, held by a gimbal.
    Held,
    /// Pan and tilt of a camera that sways.
    Swaying,
    /// The attitudes of a flight unit, which turns about the vertical, and of its gimbal.
    Attitudes,
}

/// The elliptical region as shares of the picture: the semi-axes are `half_width` x W/2 and `half_height` x
/// H/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionShares {
    /// Horizontal semi-axis as a share of half the picture's width, in (0, 1].
    pub half_width: f64,
    /// Vertical semi-axis as a share of half the picture's height, in (0, 1].
    pub half_height: f64,
}

/// How a zoom keeps a target's size: the longer side of its box as a share of the picture's height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeKeeping {
    /// Above 0, below `largest`.
    pub smallest: f64,
    /// At most 1.
    pub largest: f64,
    /// Whether the size is kept from the start of a run.
    pub is_on_at_start: bool,
}

impl SizeKeeping {
    /// From 14 to 86 pixels of 720: a boat of 1.2 m is recognised from 12 pixels on, and leaves room around
    /// it up to an eighth.
    pub const DEFAULT: Self = Self { smallest: 0.02, largest: 0.12, is_on_at_start: false };
}

/// One rate for each camera axis, both at least zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisRates {
    /// Pan.
    pub pan: AngularRate,
    /// Tilt.
    pub tilt: AngularRate,
}

/// Nominal dynamics and optics of a camera, as a law assumes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDynamics {
    /// Focal length divided by the picture's width, both in pixels.
    pub focal_share: f64,
    /// The calibrated lens, with which points on the water are computed; `None`: a pinhole of `focal_share`.
    pub lens: Option<Lens>,
    /// Elevation of the camera's axis at the start if no telemetry reports it; negative below the horizon.
    pub initial_tilt: Angle,
    /// Lower and upper end stop of the elevation.
    pub tilt_stops: (Angle, Angle),
    /// Dynamics of the pan axis.
    pub pan: AxisDynamics,
    /// Dynamics of the tilt axis.
    pub tilt: AxisDynamics,
}

/// The response of one axis to a commanded rate: a dead time, then a first-order lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisDynamics {
    /// Time from a non-zero command to the start of its effect, without the video latency.
    pub start_dead_time: Duration,
    /// Time from a zero command to the start of its effect; at least `start_dead_time`.
    pub stop_dead_time: Duration,
    /// Time constant of the rate after the dead time.
    pub lag: Duration,
    /// The smallest non-zero rate at which the axis turns.
    pub min_rate: AngularRate,
    /// The rate that the axis reaches, divided by the rate that is sent to it; above zero.
    pub gain: f64,
}

/// Signs of the vehicle's rates relative to [`CameraCommand`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisSigns {
    /// Sign of the yaw rate relative to pan.
    pub yaw: Sign,
    /// Sign of the pitch rate relative to tilt.
    pub pitch: Sign,
}

/// Same or opposite direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// The vehicle's positive direction is that of [`CameraCommand`].
    Same,
    /// The vehicle's positive direction is the opposite.
    Opposite,
}

impl Sign {
    fn apply(self, rate: AngularRate) -> AngularRate {
        match self {
            // Negated twice: negation removes the sign of a negative zero.
            Self::Same => -(-rate),
            Self::Opposite => -rate,
        }
    }
}

/// Rates in a vehicle's own signs and within its limits, as they are sent on the link.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleRates {
    /// Yaw rate; the vehicle defines the positive direction.
    pub yaw: AngularRate,
    /// Pitch rate; the vehicle defines the positive direction.
    pub pitch: AngularRate,
    /// Speed of the zoom, -1 to 1 of its largest; positive to a closer view.
    pub zoom: f64,
}

impl VehicleRates {
    /// All axes at rest.
    pub const REST: Self = Self::turning(AngularRate::ZERO, AngularRate::ZERO);

    /// Rates that turn the camera and do not zoom.
    pub const fn turning(yaw: AngularRate, pitch: AngularRate) -> Self {
        Self { yaw, pitch, zoom: 0.0 }
    }

    /// The same rates with this speed of the zoom, -1 to 1 of its largest.
    #[must_use]
    pub const fn zooming(self, zoom: f64) -> Self {
        Self { zoom, ..self }
    }

    /// These rates as pan and tilt, where they were sent for `command`: their sizes, in the command's senses.
    /// The profile is not needed, as limits make a rate smaller and signs only turn it.
    #[must_use]
    pub fn in_the_senses_of(self, command: CameraCommand) -> CameraCommand {
        CameraCommand {
            pan: command.pan.clamped(self.yaw),
            tilt: command.tilt.clamped(self.pitch),
            zoom: if self.zoom == 0.0 { ZoomRate::ZERO } else { command.zoom },
        }
    }

    /// Yaw and pitch in rad/s, and the speed of the zoom.
    pub const fn parts(self) -> [f64; 3] {
        [self.yaw.radians_per_second(), self.pitch.radians_per_second(), self.zoom]
    }

    /// Whether all rates are zero.
    pub fn is_rest(self) -> bool {
        self.yaw.is_zero() && self.pitch.is_zero() && self.zoom == 0.0
    }
}

impl VehicleProfile {
    /// The largest rate of the zoom; zero for a camera without zoom.
    pub fn max_zoom_rate(&self) -> ZoomRate {
        self.zoom.map_or(ZoomRate::ZERO, |zoom| zoom.max_rate)
    }

    /// The largest rates that may be sent, in the vehicle's own axes.
    pub fn largest_rates(&self) -> VehicleRates {
        VehicleRates::turning(self.limits.pan, self.limits.tilt)
            .zooming(f64::from(u8::from(self.zoom.is_some())))
    }

    /// Whether the vehicle keeps the last rate for ever when the program is gone. Its port then belongs to a
    /// guard.
    pub const fn keeps_last_rate(&self) -> bool {
        self.protocol.keeps_last_rate()
    }

    /// The same vehicle with measured speeds: its limits are at most the largest rates, and its least rates
    /// those of the curves.
    #[must_use]
    pub fn with_speeds(mut self, speeds: AxisSpeeds) -> Self {
        self.limits = AxisRates {
            pan: self.limits.pan.clamped(speeds.pan.largest()),
            tilt: self.limits.tilt.clamped(speeds.tilt.largest()),
        };
        self.motor_schema_rates = AxisRates {
            pan: self.motor_schema_rates.pan.clamped(self.limits.pan),
            tilt: self.motor_schema_rates.tilt.clamped(self.limits.tilt),
        };
        (self.camera.pan.min_rate, self.camera.tilt.min_rate) = (speeds.pan.least(), speeds.tilt.least());
        self.speeds = Some(speeds);
        self
    }

    /// The same vehicle with another motor schema rate on both axes. Limits below that rate are raised to it,
    /// so that experiments with higher rates are not clipped.
    #[must_use]
    pub fn with_motor_schema_rate(mut self, rate: AngularRate) -> Self {
        let raised = |limit: AngularRate| if limit < rate { rate } else { limit };
        self.motor_schema_rates = AxisRates { pan: rate, tilt: rate };
        self.limits = AxisRates { pan: raised(self.limits.pan), tilt: raised(self.limits.tilt) };
        self
    }

    /// What the vehicle can execute of a command of any source. Rates above their limit are reduced to it. A
    /// rate below the least rate of its axis becomes the least rate, or zero if it is less than half of it.
    /// With a reported tilt, no rate leads beyond an end stop. A camera without zoom does not zoom.
    pub fn executable(&self, command: CameraCommand, tilt: Option<Angle>) -> CameraCommand {
        let (low, high) = self.camera.tilt_stops;
        let leads_beyond_stop = tilt.is_some_and(|tilt| {
            let (tilt, rate) = (tilt.radians(), command.tilt.radians_per_second());
            (rate > 0.0 && tilt >= high.radians()) || (rate < 0.0 && tilt <= low.radians())
        });
        let wanted_tilt = if leads_beyond_stop { AngularRate::ZERO } else { command.tilt };
        CameraCommand {
            pan: executable_rate(command.pan, self.limits.pan, &self.camera.pan),
            tilt: executable_rate(wanted_tilt, self.limits.tilt, &self.camera.tilt),
            zoom: command.zoom.clamped(self.max_zoom_rate()),
        }
    }

    /// The vehicle boundary: converts a command to rates in the vehicle's own signs that it can execute.
    pub fn to_vehicle(&self, command: CameraCommand) -> VehicleRates {
        let CameraCommand { pan, tilt, zoom } = self.executable(command, None);
        let sent = |rate: AngularRate, axis: &AxisDynamics| rate * axis.gain.recip();
        VehicleRates {
            yaw: self.signs.yaw.apply(sent(pan, &self.camera.pan)).clamped(self.limits.pan),
            pitch: self.signs.pitch.apply(sent(tilt, &self.camera.tilt)).clamped(self.limits.tilt),
            zoom: self.zoom.map_or(0.0, |dynamics| zoom.share_of(dynamics.max_rate)),
        }
    }

    /// The vehicle boundary in the other direction, for simulated vehicles: converts rates in the vehicle's
    /// own signs to a command. Limits are not applied.
    pub fn from_vehicle(&self, rates: VehicleRates) -> CameraCommand {
        CameraCommand {
            pan: self.signs.yaw.apply(rates.yaw) * self.camera.pan.gain,
            tilt: self.signs.pitch.apply(rates.pitch) * self.camera.tilt.gain,
            zoom: ZoomRate::from_per_second(rates.zoom * self.max_zoom_rate().per_second()),
        }
    }
}

/// A rate that the vehicle reaches within the limit of what is sent, and not below the least rate at which
/// the axis turns. An axis whose least rate is above its limit does not turn.
fn executable_rate(rate: AngularRate, limit: AngularRate, axis: &AxisDynamics) -> AngularRate {
    let (limit, min_rate) = (limit * axis.gain, axis.min_rate);
    let rate = rate.clamped(limit);
    let (size, min) = (rate.abs().radians_per_second(), min_rate.radians_per_second());
    if rate.is_zero() || size >= min {
        rate
    } else if size < 0.5 * min || min_rate > limit.abs() {
        AngularRate::ZERO
    } else {
        AngularRate::from_radians_per_second(min.copysign(rate.radians_per_second()))
    }
}
