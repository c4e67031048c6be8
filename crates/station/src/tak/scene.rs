//! What has a latitude and a longitude in a snapshot: camera, boat and marks.

use std::time::Duration;

use barrelman_console_server::snapshot::Snapshot;
use barrelman_control::water::earth::place_on_earth;
use barrelman_pilot::Outcome;
use barrelman_pilot::on_earth::NotOnEarth;
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::{Angle, MarkKind, Timestamp, Track};

/// A place that is older than this is not sent: the display shows then that nothing is known any more.
const LASTS: Duration = Duration::from_secs(2);

/// What is somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Subject {
    /// The vehicle with the camera.
    Camera {
        /// Height above the place of its start, metres.
        height_m: Option<f64>,
    },
    /// The followed boat.
    Boat,
    /// What the operator marked.
    Mark {
        /// What it is.
        kind: MarkKind,
        /// Number of the mark.
        id: u32,
    },
}

/// How something moves over ground. What is not known is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motion {
    /// Speed, m/s.
    pub(super) speed_m_per_s: Option<f64>,
    /// Direction from true north, positive to the east, any number of turns.
    pub(super) course: Option<Angle>,
}

/// Where something is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Located {
    pub(super) subject: Subject,
    /// When it was there.
    pub(super) at: Timestamp,
    pub(super) place: GeoPoint,
    /// Standard deviation, metres: of the line of sight alone, without the errors of the camera's own place
    /// and direction, which no vehicle reports. `None`: nothing is known of it.
    pub(super) std_dev_m: Option<f64>,
    pub(super) motion: Motion,
}

/// What is known at `now`: nothing but what was reported or seen in the last 2 s.
pub(super) fn located(snapshot: &Snapshot, now: Timestamp) -> Vec<Located> {
    let is_new = |at: Timestamp| now.since(at) <= LASTS;
    let Some(outcome) = snapshot.outcome.as_ref().filter(|outcome| is_new(outcome.at)) else {
        return Vec::new();
    };
    let boat = boat(snapshot, outcome).filter(|boat| is_new(boat.at));
    camera(snapshot, outcome).into_iter().chain(boat).chain(marks(outcome)).collect()
}

fn camera(snapshot: &Snapshot, outcome: &Outcome) -> Option<Located> {
    // The pilot forgets a position after 3 s; the snapshot keeps the last one.
    let place = match outcome.earth {
        Ok(frame) => frame.origin,
        Err(NotOnEarth::NoHeading) => {
            let position = snapshot.vehicle.position?;
            GeoPoint { latitude: position.latitude, longitude: position.longitude }
        }
        Err(NotOnEarth::NoPosition) => return None,
    };
    let subject = Subject::Camera { height_m: snapshot.vehicle.altitude_m };
    Some(Located { subject, at: outcome.at, place, std_dev_m: None, motion: Motion::default() })
}

/// The boat where the line of sight meets the water, which is known where its error is small enough. Its
/// speed is known to the guidance alone. A selection that is not confirmed yet is no boat, nor is what a
/// detector doubts.
fn boat(snapshot: &Snapshot, outcome: &Outcome) -> Option<Located> {
    let Track::Tracking(seen) = outcome.track else { return None };
    if outcome.is_target_uncertain() {
        return None;
    }
    let (sighting, frame) = (snapshot.boat?, outcome.earth.ok()?);
    let progress = outcome.vessel.guidance.and_then(|guidance| guidance.progress);
    // The course counts from the frame's y.
    let from_north = |course: Angle| Angle::from_radians(frame.ahead.radians() + course.radians());
    let motion = progress.map_or_else(Motion::default, |progress| Motion {
        speed_m_per_s: Some(progress.speed_m_per_s),
        course: progress.course.map(from_north),
    });
    let (place, std_dev_m) = (sighting.on_earth?, Some(sighting.std_dev_m));
    Some(Located { subject: Subject::Boat, at: seen.captured, place, std_dev_m, motion })
}

fn marks(outcome: &Outcome) -> impl Iterator<Item = Located> {
    let (frame, at) = (outcome.earth.ok(), outcome.at);
    outcome.vessel.marks.iter().filter_map(move |mark| {
        let place = place_on_earth(&frame?, mark.point(at)?)?;
        let subject = Subject::Mark { kind: mark.kind, id: mark.id };
        Some(Located { subject, at, place, std_dev_m: mark.std_dev_m(at), motion: Motion::default() })
    })
}

#[cfg(test)]
mod tests;
