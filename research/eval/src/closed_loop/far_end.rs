//! The line to a vehicle in virtual time: the session at one end, the vehicle's own end at the other. A
//! packet takes one tick.

use anyhow::{Context as _, Result};
use barrelman_sim::CameraPose;
use barrelman_vocab::profile::Protocol;
use barrelman_vocab::speed_curve::AxisSpeeds;
use barrelman_vocab::telemetry::LinkState;
use barrelman_vocab::{Angle, Telemetry, Timestamp, VehicleProfile, VehicleRates};
use barrelman_wire::fotokite_pro::GroundStation;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, SensorReadings};
use barrelman_wire::fotokite_sigma::sigma::{SigmaSettings, View};
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession, Sigma};
use barrelman_wire::http::{HttpCall as _, Received};
use barrelman_wire::mavlink::GimbalManager;
use barrelman_wire::mavlink::gimbal_manager::{GimbalAngles, GimbalManagerSettings};
use barrelman_wire::onvif::{CameraSettings, OnvifSession, OnvifSettings, PtzCamera, SpeedShares};
use barrelman_wire::{ByteProtocol, ByteProtocolName, ByteSession, Framing, OpenSession as _, Session as _};

use crate::vehicle::onvif_speeds;

/// Bits per second of the serial line.
const BAUD: u32 = 115_200;

/// A line with both its ends.
pub(super) enum Line {
    Bytes { session: Box<ByteSession>, far_end: FarEnd, down: Vec<Vec<u8>> },
    Sigma { session: Box<FotokiteSigmaSession>, sigma: Box<Sigma>, down: Vec<Received>, ticks: u32 },
    Onvif { session: Box<OnvifSession>, camera: Box<PtzCamera>, speeds: AxisSpeeds, down: Vec<Received> },
}

/// The far end of a line that carries bytes.
pub(super) enum FarEnd {
    FotokitePro(Box<GroundStation>),
    MavlinkGimbal(Box<GimbalManager>),
}

impl Line {
    /// A line to a vehicle that has just been switched on. `has_no_least_rates`: the vehicle executes any
    /// rate.
    ///
    /// # Errors
    /// If the vehicle's protocol is of a kind that is not known here.
    pub(super) fn new(profile: &VehicleProfile, has_no_least_rates: bool, now: Timestamp) -> Result<Self> {
        let far_end = match profile.protocol {
            Protocol::FotokitePro => {
                FarEnd::FotokitePro(Box::new(GroundStation::boot(GroundStationSettings::default(), now)))
            }
            Protocol::MavlinkGimbal(_) => {
                FarEnd::MavlinkGimbal(Box::new(GimbalManager::boot(GimbalManagerSettings::default(), now)))
            }
            Protocol::FotokiteSigma => {
                let field_of_view = 2.0 * (0.5 / profile.camera.focal_share).atan();
                let mut settings = SigmaSettings {
                    field_of_view_deg: field_of_view.to_degrees(),
                    ..SigmaSettings::example()
                };
                if has_no_least_rates {
                    (settings.camera.pan_speed_min, settings.camera.tilt_speed_min) = (0.0, 0.0);
                }
                let session = Box::new(FotokiteSigmaSession::open(None, profile.max_zoom_rate(), now));
                let sigma = Box::new(Sigma::new(settings));
                return Ok(Self::Sigma { session, sigma, down: Vec::new(), ticks: 0 });
            }
            Protocol::OnvifPtz => {
                let speeds = onvif_speeds();
                let settings = OnvifSettings { login: None, speeds: Some(speeds.clone()), profile: None };
                let session = Box::new(OnvifSession::open(&settings, [0; 16], now));
                let camera = Box::new(PtzCamera::new(CameraSettings::example()));
                return Ok(Self::Onvif { session, camera, speeds, down: Vec::new() });
            }
        };
        let protocol = ByteProtocolName::of(profile.protocol).context("the protocol carries no bytes")?;
        let protocol = ByteProtocol { protocol, framing: Framing::CarriageReturns, baud: BAUD };
        Ok(Self::Bytes { session: protocol.open(now), far_end, down: Vec::new() })
    }

