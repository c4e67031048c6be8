//! The effective configuration, from a file with defaults filled in.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use barrelman_pilot::NUDGE_RATE_RAD_PER_S;
use barrelman_video::engine::VideoEngine;
use barrelman_video::sender_clock::ClockChoice;
use barrelman_vocab::profile::{Addressing, AxisRates, AxisSigns, Protocol, RegionShares, Sign};
use barrelman_vocab::{Angle, AngularRate, VehicleProfile};
use barrelman_wire::Framing;

use super::console::{ConsoleConfig, RecordingConfig};
use super::declared;
use super::file::{ConfigFile, LineEnding, LinkSection, SignName, VehicleSection, VideoSection};
use super::mavlink;
use super::tak::TakConfig;
use super::tracking_camera::TrackingCameraConfig;
use super::turning::{gimbal_tilt, net_yaw_limits};
use super::vessel::VesselConfig;
use crate::config::detector::DetectorConfig;
use crate::secrets::{LinkAccess, LoginSource, TrustFiles, VideoLogin};
use crate::share::ShareAddress;
use barrelman_experiments::law_choice::{GivenLaw, LawChoice, LawKeys};
use barrelman_experiments::tracker_choice::{TrackerName, TrackerSettings};

mod complete_file;

/// The second video of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondVideo {
    /// Address of the source.
    pub url: String,
    /// Horizontal field of view; `None`: that of the first video.
    pub field_of_view: Option<Angle>,
}

/// The effective configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// Address of the video source, if it is given.
    pub video: Option<String>,
    /// The second video, if there is one.
    pub second_video: Option<SecondVideo>,
    /// The name of the vehicle's video that is used; `None`: the main one.
    pub video_stream: Option<String>,
    /// Which clock gives the times of capture of a live stream.
    pub video_clock: ClockChoice,
    /// The engine that reads and decodes the video.
    pub video_engine: VideoEngine,
    /// The video's login, if it is not in the address, and how it may be used.
    pub video_login: VideoLogin,
    /// Which certificate of a video in TLS is accepted.
    pub video_trust: TrustFiles,
    /// Address of the vehicle's link; `None`: a dry run.
    pub link: Option<String>,
    /// What proves who asks a vehicle over HTTP, and which vehicle is the right one.
    pub link_access: LinkAccess,
    /// The host beside that of the link on which a vehicle may name its video.
    pub link_video_host: Option<String>,
    /// The file of the key of signed packets, where the vehicle's packets are signed.
    pub signing_key_file: Option<PathBuf>,
    /// The guard of the vehicle's port.
    pub guard: GuardChoice,
    /// Framing of text lines, where the vehicle's protocol has some.
    pub framing: Framing,
    /// The vehicle.
    pub profile: VehicleProfile,
    /// The camera law.
    pub law: LawChoice,
    /// The tracker.
    pub tracker: TrackerSettings,
    /// The tracking camera on a MAVLink link.
    pub tracking_camera: TrackingCameraConfig,
    /// Events for TAK.
    pub tak: TakConfig,
    /// Where the annotated video is served; `None`: nowhere.
    pub share: Option<ShareAddress>,
    /// The detector; `None`: nothing is detected.
    pub detector: Option<DetectorConfig>,
    /// The boat that is commanded; `None`: none.
    pub vessel: Option<VesselConfig>,
    /// The operator's console.
    pub console: ConsoleConfig,
    /// The recordings that `run` makes without being asked.
    pub recording: RecordingConfig,
}

/// Which guard serves the port of a vehicle that keeps its last rate.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GuardChoice {
    /// The guard's program; `None`: the one beside this program.
    pub program: Option<PathBuf>,
    /// Whether the run does without a guard.
    pub is_omitted: bool,
}

/// The largest rate of a simulated vehicle, rad/s.
const MAX_SIMULATED_RAD_PER_S: f64 = 3.0;

/// Checks that the tracking camera and the vehicle's camera have components of their own.
///
/// # Errors
/// If both have one component: the answers of one would be taken for those of the other.
fn check_components(tracking: &TrackingCameraConfig, protocol: Protocol) -> Result<()> {
    let component = tracking.settings.component.0;
    if tracking.url.is_some() && mavlink::camera_of(protocol) == Some(component) {
        bail!(
            "tracking_camera.component_id and vehicle.camera are both {component}: set tracking_camera.component_id = {}",
            if component == 101 { 102 } else { 101 }
        );
    }
    Ok(())
}

