//! Outcomes of steps, to and from their stored form.

use core::time::Duration;

use barrelman_control::Percept;
use barrelman_pilot::{Advice, Mode};
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::{
    Angle, AngularRate, CameraCommand, ImagePoint, Timestamp, Track, VehicleRates, VesselCommand, WaterPoint,
    ZoomRate,
};

use super::malformed::{Malformed, missing};
use crate::records::entry::{RecordedMark, RecordedOutcome, RecordedProgress, RecordedVessel};
use crate::records::stored;

fn nanos(span: Duration) -> u64 {
    u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)
}

impl From<&RecordedOutcome> for stored::Outcome {
    fn from(outcome: &RecordedOutcome) -> Self {
        let (mut hold, mut stop) = (stored::HoldCause::None, stored::StopCause::None);
        let mode = match outcome.mode {
            Mode::Idle => stored::Mode::Idle,
            Mode::Servoing => stored::Mode::Servoing,
            Mode::Nudging => stored::Mode::Nudging,
            Mode::Searching => stored::Mode::Searching,
            Mode::Calibrating => stored::Mode::Calibrating,
            Mode::Holding(why) => {
                hold = why.into();
                stored::Mode::Holding
            }
            Mode::Stopped(cause) => {
                stop = cause.into();
                stored::Mode::Stopped
            }
        };
        let sector = outcome.advice.and_then(|advice| advice.sector);
        Self {
            step: outcome.step,
            now_ns: outcome.at.as_nanos(),
            mode: mode as i32,
            hold_cause: hold as i32,
            stop_cause: stop as i32,
            track: Some((&outcome.track).into()),
            age_ns: outcome.age.map(nanos),
            percept: outcome.percept.map(|percept| stored::Percept {
                x: percept.position.x,
                y: percept.position.y,
                p: percept.p,
                r_px: percept.r_px,
                direction_rad: percept.direction.radians(),
            }),
            advised_pan: outcome.advice.map(|advice| advice.command.pan.radians_per_second()),
            advised_tilt: outcome.advice.map(|advice| advice.command.tilt.radians_per_second()),
            advised_zoom: outcome.advice.map(|advice| advice.command.zoom.per_second()),
            sector: sector.map_or(stored::Sector::None, Into::into) as i32,
            pan: outcome.command.pan.radians_per_second(),
            tilt: outcome.command.tilt.radians_per_second(),
            zoom: outcome.command.zoom.per_second(),
            zoom_speed: outcome.rates.zoom,
            yaw_rate: outcome.rates.yaw.radians_per_second(),
            pitch_rate: outcome.rates.pitch.radians_per_second(),
            wake_at_ns: outcome.wake_at.map(Timestamp::as_nanos),
            vessel: outcome.vessel.as_deref().map(Into::into),
            notice: outcome.notice.clone(),
        }
    }
}

impl From<&RecordedVessel> for stored::VesselOutcome {
    fn from(vessel: &RecordedVessel) -> Self {
        let progress = vessel.progress;
        let destination = vessel.destination.and_then(|(_, point)| point);
        Self {
            mode: vessel.mode.clone(),
            throttle: vessel.command.throttle,
            rudder: vessel.command.rudder,
            renew_by_ns: vessel.renew_by.map(Timestamp::as_nanos),
            boat_x_m: progress.map(|progress| progress.boat.x),
            boat_y_m: progress.map(|progress| progress.boat.y),
            speed_m_per_s: progress.map(|progress| progress.speed_m_per_s),
            course_rad: progress.and_then(|progress| progress.course_rad),
            distance_m: progress.map(|progress| progress.distance_m),
            cross_track_m: progress.map(|progress| progress.cross_track_m),
            destination: vessel.destination.map_or(0, |(id, _)| id),
            destination_x_m: destination.map(|point| point.x),
            destination_y_m: destination.map(|point| point.y),
            marks: vessel.marks.iter().copied().map(Into::into).collect(),
            view: vessel.view.into_iter().flatten().map(Into::into).collect(),
            boat_on_earth: vessel.boat_on_earth.map(Into::into),
        }
    }
}

impl From<WaterPoint> for stored::WaterPoint {
    fn from(WaterPoint { x, y }: WaterPoint) -> Self {
        Self { x_m: x, y_m: y }
    }
}

impl From<stored::WaterPoint> for WaterPoint {
    fn from(point: stored::WaterPoint) -> Self {
        Self { x: point.x_m, y: point.y_m }
    }
}

impl From<GeoPoint> for stored::GeoPoint {
    fn from(GeoPoint { latitude, longitude }: GeoPoint) -> Self {
        Self { latitude_rad: latitude.radians(), longitude_rad: longitude.radians() }
    }
}

impl From<stored::GeoPoint> for GeoPoint {
    fn from(point: stored::GeoPoint) -> Self {
        Self {
            latitude: Angle::from_radians(point.latitude_rad),
            longitude: Angle::from_radians(point.longitude_rad),
        }
    }
}

