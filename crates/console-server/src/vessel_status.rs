//! The API's form of the boat that is commanded.

use std::time::Duration;

use barrelman_control::guidance::GuidanceState;
use barrelman_control::water::earth::place_on_earth;
use barrelman_pilot::vessel::{FrameView, Guidance, GuidanceBasis, Mark};
use barrelman_pilot::{Outcome, VesselMode};
use barrelman_vocab::{PictureSize, PixelPoint, Timestamp, VesselProfile, WaterPoint};

use super::api::{MarkStatus, PlaceStatus, ProgressStatus, VesselStatus};
use crate::snapshot::Snapshot;
use crate::track_status::track_of;

/// How long a text of the boat is shown.
const TEXT_LASTS: Duration = Duration::from_secs(30);
/// Points of a circle.
const RING_POINTS: usize = 24;

/// The boat that is commanded; `None`: there is none.
pub(super) fn vessel_of(snapshot: &Snapshot) -> Option<VesselStatus> {
    let outcome = snapshot.outcome.as_ref()?;
    let vessel = &outcome.vessel;
    let mode = match vessel.mode {
        VesselMode::Absent => return None,
        VesselMode::Released => "released",
        VesselMode::Neutral => "neutral",
        VesselMode::ByHand => "by-hand",
        VesselMode::Guided => "guided",
        VesselMode::Holding(_) | VesselMode::KeepingWay(_) => "holding",
        VesselMode::Stopped(_) => "stopped",
    };
    let profile = &vessel.profile;
    let destination = vessel.marks.destination().map(|mark| mark.id);
    let picture = snapshot.video.frame.map(|(_, size)| size);
    Some(VesselStatus {
        mode,
        text: vessel.mode.to_string(),
        throttle: vessel.command.throttle,
        rudder: vessel.command.rudder,
        link: snapshot.vessel.link.key(),
        basis: vessel.guidance.map(|guidance| match guidance.basis {
            GuidanceBasis::Water => "water",
            GuidanceBasis::Picture => "picture",
        }),
        go_again: vessel.asks_go_again,
        says: says(snapshot, outcome.at),
        guidance: vessel.guidance.map(|guidance| state_name(guidance.state)),
        progress: vessel.guidance.and_then(|guidance| progress_of(guidance, outcome)),
        marks: vessel
            .marks
            .iter()
            .map(|mark| {
                mark_of(mark, destination == Some(mark.id), profile, vessel.frame_view.as_ref(), outcome)
            })
            .collect(),
        footprint: vessel
            .frame_view
            .as_ref()
            .zip(picture)
            .and_then(|(frame_view, picture)| footprint(frame_view, picture)),
    })
}

/// What the boat said last, while that is new.
fn says(snapshot: &Snapshot, now: Timestamp) -> Option<String> {
    let (text, at) = snapshot.vessel_text?;
    (now.since(at) <= TEXT_LASTS).then(|| text.to_string())
}

const fn state_name(state: GuidanceState) -> &'static str {
    match state {
        GuidanceState::NoDestination => "no-destination",
        GuidanceState::NoFix => "no-fix",
        GuidanceState::GettingWay => "getting-way",
        GuidanceState::UnderWay => "under-way",
        GuidanceState::Avoiding => "avoiding",
        GuidanceState::Blocked => "blocked",
        GuidanceState::Holding => "holding",
        GuidanceState::StandingOff => "standing-off",
    }
}

/// The place of a point on the water on Earth, where that is known.
fn on_earth(point: WaterPoint, outcome: &Outcome) -> Option<PlaceStatus> {
    place_on_earth(&outcome.earth.ok()?, point).map(Into::into)
}

fn progress_of(guidance: Guidance, outcome: &Outcome) -> Option<ProgressStatus> {
    let progress = guidance.progress?;
    Some(ProgressStatus {
        boat_m: [progress.boat.x, progress.boat.y],
        on_earth: on_earth(progress.boat, outcome),
        speed_m_per_s: progress.speed_m_per_s,
        course_deg: progress.course.map(|course| course.degrees()),
        distance_m: progress.distance_m,
        cross_track_m: progress.cross_track_m,
    })
}

fn mark_of(
    mark: &Mark,
    is_destination: bool,
    profile: &VesselProfile,
    frame_view: Option<&FrameView>,
    outcome: &Outcome,
) -> MarkStatus {
    let radius_m = mark.radius_m(profile, is_destination);
    let pixel = |pixel: PixelPoint| [pixel.u, pixel.v];
    MarkStatus {
        id: mark.id,
        kind: mark.kind.key(),
        destination: is_destination,
        at: frame_view.and_then(|frame_view| mark.pixel(frame_view, outcome.at)).map(pixel),
        ring: frame_view.map(|frame_view| ring(mark, radius_m, frame_view, outcome.at)).unwrap_or_default(),
        water_m: mark.point(outcome.at).map(|point| [point.x, point.y]),
        on_earth: mark.point(outcome.at).and_then(|point| on_earth(point, outcome)),
        std_dev_m: mark.std_dev_m(outcome.at),
        radius_m,
        held: mark.held.map(|track| track_of(&track, outcome.at)),
    }
}

/// The circle around a mark, as pixels. A circle of which a part is behind the camera is left out.
fn ring(mark: &Mark, radius_m: f64, frame_view: &FrameView, now: Timestamp) -> Vec<[f64; 2]> {
    let (Some(centre), Some(std_dev_m)) = (mark.point(now), mark.std_dev_m(now)) else { return Vec::new() };
    if radius_m <= 0.0 || !frame_view.sees_water {
        return Vec::new();
    }
    let points = (0..RING_POINTS).map(|index| {
        let (sin, cos) = (core::f64::consts::TAU * index as f64 / RING_POINTS as f64).sin_cos();
        let reach_m = radius_m + std_dev_m;
        let point = WaterPoint { x: centre.x + reach_m * cos, y: centre.y + reach_m * sin };
        frame_view.view.pixel_of_water(point).map(|pixel| [pixel.u, pixel.v])
    });
    points.collect::<Option<_>>().unwrap_or_default()
}

/// What the camera sees of the water, where the whole picture is below the horizon.
fn footprint(frame_view: &FrameView, picture: PictureSize) -> Option<Vec<[f64; 2]>> {
    let (width, height) = (f64::from(picture.width), f64::from(picture.height));
    [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
        .into_iter()
        .map(|(u, v)| frame_view.fix(PixelPoint { u, v }).map(|fix| [fix.point.x, fix.point.y]))
        .collect()
}