/// The vehicle's video that the file chooses.
fn video_stream(file: &VideoSection, profile: &VehicleProfile) -> Result<Option<String>> {
    if file.stream.is_some() && profile.protocol.addressing() == Addressing::Line {
        bail!("video.stream has no effect on the vehicle {}, which names no videos: omit it", profile.name);
    }
    Ok(file.stream.clone())
}

/// The built-in profile of a name.
///
/// # Errors
/// If there is no such profile; the message lists the names.
pub fn profile_named(name: &str) -> Result<VehicleProfile> {
    VehicleProfile::named(name).with_context(|| {
        format!("there is no vehicle profile {name:?}: use one of {}", VehicleProfile::NAMES.join(", "))
    })
}

impl Configuration {
    /// The addresses of the videos.
    pub fn video_urls(&self) -> Vec<String> {
        self.video.iter().chain(self.second_video.as_ref().map(|second| &second.url)).cloned().collect()
    }

    /// Fills in the defaults of the keys that the file omits.
    ///
    /// # Errors
    /// If a value is out of range; the message names the key and the range.
    pub fn resolve(file: &ConfigFile) -> Result<Self> {
        let rate_limits = |profile: &VehicleProfile| profile.protocol.rate_limits();
        let configuration = Self::resolve_within(file, rate_limits)?;
        ensure_axes_turn(&configuration.profile)?;
        let is_simulated = configuration.link.as_deref().is_some_and(|link| link.starts_with("sim:"));
        if configuration.profile.zoom.is_some() && !configuration.profile.protocol.zooms() && !is_simulated {
            bail!(
                "camera.zoom.ratio has no effect on this vehicle, whose camera has no command to zoom: omit it"
            );
        }
        Ok(configuration)
    }

    /// Like [`Self::resolve`], for the configuration of a recording: a simulated vehicle may turn faster than
    /// a real one. A replay sends nothing.
    ///
    /// # Errors
    /// If a value is out of range; the message names the key and the range.
    pub fn resolve_recorded(file: &ConfigFile) -> Result<Self> {
        let max = AngularRate::from_radians_per_second(MAX_SIMULATED_RAD_PER_S);
        Self::resolve_within(file, |_| AxisRates { pan: max, tilt: max })
    }

    fn resolve_within(file: &ConfigFile, rate_limits: impl Fn(&VehicleProfile) -> AxisRates) -> Result<Self> {
        declared::check(file, "")?;
        let vehicle = &file.vehicle;
        let base = profile_named(vehicle.profile.as_deref().unwrap_or(VehicleProfile::NAMES[0]))
            .context("vehicle.profile")?;
        let max_rates = rate_limits(&base);
        let mut profile = overridden(base, vehicle, max_rates)?;
        profile.protocol = mavlink::between_peers(profile.protocol, &file.link)?;
        profile.protocol = mavlink::with_device(profile.protocol, file.vehicle.gimbal_device)?;
        profile = file.camera.apply_to(profile)?;
        let zooms = profile.zoom.is_some();
        profile.protocol = mavlink::with_camera(profile.protocol, file.vehicle.camera, zooms)?;
        for (axis, dynamics, limit) in [
            ("pan", &profile.camera.pan, profile.limits.pan),
            ("tilt", &profile.camera.tilt, profile.limits.tilt),
        ] {
            let min_rate = dynamics.min_rate;
            if min_rate > limit {
                bail!(
                    "camera.{axis}.least_rad_per_s = {} is above vehicle.limit_{axis}_rad_per_s = {}: lower it, or raise the limit",
                    min_rate.radians_per_second(),
                    limit.radians_per_second()
                );
            }
        }
        let tracking_camera = file.tracking_camera.resolve();
        check_components(&tracking_camera, profile.protocol)?;
        Ok(Self {
            video: file.video.url.clone(),
            second_video: second_video(&file.video)?,
            video_stream: video_stream(&file.video, &profile)?,
            video_clock: file.video.clock.unwrap_or_default(),
            video_engine: file.video.engine.unwrap_or_default(),
            video_login: VideoLogin {
                source: login_source(&file.video)?,
                permits_basic: file.video.allow_basic_login.unwrap_or(false),
            },
            video_trust: video_trust(&file.video)?,
            link: file.link.url.clone(),
            link_access: link_access(&file.link)?,
            link_video_host: file.link.video_host.clone(),
            signing_key_file: file.link.signing_key_file.clone(),
            guard: GuardChoice {
                program: file.link.guard.clone(),
                is_omitted: file.link.without_guard.unwrap_or(false),
            },
            framing: match file.link.line_ending {
                None | Some(LineEnding::CrAround) => Framing::CarriageReturns,
                Some(LineEnding::Lf) => Framing::LineFeed,
            },
            profile,
            law: GivenLaw {
                name: file.law.name,
                mode: file.law.mode,
                horizon_s: file.law.horizon_s,
                framed: file.law.frame,
            }
            .or(LawChoice::OPTIMAL, LawKeys::FILE)?,
            tracker: file.tracker.settings().validated()?,
            tracking_camera,
            tak: file.tak.resolve()?,
            share: file.share.resolve()?,
            detector: file.detector.resolve(),
            vessel: file.vessel.resolve()?,
            console: file.console.resolve()?,
            recording: file.recording.resolve(),
        })
    }