impl From<RecordedMark> for stored::VesselMark {
    fn from(mark: RecordedMark) -> Self {
        Self {
            id: mark.id,
            kind: stored::MarkKind::from(mark.kind) as i32,
            at: Some(mark.at.into()),
            radius_m: mark.radius_m,
            std_dev_m: mark.std_dev_m,
            on_earth: mark.on_earth.map(Into::into),
            held: mark.held.as_ref().map(Into::into),
        }
    }
}

impl TryFrom<stored::VesselMark> for RecordedMark {
    type Error = Malformed;

    fn try_from(mark: stored::VesselMark) -> Result<Self, Malformed> {
        Ok(Self {
            id: mark.id,
            kind: mark.kind().try_into()?,
            at: mark.at.ok_or_else(|| missing("at"))?.into(),
            radius_m: mark.radius_m,
            std_dev_m: mark.std_dev_m,
            on_earth: mark.on_earth.map(Into::into),
            held: mark.held.map(Track::try_from).transpose()?,
        })
    }
}

impl TryFrom<stored::VesselOutcome> for RecordedVessel {
    type Error = Malformed;

    fn try_from(vessel: stored::VesselOutcome) -> Result<Self, Malformed> {
        let point = |x: Option<f64>, y: Option<f64>| x.zip(y).map(|(x, y)| WaterPoint { x, y });
        let progress = || {
            Some(RecordedProgress {
                boat: point(vessel.boat_x_m, vessel.boat_y_m)?,
                speed_m_per_s: vessel.speed_m_per_s?,
                course_rad: vessel.course_rad,
                distance_m: vessel.distance_m?,
                cross_track_m: vessel.cross_track_m?,
            })
        };
        let destination = (vessel.destination > 0)
            .then(|| (vessel.destination, point(vessel.destination_x_m, vessel.destination_y_m)));
        let marks: Result<_, _> = vessel.marks.iter().copied().map(RecordedMark::try_from).collect();
        let corners: Vec<WaterPoint> = vessel.view.iter().copied().map(Into::into).collect();
        Ok(Self {
            progress: progress(),
            destination,
            marks: marks?,
            view: corners.try_into().ok(),
            boat_on_earth: vessel.boat_on_earth.map(Into::into),
            command: VesselCommand { throttle: vessel.throttle, rudder: vessel.rudder },
            renew_by: vessel.renew_by_ns.map(Timestamp::from_nanos),
            mode: vessel.mode,
        })
    }
}

impl TryFrom<stored::Outcome> for RecordedOutcome {
    type Error = Malformed;

    fn try_from(outcome: stored::Outcome) -> Result<Self, Malformed> {
        let rate = AngularRate::from_radians_per_second;
        let mode = match stored::Mode::try_from(outcome.mode).map_err(|_| missing("mode"))? {
            stored::Mode::Idle => Mode::Idle,
            stored::Mode::Servoing => Mode::Servoing,
            stored::Mode::Nudging => Mode::Nudging,
            stored::Mode::Searching => Mode::Searching,
            stored::Mode::Calibrating => Mode::Calibrating,
            stored::Mode::Holding => Mode::Holding(outcome.hold_cause().try_into()?),
            stored::Mode::Stopped => Mode::Stopped(outcome.stop_cause().try_into()?),
        };
        let sector = match stored::Sector::try_from(outcome.sector).map_err(|_| missing("sector"))? {
            stored::Sector::None => None,
            sector => Some(sector.try_into()?),
        };
        let advice = match (outcome.advised_pan, outcome.advised_tilt, outcome.advised_zoom) {
            (Some(pan), Some(tilt), Some(zoom)) => {
                let zoom = ZoomRate::from_per_second(zoom);
                Some(Advice { command: CameraCommand::turning(rate(pan), rate(tilt)).zooming(zoom), sector })
            }
            _ => None,
        };
        let zoom = ZoomRate::from_per_second(outcome.zoom);
        Ok(Self {
            step: outcome.step,
            at: Timestamp::from_nanos(outcome.now_ns),
            mode,
            age: outcome.age_ns.map(Duration::from_nanos),
            percept: outcome.percept.as_ref().map(|percept| Percept {
                position: ImagePoint { x: percept.x, y: percept.y },
                p: percept.p,
                r_px: percept.r_px,
                direction: Angle::from_radians(percept.direction_rad),
            }),
            advice,
            command: CameraCommand::turning(rate(outcome.pan), rate(outcome.tilt)).zooming(zoom),
            rates: VehicleRates::turning(rate(outcome.yaw_rate), rate(outcome.pitch_rate))
                .zooming(outcome.zoom_speed),
            wake_at: outcome.wake_at_ns.map(Timestamp::from_nanos),
            track: outcome.track.ok_or_else(|| missing("track"))?.try_into()?,
            vessel: outcome.vessel.map(RecordedVessel::try_from).transpose()?.map(Box::new),
            notice: outcome.notice,
        })
    }
}