    pub(super) fn link_state(&self) -> LinkState {
        match self {
            Self::Bytes { session, .. } => session.link_state(),
            Self::Sigma { session, .. } => session.link_state(),
            Self::Onvif { session, .. } => session.link_state(),
        }
    }

    pub(super) fn request(&mut self, rates: VehicleRates, renew_by: Option<Timestamp>) {
        match self {
            Self::Bytes { session, .. } => session.request(rates, renew_by),
            Self::Sigma { session, .. } => session.request(rates, renew_by),
            Self::Onvif { session, .. } => session.request(rates, renew_by),
        }
    }

    /// Lets a tick pass, appends what the vehicle reports to `reports`, and returns the rates in force.
    pub(super) fn advance(
        &mut self,
        pose: CameraPose,
        now: Timestamp,
        reports: &mut Vec<Telemetry>,
    ) -> VehicleRates {
        match self {
            Self::Bytes { session, far_end, down } => {
                for packet in std::mem::take(down) {
                    session.received(&packet, now, &mut |report| reports.push(report));
                }
                let mut up = Vec::new();
                let _ = session.poll(now, &mut up);
                far_end.advance(&up, pose, now, down)
            }
            Self::Sigma { session, sigma, down, ticks } => {
                for received in std::mem::take(down) {
                    session.received(&received, now, &mut |report| reports.push(report));
                }
                let mut up = Vec::new();
                let _ = session.poll(now, &mut up);
                let view = View { pan_ned: wrapped(pose.pan).degrees(), tilt_ned: -pose.tilt.degrees() };
                for request in up {
                    let (status, body) = match request.call {
                        Call::Subscribe => (101, Vec::new()),
                        call => {
                            let answer = sigma.answer_call(&call, "token", view, now);
                            (answer.status, answer.body.into_bytes())
                        }
                    };
                    down.push(Received::Answer { id: request.id, status, body });
                }
                *ticks += 1;
                // Ten times a second, as the vehicle does.
                if ticks.is_multiple_of(12) {
                    down.push(Received::Message(Sigma::camera_state(view).to_string().into_bytes()));
                }
                sigma.rates(now)
            }
            Self::Onvif { session, camera, speeds, down } => {
                for received in std::mem::take(down) {
                    session.received(&received, now, &mut |report| reports.push(report));
                }
                let mut up = Vec::new();
                let _ = session.poll(now, &mut up);
                let position = (wrapped(pose.pan).degrees() / 180.0, pose.tilt.degrees() / 90.0);
                for request in up {
                    let message = request.call.body().unwrap_or_default();
                    let answer = camera.answer(message.as_bytes(), position, false, now);
                    let (status, body) = (answer.status, answer.body.into_bytes());
                    down.push(Received::Answer { id: request.id, status, body });
                }
                let SpeedShares { pan, tilt, zoom } = camera.velocity(now);
                VehicleRates::turning(speeds.pan.rate_at(pan), speeds.tilt.rate_at(tilt)).zooming(zoom)
            }
        }
    }
}

impl FarEnd {
    fn advance(
        &mut self,
        up: &[Vec<u8>],
        pose: CameraPose,
        now: Timestamp,
        down: &mut Vec<Vec<u8>>,
    ) -> VehicleRates {
        match self {
            Self::FotokitePro(station) => {
                let mut answer = Vec::new();
                for packet in up {
                    station.receive(packet, now, &mut answer, |_| {});
                }
                station.tick(now);
                station.write_telemetry(&SensorReadings::of_camera(pose.pan, pose.tilt), now, &mut answer);
                down.push(answer);
                let rates = station.rates();
                VehicleRates::turning(rates.yaw, rates.pitch)
            }
            Self::MavlinkGimbal(manager) => {
                for packet in up {
                    manager.receive(packet, now, down, |_, _| {});
                }
                let angles = GimbalAngles { yaw: pose.pan, pitch: pose.tilt };
                manager.write_telemetry(angles, now, down);
                manager.rates()
            }
        }
    }
}

fn wrapped(pan: Angle) -> Angle {
    let turns = (pan.degrees() / 360.0).round();
    Angle::from_degrees(pan.degrees() - turns * 360.0)
}