    /// The configuration of a simulated run: the defaults, with this vehicle, law and tracker.
    ///
    /// # Errors
    /// Never in practice: the defaults lie in their ranges.
    pub fn simulated(profile: VehicleProfile, law: LawChoice, tracker: TrackerName) -> Result<Self> {
        let defaults = Self::resolve(&ConfigFile::default())?;
        Ok(Self { profile, law, tracker: TrackerSettings::new(tracker), ..defaults })
    }
}

fn link_access(link: &LinkSection) -> Result<LinkAccess> {
    Ok(LinkAccess {
        token_file: link.token_file.clone(),
        login_file: link.login_file.clone(),
        trust: trust_files(
            "link",
            &["https://", "onvifs://"],
            &[&link.url],
            (&link.certificate_sha256, &link.ca_file),
        )?,
    })
}

fn video_trust(video: &VideoSection) -> Result<TrustFiles> {
    let addresses = [&video.url, &video.second_url];
    trust_files("video", &["rtsps://"], &addresses, (&video.certificate_sha256, &video.ca_file))
}

/// The certificates of a section. Where addresses are given, one of them has to be encrypted, by one of these
/// schemes: otherwise nothing would be checked.
fn trust_files(
    section: &str,
    schemes: &[&str],
    addresses: &[&Option<String>],
    (certificate_sha256, ca_file): (&Option<String>, &Option<PathBuf>),
) -> Result<TrustFiles> {
    if certificate_sha256.is_some() && ca_file.is_some() {
        bail!("{section}.certificate_sha256 and {section}.ca_file are both given: omit one");
    }
    let is_given = certificate_sha256.is_some() || ca_file.is_some();
    let addresses: Vec<&str> = addresses.iter().filter_map(|address| address.as_deref()).collect();
    let is_encrypted = |address: &&str| schemes.iter().any(|scheme| address.starts_with(scheme));
    if is_given && !addresses.is_empty() && !addresses.iter().any(is_encrypted) {
        let key = if ca_file.is_some() { "ca_file" } else { "certificate_sha256" };
        let wanted = schemes.join(" or ");
        bail!(
            "{section}.{key} is about {wanted}, and {section}.url is not encrypted: omit the key, or use {wanted}"
        );
    }
    Ok(TrustFiles { certificate_sha256: certificate_sha256.clone(), ca_file: ca_file.clone() })
}

/// Checks that each axis turns at the rates that are commanded by hand, in a search and in a calibration, and
/// reaches its least rate within its limit.
fn ensure_axes_turn(profile: &VehicleProfile) -> Result<()> {
    let axes = [
        ("pan", &profile.camera.pan, profile.limits.pan),
        ("tilt", &profile.camera.tilt, profile.limits.tilt),
    ];
    for (axis, dynamics, limit) in axes {
        let least = dynamics.min_rate.radians_per_second();
        let reached = limit.radians_per_second() * dynamics.gain;
        if least > reached {
            bail!(
                "camera.{axis}.least_rad_per_s = {least} is above what the axis reaches, vehicle.limit_{axis}_rad_per_s times \
                 camera.{axis}.gain = {reached}: lower it, or correct the others"
            );
        }
        // Half of the least rate and more is raised to it; less is no motion.
        let most = 2.0 * NUDGE_RATE_RAD_PER_S;
        if least > most {
            bail!(
                "camera.{axis}.least_rad_per_s = {least}: use rad/s from 0 to {most}; nudges and searches turn at \
                 {NUDGE_RATE_RAD_PER_S} rad/s, and would not move this axis"
            );
        }
    }
    Ok(())
}

