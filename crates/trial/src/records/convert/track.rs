//! Tracks and localisations, to and from their stored forms.

use barrelman_vocab::track::Shape;
use barrelman_vocab::{Angle, Localisation, PictureSize, PixelBox, PixelPoint, Timestamp, Track};

use super::malformed::{Malformed, missing};
use crate::records::stored;

impl From<PixelBox> for stored::Box {
    fn from(from: PixelBox) -> Self {
        Self { u: from.u, v: from.v, w: from.w, h: from.h }
    }
}

impl From<stored::Box> for PixelBox {
    fn from(from: stored::Box) -> Self {
        Self { u: from.u, v: from.v, w: from.w, h: from.h }
    }
}

impl From<&Localisation> for stored::Localisation {
    fn from(seen: &Localisation) -> Self {
        Self {
            captured_ns: seen.captured.as_nanos(),
            picture_width: seen.picture.width,
            picture_height: seen.picture.height,
            u: seen.centre.u,
            v: seen.centre.v,
            bounds: Some(seen.bounds.into()),
            major_px: seen.shape.map(|shape| shape.major_px),
            minor_px: seen.shape.map(|shape| shape.minor_px),
            axis_rad: seen.shape.map(|shape| shape.axis.radians()),
            heading_rad: seen.heading.map(Angle::radians),
        }
    }
}

fn localisation(seen: &stored::Localisation, confidence: f64) -> Result<Localisation, Malformed> {
    let shape = match (seen.major_px, seen.minor_px, seen.axis_rad) {
        (Some(major_px), Some(minor_px), Some(axis)) => {
            Some(Shape { major_px, minor_px, axis: Angle::from_radians(axis) })
        }
        _ => None,
    };
    Ok(Localisation {
        captured: Timestamp::from_nanos(seen.captured_ns),
        picture: PictureSize::new(seen.picture_width, seen.picture_height),
        centre: PixelPoint { u: seen.u, v: seen.v },
        bounds: seen.bounds.ok_or_else(|| missing("bounds"))?.into(),
        shape,
        heading: seen.heading_rad.map(Angle::from_radians),
        confidence,
    })
}

impl From<&Track> for stored::Track {
    fn from(track: &Track) -> Self {
        let (state, lost_since, confidence) = match track {
            Track::Unseeded => (stored::TrackState::Unseeded, 0, 0.0),
            Track::Tracking(seen) => (stored::TrackState::Tracking, 0, seen.confidence),
            Track::Coasting(seen) => (stored::TrackState::Coasting, 0, seen.confidence),
            Track::Lost { since, confidence } => (stored::TrackState::Lost, since.as_nanos(), *confidence),
        };
        Self {
            state: state as i32,
            localisation: track.localisation().map(Into::into),
            lost_since_ns: lost_since,
            confidence,
        }
    }
}

impl TryFrom<stored::Track> for Track {
    type Error = Malformed;

    fn try_from(track: stored::Track) -> Result<Self, Malformed> {
        let seen = || {
            let seen = track.localisation.as_ref().ok_or_else(|| missing("localisation"))?;
            localisation(seen, track.confidence)
        };
        Ok(match stored::TrackState::try_from(track.state).map_err(|_| missing("state"))? {
            stored::TrackState::Unseeded => Self::Unseeded,
            stored::TrackState::Tracking => Self::Tracking(seen()?),
            stored::TrackState::Coasting => Self::Coasting(seen()?),
            stored::TrackState::Lost => {
                Self::Lost { since: Timestamp::from_nanos(track.lost_since_ns), confidence: track.confidence }
            }
        })
    }
}
