//! What Foxglove and Lichtblick show of a recording by themselves: box, region and label on the picture
//! (`foxglove.ImageAnnotations`), events (`foxglove.Log`), and the boat on the map (`foxglove.LocationFix`).
//!
//! These messages repeat what the outcomes say. A reader of this program leaves them out.

use barrelman_control::Region;
use barrelman_pilot::Mode;
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::profile::RegionShares;
use barrelman_vocab::{Angle, Localisation, Track};
use foxglove::messages::log::Level;
use foxglove::messages::points_annotation::Type;
use foxglove::messages::{
    Color, ImageAnnotations, LocationFix, Log, Point2, PointsAnnotation, TextAnnotation, Timestamp,
};

use super::entry::RecordedOutcome;

/// Corners of the polygon that stands for the region's ellipse.
const ELLIPSE_CORNERS: u32 = 48;

const WHITE: Color = Color { r: 1.0, g: 1.0, b: 1.0, a: 1.0 };
const DARK: Color = Color { r: 0.0, g: 0.0, b: 0.0, a: 0.6 };
const TRACKED: Color = Color { r: 0.3, g: 0.9, b: 0.8, a: 1.0 };
const COASTING: Color = Color { r: 1.0, g: 0.75, b: 0.2, a: 1.0 };

/// Box, region and label of an outcome, for the picture of this time; `None` without a localisation.
pub(super) fn annotations(
    outcome: &RecordedOutcome,
    shares: RegionShares,
    captured: Timestamp,
) -> Option<ImageAnnotations> {
    let (seen, colour) = match &outcome.track {
        Track::Tracking(seen) => (seen, TRACKED),
        Track::Coasting(seen) => (seen, COASTING),
        Track::Unseeded | Track::Lost { .. } => return None,
    };
    let label = match outcome.percept {
        Some(percept) => format!("{}, P {:.2}", outcome.mode, percept.p),
        None => outcome.mode.to_string(),
    };
    Some(ImageAnnotations {
        timestamp: Some(captured),
        points: vec![loop_of(box_of(seen), colour), loop_of(ellipse_of(seen, shares), WHITE)],
        texts: vec![TextAnnotation {
            position: Some(Point2 { x: seen.bounds.u, y: seen.bounds.v }),
            text: label,
            font_size: 14.0,
            text_color: Some(WHITE),
            background_color: Some(DARK),
            ..TextAnnotation::default()
        }],
        ..ImageAnnotations::default()
    })
}

/// The event of an outcome: a new mode, or a notice to the operator.
pub(super) fn log(outcome: &RecordedOutcome, last_mode: Option<Mode>, at: Timestamp) -> Option<Log> {
    let is_new = last_mode != Some(outcome.mode);
    let message = match (is_new, outcome.notice.as_str()) {
        (false, "") => return None,
        (true, "") => outcome.mode.to_string(),
        (false, notice) => notice.to_owned(),
        (true, notice) => format!("{}: {notice}", outcome.mode),
    };
    let level = match outcome.mode {
        Mode::Stopped(_) | Mode::Holding(_) => Level::Warning,
        Mode::Idle | Mode::Nudging | Mode::Searching | Mode::Calibrating | Mode::Servoing => Level::Info,
    };
    let name = "barrelman".to_owned();
    Some(Log { timestamp: Some(at), level: level.into(), message, name, ..Log::default() })
}

/// Where the boat is on Earth, if that is known.
pub(super) fn location(outcome: &RecordedOutcome, at: Timestamp) -> Option<LocationFix> {
    let GeoPoint { latitude, longitude } = outcome.vessel.as_ref()?.boat_on_earth?;
    Some(LocationFix {
        timestamp: Some(at),
        frame_id: "boat".to_owned(),
        latitude: latitude.degrees(),
        longitude: longitude.degrees(),
        ..LocationFix::default()
    })
}

fn loop_of(points: Vec<Point2>, colour: Color) -> PointsAnnotation {
    PointsAnnotation {
        r#type: Type::LineLoop.into(),
        points,
        outline_color: Some(colour),
        thickness: 2.0,
        ..PointsAnnotation::default()
    }
}

fn box_of(seen: &Localisation) -> Vec<Point2> {
    let bounds = seen.bounds;
    let (right, bottom) = (bounds.u + bounds.w, bounds.v + bounds.h);
    [(bounds.u, bounds.v), (right, bounds.v), (right, bottom), (bounds.u, bottom)]
        .map(|(x, y)| Point2 { x, y })
        .into()
}

fn ellipse_of(seen: &Localisation, shares: RegionShares) -> Vec<Point2> {
    let region = Region::from_shares(shares, seen.picture);
    let (middle_u, middle_v) = (f64::from(seen.picture.width) / 2.0, f64::from(seen.picture.height) / 2.0);
    (0..ELLIPSE_CORNERS)
        .map(|corner| Angle::from_degrees(360.0 * f64::from(corner) / f64::from(ELLIPSE_CORNERS)))
        .map(|angle| Point2 {
            x: middle_u + region.a_px * libm::cos(angle.radians()),
            y: middle_v + region.b_px * libm::sin(angle.radians()),
        })
        .collect()
}