fn second_video(video: &VideoSection) -> Result<Option<SecondVideo>> {
    let field_of_view = video.second_field_of_view_deg.map(Angle::from_degrees);
    match (&video.second_url, &video.url) {
        (None, _) if field_of_view.is_some() => {
            bail!("video.second_field_of_view_deg is given, but no second video: give video.second_url")
        }
        (None, _) => Ok(None),
        (Some(_), None) => bail!("video.second_url is given, but no first video: give video.url"),
        (Some(url), Some(_)) => Ok(Some(SecondVideo { url: url.clone(), field_of_view })),
    }
}

fn login_source(video: &VideoSection) -> Result<Option<LoginSource>> {
    match (&video.login_file, &video.login_env) {
        (Some(_), Some(_)) => bail!("video.login_file and video.login_env are both given: omit one"),
        (Some(path), None) => Ok(Some(LoginSource::File(path.clone()))),
        (None, Some(name)) => Ok(Some(LoginSource::Environment(name.clone()))),
        (None, None) => Ok(None),
    }
}

/// The profile `base` with the values of a file. Limits are at most `max`, motor schema rates at most their
/// axis' limit.
fn overridden(base: VehicleProfile, vehicle: &VehicleSection, max: AxisRates) -> Result<VehicleProfile> {
    let base = match &vehicle.speeds {
        Some(speeds) => speeds.apply_to(base)?,
        None => base,
    };
    let vehicle_limit = "the limit of the vehicle";
    let (pan, tilt) = (vehicle.limit_pan_rad_per_s, vehicle.limit_tilt_rad_per_s);
    let limits = AxisRates {
        pan: rate("limit_pan_rad_per_s", pan, base.limits.pan, max.pan, vehicle_limit)?,
        tilt: rate("limit_tilt_rad_per_s", tilt, base.limits.tilt, max.tilt, vehicle_limit)?,
    };
    let (pan_limit, tilt_limit) = ("vehicle.limit_pan_rad_per_s", "vehicle.limit_tilt_rad_per_s");
    let (pan, tilt) = (vehicle.schema_pan_rad_per_s, vehicle.schema_tilt_rad_per_s);
    let motor_schema_rates = AxisRates {
        pan: rate("schema_pan_rad_per_s", pan, base.motor_schema_rates.pan, limits.pan, pan_limit)?,
        tilt: rate("schema_tilt_rad_per_s", tilt, base.motor_schema_rates.tilt, limits.tilt, tilt_limit)?,
    };
    let seconds = |value: Option<f64>, base: Duration| value.map_or(base, Duration::from_secs_f64);
    let sign = |value: Option<SignName>, base: Sign| match value {
        Some(SignName::Same) => Sign::Same,
        Some(SignName::Opposite) => Sign::Opposite,
        None => base,
    };
    Ok(VehicleProfile {
        region: RegionShares {
            half_width: vehicle.region_half_width.unwrap_or(base.region.half_width),
            half_height: vehicle.region_half_height.unwrap_or(base.region.half_height),
        },
        motor_schema_rates,
        limits,
        signs: AxisSigns {
            yaw: sign(vehicle.yaw_sign, base.signs.yaw),
            pitch: sign(vehicle.pitch_sign, base.signs.pitch),
        },
        video_latency: seconds(vehicle.video_latency_s, base.video_latency),
        stale_after: seconds(vehicle.stale_after_s, base.stale_after),
        coast_motion: seconds(vehicle.coast_motion_s, base.coast_motion),
        net_yaw: net_yaw_limits(vehicle, base.net_yaw)?,
        attitude_yaw: vehicle
            .attitude_yaw_sign
            .map(|name| sign(Some(name), Sign::Same))
            .or(base.attitude_yaw),
        gimbal_tilt: vehicle.gimbal_tilt.as_ref().map(gimbal_tilt).or(base.gimbal_tilt),
        ..base
    })
}

/// A rate from 0 to `max`; `limited_by` names the source of that limit in the error.
fn rate(
    key: &str,
    value: Option<f64>,
    base: AngularRate,
    max: AngularRate,
    limited_by: &str,
) -> Result<AngularRate> {
    let (value, max) = (value.unwrap_or(base.radians_per_second()), max.radians_per_second());
    if (0.0..=max).contains(&value) {
        Ok(AngularRate::from_radians_per_second(value))
    } else {
        bail!("vehicle.{key} = {value}: use rad/s from 0 to {max}, {limited_by}")
    }
}
