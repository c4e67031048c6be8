//! The API's form of a snapshot.

use barrelman_control::{Percept, Region, Sector};
use barrelman_pilot::on_earth::NotOnEarth;
use barrelman_pilot::{Advice, Candidate, Mode, Outcome, ProposedObject, VesselMode};
use barrelman_vocab::acceptance::Acceptance;
use barrelman_vocab::telemetry::{ControlState, FlightState};
use barrelman_vocab::{Angle, CameraCommand, MarkKind, Named as _, PixelBox, ShortText, Videos};

use super::api::{
    AxisRates, BoatStatus, CameraWork, CandidateStatus, EncodedVideo, LinkStatus, ModeStatus,
    OtherVideoStatus, PerceptStatus, PositionStatus, ProposalStatus, RecordingStatus, RegionStatus,
    StatusSnapshot, TrackStatus, VideoStatus, WorkFigures, ZoomStatus,
};
use super::track_status::{NO_TRACK, track_of};
use super::vessel_status::vessel_of;
use crate::snapshot::{
    self, RecordingState, Snapshot, SourceSnapshot, VehicleSnapshot, VideoSnapshot, VideoSourceState,
};

/// The API's form of a snapshot. `codecs`: the codecs in which the videos can be sent as they come.
pub(super) fn status_of(snapshot: &Snapshot, codecs: &Videos<Option<EncodedVideo>>) -> StatusSnapshot {
    let codec_of = |number| codecs.get(number).copied().flatten();
    let outcome = snapshot.outcome.as_ref();
    StatusSnapshot {
        step: snapshot.steps,
        at_ns: outcome.map_or(0, |outcome| outcome.at.as_nanos()),
        beat: snapshot.beats,
        mode: mode_of(outcome.map_or(Mode::Idle, |outcome| outcome.mode)),
        track: outcome.map_or(NO_TRACK, |outcome| {
            let (confirming, doubted) = (outcome.is_confirming, outcome.is_doubted);
            TrackStatus { confirming, doubted, ..track_of(&outcome.track, outcome.at) }
        }),
        proposal: outcome.and_then(|outcome| outcome.proposal).map(proposal_of),
        candidates: outcome.map_or_else(Vec::new, candidates_of),
        candidates_on_demand: outcome.is_some_and(|outcome| outcome.are_candidates_wanted),
        region: outcome.and_then(|outcome| outcome.region).map(region_of),
        percept: outcome.and_then(|outcome| percept_of(outcome.percept, outcome.advice)),
        advice: outcome.and_then(|outcome| outcome.advice).map(|advice| axes_of(advice.command)),
        command: outcome.map_or_else(|| axes_of(CameraCommand::REST), |outcome| axes_of(outcome.command)),
        yaw_rate: snapshot.rates.yaw.radians_per_second(),
        pitch_rate: snapshot.rates.pitch.radians_per_second(),
        zoom: outcome
            .and_then(|outcome| outcome.zoom)
            .map(|zoom| ZoomStatus { ratio: zoom.ratio, keeps_size: zoom.keeps_size }),
        net_yaw_deg: outcome.map_or(0.0, |outcome| outcome.net_yaw.angle.degrees()),
        search_refusal: outcome.and_then(|outcome| outcome.search_refusal).map(|refusal| refusal.to_string()),
        law: snapshot.law,
        video: video_of(&snapshot.video, codec_of(snapshot.video.number)),
        other_video: snapshot.other_video.as_ref().map(|other| {
            let number = snapshot.video.number.other();
            let (state, reason) = source_of(other);
            OtherVideoStatus { number, state, reason, codec: codec_of(number) }
        }),
        boat: snapshot.boat.map(boat_of),
        earth: match outcome.map(|outcome| outcome.earth) {
            Some(Ok(_)) => "known",
            Some(Err(NotOnEarth::NoHeading)) => "no-heading",
            None | Some(Err(NotOnEarth::NoPosition)) => "no-position",
        },
        water_on_earth: outcome.and_then(|outcome| outcome.earth.ok()).map(Into::into),
        vessel: vessel_of(snapshot),
        link: link_of(&snapshot.vehicle),
        recording: recording_of(&snapshot.recording),
        work: work_of(&snapshot.work),
        alarms: snapshot.alarms.iter().map(|alarm| alarm.key()).collect(),
        stops_taken: snapshot.stops_taken,
        world: snapshot.world.clone(),
        drill: snapshot.drill.clone(),
        drive: snapshot.drive.clone(),
    }
}

pub(super) fn mode_of(mode: Mode) -> ModeStatus {
    let (name, cause) = match mode {
        Mode::Idle => ("idle", None),
        Mode::Servoing => ("servoing", None),
        Mode::Nudging => ("nudging", None),
        Mode::Searching => ("searching", None),
        Mode::Calibrating => ("calibrating", None),
        Mode::Holding(cause) => ("holding", Some(cause.key())),
        Mode::Stopped(cause) => ("stopped", Some(cause.key())),
    };
    ModeStatus { name, cause, engaged: mode.is_engaged() }
}

pub(super) const fn region_of(region: Region) -> RegionStatus {
    RegionStatus { a_px: region.a_px, b_px: region.b_px }
}

