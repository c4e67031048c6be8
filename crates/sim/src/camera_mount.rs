//! The axes of a vehicle's camera: pan (yaw of the flight unit), tilt (pitch of the gimbal), and the zoom.

use barrelman_vocab::{Angle, AngularRate, CameraCommand, ZoomDynamics};

use crate::camera_axis::{AxisImperfections, AxisPlant, CameraAxis};
use crate::tick::TICKS_PER_SECOND;
use crate::zoom::CommandedZoom;

/// Ticks from one report of the tilt to the next, where the gimbal reports its tilt: 10 Hz.
pub const TICKS_PER_TILT_REPORT: u32 = TICKS_PER_SECOND / 10;

/// Dynamics of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountPlant {
    /// Pan.
    pub pan: AxisPlant,
    /// Tilt.
    pub tilt: AxisPlant,
    /// Share of each axis's rate that is added to the other axis.
    pub cross_talk: f64,
    /// Rate at which the tilt sinks by itself, rad/s.
    pub droop_rad_per_s: f64,
    /// The zoom; `None`: the camera has none.
    pub zoom: Option<ZoomDynamics>,
}

impl MountPlant {
    /// The laboratory's Fotokite Pro, identified from its recorded trials. The identified values are:
    /// yaw 0.30 s dead time to start, 0.50 s to stop, lag 0.42 s; pitch 0.20 s, 0.50 s, 0.10 s. The plant's
    /// dead times are these less 0.10 s, the camera's share of the measurement. The travel of the gimbal is
    /// not known; assumed: straight down to 10 degrees above level.
    pub fn laboratory() -> Self {
        let max_rate = AngularRate::from_radians_per_second;
        Self {
            pan: AxisPlant {
                start_dead_time_s: 0.20,
                stop_dead_time_s: 0.40,
                lag_s: 0.42,
                max_rate: max_rate(0.4),
                end_stops: None,
                imperfections: AxisImperfections::default(),
            },
            tilt: AxisPlant {
                start_dead_time_s: 0.10,
                stop_dead_time_s: 0.40,
                lag_s: 0.10,
                max_rate: max_rate(0.3),
                end_stops: Some((Angle::from_degrees(-90.0), Angle::from_degrees(10.0))),
                imperfections: AxisImperfections::default(),
            },
            cross_talk: 0.0,
            droop_rad_per_s: 0.0,
            zoom: None,
        }
    }
}

/// A camera on its two axes.
#[derive(Debug, Clone)]
pub struct CameraMount {
    /// Pan: 0 at the start, positive to the right.
    pub pan: CameraAxis,
    /// Tilt: 0 is level, positive upwards.
    pub tilt: CameraAxis,
    zoom: Option<CommandedZoom>,
    cross_talk: f64,
    droop_rad_per_s: f64,
    tick: u64,
}

impl CameraMount {
    /// A camera at rest that looks straight ahead and down by `depression`.
    pub fn at_rest(plant: MountPlant, depression: Angle) -> Self {
        Self::at_angles(plant, Angle::ZERO, Angle::from_radians(-depression.radians()))
    }

    /// A camera at rest at these angles.
    pub fn at_angles(plant: MountPlant, pan: Angle, tilt: Angle) -> Self {
        Self {
            pan: CameraAxis::at_rest(plant.pan, pan),
            tilt: CameraAxis::at_rest(plant.tilt, tilt),
            zoom: plant.zoom.map(CommandedZoom::at_rest),
            cross_talk: plant.cross_talk,
            droop_rad_per_s: plant.droop_rad_per_s,
            tick: 0,
        }
    }

    /// Passes a command to the axes, at the present tick.
    pub fn command(&mut self, command: CameraCommand) {
        self.pan.command(command.pan, self.tick);
        self.tilt.command(command.tilt, self.tick);
        if let Some(zoom) = &mut self.zoom {
            zoom.command(command.zoom, self.tick);
        }
    }

    /// Advances by one tick.
    pub fn advance(&mut self) {
        let (pan, tilt) = (self.pan.rate().radians_per_second(), self.tilt.rate().radians_per_second());
        self.pan.advance_with_disturbance(self.tick, self.cross_talk * tilt);
        self.tilt.advance_with_disturbance(self.tick, self.cross_talk * pan - self.droop_rad_per_s);
        if let Some(zoom) = &mut self.zoom {
            zoom.advance(self.tick);
        }
        self.tick += 1;
    }

    /// The focal length over that of the widest view; `None`: the camera does not zoom by command.
    pub fn zoom_factor(&self) -> Option<f64> {
        self.zoom.as_ref().map(CommandedZoom::factor)
    }

    /// Ticks so far.
    pub const fn tick(&self) -> u64 {
        self.tick
    }
}
