//! The effective configuration as a complete file.

use std::time::Duration;

use anyhow::Result;
use barrelman_vocab::profile::Sign;
use barrelman_vocab::{Angle, AngularRate};
use barrelman_wire::Framing;

use super::Configuration;
use crate::config::camera::CameraSection;
use crate::config::console::{ConsoleSection, RecordingSection};
use crate::config::detector::DetectorSection;
use crate::config::file::{
    ConfigFile, LawSection, LineEnding, LinkSection, SignName, VehicleSection, VideoSection,
};
use crate::config::mavlink;
use crate::config::share::ShareSection;
use crate::config::speeds::SpeedsSection;
use crate::config::tak::TakSection;
use crate::config::tracker::TrackerSection;
use crate::config::tracking_camera::TrackingCameraSection;
use crate::config::turning::section_of;
use crate::config::vessel::VesselSection;
use crate::secrets::LoginSource;

impl Configuration {
    /// The configuration as a complete file.
    pub fn to_file(&self) -> ConfigFile {
        ConfigFile {
            video: self.video_section(),
            link: self.link_section(),
            vehicle: self.vehicle_section(),
            camera: CameraSection::of(&self.profile),
            law: LawSection {
                name: Some(self.law.law.name()),
                mode: self.law.law.mode(),
                horizon_s: self.law.horizon_s,
                frame: Some(self.law.framed),
            },
            tracker: TrackerSection::from_settings(&self.tracker),
            tracking_camera: TrackingCameraSection::from_config(&self.tracking_camera),
            tak: TakSection::from_config(&self.tak),
            share: ShareSection::from_config(self.share.as_ref()),
            detector: DetectorSection::from_config(self.detector.as_ref()),
            vessel: VesselSection::from_config(self.vessel.as_ref()),
            console: ConsoleSection::from_config(&self.console),
            recording: RecordingSection::from_config(&self.recording),
        }
    }

    fn video_section(&self) -> VideoSection {
        VideoSection {
            url: self.video.clone(),
            second_url: self.second_video.as_ref().map(|second| second.url.clone()),
            second_field_of_view_deg: self
                .second_video
                .as_ref()
                .and_then(|second| second.field_of_view)
                .map(Angle::degrees),
            stream: self.video_stream.clone(),
            clock: Some(self.video_clock),
            engine: Some(self.video_engine),
            login_file: match &self.video_login.source {
                Some(LoginSource::File(path)) => Some(path.clone()),
                Some(LoginSource::Environment(_)) | None => None,
            },
            login_env: match &self.video_login.source {
                Some(LoginSource::Environment(name)) => Some(name.clone()),
                Some(LoginSource::File(_)) | None => None,
            },
            allow_basic_login: Some(self.video_login.permits_basic),
            certificate_sha256: self.video_trust.certificate_sha256.clone(),
            ca_file: self.video_trust.ca_file.clone(),
        }
    }

    fn link_section(&self) -> LinkSection {
        LinkSection {
            url: self.link.clone(),
            guard: self.guard.program.clone(),
            without_guard: Some(self.guard.is_omitted),
            token_file: self.link_access.token_file.clone(),
            login_file: self.link_access.login_file.clone(),
            certificate_sha256: self.link_access.trust.certificate_sha256.clone(),
            ca_file: self.link_access.trust.ca_file.clone(),
            signing_key_file: self.signing_key_file.clone(),
            video_host: self.link_video_host.clone(),
            line_ending: Some(match self.framing {
                Framing::CarriageReturns => LineEnding::CrAround,
                Framing::LineFeed => LineEnding::Lf,
            }),
            ..mavlink::section_of(self.profile.protocol)
        }
    }

    fn vehicle_section(&self) -> VehicleSection {
        let profile = &self.profile;
        let sign = |sign: Sign| {
            Some(match sign {
                Sign::Same => SignName::Same,
                Sign::Opposite => SignName::Opposite,
            })
        };
        let rate = |rate: AngularRate| Some(rate.radians_per_second());
        let seconds = |duration: Duration| Some(duration.as_secs_f64());
        VehicleSection {
            profile: Some(profile.name.clone()),
            region_half_width: Some(profile.region.half_width),
            region_half_height: Some(profile.region.half_height),
            schema_pan_rad_per_s: rate(profile.motor_schema_rates.pan),
            schema_tilt_rad_per_s: rate(profile.motor_schema_rates.tilt),
            limit_pan_rad_per_s: rate(profile.limits.pan),
            limit_tilt_rad_per_s: rate(profile.limits.tilt),
            yaw_sign: sign(profile.signs.yaw),
            pitch_sign: sign(profile.signs.pitch),
            video_latency_s: seconds(profile.video_latency),
            stale_after_s: seconds(profile.stale_after),
            coast_motion_s: seconds(profile.coast_motion),
            net_yaw_warn_rad: Some(profile.net_yaw.warn.radians()),
            net_yaw_limit_rad: Some(profile.net_yaw.refuse.radians()),
            attitude_yaw_sign: profile.attitude_yaw.and_then(sign),
            gimbal_device: mavlink::device_of(profile.protocol),
            camera: mavlink::camera_of(profile.protocol),
            gimbal_tilt: profile.gimbal_tilt.map(|tilt| section_of(&tilt)),
            speeds: profile.speeds.as_ref().map(SpeedsSection::of),
        }
    }

    /// The configuration as complete TOML.
    ///
    /// # Errors
    /// Never in practice: plain data can be serialised.
    pub fn to_toml(&self) -> Result<String> {
        Ok(toml::to_string_pretty(&self.to_file())?)
    }
}