fn proposal_of(object: ProposedObject) -> ProposalStatus {
    let PixelBox { u, v, w, h } = object.bounds;
    ProposalStatus { bounds: [u, v, w, h], captured_ns: object.captured.as_nanos() }
}

fn candidates_of(outcome: &Outcome) -> Vec<CandidateStatus> {
    let has_marks = outcome.vessel.mode != VesselMode::Absent;
    outcome.candidates.iter().flatten().map(|candidate| candidate_of(candidate, has_marks)).collect()
}

fn candidate_of(candidate: &Candidate, has_marks: bool) -> CandidateStatus {
    let PixelBox { u, v, w, h } = candidate.bounds;
    CandidateStatus {
        number: candidate.number,
        bounds: [u, v, w, h],
        captured_ns: candidate.captured.as_nanos(),
        class: candidate.classification.map(|said| said.class.as_str().to_owned()),
        score: candidate.classification.map(|said| said.score),
        mark: candidate
            .classification
            .filter(|said| has_marks && said.class.is_person())
            .map(|_| MarkKind::Person),
    }
}

pub(super) fn percept_of(percept: Option<Percept>, advice: Option<Advice>) -> Option<PerceptStatus> {
    let percept = percept?;
    let sector = advice.and_then(|advice| advice.sector).map(|sector| match sector {
        Sector::Right => "right",
        Sector::Top => "top",
        Sector::Left => "left",
        Sector::Bottom => "bottom",
    });
    Some(PerceptStatus { x: percept.position.x, y: percept.position.y, p: percept.p, sector })
}

pub(super) fn axes_of(command: CameraCommand) -> AxisRates {
    AxisRates {
        pan: command.pan.radians_per_second(),
        tilt: command.tilt.radians_per_second(),
        zoom: command.zoom.per_second(),
    }
}

/// The name of a source's state, and the reason for it.
fn source_of(source: &SourceSnapshot) -> (&'static str, Option<String>) {
    match &source.state {
        VideoSourceState::Connecting => ("connecting", None),
        VideoSourceState::Up => ("up", source.timing_text.as_deref().map(str::to_owned)),
        VideoSourceState::Lost(reason) => ("lost", Some(reason.clone())),
        VideoSourceState::Ended => ("ended", None),
    }
}

fn video_of(video: &VideoSnapshot, codec: Option<EncodedVideo>) -> VideoStatus {
    let (state, reason) = source_of(&video.source);
    VideoStatus {
        number: video.number,
        state,
        reason,
        size: video.frame.map(|(_, size)| [size.width, size.height]),
        captured_ns: video.frame.map(|(captured, _)| captured.as_nanos()),
        age_ms: video.age.map(|age| age.as_secs_f64() * 1e3),
        step_ms: video.step_time.map(|time| time.as_secs_f64() * 1e3),
        fps: video.fps,
        dropped: video.dropped,
        codec,
    }
}

fn boat_of(boat: snapshot::BoatOnWater) -> BoatStatus {
    BoatStatus {
        distance_m: boat.distance_m,
        std_dev_m: boat.std_dev_m,
        direction_deg: boat.direction.degrees(),
        on_earth: boat.on_earth.map(Into::into),
    }
}

fn link_of(vehicle: &VehicleSnapshot) -> LinkStatus {
    let name = |used: Option<ShortText>| used.map(|name| name.as_str().to_owned());
    LinkStatus {
        state: vehicle.link.key(),
        in_control: vehicle.control.map(|control| control == ControlState::Ours),
        acceptance: vehicle.acceptance.map(Acceptance::key),
        battery_v: vehicle.battery_v,
        tilt_deg: vehicle.tilt.map(|tilt| tilt.radians().to_degrees()),
        altitude_m: vehicle.altitude_m,
        position: vehicle.position.map(|position| PositionStatus {
            latitude_deg: position.latitude.degrees(),
            longitude_deg: position.longitude.degrees(),
            heading_deg: position.heading.map(Angle::degrees),
        }),
        flight: vehicle.flight.map(|state| match state {
            FlightState::Idle => "idle",
            FlightState::Flying => "flying",
            FlightState::Landing => "landing",
            FlightState::Emergency => "emergency",
            FlightState::Other(_) => "other",
        }),
        gimbal: name(vehicle.equipment.gimbal),
        camera: name(vehicle.equipment.camera),
        stream: name(vehicle.equipment.stream),
    }
}

fn recording_of(recording: &RecordingState) -> RecordingStatus {
    match recording {
        RecordingState::Off => RecordingStatus { state: "off", path: None, reason: None },
        RecordingState::On(path) => {
            RecordingStatus { state: "recording", path: Some(path.clone()), reason: None }
        }
        RecordingState::Failed(reason) => {
            RecordingStatus { state: "failed", path: None, reason: Some(reason.clone()) }
        }
    }
}

fn work_of(work: &snapshot::CameraWork) -> CameraWork {
    let figures = |figures: snapshot::WorkFigures| WorkFigures {
        moves: figures.moves,
        travel_rad: figures.travel_rad,
        rest_share: if figures.seconds > 0.0 { figures.rest_s / figures.seconds } else { 1.0 },
        seconds: figures.seconds,
    };
    CameraWork { camera: figures(work.camera), schema: work.schema.map(figures), schema_p: work.schema_p }
}

#[cfg(test)]
mod tests;
